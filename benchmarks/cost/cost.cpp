// Is the advice of cost_of_accuracy() right? Eight systems, four targets, against a scan of every method and step.
//
//     bench_cost [folder] [system] [verbose]
//
// writes the table to the screen and to folder/advice.md ("out" by default), and keeps the scans there.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <semiexplicit/accuracy.hpp>

#include "common/output.hpp"
#include "systems.hpp"

namespace {

using namespace bench;

/// A run over the whole time.
struct Point {
  std::string method;
  double dt, error, gradients;
};

template <class H>
Point whole_run(const H& hamiltonian, PhasePoint<double, H::Dof> z, double T, const Setting& setting,
                double hopeless) {
  Point point{setting.name(), setting.dt, 0, 0};
  const double initial = hamiltonian.energy(z.q(), z.p());
  const double unit = initial == 0 ? 1 : std::abs(initial);
  try {
    point.gradients =
        static_cast<double>(run(hamiltonian, z, T, setting, [&](double, const auto& now) {
                              const double error =
                                  std::abs(hamiltonian.energy(now.q(), now.p()) - initial) / unit;
                              if (!(error <= point.error)) point.error = error;
                              return point.error <= hopeless;
                            }).gradients);
  } catch (const IntegrationError&) {
    point.error = std::numeric_limits<double>::infinity();
  }
  return point;
}

/// Every method with steps a factor 2^(1/4) apart, from the largest that works down to the tightest target.
template <class H>
std::vector<Point> exhaustive(const H& hamiltonian, const PhasePoint<double, H::Dof>& z0, double T,
                              double tightest) {
  const CostOptions options;
  std::vector<Setting> settings;
  for (const std::string& name : options.schemes) settings.push_back({.scheme = name});
  for (const int stages : options.gauss_stages)
    settings.push_back({.method = Setting::Method::gauss, .stages = stages});
  auto x = z0;
  auto gq = x.q().eval(), gp = x.p().eval();
  hamiltonian.gradient(z0.q(), z0.p(), gq, gp);
  const double scale = z0.vector().norm() / std::hypot(gq.norm(), gp.norm());
  std::vector<Point> points;
  for (Setting setting : settings)
    for (int k = 0; k < 60; ++k) {
      setting.dt = 4 * scale * std::pow(2, -k / 4.0);
      const Point point = whole_run(hamiltonian, z0, T, setting, 0.01);
      if (point.error < 0.01) points.push_back(point);
      if (point.error < tightest) break;
    }
  return points;
}

/// The scan takes minutes: it is kept in a file, and read from there the next time.
template <class H>
std::vector<Point> reference(const std::filesystem::path& file, const H& hamiltonian,
                             const PhasePoint<double, H::Dof>& z0, double T, double tightest) {
  std::vector<Point> points;
  if (std::ifstream in(file); in) {
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::istringstream fields(line);
      Point point;
      std::getline(fields, point.method, ';');
      char separator = 0;
      if (fields >> point.dt >> separator >> point.error >> separator >> point.gradients)
        points.push_back(point);
    }
    return points;
  }
  points = exhaustive(hamiltonian, z0, T, tightest);
  examples::write_whole(file, [&](std::ostream& out) {
    out.precision(17);
    out << "method;dt;error;gradients\n";
    for (const Point& p : points)
      out << p.method << ';' << p.dt << ';' << p.error << ';' << p.gradients << '\n';
  });
  return points;
}

std::string row(const char* format, auto... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : "out";
  const std::string only = argc > 2 ? argv[2] : "";
  const bool verbose = argc > 3;
  const std::vector<double> targets{1e-4, 1e-6, 1e-8, 1e-10};
  std::filesystem::create_directories(folder);

  std::string table =
      "| system | target | advised | dt | expected | reached | reached / target | gradients | best of the "
      "scan | "
      "its gradients | cost / best | advice / run |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  int wrong = 0;
  double worst_error = 0, worst_cost = 0;
  std::cout << table << std::flush;
  const auto print = [&](const std::string& line) {
    table += line;
    std::cout << line << std::flush;
  };

  for_each_system([&](const std::string& name, const auto& hamiltonian, const auto& z0, double T) {
    if (!only.empty() && name != only) return;
    std::string file = name + ".csv";
    for (char& c : file)
      if (c == ' ') c = '_';
    const auto points = reference(folder / file, hamiltonian, z0, T, targets.back() / 2);
    for (const double target : targets) {
      const CostOfAccuracy cost = cost_of_accuracy(hamiltonian, z0, T, {.targets = {target}});
      if (verbose) std::cout << cost;
      const Point* best = nullptr;
      for (const Point& point : points)
        if (point.error <= target && (best == nullptr || point.gradients < best->gradients)) best = &point;
      const auto advice = cost.cheapest(target);
      if (!advice) {
        ++wrong;
        print(row("| %s | %.0e | out of reach | | | | | | %s | | | |\n", name.c_str(), target,
                  best == nullptr ? "out of reach" : best->method.c_str()));
        continue;
      }
      const Point reached = whole_run(hamiltonian, z0, T, advice->setting, 1e300);
      const double off = reached.error / target,
                   dearer = best == nullptr ? 0 : reached.gradients / best->gradients;
      worst_error = std::max(worst_error, off);
      worst_cost = std::max(worst_cost, dearer);
      const bool right = off <= 3 && dearer <= 1.5;
      wrong += !right;
      print(
          row("| %s | %.0e | %s | %.4g | %.1e | %.1e | %s%.2f%s | %.3g | %s, dt %.4g | %.3g | %s%.2f%s | "
              "%.1f%% |\n",
              name.c_str(), target, advice->setting.name().c_str(), advice->setting.dt, advice->error,
              reached.error, off > 3 ? "**" : "", off, off > 3 ? "**" : "", reached.gradients,
              best == nullptr ? "-" : best->method.c_str(), best == nullptr ? 0 : best->dt,
              best == nullptr ? 0 : best->gradients, dearer > 1.5 ? "**" : "", dearer,
              dearer > 1.5 ? "**" : "", 100 * cost.fraction_of(*advice)));
    }
  });
  print(row("\n%d of them outside a factor 3 of the target or 1.5 of the best cost; worst %.2f and %.2f.\n",
            wrong, worst_error, worst_cost));
  examples::write_whole(folder / "advice.md", [&](std::ostream& out) { out << table; });
}
