// Hard cases and long runs: who survives, and how errors grow. See README.md in this folder.

#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "battery.hpp"
#include "common/output.hpp"
#include "long_runs.hpp"

namespace {

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", value);
  return text;
}

void write_battery(const std::filesystem::path& folder, const std::vector<stability::Line>& lines) {
  examples::write_whole(folder / "battery.md", [&](std::ostream& out) {
    out << "| case | to t = | energy within |";
    for (const std::string& name : stability::method_names()) out << ' ' << name << " |";
    out << "\n|--|--|--|--|--|--|--|--|\n";
    for (const auto& line : lines) {
      out << "| " << line.name << " | " << line.t_end << " | " << line.energy_bound << " |";
      for (const auto& o : line.outcomes) {
        const std::string errors =
            short_number(o.energy) + (line.invariant_bound > 0 ? " / " + short_number(o.invariant) : "");
        if (o.survived)
          out << ' ' << errors << " |";
        else if (o.t < 0.999 * line.t_end)
          out << " **lost** at t = " << o.t << " |";
        else
          out << " **lost**: " << errors << " |";
      }
      out << '\n';
    }
  });
  examples::write_whole(folder / "battery.csv", [&](std::ostream& out) {
    out << "case,method,setting,survived,t,t_end,energy_error,invariant_error,gradients,seconds\n";
    out.precision(6);
    for (const auto& line : lines)
      for (std::size_t i = 0; i < line.outcomes.size(); ++i) {
        const auto& o = line.outcomes[i];
        out << '"' << line.name << "\",\"" << stability::method_names()[i] << "\",\"" << o.setting << "\","
            << (o.survived ? "yes" : "no") << ',' << o.t << ',' << line.t_end << ',' << o.energy << ','
            << o.invariant << ',' << o.gradients << ',' << o.seconds << '\n';
      }
  });
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Hard cases with every method, and the growth of rounding errors over long runs");
  std::filesystem::path output = "out";
  double part = 1, steps = 1e8;
  std::string only;
  bool battery = false, rounding = false, drift = false, cost = false, solvers = false, no_plot = false;
  app.add_flag("--battery", battery, "the hard cases, every method");
  app.add_flag("--rounding", rounding, "rounding errors over --steps steps: the growth, fitted");
  app.add_flag("--drift", drift, "drift by the tolerance of the product rule");
  app.add_flag("--cost", cost, "what compensated summation costs");
  app.add_flag("--solvers", solvers, "evaluations a step of every solver on a stiff lattice");
  app.add_option("--part", part, "part of the battery's long times to run")->check(CLI::Range(0.0, 1.0));
  app.add_option("--only", only, "the cases with this in their name");
  app.add_option("--steps", steps, "longest run of the small problem; a tenth for NLS")
      ->check(CLI::Range(1e3, 1e10));
  app.add_option("--output", output, "folder for tables and figures");
  app.add_flag("--no-plot", no_plot, "no pictures");
  CLI11_PARSE(app, argc, argv);
  std::filesystem::create_directories(output);

  const bool all = !battery && !rounding && !drift && !cost && !solvers;
  if (all || battery) write_battery(output, stability::run_battery(part, only));
  if (all || rounding) stability::run_rounding(static_cast<std::int64_t>(steps), output, !no_plot);
  if (all || drift) stability::run_drift(output);
  if (all || cost) stability::run_summation_cost(output);
  if (all || solvers) stability::run_solvers(output);
  return 0;
} catch (const std::exception& error) {
  std::cerr << "bench_stability: " << error.what() << '\n';
  return 1;
}
