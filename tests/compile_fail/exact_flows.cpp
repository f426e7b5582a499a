// case no_mistake: compiles
// case not_there: exactly<...>() names an effect that the scene does not have
// case without_flow: these effects have no exact flow together: specialise semiexplicit::ExactFlow
// case twice_there: exactly<...>() names an effect that is there more than once
// case nothing_named: exactly<...>() names the effects that have an exact flow together
// case without_increments: this ExactFlow has no `Status increments
// case increments_by_value: take dq or dp by value, so that nothing moves: write `auto& dq, auto& dp`
// case template_by_value: take dq or dp by value, so that nothing moves: write `auto& dq, auto& dp`
// case prepared_by_value: takes an output by value, so what it writes is lost: take it as `auto& dq`
// case prepared_not_const_by_value: takes an output by value, so what it writes is lost: take it as `auto& dq`
// case whole_time: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case prepared_of_whole_time: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case stale_prepared: has increments() of its own and inherits prepared(), which is asked instead: write both
// case flag_as_function: rest_is_small or quadratic_in_momenta of this ExactFlow is a function: write `static constexpr bool
// case flag_of_a_value: rest_is_small or quadratic_in_momenta of this ExactFlow is a function: write `static constexpr bool
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
using namespace effects::orbits;

struct Base {
  struct Prepared {
    Status increments(const auto&, const auto&, auto&, auto&) const { return Status::success; }
  };
#ifdef stale_prepared
  Prepared prepared(const double&) const { return {}; }
#endif
};

template <>
struct semiexplicit::ExactFlow<Oblateness<double, 2>> : Base {
  static constexpr const char* name = "a kick";
  explicit ExactFlow(const Oblateness<double, 2>&) {}
#ifdef flag_as_function
  static constexpr bool rest_is_small() { return false; }
#elif defined(flag_of_a_value)
  bool quadratic_in_momenta() const { return true; }
#endif
#ifdef increments_by_value
  using Column = Eigen::Vector2d;
  Status increments(double, const Column&, const Column&, Column, Column) const { return Status::success; }
#elif defined(template_by_value)
  Status increments(double, const auto&, const auto&, auto, auto) const { return Status::success; }
#elif defined(whole_time)
  Status increments(long, const auto&, const auto&, auto&, auto&) const { return Status::success; }
#elif !defined(without_increments)
  Status increments(const double&, const auto&, const auto&, auto&, auto&) const { return Status::success; }
#endif
#ifdef prepared_by_value
  struct Prepared {
    Status increments(const auto&, const auto&, auto, auto) const { return Status::success; }
  };
  Prepared prepared(const double&) const { return {}; }
#elif defined(prepared_of_whole_time)
  Prepared prepared(int) const { return {}; }
#elif defined(prepared_not_const_by_value)
  struct Prepared {
    Status increments(const auto&, const auto&, auto, auto) { return Status::success; }
  };
  Prepared prepared(const double&) const { return {}; }
#endif
};

int main() {
  const Scene scene(Kinetic<double, 2>{}, Attraction<double, 2>{}, Oblateness<double, 2>{});
#if defined(not_there)
  auto stepper = stepper_for(scene, exactly<Kinetic<double, 3>, Attraction<double, 3>>());
#elif defined(without_flow)
  auto stepper = stepper_for(scene, exactly<Attraction<double, 2>, Oblateness<double, 2>>());
#elif defined(twice_there)
  auto stepper = stepper_for(Scene(Kinetic<double, 2>{}, Attraction<double, 2>{}, Attraction<double, 2>{}),
                             exactly<Kinetic<double, 2>, Attraction<double, 2>>());
#elif defined(nothing_named)
  auto stepper = stepper_for(scene, exactly<>());
#else
  auto stepper = stepper_for(scene, exactly<Oblateness<double, 2>>());
#endif
  (void)stepper;
}
