#pragma once

#include <utility>

#include <semiexplicit/observers/events.hpp>

namespace semiexplicit {

/// What poincare_section() may be told.
struct PoincareSectionOptions {
  CrossingDirection direction = CrossingDirection::rising;
  int nodes = 4;  ///< states that the interpolation goes through; see DenseOutput
};

/// Hands on the points where an orbit crosses a surface: events() of one kind that changes nothing; see
/// poincare_section().
template <class H, class Surface, class Observer>
class PoincareSection : public Events<H, OnEvent<Surface, Observer>> {
  using Base = Events<H, OnEvent<Surface, Observer>>;
  static_assert(
      !Base::changes_state,
      "the observer of a section does not change the state: take it by const reference, or use events()");

 public:
  static constexpr const char* name = "poincare_section";

  PoincareSection(H hamiltonian, Surface surface, Observer&& observer, PoincareSectionOptions options)
      : Base(std::move(hamiltonian), options.nodes,
             OnEvent<Surface, Observer>{std::move(surface), std::forward<Observer>(observer),
                                        options.direction}) {}
};

/// A Poincaré section: an observer that calls another one, (t, z), with every point where the orbit crosses
/// the surface s(q, p) = 0, found to rounding on the interpolation between the steps (see DenseOutput).
///
///     auto section = poincare_section(H, [](const auto& q, const auto& p) { return q[0]; },
///                                     [](double t, const auto& z) { ... });
///     integrate(stepper, z, {.dt = 0.1, .steps = 100'000}, section);
///
/// s is to be continuous, and the steps so small that it changes its sign once in each: of an angle take
/// sin(q), not q modulo 2π; NaN throws std::invalid_argument. A start on the surface is no crossing, nor is a
/// state that only touches it, nor a jump over it by an action of events(), which says what counts where the
/// state is changed on the surface itself. Of an extended Hamiltonian s has the extended q and p, so that the
/// time is the last q, and the observer gets the time and the phase point without it. An observer that
/// returns false ends the run. Call finish() at the end: the last ones wait for it where fewer than
/// nodes - 1 steps were taken from the start, or from the last event that changed the state. A named observer
/// is referred to, a temporary is kept.
///
/// Points and times are as accurate as the run and the interpolation: on an orbit of systems::Product with 80
/// steps a period the times are found to 1e-10 with four nodes and to 1e-12 with six. With steps that do not
/// resolve the motion, as those of exact flows may be, they are far worse than the run: interpolation_error()
/// tells. If it is too large, shorten the steps.
template <class H, class Surface, class Observer>
PoincareSection<H, Surface, Observer> poincare_section(H hamiltonian, Surface surface, Observer&& observer,
                                                       PoincareSectionOptions options = {}) {
  return {std::move(hamiltonian), std::move(surface), std::forward<Observer>(observer), options};
}

}  // namespace semiexplicit
