// error names: no type named 'Scalar'
#include <semiexplicit/semiexplicit.hpp>

struct NoScalar {
  static constexpr int Dof = 1;
  void gradient(semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p,
                semiexplicit::Ref<double, 1> dHdq, semiexplicit::Ref<double, 1> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

int main() { semiexplicit::Semiexplicit stepper(NoScalar{}, semiexplicit::schemes::strang<double>()); }
