#pragma once

// Needs the headers of Boost (Debian, Ubuntu: apt-get install libboost-dev), so semiexplicit.hpp does not
// include it.

#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <boost/numeric/odeint/stepper/stepper_categories.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/integrate.hpp>

namespace semiexplicit {

/// What an OdeintStepper takes for odeint's `system` argument: nothing, since the Hamiltonian is in the
/// stepper.
struct OdeintSystem {};

/// A stepper of this library as a stepper of Boost.odeint (its concept "Stepper"), for programs that
/// integrate with odeint:
///
///     OdeintStepper stepper(Semiexplicit(H, schemes::low_defect6_s13()));
///     boost::numeric::odeint::integrate_const(stepper, stepper.system(), x, 0.0, 100.0, 0.1, observer);
///
/// The `system` of odeint's functions is stepper.system(); the right-hand side is that of the H which the
/// stepper was made of, and anything else in that place does not compile. The state x is a PhasePoint, or 2d
/// numbers with positions first (std::vector, std::array, an Eigen column), or the pair of q and p that
/// odeint's own symplectic steppers take. (Pihajoki and Tao, which move two copies, have no place here, and
/// no stepper that ChoosesSteps, whose dt is no time.)
///
/// A step that fails throws IntegrationError and leaves x as it was; a state of another size than H throws
/// std::invalid_argument. odeint copies the stepper it is given, unless it gets std::ref(stepper). The step
/// is fixed: odeint's controlled steppers would break what a symplectic method is for.
///
/// Source: K. Ahnert, M. Mulansky, AIP Conf. Proc. 1389 (2011) 1586; odeint's documentation, "Concepts:
/// Stepper".
template <Stepper S>
requires std::same_as<typename S::State, PhasePoint<typename S::Scalar, S::Dof>>
class OdeintStepper {
  static_assert(detail::is_stepper<S>());
  static_assert(!ChoosesSteps<S>,
                "odeint's dt is a time, and this stepper chooses the times of its steps: "
                "take its inner stepper, or integrate()");

 public:
  using state_type = typename S::State;
  using deriv_type = state_type;
  using value_type = typename S::Scalar;
  using time_type = typename S::Scalar;
  using order_type = unsigned short;
  using stepper_category = boost::numeric::odeint::stepper_tag;

  explicit OdeintStepper(S stepper) : stepper_(std::move(stepper)), state_(stepper_.dof()) {}

  static OdeintSystem system() { return {}; }

  /// The order of the scheme, or of the Gauss method.
  order_type order() const {
    if constexpr (requires { stepper_.scheme().order; })
      return static_cast<order_type>(stepper_.scheme().order);
    else
      return static_cast<order_type>(2 * stepper_.options().stages);
  }

  /// One step of size dt. `t` is for the message where it fails.
  template <class System, class State>
  void do_step(const System&, State& x, const time_type& t, const time_type& dt) {
    static_assert(std::same_as<System, OdeintSystem>,
                  "the Hamiltonian is in the stepper: give odeint stepper.system() for its system");
    if constexpr (std::same_as<State, state_type>) {
      require_size(x.vector().size(), state_.vector().size());
      step(x, t, dt);
    } else if constexpr (requires {
                           x.first;
                           x.second;
                         }) {
      copy(x.first, state_.q());
      copy(x.second, state_.p());
      step(state_, t, dt);
      copy_back(state_.q(), x.first);
      copy_back(state_.p(), x.second);
    } else {
      copy(x, state_.vector());
      step(state_, t, dt);
      copy_back(state_.vector(), x);
    }
  }

  const S& stepper() const { return stepper_; }

 private:
  void step(state_type& z, const time_type& t, const time_type& dt) {
    const StepReport report = stepper_.step(z, dt);
    if (!report.ok())
      throw IntegrationError({.status = report.status,
                              .t = static_cast<double>(t),
                              .dt = static_cast<double>(dt),
                              .steps = steps_,
                              .evaluations = report.evaluations,
                              .gradients = report.gradients,
                              .last = report},
                             static_cast<double>(dt));
    ++steps_;
  }

  static void require_size(Eigen::Index state, Eigen::Index own) {
    if (state != own)
      throw std::invalid_argument("OdeintStepper: the state has " + std::to_string(state) +
                                  " numbers where the Hamiltonian has " + std::to_string(own));
  }
  template <class From, class To>
  static void copy(const From& from, To&& to) {
    static_assert(!detail::is_narrower<std::remove_cvref_t<decltype(*from.begin())>, value_type>,
                  "the state is of whole numbers, or ones of fewer digits than the stepper's, to which each "
                  "step would be rounded: give one of the stepper's Scalar, as std::vector<double>");
    require_size(static_cast<Eigen::Index>(from.size()), to.size());
    auto source = from.begin();
    for (Eigen::Index i = 0; i < to.size(); ++i, ++source) to[i] = *source;
  }
  template <class From, class To>
  static void copy_back(const From& from, To& to) {
    auto target = to.begin();
    for (Eigen::Index i = 0; i < from.size(); ++i, ++target) *target = from[i];
  }

  S stepper_;
  state_type state_;
  std::int64_t steps_ = 0;
};

}  // namespace semiexplicit
