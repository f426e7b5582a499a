// error names: h.gradient(q, p, dHdq, dHdp)
#include <semiexplicit/semiexplicit.hpp>

struct WrongGradient {  // returns its gradient instead of writing it
  using Scalar = double;
  static constexpr int Dof = 1;
  Eigen::Vector2d gradient(semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p) const {
    return {q[0], p[0]};
  }
};

int main() { semiexplicit::Semiexplicit stepper(WrongGradient{}, semiexplicit::schemes::strang<double>()); }
