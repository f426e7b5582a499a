// compiles
#include <semiexplicit/semiexplicit.hpp>

struct Complete {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p,
                semiexplicit::Ref<double, 1> dHdq, semiexplicit::Ref<double, 1> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

int main() { semiexplicit::Semiexplicit stepper(Complete{}, semiexplicit::schemes::strang<double>()); }
