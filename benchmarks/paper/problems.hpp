#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/systems.hpp>

#include "as_published.hpp"

namespace paper {

/// A function of (q, p) that the exact flow keeps, with the letter the figures give it.
template <int Dof>
struct Invariant {
  std::string name;
  std::function<double(const In<double, Dof>&, const In<double, Dof>&)> value;
};

/// A test problem: Hamiltonian, initial state, invariants, and Tao's ω.
template <class H>
struct Problem {
  H hamiltonian;
  PhasePoint<double, H::Dof> start;
  std::vector<Invariant<H::Dof>> invariants;
  double omega;
};

inline auto product_problem() {
  using H = systems::Product<double>;
  const H hamiltonian;
  return Problem<H>{hamiltonian,
                    PhasePoint<double, 1>(-3, 0),
                    {{"H", [=](const auto& q, const auto& p) { return hamiltonian.energy(q, p); }}},
                    20};
}

inline auto nls_problem() {
  using H = systems::NlsLattice<double, 5>;
  const H hamiltonian;
  return Problem<H>{hamiltonian,
                    PhasePoint<double, 5>({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}),
                    {{"H", [=](const auto& q, const auto& p) { return hamiltonian.energy(q, p); }},
                     {"I", [](const auto& q, const auto& p) { return H::mass(q, p); }}},
                    100};
}

using Ten = Vector<double, 10>;

/// `wrap` makes the Hamiltonian of the runs from the physical one.
template <class Wrap>
auto vortex_problem(const Ten& circulations, const Ten& x, const Ten& y, const Wrap& wrap) {
  const systems::PointVortices<double, 10> vortices(circulations);
  const auto hamiltonian = wrap(vortices);
  using H = std::remove_const_t<decltype(hamiltonian)>;
  return Problem<H>{hamiltonian,
                    vortices.phase_point(x, y),
                    {{"H", [=](const auto& q, const auto& p) { return hamiltonian.energy(q, p); }},
                     {"Q", [=](const auto& q, const auto& p) { return vortices.linear_impulse_x(q, p); }},
                     {"P", [=](const auto& q, const auto& p) { return vortices.linear_impulse_y(q, p); }},
                     {"I", [=](const auto& q, const auto& p) { return vortices.angular_impulse(q, p); }}},
                    7};
}

template <class Wrap>
auto vortices_problem(const Wrap& wrap) {
  return vortex_problem(Ten{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6},
                        Ten{3, -10, 6, 9, 0, 7, -8, 5, 9, 7}, Ten{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}, wrap);
}

template <class Wrap>
auto disparate_vortices_problem(const Wrap& wrap) {
  return vortex_problem(Ten{-14.8, -18.8, 17.6, -8, -8.2, -6.8, -1.4, 6, -11, 13.8},
                        Ten{.5, 3.5, -1.5, -.5, -4.5, -3.5, 1.5, -2, 4, -4},
                        Ten{5, .5, 2, 5, -2, -1, -.5, 3, 3.5, -4}, wrap);
}

/// Calls use(problem) with the problem of that name.
template <class Use>
void with_problem(const std::string& name, bool as_published, const Use& use) {
  const auto physical = [](const auto& vortices) { return vortices; };
  const auto once = [](const auto& vortices) { return PairsOnce(vortices); };
  if (name == "product")
    use(product_problem());
  else if (name == "nls")
    use(nls_problem());
  else if (name == "vortices" && as_published)
    use(vortices_problem(once));
  else if (name == "vortices")
    use(vortices_problem(physical));
  else if (name == "disparate vortices" && as_published)
    use(disparate_vortices_problem(once));
  else if (name == "disparate vortices")
    use(disparate_vortices_problem(physical));
  else
    throw std::invalid_argument("there is no problem called " + name);
}

/// The invariants' letters, in the order of the figures.
inline std::vector<std::string> invariant_names(const std::string& problem) {
  std::vector<std::string> names;
  with_problem(problem, false, [&](const auto& p) {
    for (const auto& invariant : p.invariants) names.push_back(invariant.name);
  });
  return names;
}

}  // namespace paper
