#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <ostream>
#include <random>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <semiexplicit/semiexplicit.hpp>

#include "scene_choice.hpp"
#include "table.hpp"

namespace examples {

inline Eigen::Index sites(const Choice& c) {
  const double n = c["sites"];
  if (!(n >= 1 && n <= 1e7) || n != std::floor(n))
    throw std::invalid_argument("--sites: give a whole number from 1 to 10000000");
  return static_cast<Eigen::Index>(n);
}

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

inline Eigen::VectorXd density(const HalfRef<Eigen::Dynamic>& q, const HalfRef<Eigen::Dynamic>& p) {
  return q.cwiseAbs2() + p.cwiseAbs2();
}

/// How many sites share the mass: (Σ|ψ|²)²/Σ|ψ|⁴.
inline double participation(const Eigen::VectorXd& density) {
  return density.sum() * density.sum() / density.squaredNorm();
}

/// The densities at t where nothing but hopping and disorder acts: the eigenvectors of the chain turn at their energies.
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
  return {[=](double t, const HalfRef<Eigen::Dynamic>& q, const HalfRef<Eigen::Dynamic>& p) {
            seen->t = t;
            seen->last = density(q, p);
          },
          [=](std::ostream& out) {
            out << "participation number at the end: " << formatted("%.4f", participation(seen->last))
                << " of " << sites(c) << " sites\n";
            if (c.on("on_site") || c.on("pair_exchange") || sites(c) > 1000) return;
            const Eigen::VectorXd exact = by_eigenvectors(c, seen->t);
            out << "by the eigenvectors of the chain: " << formatted("%.4f", participation(exact))
                << formatted("; largest difference of a density: %.1e\n",
                             (seen->last - exact).cwiseAbs().maxCoeff());
          },
          memory_of(seen)};
}

/// Does the mass stay where it starts? On two sites the least that is left there is known: M. Kenkre and D. Campbell, Phys.
/// Rev. B 34 (1986) 4959; the threshold of the long chain: M. Molina and G. Tsironis, Physica D 65 (1993) 267.
inline Measurement<Eigen::Dynamic> trapping(const Choice& c) {
  struct Seen {
    double least = 1, sum = 0, count = 0;
    void visit_memory(CheckpointMemory& visit) {
      for (double* number : {&least, &sum, &count}) visit(*number);
    }
  };
  const auto seen = std::make_shared<Seen>();
  const Eigen::Index middle = sites(c) / 2;
  const double mass = c["mass"], strength = c["g"] * mass / c["j"];
  return {[=](double, const HalfRef<Eigen::Dynamic>& q, const HalfRef<Eigen::Dynamic>& p) {
            const double share = (q[middle] * q[middle] + p[middle] * p[middle]) / mass;
            seen->least = std::min(seen->least, share);
            seen->sum += share;
            ++seen->count;
          },
          [=, two = sites(c) == 2](std::ostream& out) {
            out << "left on the site of the start: " << formatted("%.6f at least, ", seen->least)
                << formatted("%.6f in the mean", seen->sum / seen->count) << "; g|ψ|²/J = " << strength;
            if (two)
              out << "; in closed form, at least "
                  << formatted("%.6f\n",
                               strength > 4 ? (1 + std::sqrt(1 - 16 / (strength * strength))) / 2 : 0.0);
            else
              out << ", self-trapping in a long chain from 3.2 on\n";
          },
          memory_of(seen)};
}

}  // namespace examples
