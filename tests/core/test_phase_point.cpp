#include "catch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <semiexplicit/core/phase_point.hpp>

#include "refusal.hpp"

namespace test_phase_point {

namespace {

using namespace semiexplicit;
using Fixed = PhasePoint<double, 2>;
using Dynamic = PhasePoint<double, Eigen::Dynamic>;

}  // namespace

TEST_CASE("A phase point begins at zero", "[phase point]") {
  const Fixed fixed;
  CHECK(fixed.dof() == 2);
  CHECK(fixed.vector() == Eigen::Vector4d::Zero());
  CHECK(Fixed(2).vector() == Eigen::Vector4d::Zero());

  const Dynamic empty, dynamic(3);
  CHECK(empty.dof() == 0);
  CHECK(empty.q().size() == 0);
  CHECK(dynamic.dof() == 3);
  CHECK(dynamic.vector() == Eigen::VectorXd::Zero(6));
}

TEST_CASE("A phase point is one contiguous vector, positions first", "[phase point]") {
  Fixed fixed({1, 2}, {3, 4});
  CHECK(fixed.vector() == Eigen::Vector4d(1, 2, 3, 4));
  CHECK(fixed.q() == Eigen::Vector2d(1, 2));
  CHECK(fixed.p() == Eigen::Vector2d(3, 4));
  CHECK(fixed.q().data() == fixed.vector().data());
  CHECK(fixed.p().data() == fixed.vector().data() + 2);
  fixed.q()[1] = 7;
  fixed.p() *= 2;
  CHECK(fixed.vector() == Eigen::Vector4d(1, 7, 6, 8));
  static_assert(decltype(fixed.q())::SizeAtCompileTime == 2);
  static_assert(decltype(fixed.p())::SizeAtCompileTime == 2);

  Dynamic dynamic({1, 2, 3}, {4, 5, 6});
  CHECK(dynamic.dof() == 3);
  CHECK(dynamic.vector() == (Eigen::VectorXd(6) << 1, 2, 3, 4, 5, 6).finished());
  CHECK(dynamic.p().data() == dynamic.vector().data() + 3);
  dynamic.p().setConstant(1);
  CHECK(dynamic.vector() == (Eigen::VectorXd(6) << 1, 2, 3, 1, 1, 1).finished());

  // The halves bind to what a gradient takes, without a copy.
  const In<double, 2> q = static_cast<const Fixed&>(fixed).q();
  CHECK(q.data() == fixed.vector().data());
  Out<double, Eigen::Dynamic> p = dynamic.p();
  CHECK(p.data() == dynamic.vector().data() + 3);
}

TEST_CASE("A phase point is made from vectors, expressions, lists and numbers", "[phase point]") {
  const Eigen::Vector2d q(1, 2), p(3, 4);
  CHECK(Fixed(q, p).vector() == Eigen::Vector4d(1, 2, 3, 4));
  CHECK(Fixed(2 * q, p + q).vector() == Eigen::Vector4d(2, 4, 4, 6));
  const PhasePoint deduced(q, p);
  static_assert(std::is_same_v<decltype(deduced), const Fixed>);
  const Eigen::VectorXd long_q = q;
  const PhasePoint dynamic(long_q, long_q);
  static_assert(std::is_same_v<decltype(dynamic), const Dynamic>);
  CHECK(dynamic.dof() == 2);

  const PhasePoint<double, 1> pair(-3, 0.5), lists({-3}, {0.5});
  CHECK(pair.vector() == Eigen::Vector2d(-3, 0.5));
  CHECK(lists.vector() == pair.vector());
  const PhasePoint<float, 1> single(1.0F, 2.0F);
  CHECK(single.p()[0] == 2.0F);

  Fixed copy = Fixed(q, p);
  const Fixed other = copy;
  copy.q()[0] = 9;
  CHECK(other.q()[0] == 1);
}

TEST_CASE("Sizes that do not fit are refused, with both numbers", "[phase point]") {
  CHECK(says(refusal([] { Fixed(3); }), "dof has size 3, but this type has 2"));
  CHECK(says(refusal([] { Fixed({1, 2, 3}, {1, 2}); }), "q has size 3, but this type has 2"));
  CHECK(says(refusal([] { Fixed({1, 2}, {1}); }), "p has size 1"));
  CHECK(says(refusal([] { Dynamic({1, 2}, {1}); }), "q has 2 entries and p has 1"));
  CHECK(says(refusal([] { Dynamic(Eigen::VectorXd::Zero(4), Eigen::VectorXd::Zero(5)); }),
             "q has 4 entries and p has 5"));
}

TEST_CASE("An extended point is two copies, named as four blocks", "[phase point]") {
  const Fixed z({1, 2}, {3, 4});
  ExtendedPoint zeta(z);
  static_assert(std::is_same_v<decltype(zeta), ExtendedPoint<double, 2>>);
  CHECK(zeta.dof() == 2);
  CHECK(zeta.a.vector() == z.vector());
  CHECK(zeta.b.vector() == z.vector());
  CHECK(zeta.defect() == 0);
  zeta.a = Fixed({1, 2}, {30, 40});  // (q, y)
  zeta.b = Fixed({5, 6}, {3, 4});    // (x, p)
  CHECK(zeta.q() == Eigen::Vector2d(1, 2));
  CHECK(zeta.x() == Eigen::Vector2d(5, 6));
  CHECK(zeta.p() == Eigen::Vector2d(3, 4));
  CHECK(zeta.y() == Eigen::Vector2d(30, 40));
  CHECK(zeta.defect() == Approx(std::sqrt(16 + 16 + 27 * 27 + 36 * 36.0)));
  const ExtendedPoint dynamic(Dynamic({1, 2, 3}, {4, 5, 6}));
  CHECK(dynamic.dof() == 3);
  CHECK(dynamic.y() == Eigen::Vector3d(4, 5, 6));
}

TEST_CASE("The defect of tiny and of huge points neither underflows nor overflows", "[phase point]") {
  for (const double size : {1e-300, 1e-200, 1e-160, 1e-20, 1.0, 1e20, 1e160, 1e200, 1e300}) {
    CAPTURE(size);
    ExtendedPoint zeta(Fixed({0, 0}, {0, 0}));
    zeta.a = Fixed({3 * size, 0}, {0, -4 * size});
    CHECK(zeta.defect() == Approx(5 * size).epsilon(1e-15));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  // Wherever the NaN stands, and whatever stands beside it.
  for (const double other : {0.0, 1.0, 1e-200, 1e200})
    for (Eigen::Index i = 0; i < 4; ++i) {
      CAPTURE(other, i);
      ExtendedPoint zeta(Fixed({0, 0}, {0, 0}));
      zeta.a.vector().setConstant(other);
      zeta.a.vector()[i] = nan;
      CHECK(std::isnan(zeta.defect()));
      zeta.a.vector()[i] = inf;
      CHECK(std::isinf(zeta.defect()));
    }
}

TEST_CASE("A phase point of less than no degrees of freedom is refused", "[phase point]") {
  CHECK(refuses([] { Dynamic(-1); }, "PhasePoint: dof has size -1; give 0 or more"));
  CHECK(refuses([] { Fixed(-2); }, "PhasePoint: dof has size -2"));
}

}  // namespace test_phase_point
