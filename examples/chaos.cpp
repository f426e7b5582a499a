// The finite-time Lyapunov exponent of a wave packet that spreads in a disordered nonlinear chain, in weak
// and strong chaos.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "chaos/chain.hpp"
#include "chaos/series.hpp"
#include "common/arguments.hpp"
#include "common/output.hpp"
#include "common/prepare_outputs.hpp"

namespace {

using namespace examples;

/// Of 21 sites with |ψ|² = 1 in a chain with W = 4: Laptyeva, Bodyfelt, Krimer, Skokos, Flach, Europhys.
/// Lett. 91 (2010) 30001. The slopes: Senyange, Many Manda, Skokos, Phys. Rev. E 98 (2018) 052229.
struct Regime {
  std::string name;
  double beta, published_slope;
  std::string color;
};
const std::vector<Regime> all_regimes{{"weak", 0.04, -0.25, "'#08519c'"},
                                      {"strong", 0.72, -0.3, "'#cb181d'"}};
constexpr Eigen::Index excited = 21;
constexpr double picture_begin = 10;

struct Request {
  Eigen::Index sites = 1000;
  std::int64_t realizations = 1, seed = 1;
  double dt = 0.15, time = 3e4;
  std::string only{};

  std::vector<Regime> regimes() const {
    std::vector<Regime> asked_for;
    std::copy_if(all_regimes.begin(), all_regimes.end(), std::back_inserter(asked_for),
                 [&](const Regime& regime) { return only.empty() || regime.name == only; });
    return asked_for;
  }
  std::int64_t steps() const { return steps_in(time, dt); }
};

/// What realizations add to stays where a later one fails.
void run(const Regime& regime, const Request& request, Series& mean) {
  for (std::int64_t k = 0; k < request.realizations; ++k) {
    std::mt19937_64 random(static_cast<std::uint64_t>(request.seed + k));
    const auto uniform = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
    Eigen::VectorXd energies(request.sites);
    for (double& energy : energies) energy = 4 * (uniform() - 0.5);
    PhasePoint<double, Eigen::Dynamic> z(request.sites), direction = z;
    for (Eigen::Index i = (request.sites - excited) / 2, n = 0; n < excited; ++i, ++n) {
      const double phase = 2 * std::numbers::pi * uniform();
      z.q()[i] = std::sqrt(2.0) * std::cos(phase);
      z.p()[i] = std::sqrt(2.0) * std::sin(phase);
      direction.q()[i] = uniform() - 0.5;
      direction.p()[i] = uniform() - 0.5;
    }
    const Chain chain(energies, regime.beta);
    Semiexplicit stepper(chain, schemes::low_defect4_s7<double>());
    LyapunovExponents lyapunov(stepper, 1);
    lyapunov.start_with(direction.vector());
    Invariants invariants(chain);
    const std::string name = regime.name + " chaos, realization " + std::to_string(k + 1);
    Progress progress(request.time, name);
    const auto report =
        integrate(stepper, z, {.dt = request.dt, .t_end = request.time}, lyapunov, invariants, progress);
    std::cerr << name
              << formatted(": %.2g µs a step", 1e6 * report.seconds / static_cast<double>(report.steps))
              << formatted(", %.2f evaluations", double(report.evaluations) / double(report.steps))
              << formatted(", energy error %.1e, %.0f s", invariants["energy"].worst, report.seconds)
              << std::endl;
    mean.add(lyapunov.times(), lyapunov.series());
  }
}

/// One regime and what was measured of it.
struct Measured {
  Regime regime;
  Series series;
};

void write(const std::filesystem::path& csv, const std::vector<Measured>& all) {
  std::vector<std::string> header{"t"};
  for (const Measured& one : all) header.push_back(one.regime.name + "_exponent");
  CsvWriter writer(csv, header);
  const std::vector<double>& t = all.front().series.t;
  for (std::size_t i = 0; i < t.size(); ++i) {
    std::vector<double> row{t[i]};
    for (const Measured& one : all) row.push_back(one.series.exponent(i));
    writer.row(row);
  }
  writer.commit();
}

std::string picture(const std::filesystem::path& png, const std::filesystem::path& csv,
                    const std::vector<Measured>& all) {
  std::string script =
      gnuplot_prologue(png, 1000, 700) +
      "set logscale xy\nset format xy '10^{%T}'\nset xlabel 'time'\n"
      "set ylabel 'largest Lyapunov exponent up to the time'\nset key below maxrows 3 samplen 2\n"
      "set yrange [*:1]\n" +
      formatted("set xrange [%g:*]\nplot ", picture_begin);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& [name, beta, published, color] = all[i].regime;
    const Series& series = all[i].series;
    const double end = series.t.back(), at_end = series.end(), slope = series.slope();
    script += quoted(csv.string()) + " skip 1 using 1:" + std::to_string(i + 2) + " with lines lw 2 lc rgb " +
              color + " title '" + name + " chaos, β = " + formatted("%g", beta) +
              (std::isfinite(slope) && series.is_long() ? formatted(", slope %.2f", slope) : "") +
              "', \\\n  ";
    if (!std::isfinite(at_end) || !series.is_long()) continue;  // nothing to compare with
    script += "[" + formatted("%g:%g", end / 1e3, end) + "] " +
              formatted("%g * (x / %g)**%g", 1.3 * at_end, end, published) + " dashtype 2 lc rgb " + color +
              " title 'published: t^{" + formatted("%g", published) + "}', \\\n  ";
  }
  return script + "[10:1e4] 2 / x lc rgb '#999999' title 'order: 1/t'\n";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "The finite-time Lyapunov exponent of a wave packet that spreads in a disordered nonlinear chain."};
  Request request;
  Settings settings;
  add_value(app, "--sites", request.sites, "of the chain", whole_number(excited, 10'000'000), "N");
  add_value(app, "--time", request.time, "time to integrate to", positive());
  add_value(app, "--dt", request.dt, "step size", positive());
  add_value(app, "--realizations", request.realizations, "of the disorder, over which log Λ is averaged",
            whole_number(1, 1'000'000), "N");
  add_value(app, "--seed", request.seed, "of the first one", whole_number(0, 1'000'000'000), "N");
  app.add_option("--only", request.only, "one regime: weak or strong")->check(one_of({"weak", "strong"}));
  add_output(app, settings, false);
  app.footer("About a minute. One realization scatters: average over several, with --time 3e5 or more.");

  return run_program(app, argc, argv, [&] {
    request.steps();  // refused before the folder is made
    const std::filesystem::path csv = settings.output / "chaos.csv", png = settings.output / "chaos.png";
    prepare_outputs(settings, {csv, png});
    std::vector<Measured> all;
    const auto write_and_tell = [&] {  // in this order, as whoever reads the words may go
      write(csv, all);
      for (const auto& [regime, series] : all)
        std::cout << regime.name << " chaos: " << series.in_words(regime.published_slope) << '\n';
    };
    for (const Regime& regime : request.regimes()) {
      all.push_back({regime, {}});
      try {
        run(regime, request, all.back().series);
      } catch (const std::runtime_error&) {  // of the run, or of the exponents: the step has no tangent map
        const std::int64_t done = all.back().series.realizations();
        if (done == 0) all.pop_back();
        if (!all.empty()) {
          write_and_tell();
          std::cout << "data so far: " << csv.string();
          if (done > 0)
            std::cout << ", of " << regime.name << " chaos " << done << " of " << request.realizations
                      << " realizations";
          std::cout << std::endl;
        } else {
          tell_of_earlier(csv, "the data");
        }
        if (!settings.no_plot) tell_of_earlier_picture(png);
        throw;
      }
    }
    write_and_tell();
    std::cout << "data: " << csv.string() << '\n';
    if (settings.no_plot) return 0;
    if (all.front().series.t.back() <= picture_begin)
      tell_no_picture(png, formatted("it begins at t = %g", picture_begin));
    else
      draw(png, picture(png, csv, all), {csv});
    return 0;
  });
}
