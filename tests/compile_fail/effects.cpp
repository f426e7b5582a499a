// case no_mistake: compiles
// case without_acts: an effect says what it acts on: using Acts = OnPosition<double, 2>;
// case acts_of_my_own: an effect acts as one of five: using Acts = OnPosition<double, 2>; or OnMomentum
// case without_name: an effect has a name: static constexpr const char* name =
// case without_gradient: an effect on one half needs energy(x) const and add_gradient(x, dHdx) const
// case without_force: an effect OnMotion needs add_force(q, p, force) const
// case gradient_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case force_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case any_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case template_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case mixed_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case template_force_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case gradient_answers: add_gradient or add_force of this effect returns a bool, an int or a Status, and nobody asks: let it return nothing
// case force_answers: add_gradient or add_force of this effect returns a bool, an int or a Status, and nobody asks: let it return nothing
// case time_last: a member of this effect ends with a number, which would always be its default: leave it out
// case energy_time_last: a member of this effect ends with a number, which would always be its default: leave it out
// case force_time_last: a member of this effect ends with a number, which would always be its default: leave it out
// case energy_is_whole: the energy of this effect is a whole number, or one of fewer digits than its Scalar: let it return a Scalar
// case without_size: an effect with Dof = Eigen::Dynamic says its size at run time: write `Eigen::Index dof() const {
// case force_beside_energy: has a force of its own, add_force, which is asked for OnMotion only: make two effects of it
// case energy_beside_force: this effect OnMotion has an energy with its gradient, which is not asked: make two effects of it
// case size_not_const: dof() of this effect cannot be called: write `Eigen::Index dof() const`
// case constants_of_another_type: is not asked: write `std::vector<double> scene_constants() const`
// case constants_not_const: is not asked: write `std::vector<double> scene_constants() const`
// case disagree: must agree on the degrees of freedom
#include <semiexplicit/scene/any_effect.hpp>
#include <semiexplicit/scene/scene.hpp>
#include <semiexplicit/systems/orbits.hpp>

using namespace semiexplicit;

struct Mine {
#ifdef acts_of_my_own
  struct Acts : OnPosition<double, 2> {};
#elif defined(without_size)
  using Acts = OnPosition<double, Eigen::Dynamic>;
#elif !defined(without_acts)
  using Acts = OnPosition<double, 2>;
#endif
#ifndef without_name
  static constexpr const char* name = "mine";
#endif
#ifdef force_beside_energy
  void add_force(const auto&, const auto&, auto& force) const { force[0] += 1; }
#endif
#ifdef constants_of_another_type
  auto scene_constants() const { return Eigen::Vector2d(1, 2); }
#elif defined(constants_not_const)
  std::vector<double> scene_constants() { return {1, 2}; }
#else
  std::vector<double> scene_constants() const { return {1, 2}; }
#endif
#ifdef size_not_const
  Eigen::Index dof() { return 2; }
#endif
#if defined(energy_is_whole)
  int energy(const auto& q) const { return int(q[0]); }
#elif defined(energy_time_last)
  auto energy(const auto& q, double t = 0) const { return q[0] * t; }
#else
  double energy(const auto& q) const { return q[0]; }
#endif
#if defined(gradient_answers)
  bool add_gradient(const auto&, auto& dHdq) const {
    dHdq[0] += 1;
    return true;
  }
#elif defined(time_last)
  void add_gradient(const auto&, auto& dHdq, double t = 0) const { dHdq[0] += t; }
#elif defined(gradient_by_value) || defined(any_by_value)
  void add_gradient(const Eigen::Vector2d&, Eigen::Vector2d dHdq) const { dHdq[0] += 1; }
#elif defined(template_by_value)
  void add_gradient(const auto&, auto dHdq) const { dHdq[0] += 1; }
#elif defined(mixed_by_value)
  void add_gradient(const auto&, Eigen::Vector2d dHdq) const { dHdq[0] += 1; }
#elif !defined(without_gradient)
  void add_gradient(const auto&, auto& dHdq) const { dHdq[0] += 1; }
#endif
};

struct Wind {
  using Acts = OnMotion<double, 2>;
  static constexpr const char* name = "wind";
#ifdef energy_beside_force
  double energy(const auto& q) const { return q[0]; }
  void add_gradient(const auto&, auto& dHdq) const { dHdq[0] += 1; }
#endif
#ifdef force_by_value
  void add_force(In<double, 2>, In<double, 2>, Eigen::Vector2d force) const { force[0] += 1; }
#elif defined(template_force_by_value)
  void add_force(const auto&, const auto&, auto force) const { force[0] += 1; }
#elif defined(force_answers)
  auto add_force(const auto&, const auto&, auto& force) const {
    force[0] += 1;
    return true;
  }
#elif defined(force_time_last)
  void add_force(const auto&, const auto&, auto& force, double t = 0) const { force[0] += t; }
#elif !defined(without_force)
  void add_force(const auto&, const auto&, auto& force) const { force[0] += 1; }
#endif
};

int main() {
#if defined(any_by_value)
  const AnyEffect<double, 2> any(Mine{});
#elif defined(without_size)
  Scene scene(Mine{});
#elif defined(disagree)
  Scene scene(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 3>{});
#else
  Scene scene(Mine{}, effects::orbits::Kinetic<double, 2>{}, Wind{});
#endif
}
