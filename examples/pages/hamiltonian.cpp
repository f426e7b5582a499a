// A particle whose mass depends on its position, H = p²/(2 m(q)) + q²/2 with m(q) = 1 + q²: as a type for any
// number, from two lambdas, and n of them side by side, with n known at run time only.
#include <algorithm>
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

template <class Number>
struct VaryingMass {
  using Scalar = Number;
  static constexpr int Dof = 1;

  Number energy(In<Number, 1> q, In<Number, 1> p) const {
    return p[0] * p[0] / (2 * (1 + q[0] * q[0])) + q[0] * q[0] / 2;
  }
  void gradient(In<Number, 1> q, In<Number, 1> p, Out<Number, 1> dHdq, Out<Number, 1> dHdp) const {
    const Number velocity = p[0] / (1 + q[0] * q[0]);
    dHdq[0] = q[0] - velocity * velocity * q[0];
    dHdp[0] = velocity;
  }
};
static_assert(HasEnergy<VaryingMass<double>>);  // a Hamiltonian, with the optional energy

struct ManyVaryingMasses {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index n;

  Eigen::Index dof() const { return n; }
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    dHdp = p.array() / (1 + q.array().square());
    dHdq = q.array() - dHdp.array().square() * q.array();
  }
};

int main() {
  const auto scheme = schemes::low_defect6_s13<double>();
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 1000};

  Semiexplicit stepper(VaryingMass<double>(), scheme);
  PhasePoint<double, 1> z(0.7, 0.4);
  Invariants invariants(stepper.hamiltonian());
  integrate(stepper, z, options, invariants);
  std::cout << "worst relative energy error: " << invariants["energy"].worst << '\n';

  auto H = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / (2 * (1 + q[0] * q[0])) + q[0] * q[0] / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        const double velocity = p[0] / (1 + q[0] * q[0]);
        dHdq[0] = q[0] - velocity * velocity * q[0];
        dHdp[0] = velocity;
      });
  Semiexplicit with_lambdas(H, scheme);
  PhasePoint<double, 1> same(0.7, 0.4);
  integrate(with_lambdas, same, options);

  const Eigen::Index n = 3;
  Semiexplicit many(ManyVaryingMasses{n}, scheme);
  PhasePoint<double, Eigen::Dynamic> all(n);  // or PhasePoint<double, 3> z({0.7, 0.8, 0.9}, {0.4, 0.4, 0.4})
  all.q() << 0.7, 0.8, 0.9;
  all.p().setConstant(0.4);
  integrate(many, all, options);

  // Wider numbers want a tighter rule than the default, which is meant for double.
  Semiexplicit wide(VaryingMass<long double>(), schemes::low_defect8_s20<long double>(),
                    SimplifiedNewton{.stop = StoppingRule::product(1e-22)});
  PhasePoint<long double, 1> exact(0.7L, 0.4L);
  integrate(wide, exact, {.dt = 0.05L, .steps = 2000});

  const double lambdas = (same.vector() - z.vector()).norm();
  const double dynamic = std::hypot(all.q()[0] - z.q()[0], all.p()[0] - z.p()[0]);
  const double against_wide = static_cast<double>((exact.vector() - z.vector().cast<long double>()).norm());
  std::cout << "difference with two lambdas: " << lambdas << ", as one of " << n << ": " << dynamic
            << ", from long double with a smaller step: " << against_wide << '\n';
  return std::max(lambdas, dynamic) < 1e-9 && against_wide < 1e-5 && invariants["energy"].worst < 1e-8 ? 0
                                                                                                       : 1;
}
