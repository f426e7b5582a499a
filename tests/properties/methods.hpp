#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>

/// The methods that every property is tested on. A new scheme, solver or stepper is entered here, once.
namespace methods {

using namespace semiexplicit;

/// What is claimed of a method.
struct Claim {
  std::string name;
  int order = 0;
  bool symplectic = false;  ///< in the phase space itself, not only in the doubled one
  bool symmetric = false;   ///< a step back undoes a step
};

/// Which methods, and how exactly equations are solved.
struct Choice {
  std::vector<std::string> schemes{
      "strang",        "mclachlan2",      "triple_jump4",        "blanes_moan4",
      "yoshida6",      "blanes_moan6",    "low_defect4_s11",     "low_defect6_s13",
      "suzuki_umeno8", "low_defect8_s20", "sofroniou_spaletta10"};
  std::vector<std::string> tao_schemes{"strang", "triple_jump4", "suzuki4", "yoshida6", "suzuki_umeno8"};
  int most_stages = 8;
  double omega = 5;
  StoppingRule stop = StoppingRule::paper(0);  ///< nothing is below zero: until rounding stops the iteration
};

/// A stepper whose type is hidden: what is done with every method is then compiled once.
template <class State_>
class AnyMethod {
 public:
  using State = State_;
  using Scalar = typename State::Scalar;

  template <class S>
  requires std::same_as<typename S::State, State>
  explicit AnyMethod(S stepper) : held_(std::make_unique<Held<S>>(std::move(stepper))) {}
  AnyMethod(const AnyMethod& other) : held_(other.held_->copy()) {}
  AnyMethod& operator=(const AnyMethod& other) {
    held_ = other.held_->copy();
    return *this;
  }

  StepReport step(State& state, const Scalar& dt) { return held_->step(state, dt); }

 private:
  struct Method {
    virtual ~Method() = default;
    virtual StepReport step(State& state, const Scalar& dt) = 0;
    virtual std::unique_ptr<Method> copy() const = 0;
  };
  template <class S>
  struct Held : Method {
    explicit Held(S s) : stepper(std::move(s)) {}
    StepReport step(State& state, const Scalar& dt) override { return stepper.step(state, dt); }
    std::unique_ptr<Method> copy() const override { return std::make_unique<Held>(stepper); }
    S stepper;
  };
  std::unique_ptr<Method> held_;
};
template <class S>
AnyMethod(S) -> AnyMethod<typename S::State>;

/// Calls test(claim, stepper) for the methods of the phase space itself.
template <Hamiltonian H, class Test>
void for_each_of_phase_space(const H& h, const Choice& choice, Test test) {
  using Scalar = typename H::Scalar;
  for (const std::string& name : choice.schemes) {
    const Scheme<Scalar> s = schemes::by_name<Scalar>(name);
    test(Claim{"semiexplicit, simplified Newton, " + name, s.order, true, true},
         AnyMethod(Semiexplicit(h, s, SimplifiedNewton{.stop = choice.stop})));
    test(Claim{"semiexplicit, Broyden, " + name, s.order, true, true},
         AnyMethod(Semiexplicit(h, s, Broyden{.stop = choice.stop})));
    test(Claim{"semiexplicit, Newton-Krylov, " + name, s.order, true, true},
         AnyMethod(Semiexplicit(h, s, NewtonKrylov{.stop = choice.stop})));
    test(Claim{"midpoint projection, " + name, s.order, false, false}, AnyMethod(MidpointProjection(h, s)));
  }
  for (int stages = 1; stages <= choice.most_stages; ++stages) {
    const std::string gauss = "Gauss, " + std::to_string(stages) + " stages, ";
    test(Claim{gauss + "fixed point", 2 * stages, true, true},
         AnyMethod(GaussLegendre(h, {.stages = stages})));
    test(Claim{gauss + "Newton", 2 * stages, true, true},
         AnyMethod(GaussLegendre(h, {.stages = stages, .solver = StageSolver::newton})));
    if constexpr (HasPackGradient<H>)
      test(Claim{gauss + "in lanes", 2 * stages, true, true},
           AnyMethod(GaussLegendreLanes(h, {.stages = stages})));
  }
}

/// Calls test(claim, stepper) for the methods of the doubled space.
template <Hamiltonian H, class Test>
void for_each_of_doubled_space(const H& h, const Choice& choice, Test test) {
  using Scalar = typename H::Scalar;
  for (const std::string& name : choice.schemes) {
    const Scheme<Scalar> s = schemes::by_name<Scalar>(name);
    test(Claim{"Pihajoki, " + name, s.explicit_order, false, true}, AnyMethod(Pihajoki(h, s)));
  }
  for (const std::string& name : choice.tao_schemes) {
    const Scheme<Scalar> s = schemes::by_name<Scalar>(name);
    test(Claim{"Tao, " + name, s.order, false, true}, AnyMethod(Tao(h, s, Scalar(choice.omega))));
  }
}

/// Calls test(claim, stepper) for every method.
template <Hamiltonian H, class Test>
void for_each(const H& h, const Choice& choice, const Test& test) {
  for_each_of_phase_space(h, choice, test);
  for_each_of_doubled_space(h, choice, test);
}

/// The choice of every named scheme.
inline Choice every_scheme() {
  Choice all;
  all.schemes = schemes::names();
  all.tao_schemes.clear();
  for (const std::string& name : all.schemes)
    for (const char* family :
         {"strang", "triple_jump", "suzuki", "yoshida", "kahan_li", "sofroniou_spaletta"})
      if (name.starts_with(family)) {
        all.tao_schemes.push_back(name);
        break;
      }
  return all;
}

}  // namespace methods
