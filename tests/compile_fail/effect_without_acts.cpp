// error names: an effect says what it acts on
#include <semiexplicit/semiexplicit.hpp>

struct WithoutActs {
  static constexpr const char* name = "without_acts";
  double energy(const auto& q) const { return q[0]; }
  void add_gradient(const auto&, auto& dHdq) const { dHdq[0] += 1; }
};

int main() { semiexplicit::Scene scene(WithoutActs{}); }
