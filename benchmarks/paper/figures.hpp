#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment.hpp"

namespace paper {

struct Figure {
  std::string name;  ///< of the picture
  enum class Kind { orders, defect, invariants } kind;
  std::string problem;
  double dt, time, epsilon;
  std::string solver;
  std::vector<std::vector<std::string>> panels;  ///< rows of methods, one an order
};

/// All figures of the paper, in its order.
const std::vector<Figure>& figures();

/// The runs behind a figure; short: a hundredth of the time.
std::vector<Experiment> experiments(const Figure& figure, bool as_published, bool is_short);

/// Writes <folder>/<name>.gp and draws <folder>/<name>.png from it, where gnuplot is installed.
void draw_figure(const std::filesystem::path& folder, const Figure& figure, bool as_published, bool is_short,
                 const Results& results);

}  // namespace paper
