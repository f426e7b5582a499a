#pragma once

#include <string>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/words.hpp>
#include <semiexplicit/scene/advised_flow.hpp>
#include <semiexplicit/scene/scene.hpp>
#include <semiexplicit/scene/split_scene.hpp>
#include <semiexplicit/steppers/explicit_splitting.hpp>
#include <semiexplicit/steppers/flow_splitting.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit {

namespace detail {

/// Lists effects: a + b, and with a state their sizes.
template <class H, class State>
class EffectWords {
 public:
  EffectWords(const H& whole, const State* z) : whole_(whole), z_(z) {}
  template <class E>
  void add(const E& effect, bool with_size = true) {
    text_ += (text_.empty() ? "" : " + ") + effect_name(effect);
    if (!z_ || !with_size) return;
    const double size = size_of_effect(effect, whole_, *z_);
    if (size == size) text_ += ", " + in_words(size, 2) + " of the gradient";
  }
  const std::string& text() const { return text_; }

 private:
  const H& whole_;
  const State* z_;
  std::string text_;
};

/// "; not symplectic: drag adds a force of its own", or nothing.
template <class S>
std::string motion_in_words(const S& scene) {
  std::string names;
  int count = 0;
  scene.for_each([&]<class E>(const E& effect) {
    if constexpr (MotionEffect<E>) {
      names += (names.empty() ? "" : " + ") + effect_name(effect);
      ++count;
    }
  });
  if (count == 0) return "";
  return "; not symplectic: " + names +
         (count == 1 ? " adds a force of its own" : " add forces of their own");
}

inline std::string calls_in_words(std::int64_t n) {
  return std::to_string(n) + " gradient call" + (n == 1 ? "" : "s");
}

template <class H, class Solver>
SEMIEXPLICIT_COLD std::string explained(const FlowSplitting<H, Solver>& stepper,
                                        const typename FlowSplitting<H, Solver>::State* z) {
  using Stepper = FlowSplitting<H, Solver>;
  const H& split = stepper.hamiltonian();
  std::string text = "exact: " + split.flow_name();
  if constexpr (requires { split.scene(); }) {
    if (z) require_same_dof("explain", z->dof(), "scene", split.scene().dof());
    EffectWords<typename H::Whole, typename Stepper::State> kicked(split.scene(), z),
        doubled(split.scene(), z);
    split.for_each_of_rest([&]<class E>(const E& effect) {
      if constexpr (couples<E>)
        doubled.add(effect);
      else
        kicked.add(effect);
    });
    if (!kicked.text().empty()) text += "; kicked: " + kicked.text();
    text += doubled.text().empty() ? "; nothing doubled" : "; doubled: " + doubled.text();
  } else {
    if constexpr (Stepper::has_position || Stepper::has_momentum) text += "; the rest on q or p alone kicked";
    text += Stepper::has_coupled ? "; the coupled rest doubled" : "; nothing doubled";
  }
  if constexpr (Stepper::has_position || Stepper::has_momentum || Stepper::has_coupled) {
    text += "; " + stepper.list().name + " of order " + stepper.list().order_in_words() + ", " +
            std::to_string(stepper.list().b.size()) + " kicks a step";
    if constexpr (Stepper::has_coupled)
      text += ", " + calls_in_words(stepper.gradients_of_kick()) + " a kick";
    else
      text += ", " + calls_in_words(stepper.max_gradients()) + " a step";
  }
  if constexpr (requires { split.scene(); }) {
    if constexpr (!Stepper::kicks_exactly && !H::rest_is_small)
      text += "; of order 2 in all, as the kicks are, of several parts or doubled";
    text += motion_in_words(split.scene());
  }
  return text;
}

}  // namespace detail

/// In words, what a stepper does to each effect of its scene, and what that costs:
///
///     exact: kinetic + attraction (Kepler); doubled: 1pn, 1.2e-07 of the gradient; aba82 of order (8,2), ...
///
/// The sizes stand there where a state is given, explain(stepper, z): the effect's part of ∂H/∂q or of ∂H/∂p
/// at z, the larger one. Where there is no gradient, as at the centre of an attraction, there are none.
/// Throws std::invalid_argument for a state of another size.
template <class H, class Solver>
std::string explain(const FlowSplitting<H, Solver>& stepper) {
  return detail::explained(stepper, nullptr);
}
template <class H, class Solver>
std::string explain(const FlowSplitting<H, Solver>& stepper,
                    const typename FlowSplitting<H, Solver>::State& z) {
  return detail::explained(stepper, &z);
}

/// For the steppers that stepper_for(scene) gives: why all effects are doubled, or none.
template <class... Effects, class Solver>
SEMIEXPLICIT_COLD std::string explain(const Semiexplicit<Scene<Effects...>, Solver>& stepper) {
  using State = typename Semiexplicit<Scene<Effects...>, Solver>::State;
  detail::EffectWords<Scene<Effects...>, State> all(stepper.hamiltonian(), nullptr), why = all;
  stepper.hamiltonian().for_each([&]<class E>(const E& effect) {
    all.add(effect);
    if constexpr (detail::couples<E>) why.add(effect);
  });
  constexpr int coupled = (int(detail::couples<Effects>) + ...);
  const std::string verb = coupled == 1 ? " couples q and p" : " couple q and p";
  return "doubled: " + all.text() +
         (coupled == 0 ? ", though nothing couples q and p" : ", because " + why.text() + verb) + "; " +
         stepper.scheme().name + " of order " + std::to_string(stepper.scheme().order) + ", " +
         detail::calls_in_words(static_cast<std::int64_t>(stepper.scheme().kicks())) + " an evaluation" +
         detail::motion_in_words(stepper.hamiltonian());
}
template <class... Effects>
SEMIEXPLICIT_COLD std::string explain(const ExplicitSplitting<Scene<Effects...>>& stepper) {
  using State = typename ExplicitSplitting<Scene<Effects...>>::State;
  detail::EffectWords<Scene<Effects...>, State> all(stepper.hamiltonian(), nullptr);
  stepper.hamiltonian().for_each([&](const auto& effect) { all.add(effect); });
  return "drifts and kicks: " + all.text() + "; nothing doubled, because nothing couples q and p; " +
         stepper.scheme().name + " of order " + std::to_string(stepper.scheme().order) + ", " +
         detail::calls_in_words(stepper.max_gradients()) + " a step";
}

}  // namespace semiexplicit
