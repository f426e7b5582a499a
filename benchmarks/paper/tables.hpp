#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "published.hpp"

namespace paper {

/// How the tables are to be recomputed.
struct TableOptions {
  bool as_published = true;
  bool is_short = false;  ///< some thousand steps instead of all
};

/// Every run behind a table; those that chaos decides several times, from states that differ by rounding.
std::vector<Experiment> experiments(const PublishedTable& table, const TableOptions& options);

/// How many counts were compared with the published ones, and which of them are off.
struct Verdict {
  int compared = 0;
  std::vector<std::string> exceptions;
};

/// Writes <folder>/<label>.md and .csv: published, ours, difference.
Verdict write_table(const std::filesystem::path& folder, const PublishedTable& table,
                    const TableOptions& options, const Results& results);

/// The runs behind the table of times, and that table: methods of an order side by side.
std::vector<Experiment> timing_experiments(bool is_short);
void write_timings(const std::filesystem::path& folder, bool is_short, const Results& results);

}  // namespace paper
