// error names: h.gradient(q, p, dHdq, dHdp)
#include <semiexplicit/semiexplicit.hpp>

struct NoGradient {
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p) const {
    return q[0] * p[0];
  }
};

int main() { semiexplicit::Semiexplicit stepper(NoGradient{}, semiexplicit::schemes::strang<double>()); }
