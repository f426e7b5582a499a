// error names: effect.add_gradient(x, dHdx)
#include <semiexplicit/semiexplicit.hpp>

struct WithoutGradient {
  using Acts = semiexplicit::OnPosition<double, 2>;
  static constexpr const char* name = "without_gradient";
  double energy(const auto& q) const { return q[0]; }
};

int main() { semiexplicit::Scene scene(WithoutGradient{}); }
