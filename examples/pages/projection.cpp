// The projected step by four solvers, and whether it is symplectic: for one degree of freedom, whether it
// keeps areas.
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

const systems::Product<> H;
const double dt = 0.1;

template <class Stepper>
Point one_step(Stepper& stepper, Point z) {
  const StepReport report = stepper.step(z, dt);
  std::cout << describe(report.status) << ", evaluations of f: " << report.evaluations << '\n';
  return z;
}

/// The determinant of the step's Jacobian at z, by central differences, less one.
template <class Stepper>
double area_error(Stepper& stepper, const Point& z) {
  const double h = 1e-4;
  Eigen::Matrix2d jacobian;
  for (int i = 0; i < 2; ++i) {
    Point more = z, less = z;
    more.vector()[i] += h;
    less.vector()[i] -= h;
    stepper.step(more, dt);
    stepper.step(less, dt);
    jacobian.col(i) = (more.vector() - less.vector()) / (2 * h);
  }
  return jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0) - 1;
}

int main() {
  const Point start(-3, 0);
  const auto scheme = schemes::strang<double>();
  const auto tight = StoppingRule::paper(1e-13);

  Semiexplicit newton(H, scheme, SimplifiedNewton{.stop = tight});
  Semiexplicit broyden(H, scheme, Broyden{.stop = tight});
  Semiexplicit krylov(H, scheme, NewtonKrylov{.stop = tight});
  Semiexplicit robust(H, scheme, Robust{.stop = tight});
  const Point z = one_step(newton, start);
  bool all_right = true;
  for (const Point& other : {one_step(broyden, start), one_step(krylov, start), one_step(robust, start)})
    all_right = all_right && (other.vector() - z.vector()).norm() < 1e-11;

  MidpointProjection midpoint(H, scheme);  // no iteration: not symplectic
  std::cout << "area error, projected: " << area_error(newton, start)
            << ", mean of the copies: " << area_error(midpoint, start) << '\n';
  all_right =
      all_right && std::abs(area_error(newton, start)) < 1e-8 && std::abs(area_error(midpoint, start)) > 1e-6;
  return all_right ? 0 : 1;
}
