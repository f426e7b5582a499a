// Two orbits of Hénon and Heiles' system at the energy 1/8: one is chaotic, one is not.
#include <cmath>
#include <iostream>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

struct HenonHeiles {  // H = (|p|² + |q|²)/2 + x²y - y³/3
  using Scalar = double;
  static constexpr int Dof = 2;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq[0] = q[0] + 2 * q[0] * q[1];
    dHdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
    dHdp = p;
  }
  void hessian(In<double, 2> q, In<double, 2>, Eigen::Ref<Eigen::Matrix4d> matrix) const {
    matrix.setIdentity();
    matrix(0, 0) += 2 * q[1];
    matrix(0, 1) = matrix(1, 0) = 2 * q[0];
    matrix(1, 1) -= 2 * q[1];
  }
};

int main() {
  Semiexplicit stepper(HenonHeiles(), schemes::blanes_moan4<double>());
  const auto largest_exponent = [&](double y) {
    PhasePoint<double, 2> z({0, y}, {std::sqrt(0.25 - y * y + 2 * y * y * y / 3), 0});
    LyapunovExponents lyapunov(stepper, 1);
    integrate(stepper, z, {.dt = 0.2, .steps = 2000}, lyapunov);
    return lyapunov.exponents()[0];
  };
  const double chaotic = largest_exponent(-0.25), regular = largest_exponent(0.1);
  std::cout << "at t = 400: chaotic " << chaotic << ", regular " << regular
            << " (ln(t)/t = " << std::log(400.0) / 400 << ")\n";
  return chaotic > 0.03 && regular < 0.03 ? 0 : 1;
}
