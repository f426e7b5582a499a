#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <ostream>
#include <random>
#include <utility>

#include <Eigen/Eigenvalues>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/output.hpp"
#include "../common/scene_choice.hpp"

namespace examples {

inline Eigen::Index sites(const Choice& c) { return static_cast<Eigen::Index>(c["sites"]); }

/// Independent energies, uniform from -W/2 to W/2; the same everywhere for a seed.
inline Eigen::VectorXd energies(const Choice& c) {
  std::mt19937_64 random(static_cast<std::uint64_t>(c["seed"]));
  Eigen::VectorXd list(sites(c));
  for (double& energy : list)
    energy = c["width"] * (std::ldexp(static_cast<double>(random() >> 11), -53) - 0.5);
  return list;
}

/// All on the middle site.
inline PhasePoint<double, Eigen::Dynamic> one_site(const Choice& c) {
  PhasePoint<double, Eigen::Dynamic> z(sites(c));
  z.q()[sites(c) / 2] = std::sqrt(c["mass"]);
  return z;
}

inline Eigen::VectorXd density(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) {
  return q.cwiseAbs2() + p.cwiseAbs2();
}

/// How many sites share the mass: (Σ|ψ|²)²/Σ|ψ|⁴.
inline double participation(const Eigen::VectorXd& density) {
  const Eigen::VectorXd scaled = density / density.maxCoeff();  // small ones must not underflow
  return scaled.sum() * scaled.sum() / scaled.squaredNorm();
}

/// The densities at t where nothing but hopping and disorder acts: the eigenvectors of the chain turn at
/// their energies.
inline Eigen::VectorXd by_eigenvectors(const Choice& c, double t) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(sites(c), sites(c));
  if (c.on("disorder")) matrix.diagonal() = energies(c);
  if (c.on("hopping")) matrix.diagonal(1).setConstant(-c["j"]), matrix.diagonal(-1).setConstant(-c["j"]);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(matrix);
  const Eigen::VectorXcd turned = (std::complex<double>(0, -t) * solved.eigenvalues()).array().exp();
  const Eigen::VectorXd start = solved.eigenvectors().transpose() * one_site(c).q();
  return (solved.eigenvectors() * turned.cwiseProduct(start)).cwiseAbs2();
}

inline Measurement<Eigen::Dynamic> localisation(const Choice& c) {
  struct Seen {
    double t = 0;
    Eigen::VectorXd last;
    void visit_memory(CheckpointMemory& visit) {
      visit(t);
      visit(last);
    }
  };
  const auto seen = std::make_shared<Seen>();
  seen->last.setZero(sites(c));
  const auto figure = [=]() -> Figure {
    return {.name = "participation number at the end",
            .value = participation(seen->last),
            .beside = "of " + std::to_string(sites(c)) + (sites(c) == 1 ? " site" : " sites")};
  };
  return {[=](double t, const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) {
            seen->t = t;
            seen->last = density(q, p);
          },
          memory_of(seen), [=](const Run&) -> std::vector<Figure> { return {figure()}; },
          [=](std::ostream& out, const Run& run) {
            Figure compared = figure();
            if (!c.on("on_site") && !c.on("pair_exchange") && sites(c) <= 1000) {
              const Eigen::VectorXd exact = by_eigenvectors(c, seen->t);
              compared.beside +=
                  formatted("; largest difference of a density from the eigenvectors of the chain: %.1e",
                            (seen->last - exact).cwiseAbs().maxCoeff()) +
                  "; by these";
              compared.expected = participation(exact);
            }
            print_figure(out, compared, run);
          }};
}

/// Radians a unit of time of the fastest beats of the densities, which a step as long as one would not show:
/// by the width of the band, and by what the energies of sites differ by.
inline double fastest_beats(const Choice& c) {
  return (c.on("hopping") ? (sites(c) > 2 ? 4 : 2) * std::abs(c["j"]) : 0) +
         (c.on("disorder") ? c["width"] : 0) +
         (c.on("on_site") && c.has("mass") ? std::abs(c["g"]) * c["mass"] : 0);
}

/// Does the mass stay where it starts? On two sites the least that is left there is known: M. Kenkre and D.
/// Campbell, Phys. Rev. B 34 (1986) 4959. Of the long chain the threshold is a measured one (in the mean to t
/// = 150, on 401 sites, 0.04 are left at 3.6, and 0.15 at 3.8); 3.2 is that of one nonlinear site in a linear
/// chain (M. Molina and G. Tsironis, Physica D 65 (1993) 267).
inline Measurement<Eigen::Dynamic> trapping(const Choice& c) {
  struct Seen {
    Largest below;  // of -share
    // The integral by trapezoids, and up to the last even step by those, and by half as many; by how much the
    // share bends at the end.
    double sum = 0, even = 0, coarse = 0, last_even = 1;
    double steps = -1, last = 1, last_change = 0, bend = 0, change = 0;
    void visit_memory(CheckpointMemory& visit) {
      below.visit_memory(visit);
      for (double* number : {&sum, &even, &coarse, &last_even, &steps, &last, &last_change, &bend, &change})
        visit(*number);
    }
  };
  const auto seen = std::make_shared<Seen>();
  const Eigen::Index middle = sites(c) / 2;
  const double mass = c["mass"];
  // Both references are for on_site and hopping alone.
  const double strength = c.only({"on_site", "hopping"}) ? c["g"] * mass / c["j"] : NAN;
  return {[=](double, const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) {
            const double share = (q[middle] * q[middle] + p[middle] * p[middle]) / mass;
            seen->below.see(-share);
            if (++seen->steps > 0) seen->sum += (seen->last + share) / 2;
            if (std::fmod(seen->steps, 2) == 0) {
              if (seen->steps > 0) seen->coarse += seen->last_even + share;
              seen->even = seen->sum;
              seen->last_even = share;
            }
            const double change = share - seen->last;
            seen->change = std::max(seen->change, std::abs(change));
            seen->bend = std::abs(change - std::exchange(seen->last_change, change));
            seen->last = share;
          },
          memory_of(seen),
          [=, n = sites(c)](const Run& run) -> std::vector<Figure> {
            const std::string what = "left on the site of the start, ";
            if (const std::string coarse = too_coarse(fastest_beats(c) * run.report.dt, most_in_a_step);
                !coarse.empty())
              return {not_measured(what + "at least", coarse)};
            if (seen->change > 0.1)
              return {not_measured(what + "at least",
                                   "it changes by more than a tenth in a step; give a smaller --dt")};
            Figure least{what + "at least", -seen->below.value(), seen->below.uncertain()},
                mean{what + "in the mean", seen->sum / seen->steps,
                     (std::abs(seen->coarse - seen->even) + seen->bend / 6) / seen->steps};
            if (std::isfinite(strength)) {
              least.beside = formatted("g|ψ|²/J = %g", strength);
              // Nearer to the separatrix than the energy is kept, a run may be on either side of it.
              const bool on_separatrix =
                  std::abs(std::abs(strength) / 4 - 1) <= 4 * run.quantities.front().worst;
              if (n == 2 && on_separatrix) {
                least.missing = mean.missing =
                    least.beside +
                    " is the threshold, where rounding decides whether the mass stays; give another --g";
              } else if (n == 2 && -seen->below.value() == seen->last) {
                least.beside += "; still falling at the end: no closed form for that, give more --time";
              } else if (n == 2) {
                least.beside += "; in closed form";
                least.expected =
                    std::abs(strength) >= 4 ? (1 + std::sqrt(1 - 16 / (strength * strength))) / 2 : 0;
              } else if (n >= 20) {
                least.beside += ", self-trapping in a long chain from about 3.7 on";
              }
            }
            return {least, mean};
          }};
}

}  // namespace examples
