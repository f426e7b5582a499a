// Recomputes the tables and figures of Jayawardana and Ohsawa, Math. Comp. 92 (2023) 251, and sets the
// published values beside ours. See README.md in this folder.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/arguments.hpp"
#include "experiment.hpp"
#include "figures.hpp"
#include "published.hpp"
#include "tables.hpp"

namespace {

using namespace paper;

/// Runs what is not there yet.
void make_missing(const std::vector<Experiment>& wanted, const Results& results) {
  std::vector<Experiment> missing;
  std::set<std::string> keys;
  for (const Experiment& e : wanted)
    if (keys.insert(e.key()).second && !results.has(e)) missing.push_back(e);
  std::cout << keys.size() << " experiments, " << missing.size() << " of them to run\n" << std::flush;
  for (std::size_t i = 0; i < missing.size(); ++i)
    if (!results.has(missing[i]))  // another run of this program may have made it meanwhile
      results.make(missing[i], '[' + std::to_string(i + 1) + '/' + std::to_string(missing.size()) + "] " +
                                   missing[i].key());
}

bool contains(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Recomputes the tables and figures of the paper behind this library, published values beside ours. "
      "What is finished is kept in the output folder and not done again."};
  std::vector<std::string> known{"times"}, chosen;
  for (const auto& table : published_tables()) known.push_back(table.label);
  for (const auto& figure : figures()) known.push_back("fig:" + figure.name);
  std::string mode = "as-published";
  std::filesystem::path output = "out/paper";
  bool is_short = false, fresh = false, no_plot = false, all = false;
  app.add_option("what", chosen, "tables and figures; all if none is named: " + examples::joined(known))
      ->check(examples::one_of(known))
      ->type_name("NAME");
  app.add_flag("--all", all, "all tables and figures, which is also the default");
  app.add_option(
         "--mode", mode,
         "as-published: every pair of vortices counted once, the copies' defect carried from step to step; "
         "library: the physical Hamiltonian, the library's own steps")
      ->check(examples::one_of({"as-published", "library"}))
      ->type_name("NAME")
      ->capture_default_str();
  app.add_option("--output", output, "folder for results, tables and figures")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_flag("--short", is_short,
               "some thousand steps of each experiment; the counts are checked within 6 %");
  app.add_flag("--fresh", fresh, "do again what is there already");
  app.add_flag("--no-plot", no_plot, "leave the pictures out");

  return examples::run_program(app, argc, argv, [&] {
    if (all || chosen.empty()) chosen = known;
    const TableOptions options{.as_published = mode == "as-published", .is_short = is_short};
    if (!options.as_published) output /= "library";
    const Results results(output / "results");

    std::vector<Experiment> wanted;
    const auto want = [&](const std::vector<Experiment>& list) {
      wanted.insert(wanted.end(), list.begin(), list.end());
    };
    for (const auto& table : published_tables())
      if (contains(chosen, table.label)) want(experiments(table, options));
    if (contains(chosen, "times")) want(timing_experiments(is_short));
    for (const auto& figure : figures())
      if (contains(chosen, "fig:" + figure.name)) want(experiments(figure, options.as_published, is_short));
    if (fresh)
      for (const Experiment& one : wanted) std::filesystem::remove(results.file(one));
    make_missing(wanted, results);

    Verdict verdict;
    for (const auto& table : published_tables())
      if (contains(chosen, table.label)) {
        const Verdict one = write_table(output / "tables", table, options, results);
        verdict.compared += one.compared;
        verdict.exceptions.insert(verdict.exceptions.end(), one.exceptions.begin(), one.exceptions.end());
      }
    if (contains(chosen, "times")) write_timings(output / "tables", is_short, results);
    if (!no_plot)
      for (const auto& figure : figures())
        if (contains(chosen, "fig:" + figure.name))
          draw_figure(output / "figures", figure, options.as_published, is_short, results);

    std::cout << "tables: " << (output / "tables").string() << '\n';
    if (verdict.compared == 0) return 0;
    std::cout << "NW_itr: " << verdict.compared - static_cast<int>(verdict.exceptions.size()) << " of "
              << verdict.compared << " published values within " << (is_short ? 6 : 2) << " %\n";
    for (const std::string& exception : verdict.exceptions) std::cout << "  not: " << exception << '\n';
    // Only the short runs are a test: of the full ones chaos decides some.
    return is_short && options.as_published && !verdict.exceptions.empty() ? 1 : 0;
  });
}
