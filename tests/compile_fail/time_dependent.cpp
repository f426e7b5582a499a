// error names: WrapItInAutonomous
#include <semiexplicit/semiexplicit.hpp>

struct Driven {  // depends on the time and is not wrapped
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(double t, semiexplicit::ConstRef<double, 1> q, semiexplicit::ConstRef<double, 1> p,
                semiexplicit::Ref<double, 1> dHdq, semiexplicit::Ref<double, 1> dHdp) const {
    dHdq = t * q;
    dHdp = p;
  }
};

int main() { semiexplicit::Semiexplicit stepper(Driven{}, semiexplicit::schemes::strang<double>()); }
