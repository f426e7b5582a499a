// A chain of sites: nonlinearity, hopping, disorder, as the user chooses.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "common/scene_program.hpp"
#include "lattice/chain.hpp"

namespace {

using namespace examples;
constexpr int any = Eigen::Dynamic;
using State = PhasePoint<double, any>;
using Half = In<double, any>;

std::vector<EffectEntry<any>> all_effects() {
  const char* const resonant = "Colliander, Keel, Staffilani, Takaoka, Tao, Invent. Math. 181 (2010) 39";
  return {{{"g"},
           resonant,
           [](const Choice& c) { return lattice::OnSite<>{.sites = sites(c), .strength = c["g"]}; }},
          {{"k"},
           resonant,
           [](const Choice& c) { return lattice::PairExchange<>{.sites = sites(c), .strength = c["k"]}; }},
          {{"j"},
           "the tight-binding model; Kittel, Introduction to Solid State Physics, chapter 9",
           [](const Choice& c) { return lattice::Hopping<>{.sites = sites(c), .rate = c["j"]}; }},
          {{"width", "seed"}, "Anderson, Phys. Rev. 109 (1958) 1492", [](const Choice& c) {
             return lattice::Disorder<>(energies(c));
           }}};
}

/// The start of Jayawardana and Ohsawa (2023), and of the program nls.
State paper_start(const Choice& c) {
  State z(sites(c));
  z.q().setConstant(0.01);
  z.q()[0] = 3;
  z.p()[0] = 1;
  return z;
}

std::vector<ScenePreset<any>> presets() {
  return {
      {.name = "nls",
       .about = "the lattice of the resonant Schrödinger equation, as in the program nls",
       .units = {"1/g"},
       .effects = {"on_site", "pair_exchange"},
       .also = {"hopping", "disorder"},
       .values = {{"sites", "5"}, {"g", "1"}, {"k", "1"}, {"j", "0.01"}, {"width", "1e-4"}, {"seed", "1"}},
       .dt = "0.0125",
       .time = "1000",
       .start = paper_start},
      {.name = "anderson",
       .about = "one site in a disordered chain: Anderson localisation",
       .units = {"1/J"},
       .effects = {"hopping", "disorder"},
       .also = {"on_site"},
       .values = {{"sites", "128"}, {"mass", "1"}, {"j", "1"}, {"width", "4"}, {"seed", "1"}, {"g", "0.1"}},
       .dt = "0.1",
       .time = "200",
       .samples = 1000,
       .start = one_site,
       .measure = localisation},
      {.name = "dnls",
       .about = "one site of a nonlinear chain: self-trapping, a discrete breather is left",
       .units = {"1/J"},
       .effects = {"on_site", "hopping"},
       .also = {"disorder"},
       .values =
           {{"sites", "101"}, {"mass", "1"}, {"j", "1"}, {"g", "4.5"}, {"width", "0.01"}, {"seed", "1"}},
       .dt = "0.05",
       .time = "50",
       .samples = 1000,
       .start = one_site,
       .measure = trapping}};
}

/// |ψ|² of each site over time.
View<any> view(const Choice& c) {
  View<any> view;
  // All densities as one point in the plane, whose way tells whether rows are farther apart than beats.
  view.paths = 1;
  view.fastest = fastest_beats(c);
  for (Eigen::Index i = 0; i < sites(c); ++i) view.columns.push_back("density" + std::to_string(i));
  view.append = [](const Half& q, const Half& p, auto& row, auto& paths) {
    double x = 0, y = 0;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const double density = q[i] * q[i] + p[i] * p[i], angle = static_cast<double>(i);
      row.push_back(density);
      x += density * std::cos(angle);
      y += density * std::sin(angle);
    }
    paths[0].see(x, y);
  };
  view.plot = [n = sites(c), mass = c.has("mass") ? c["mass"] : 1, unit = c.units.name(1)](
                  const auto& csv, const auto& paths) {
    if (n == 1)  // an image wants two rows of them
      return "stats " + quoted(csv.string()) +
             " skip 1 using 1 nooutput\nset xrange [0:STATS_max > 0 ? STATS_max : 1]\nset key off\n" +
             "set xlabel " + quoted(in("time", unit)) + "\nset ylabel '|ψ|²'\nset yrange [0:*]\nplot " +
             quoted(csv.string()) +
             " skip 1 using 1:2 with lines linewidth 1.5 linecolor rgb '#0072B2'\nset autoscale\n";
    // Rows are evenly spaced, but for the last one, which is left out where it is not.
    const std::string word =
        paths[0].hides_motion()
            ? label_above("the rows are farther apart than beats: what looks slow may be fast")
            : "";
    return word + "stats " + quoted(csv.string()) +
           " skip 1 using 1 nooutput\nend = STATS_max\nlast = STATS_records - 1\n" + "stats " +
           quoted(csv.string()) + " skip 1 using 1 every ::::1 nooutput\nspacing = STATS_max\n" +
           "if (last * spacing > end * (1 + 1e-9)) last = last - 1\n" + "set key off\nset xlabel " +
           quoted(in("time", unit)) +
           "\nset ylabel 'site'\nset cblabel '|ψ|²'\nset rmargin at screen "
           "0.86\n"
           "set logscale cb\nset format cb '10^{%T}'\n" +
           formatted("set cbrange [%g:*]\n", std::max(1e-6 * mass, 1e-300)) +
           "set palette defined (0 '#000020', 1 '#08519c', 2 '#6baed6', 3 '#fee391', 4 '#ffffe5')\n"
           "set yrange [-0.5:" +
           std::to_string(n) +
           " - 0.5]\nset xrange [0:end > 0 ? end : 1]\nif (last < 1) { plot NaN } else { plot " +
           quoted(csv.string()) +
           " skip 1 matrix every 1:1:1:0::last using ($2 * spacing):($1 - 1):3 with image }\n"
           "unset colorbox\nset autoscale\n";
  };
  return view;
}

}  // namespace

int main(int argc, char** argv) {
  SceneProgram<any> program{.name = "lattice", .about = "A chain of sites with the effects that you choose."};
  program.parameters = {
      {"sites",
       "",
       "how many",
       {"a whole number from 1 to 10000000",
        [](double x) { return 1 <= x && x <= 1e7 && x == std::floor(x); }}},
      {"mass", "", "Σ|ψ|² at the start, on the middle site", above_zero},
      {"g", "", "strength of the nonlinearity"},
      {"k", "", "strength of the quartic coupling"},
      {"j", "", "rate of hopping, J"},
      {"width", "", "of the range of the random energies, W", not_negative},
      {"seed", "", "of the random energies", {"a whole number from 0 to 2^53", [](double x) {
                                                return 0 <= x && x <= 0x1p53 && x == std::floor(x);
                                              }}}};
  program.effects = all_effects();
  program.presets = presets();
  program.view = view;
  program.compare = Compare::state;
  program.add_invariants = [](Invariants<double, any>& invariants, const Choice&) {
    invariants.add("mass", [](const Half& q, const Half& p) { return systems::NlsLattice<>::mass(q, p); });
  };
  return run_scene_program(program, argc, argv);
}
