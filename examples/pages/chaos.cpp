// Two orbits of Hénon and Heiles' system at the energy 1/8, one chaotic and one regular: tangent map,
// Lyapunov exponents, Poincaré section.
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
  Semiexplicit stepper(HenonHeiles(), schemes::low_defect4_s7<double>());
  const auto start = [](double y) {
    return PhasePoint<double, 2>({0, y}, {std::sqrt(0.25 - y * y + 2 * y * y * y / 3), 0});
  };

  // The derivative M of a step is symplectic: MᵀJM = J.
  TangentMap tangent(stepper);
  if (tangent.at(start(0.1), 0.2) != Status::success) return 1;
  Eigen::Matrix4d J = Eigen::Matrix4d::Zero();
  J.topRightCorner<2, 2>().setIdentity();
  J.bottomLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  const Eigen::Matrix4d M = tangent.matrix();
  const double symplectic = (M.transpose() * J * M - J).norm();

  int points = 0;
  const auto largest_exponent = [&](double y) {
    PhasePoint<double, 2> z = start(y);
    LyapunovExponents lyapunov(stepper, 1);
    points = 0;
    auto section = poincare_section(
        HenonHeiles(), [](const auto& q, const auto&) { return q[0]; },
        [&](double, const PhasePoint<double, 2>&) { ++points; });  // (y, p_y) is the point to plot
    integrate(stepper, z, {.dt = 0.4, .steps = 500}, lyapunov, section);
    return lyapunov.exponents()[0];
  };
  const double chaotic = largest_exponent(-0.25), regular = largest_exponent(0.1);
  std::cout << "MᵀJM - J: " << symplectic << '\n'
            << "at t = 200: chaotic " << chaotic << ", regular " << regular
            << " (ln(t)/t = " << std::log(200.0) / 200 << "), points of the section: " << points << '\n';
  return symplectic < 1e-13 && chaotic > 0.03 && regular < 0.03 && points > 25 ? 0 : 1;
}
