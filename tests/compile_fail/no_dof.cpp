// error names: H::Dof
#include <semiexplicit/semiexplicit.hpp>

struct NoDof {
  using Scalar = double;
  void gradient(semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p,
                semiexplicit::Ref<double, 1> dHdq, semiexplicit::Ref<double, 1> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

int main() { semiexplicit::Semiexplicit stepper(NoDof{}, semiexplicit::schemes::strang<double>()); }
