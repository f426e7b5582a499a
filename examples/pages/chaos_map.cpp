// A map of chaos: the Lyapunov exponent of every orbit that starts in a slice of phase space, with checkpoints.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

struct HenonHeiles {  // H = (|p|² + |q|²)/2 + x²y - y³/3
  using Scalar = double;
  static constexpr int Dof = 2;
  using PackGradientOf = HenonHeiles;  // the orbits go in lanes
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    dHdq[0] = q[0] + 2.0 * q[0] * q[1];
    dHdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
    dHdp[0] = p[0];
    dHdp[1] = p[1];
  }
  void hessian_times(In<double, 2> q, In<double, 2>, In<double, 2> dq, In<double, 2> dp, Out<double, 2> hq,
                     Out<double, 2> hp) const {  // for the tangent vectors
    hq[0] = (1 + 2 * q[1]) * dq[0] + 2 * q[0] * dq[1];
    hq[1] = 2 * q[0] * dq[0] + (1 - 2 * q[1]) * dq[1];
    hp = dp;
  }
};

int main() {
  // The plane x = 0 at the energy 1/8, with y across and p_y ≥ 0 upward; p_x follows from the energy.
  constexpr int columns = 35, rows = 8;
  std::vector<PhasePoint<double, 2>> starts;
  std::vector<std::size_t> places;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double y = -0.5 + 1.25 * column / (columns - 1), p_y = 0.47 * row / (rows - 1);
      const double squared = 0.25 - p_y * p_y - y * y + 2 * y * y * y / 3;
      if (squared <= 0) continue;
      starts.emplace_back(Eigen::Vector2d(0, y), Eigen::Vector2d(std::sqrt(squared), p_y));
      places.push_back(static_cast<std::size_t>(row * columns + column));
    }

  Ensemble ensemble(HenonHeiles(), starts, schemes::low_defect4_s7<double>());
  std::vector<LyapunovExponents<decltype(ensemble.stepper(0))>> exponents;  // one a member
  for (Eigen::Index i = 0; i < ensemble.size(); ++i) exponents.emplace_back(ensemble.stepper(i), 1);

  EnsembleOptions options{.dt = 0.5, .steps = 300};
  EnsembleCheckpoints checkpoints("page_map.checkpoint", {.seconds = 60}, ensemble, options, exponents);
  options.done = checkpoints.resume();  // after a crash it goes on from there, bit for bit
  Progress progress(options.dt * 300);  // draws on a terminal only
  const EnsembleReport run = ensemble.run(options, each(exponents), checkpoints, progress);
  checkpoints.remove();

  // Regular orbits have an exponent of about ln(t)/t, 0.03 at t = 150.
  std::vector<std::string> map(rows, std::string(columns, ' '));
  int chaotic = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double exponent = exponents[i].exponents()[0];
    chaotic += exponent > 0.045 ? 1 : 0;
    map[places[i] / columns][places[i] % columns] = exponent > 0.06 ? '#' : exponent > 0.045 ? '+' : '.';
  }
  std::cout << ensemble.how() << '\n';
  for (auto row = map.rbegin(); row != map.rend(); ++row) std::cout << *row << '\n';
  std::cout << chaotic << " of " << run.members << " orbits are chaotic\n";
  return run.ok() && chaotic > run.members / 10 && chaotic < run.members ? 0 : 1;
}
