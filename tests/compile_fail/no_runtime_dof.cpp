// error names: HasRuntimeDof
#include <semiexplicit/semiexplicit.hpp>

struct NoRuntimeDof {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  using In = semiexplicit::ConstRef<double, Dof>;
  using Out = semiexplicit::Ref<double, Dof>;
  void gradient(In q, In p, Out dHdq, Out dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

int main() { semiexplicit::Semiexplicit stepper(NoRuntimeDof{}, semiexplicit::schemes::strang<double>()); }
