#pragma once

#include <string>
#include <utility>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace examples {

using namespace semiexplicit;
using namespace semiexplicit::effects;

using charges::FieldSum;

/// What one magnetic field B adds to the motion in others, A: |p - e(A + B)|²/(2m) - |p - eA|²/(2m). So each field is an
/// effect of its own, which charges::MagneticKinetic, all of them together, is not. `moves` adds the motion p²/(2m) itself,
/// for a first field where no kinetic effect is on; it is then charges::MagneticKinetic.
template <class Field>
class FieldEffect {
 public:
  using Acts = OnBoth<double, 3>;

  FieldEffect(std::string called, double charge, double mass, Field field, FieldSum others, bool moves)
      : name_(std::move(called)),
        charge_(charge),
        mass_(mass),
        field_(std::move(field)),
        others_(std::move(others)),
        moves_(moves) {}

  std::string name() const { return name_; }

  double energy(const auto& q, const auto& p) const {
    const auto a = others_.potential(q), b = potential(q);
    double sum = moves_ ? (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) / 2 : 0;
    for (int i = 0; i < 3; ++i) sum -= charge_ * b[i] * (p[i] - charge_ * (a[i] + b[i] / 2));
    return sum / mass_;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto a = others_.potential(q), b = potential(q);
    Vector<double, 3> v;
    for (int i = 0; i < 3; ++i) {
      v[i] = (p[i] - charge_ * (a[i] + b[i])) / mass_;
      dHdp[i] += moves_ ? v[i] : -charge_ * b[i] / mass_;
    }
    field_.add_gradient(q, v, -charge_, dHdq);
    others_.add_gradient(q, b, charge_ * charge_ / mass_, dHdq);
  }

 private:
  Vector<double, 3> potential(const auto& q) const {
    Vector<double, 3> b(0, 0, 0);
    field_.add_potential(q, b);
    return b;
  }

  std::string name_;
  double charge_, mass_;
  Field field_;
  FieldSum others_;
  bool moves_;
};

}  // namespace examples
