#include "long_runs.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../batches.hpp"
#include "common/output.hpp"

namespace stability {

namespace {

using namespace semiexplicit;

constexpr int starts = 16;  ///< of which the root mean square is taken

std::string number(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// One line of the picture: errors after 10, 20, 40, ... steps and at the end.
struct Growth {
  std::string problem, method, quantity;
  std::vector<std::int64_t> n;
  std::vector<double> rms;

  /// Slope of log(rms) over log(n), by least squares from 1000 steps on: 1/2 is a random walk, 1 a drift.
  double exponent() const {
    double sx = 0, sy = 0, sxx = 0, sxy = 0, m = 0;
    for (std::size_t i = 0; i < n.size(); ++i) {
      if (n[i] < 1000 || !(rms[i] > 0)) continue;
      const double x = std::log(static_cast<double>(n[i])), y = std::log(rms[i]);
      sx += x, sy += y, sxx += x * x, sxy += x * y, m += 1;
    }
    return (m * sxy - sx * sy) / (m * sxx - sx * sx);
  }
};

template <class State>
using Quantities = std::vector<std::pair<std::string, std::function<double(const State&)>>>;

/// Runs `starts` copies of a stepper from states a little apart.
template <class S>
std::vector<Growth> grow(const std::string& problem, const std::string& method, const S& fresh,
                         const typename S::State& start, double dt, std::int64_t steps,
                         const Quantities<typename S::State>& quantities) {
  std::vector<Growth> lines;
  for (const auto& [name, value] : quantities) lines.push_back({problem, method, name, {}, {}});
  for (int k = 0; k < starts; ++k) {
    auto stepper = fresh;
    auto z = start;
    z.vector() *= 1 + 0.01 * k;
    std::vector<double> first;
    for (const auto& quantity : quantities) first.push_back(quantity.second(z));
    std::size_t row = 0;
    std::int64_t next = std::min<std::int64_t>(10, steps), n = 0;
    while (n < steps) {
      for (; n < next; ++n)
        if (!stepper.step(z, dt).ok()) throw std::runtime_error(problem + ", " + method + ": a step failed");
      for (std::size_t i = 0; i < lines.size(); ++i) {
        if (k == 0) {
          lines[i].n.push_back(n);
          lines[i].rms.push_back(0);
        }
        const double error = quantities[i].second(z) / first[i] - 1;
        lines[i].rms[row] += error * error;
      }
      ++row;
      next = std::min(2 * next, steps);
    }
  }
  for (Growth& line : lines) {
    for (double& value : line.rms) value = std::sqrt(value / starts);
    std::cout << "  " << line.problem << ", " << line.method << ", " << line.quantity << ": "
              << number("%.1e", line.rms.back()) << " after "
              << number("%.1e", static_cast<double>(line.n.back())) << " steps, growing as n^"
              << number("%.2f", line.exponent()) << '\n'
              << std::flush;
  }
  return lines;
}

void append(std::vector<Growth>& all, std::vector<Growth> more) {
  for (Growth& line : more) all.push_back(std::move(line));
}

void draw_growth(const std::filesystem::path& folder, const std::vector<Growth>& lines) {
  std::string script = examples::gnuplot_prologue(folder / "rounding.png", 1200, 560);
  script +=
      "set logscale xy\nset format '10^{%T}'\nset xlabel 'steps'\nset key right bottom samplen 2 font "
      "',11'\nset "
      "grid lc "
      "rgb '#dddddd'\nset multiplot layout 1,2\n";
  for (const char* problem : {"product", "NLS"}) {
    script += "set title '" + std::string(problem) + ": relative error, root mean square of 16 runs'\nplot ";
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (lines[i].problem == problem)
        script += "'rounding.csv' using ($1==" + std::to_string(i) +
                  " && $6>0 ? $5 : NaN):6 with linespoints pt 7 ps 0.6 title " +
                  examples::quoted(lines[i].method + ", " + lines[i].quantity + ": n^{" +
                                   number("%.2f", lines[i].exponent()) + "}") +
                  ", ";
    script += "1e-17*sqrt(x) lc rgb '#888888' dt 2 title '{/Symbol \\326}n'\n";
  }
  script += "unset multiplot\n";
  // gnuplot runs where the program does: the data is named with its folder.
  for (std::size_t at = 0; (at = script.find("'rounding.csv'", at)) != std::string::npos; at += 5)
    script.replace(at, 14, examples::quoted((folder / "rounding.csv").string()));
  examples::draw(folder / "rounding.png", script);
}

}  // namespace

void run_rounding(std::int64_t steps, const std::filesystem::path& folder, bool plot) {
  std::cout << "rounding errors over " << number("%.0e", static_cast<double>(steps)) << " steps\n";
  // Steps at which the method's own error is below the rounding of one step, and a tolerance that the first
  // evaluation meets.
  const SimplifiedNewton solver{.stop = StoppingRule::product(1e-24)};
  std::vector<Growth> lines;

  const systems::Product<double> product;
  using Line = PhasePoint<double, 1>;
  const Quantities<Line> energy{{"energy", [&](const Line& z) { return product.energy(z.q(), z.p()); }}};
  const Line z1(-3, 0);
  const auto s = schemes::low_defect8_s20();
  append(lines, grow("product", "compensated", Semiexplicit(product, s, solver), z1, 0.005, steps, energy));
  append(lines, grow("product", "plain", Semiexplicit(product, s, solver, Summation::plain), z1, 0.005,
                     steps / 10, energy));
  append(lines, grow("product", "Gauss, 6 stages", GaussLegendre(product, {.stages = 6}), z1, 0.02,
                     steps / 10, energy));

  const systems::NlsLattice<double, 5> nls;
  using Five = PhasePoint<double, 5>;
  const Quantities<Five> both{{"energy", [&](const Five& z) { return nls.energy(z.q(), z.p()); }},
                              {"mass", [](const Five& z) { return z.vector().squaredNorm(); }}};
  const Five z5({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  append(lines, grow("NLS", "compensated", Semiexplicit(nls, s, solver), z5, 0.0025, steps / 10, both));
  append(lines,
         grow("NLS", "plain", Semiexplicit(nls, s, solver, Summation::plain), z5, 0.0025, steps / 100, both));
  append(lines,
         grow("NLS", "Gauss, 6 stages", GaussLegendre(nls, {.stages = 6}), z5, 0.005, steps / 100, both));

  examples::write_whole(folder / "rounding.csv", [&](std::ostream& out) {
    out << "line,problem,method,quantity,steps,rms_error\n";
    out.precision(6);
    for (std::size_t i = 0; i < lines.size(); ++i)
      for (std::size_t k = 0; k < lines[i].n.size(); ++k)
        out << i << ",\"" << lines[i].problem << "\",\"" << lines[i].method << "\"," << lines[i].quantity
            << ',' << lines[i].n[k] << ',' << lines[i].rms[k] << '\n';
  });
  examples::write_whole(folder / "rounding.md", [&](std::ostream& out) {
    out << "| problem | method | quantity | steps | rms error | grows as |\n|--|--|--|--|--|--|\n";
    for (const Growth& line : lines)
      out << "| " << line.problem << " | " << line.method << " | " << line.quantity << " | "
          << number("%.1e", static_cast<double>(line.n.back())) << " | " << number("%.1e", line.rms.back())
          << " | n^" << number("%.2f", line.exponent()) << " |\n";
  });
  if (plot) draw_growth(folder, lines);
}

void run_drift(const std::filesystem::path& folder) {
  std::cout << "drift of the mass by the tolerance of the product rule, 10^6 steps of NLS\n";
  const systems::NlsLattice<double, 5> nls;
  const PhasePoint<double, 5> start({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  const double n = 1e6;
  examples::write_whole(folder / "drift.md", [&](std::ostream& out) {
    out << "| scheme | dt | τ | evaluations a step | mass drift after 10⁶ steps | drift / (τ n) "
           "|\n|--|--|--|--|--|--|\n";
    for (const char* name : {"blanes_moan6", "low_defect6_s13"})
      for (const double dt : {0.005, 0.0125, 0.02})
        for (const double tau : {1e-8, 1e-10, 1e-12, 1e-14, 1e-16, 1e-18, 1e-20, 1e-24}) {
          Semiexplicit stepper(nls, schemes::by_name(name),
                               SimplifiedNewton{.stop = StoppingRule::product(tau)});
          auto z = start;
          const double m0 = z.vector().squaredNorm();
          const auto report = integrate(
              stepper, z, {.dt = dt, .steps = static_cast<std::int64_t>(n), .on_failure = OnFailure::stop});
          const double drift = std::abs(z.vector().squaredNorm() / m0 - 1);
          out << "| " << name << " | " << dt << " | " << number("%.0e", tau) << " | "
              << number("%.2f", static_cast<double>(report.evaluations) / static_cast<double>(report.steps))
              << " | " << (report.ok() ? number("%.1e", drift) : "failed at t = " + number("%g", report.t))
              << " | " << (report.ok() ? number("%.1e", drift / (tau * n)) : "–") << " |\n";
          std::cout << "  " << name << ", dt = " << dt << ", tau = " << tau << ": " << drift << ", of tau n "
                    << drift / (tau * n) << (report.ok() ? "\n" : " FAILED\n") << std::flush;
        }
  });
}

namespace {

/// Median and quartiles of compensated/plain time over alternating batches.
template <class H>
std::string ratio(const H& hamiltonian, const PhasePoint<double, H::Dof>& start, double dt, int steps) {
  using Clock = std::chrono::steady_clock;
  Semiexplicit compensated(hamiltonian, schemes::low_defect6_s13());
  Semiexplicit plain(hamiltonian, schemes::low_defect6_s13(), SimplifiedNewton{}, Summation::plain);
  const auto time = [&](auto& stepper) {
    auto z = start;
    const auto begin = Clock::now();
    for (int i = 0; i < steps; ++i)
      if (!stepper.step(z, dt).ok()) throw std::runtime_error("a step failed");
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  std::vector<double> ratios;
  for (int round = 0; round < 101; ++round) {
    const double first = time(compensated), second = time(plain);
    ratios.push_back(first / second);
  }
  return number("%.3f", bench::quantile(ratios, 0.5)) + " | " +
         number("%.3f", bench::quantile(ratios, 0.25)) + " to " +
         number("%.3f", bench::quantile(ratios, 0.75));
}

}  // namespace

void run_summation_cost(const std::filesystem::path& folder) {
  std::cout << "time of a compensated step over a plain one\n";
  examples::write_whole(folder / "summation.md", [&](std::ostream& out) {
    out << "| system | median | quartiles |\n|--|--|--|\n";
    const auto line = [&](const std::string& name, const std::string& figures) {
      out << "| " << name << " | " << figures << " |\n";
      std::cout << "  " << name << ": " << figures << '\n' << std::flush;
    };
    line("one degree of freedom",
         ratio(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 0.01, 2000));
    line("NLS, 5 sites",
         ratio(systems::NlsLattice<double, 5>(),
               PhasePoint<double, 5>({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}), 0.01, 1000));
    PhasePoint<double, Eigen::Dynamic> many(1000);
    many.q().setConstant(0.5);
    line("NLS, 1000 sites", ratio(systems::NlsLattice<double>(1000), many, 0.01, 20));
  });
}

}  // namespace stability
