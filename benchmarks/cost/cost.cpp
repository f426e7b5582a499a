// Is the advice of cost_of_accuracy() right? Twelve pairs of a system and of what is measured, against a scan
// of every method and step, and with --energy eight systems and four targets for the energy.
//
//     bench_cost [--energy] [--verbose] [--only NAME] [folder]
//     bench_cost --forecasts [COUNT] [folder]
//
// writes the table to the screen and to folder/advice.md ("out" by default). Costs are gradient calls. The
// second asks COUNT random questions (40 by default) about each of six kinds of systems, with too few calls
// to run anything as a whole, and counts how often what is advised holds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <semiexplicit/accuracy.hpp>

#include "common/output.hpp"
#include "forecasts.hpp"
#include "pairs.hpp"

namespace {

using namespace bench;

/// What a whole run gives.
struct Point {
  Setting setting;
  double error, gradients;
};

/// Errors of whole runs: of an invariant against its first value at every step, of any other observable
/// against a tight run at `samples` times that all steps fit into.
template <class H>
class Judge {
 public:
  static constexpr int Dof = H::Dof;
  using State = PhasePoint<double, Dof>;

  Judge(const H& h, const State& z0, double T, const Observable<double, Dof>& f, bool invariant)
      : h_(h), z0_(z0), time_(T), f_(f), invariant_(invariant) {
    if (invariant) {
      samples_ = 1;
      unit_ = f_of(z0).norm();
      return;
    }
    const Setting tight{.method = Setting::Method::gauss, .stages = 8, .dt = tight_step()};
    follow(tight, [&](std::size_t, const Eigen::VectorXd& value) {
      truth_.push_back(value);
      unit_ = std::max(unit_, value.norm());
      return true;
    });
  }

  /// With the largest step up to setting.dt that fits between the samples.
  Point run_fitting(Setting setting, double hopeless) const {
    setting.dt = fitting(setting.dt);
    Point point{setting, 0, 0};
    try {
      point.gradients = follow(setting, [&](std::size_t k, const Eigen::VectorXd& value) {
        note(point, k, value);
        return point.error <= hopeless;
      });
    } catch (const IntegrationError&) {
      point.error = std::numeric_limits<double>::infinity();
    }
    if (!(point.error <= hopeless)) point.error = std::numeric_limits<double>::infinity();
    return point;
  }

  /// With the very step of the setting: tight ones lead from its steps' ends to the samples.
  Point run_exactly(const Setting& setting) const {
    if (invariant_ && !setting.reversible) return run_fitting(setting, 1e300);
    Point point{setting, 0, 0};
    State z = z0_;
    std::size_t k = 0;
    State last = z0_;
    double before = 0;
    try {
      point.gradients = static_cast<double>(
          run(h_, z, time_, setting, [&](double t, const State& now) {
            if (invariant_) return note(point, 0, f_of(now));
            const double between = time_ / samples_;
            for (; static_cast<double>(k) * between <= t * (1 + 1e-12) && k < truth_.size(); ++k) {
              State at = last;
              const double part = static_cast<double>(k) * between - before;
              if (part > 0)
                run(h_, at, part, {.method = Setting::Method::gauss, .stages = 8, .dt = tight_step()});
              note(point, k, f_of(at));
            }
            last = now, before = t;
          }).gradients);
    } catch (const IntegrationError&) {
      point.error = std::numeric_limits<double>::infinity();
    }
    return point;
  }

 private:
  void note(Point& point, std::size_t k, const Eigen::VectorXd& value) const {
    const double error = (value - (invariant_ ? f_of(z0_) : truth_[k])).norm() / unit_;
    if (!(error <= point.error)) point.error = error;
  }
  Eigen::VectorXd f_of(const State& z) const {
    if (f_.is_energy()) return Eigen::VectorXd::Constant(1, h_.energy(z.q(), z.p()));
    return f_(z);
  }
  /// The largest step up to dt that a whole number of fits between two samples.
  double fitting(double dt) const {
    const double between = time_ / samples_;
    return between / std::ceil(between / dt - 1e-9);
  }
  double tight_step() const {
    auto gq = z0_.q().eval(), gp = z0_.p().eval();
    h_.gradient(z0_.q(), z0_.p(), gq, gp);
    return fitting(0.05 * std::min(1.0, z0_.vector().norm() / std::hypot(gq.norm(), gp.norm())));
  }
  template <class Use>
  double follow(const Setting& setting, const Use& use) const {
    State z = z0_;
    const auto stride = static_cast<std::int64_t>(std::lround(time_ / samples_ / setting.dt));
    std::int64_t n = -1;
    std::size_t k = 0;
    return static_cast<double>(run(h_, z, time_, setting, [&](double, const State& now) {
                                 ++n;
                                 if (!invariant_ && n % stride != 0) return true;
                                 return use(k++, f_of(now));
                               }).gradients);
  }

  const H& h_;
  State z0_;
  double time_;
  const Observable<double, Dof>& f_;
  bool invariant_;
  int samples_ = 400;
  double unit_ = 0;
  std::vector<Eigen::VectorXd> truth_{};
};

/// The cheapest of every method with steps a factor 2^(1/4) apart; with reversible ones where `cost` tried
/// such.
template <class H>
std::optional<Point> cheapest_of_all(const H& h, const PhasePoint<double, H::Dof>& z0, double T,
                                     double target, const Judge<H>& judge, const CostTable& cost) {
  const CostOptions options;
  std::vector<Setting> settings;
  for (const std::string& name : options.schemes) {
    settings.push_back({.scheme = name});
    settings.push_back({.method = Setting::Method::midpoint, .scheme = name});
  }
  for (const int stages : options.gauss_stages)
    settings.push_back({.method = Setting::Method::gauss, .stages = stages});
  if (SeparableHamiltonian<H>)
    for (const std::string& name : options.splittings)
      settings.push_back({.method = Setting::Method::splitting, .scheme = name});
  for (const CostRow& row : cost.rows)
    if (row.setting.reversible) {
      const std::size_t equal = settings.size();
      for (std::size_t i = 0; i < equal; ++i)
        if (settings[i].method != Setting::Method::midpoint && !settings[i].is_gauss()) {
          settings.push_back(settings[i]);
          settings.back().reversible = true, settings.back().pace = row.setting.pace;
        }
      break;
    }
  auto gq = z0.q().eval(), gp = z0.p().eval();
  h.gradient(z0.q(), z0.p(), gq, gp);
  const double scale = std::min(T, z0.vector().norm() / std::hypot(gq.norm(), gp.norm()));
  std::optional<Point> best;
  for (Setting setting : settings) {
    int met = 0;
    for (int k = 0; k < 48 && met < 4; ++k) {
      setting.dt = 4 * scale * std::pow(2, -k / 4.0);
      if (setting.reversible) setting.dt = 4 * std::pow(2, -k / 4.0);
      const Point point = setting.reversible ? judge.run_exactly(setting) : judge.run_fitting(setting, 1);
      if (best && point.gradients > 3 * best->gradients) break;
      if (!(point.error <= target)) continue;
      ++met;  // where the projection takes several evaluations, a smaller step may be cheaper
      if (!best || point.gradients < best->gradients) best = point;
    }
  }
  return best;
}

std::string text(const char* format, auto... values) {
  char line[600];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

/// How often advice holds that rests on a part of T.
struct Forecasts {
  std::function<void(const std::string&)> print;
  std::string name{};
  int asked = 0, whole = 0, met = 0, nearly = 0, off = 0, failed = 0;
  double worst = 0;

  void begin(const std::string& next) {
    end();
    *this = {.print = print, .name = next};
  }
  void end() const {
    if (asked > 0)
      print(text("| %s | %d | %d | %d | %d | %d | %d | %d | %.1f |\n", name.c_str(), asked,
                 asked - whole - met - nearly - off - failed, whole, met, nearly, off, failed, worst));
  }
  template <class H>
  void operator()(const H& h, const PhasePoint<double, H::Dof>& z0, const Question& question, const auto& f,
                  auto exact) {
    ++asked;
    const auto cost = cost_of_accuracy(
        h, z0, question.T,
        {.observable = f, .targets = {question.target}, .min_gradients = question.min_gradients});
    const auto advice = cost.cheapest(question.target);
    if (!advice) return;
    if (advice->tried >= question.T) return void(++whole);
    double error = 0, next = 0;
    try {
      auto z = z0;
      cost.run(z, *advice, [&](double t, const auto& now) {
        if (t < next) return;
        next += question.T / 2000;
        const auto there = exact(t);
        error = std::max(error, std::abs(f(now.q(), now.p()) - f(there.q(), there.p())) / cost.unit);
      });
    } catch (const IntegrationError&) {
      return void(++failed);
    }
    const double ratio = error / question.target;
    worst = std::max(worst, ratio);
    ++(ratio <= 1 ? met : ratio <= 3 ? nearly : off);
  }
};

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path folder = "out";
  std::string only;
  bool verbose = false, energies = false;
  int forecasts = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--verbose")
      verbose = true;
    else if (word == "--energy")
      energies = true;
    else if (word == "--forecasts")
      forecasts = i + 1 < argc && std::atoi(argv[i + 1]) > 0 ? std::atoi(argv[++i]) : 40;
    else if (word == "--only" && i + 1 < argc)
      only = argv[++i];
    else
      folder = word;
  }

  std::string table;
  const auto print = [&](const std::string& line) {
    table += line;
    std::cout << line << std::flush;
  };
  const auto write = [&](const std::string& name) {
    std::filesystem::create_directories(folder);
    examples::write_whole(folder / name, [&](std::ostream& out) { out << table; });
  };
  if (forecasts > 0) {
    print(
        "| system | asked | refused | run as a whole | target met | within 3 | beyond | failed | the worst "
        "|\n|---|---|---|---|---|---|---|---|---|\n");
    Forecasts counts{.print = print};
    for_each_forecast(forecasts, counts);
    counts.end();
    return write("forecasts.md"), 0;
  }
  print(
      "| measured | target | advised | dt | expected | reached | reached / target | gradients | best of the "
      "scan | its gradients | cost / best | advice / run "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  int pairs = 0, wrong = 0;
  const auto compare = [&](const std::string& name, const auto& h, const auto& z0, double T, double target,
                           const auto& f) {
    if (!only.empty() && name != only) return;
    using H = std::decay_t<decltype(h)>;
    ++pairs;
    const auto cost = cost_of_accuracy(h, z0, T, {.observable = f, .targets = {target}});
    if (verbose) std::cout << cost;
    const auto advice = cost.cheapest(target);
    if (cost.reach(target) == Reach::orbits_part) {
      print(text("| %s | %.0e | refused: %s | | | | | | | | | |\n", name.c_str(), target,
                 cost.why(target).c_str()));
      return;
    }
    const Judge<H> judge(h, z0, T, f, cost.invariant);
    const auto best = cheapest_of_all(h, z0, T, target, judge, cost);
    const std::string scan =
        best ? best->setting.name() + text(", dt %.4g | %.3g", best->setting.dt, best->gradients)
             : "out of reach |";
    if (!advice) {
      wrong += best.has_value();
      print(text("| %s | %.0e | out of reach: %s | | | | | | %s | | |\n", name.c_str(), target,
                 cost.why(target).c_str(), scan.c_str()));
      return;
    }
    const Point reached = judge.run_exactly(advice->setting);
    const double off = reached.error / target, dearer = best ? reached.gradients / best->gradients : 0;
    wrong += !(off <= 3 && dearer <= 1.5);
    print(text("| %s | %.0e | %s | %.4g | %.1e | %.1e | %s%.2f%s | %.3g | %s | %s%.2f%s | %.1f%% |\n",
               name.c_str(), target, advice->setting.name().c_str(), advice->setting.dt, advice->error,
               reached.error, off > 3 ? "**" : "", off, off > 3 ? "**" : "", reached.gradients, scan.c_str(),
               dearer > 1.5 ? "**" : "", dearer, dearer > 1.5 ? "**" : "", 100 * cost.fraction_of(*advice)));
  };
  if (energies)
    for_each_system([&](const std::string& name, const auto& h, const auto& z0, double T) {
      using H = std::decay_t<decltype(h)>;
      for (const double target : {1e-4, 1e-6, 1e-8, 1e-10})
        compare(name, h, z0, T, target, Observable<double, H::Dof>());
    });
  else
    for_each_pair(compare);
  print(text("\n%d of %d outside a factor 3 of the target or 1.5 of the best cost.\n", wrong, pairs));
  write(energies ? "advice_energy.md" : "advice.md");
}
