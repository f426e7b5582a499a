// error names: h.gradient(q, p, dHdq, dHdp)
#include <semiexplicit/semiexplicit.hpp>

struct GradientNotConst {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p,
                semiexplicit::Ref<double, 1> dHdq, semiexplicit::Ref<double, 1> dHdp) {
    dHdq = q;
    dHdp = p;
  }
};

int main() {
  semiexplicit::Semiexplicit stepper(GradientNotConst{}, semiexplicit::schemes::strang<double>());
}
