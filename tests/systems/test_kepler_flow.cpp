#include "catch.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/eigen.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/systems/kepler_flow.hpp>
#include <semiexplicit/systems/rotating_flow.hpp>

namespace test_kepler_flow {

// Kepler's motion in closed form, and what a turning frame makes of it.

namespace {

using namespace semiexplicit;
using namespace effects::orbits;
using Wide = boost::multiprecision::cpp_bin_float_50;
using Column = Vector<double, 3>;
template <class Scalar>
using Point = PhasePoint<Scalar, 3>;

/// Where a flow takes z in the time t, and how that went.
template <class Scalar, int Dim, class Flow>
Status move(const Flow& flow, PhasePoint<Scalar, Dim>& z, const Scalar& t) {
  const Vector<Scalar, Dim> q = z.q(), p = z.p();
  Vector<Scalar, Dim> dq = Vector<Scalar, Dim>::Zero(), dp = dq;
  const Status status = flow.increments(t, q, p, dq, dp);
  z.q() += dq;
  z.p() += dp;
  return status;
}

/// Kepler's motion from the eccentric anomaly, or the hyperbolic one, with 50 digits: by elements, not by
/// universal variables.
Point<Wide> by_elements(const Point<Wide>& z, const Wide& gm, const Wide& t) {
  const Vector<Wide, 3> q = z.q(), p = z.p();
  const Wide r = sqrt(q.dot(q)), eta = q.dot(p), a = 1 / (2 / r - p.dot(p) / gm);
  Wide f, g, df, dg;
  if (a > 0) {
    const Wide n = sqrt(gm / (a * a * a)), ec = 1 - r / a, es = eta / sqrt(gm * a), turn = 2 * acos(Wide(-1));
    Wide m = n * t;
    m -= turn * floor(m / turn);
    Wide low = 0, high = turn, x = m;  // of x - ec sin x + es (1 - cos x) = m
    for (int i = 0; i < 400; ++i) {
      const Wide value = x - ec * sin(x) + es * (1 - cos(x)) - m;
      (value < 0 ? low : high) = x;
      Wide next = x - value / (1 - ec * cos(x) + es * sin(x));
      if (!(next > low && next < high)) next = (low + high) / 2;
      const bool done = abs(next - x) < Wide(1e-45);
      x = next;
      if (done) break;
    }
    const Wide r1 = a * (1 - ec * cos(x) + es * sin(x));
    f = 1 - a / r * (1 - cos(x));
    g = (m - (x - sin(x))) / n;
    df = -sqrt(gm * a) / (r * r1) * sin(x);
    dg = 1 - a / r1 * (1 - cos(x));
  } else {
    const Wide n = sqrt(-gm / (a * a * a)), ec = 1 - r / a, es = eta / sqrt(-gm * a),
               e = sqrt(ec * ec - es * es), h0 = asinh(es / e), m = es - h0 + n * t;
    Wide low = -2000, high = 2000, h = asinh(m / e);  // of e sinh h - h = m
    for (int i = 0; i < 1000; ++i) {
      const Wide value = e * sinh(h) - h - m;
      (value < 0 ? low : high) = h;
      Wide next = h - value / (e * cosh(h) - 1);
      if (!(next > low && next < high)) next = (low + high) / 2;
      const bool done = abs(next - h) < Wide(1e-45);
      h = next;
      if (done) break;
    }
    const Wide x = h - h0;
    const Wide r1 = -a * (ec * cosh(x) - 1 + es * sinh(x));
    f = 1 - a / r * (1 - cosh(x));
    g = t - (sinh(x) - x) / n;
    df = -sqrt(-gm * a) / (r * r1) * sinh(x);
    dg = 1 - a / r1 * (1 - cosh(x));
  }
  return {Vector<Wide, 3>(f * q + g * p), Vector<Wide, 3>(df * q + dg * p)};
}

/// Orbits of every kind, from 0.01 to 100 in size, and times from 1e-4 to 1e4 of their scale, of either sign.
class States {
 public:
  struct State {
    Point<double> z;
    double t;
    int kind;
  };
  static constexpr int kinds = 7;

  State next() {
    const int kind = count_++ % kinds;
    const auto direction = [this] {
      return Column(normal_(random_), normal_(random_), normal_(random_)).normalized().eval();
    };
    const double r = std::pow(10, 2 * signed_(random_)), x = std::abs(signed_(random_));
    const Column along = direction();
    Column way = direction();
    double speed = std::sqrt(2 / r);  // of a parabola
    if (kind == 0) speed *= x;        // ellipses
    if (kind == 1)
      speed *= 1 + std::pow(10, -3 - 12 * x) * (signed_(random_) > 0 ? 1 : -1);  // nearly parabolas
    if (kind == 2) speed *= 1 + 10 * x;                                          // hyperbolas
    if (kind == 3) {                                                             // circles
      way = along.cross(way).normalized();
      speed *= std::sqrt(0.5);
    }
    if (kind == 4) way = (signed_(random_) > 0 ? 1 : -1) * along + 1e-4 * x * way;  // nearly on a line
    if (kind == 5) way = along * (signed_(random_) > 0 ? 1 : -1);                   // on a line
    if (kind == 6) speed *= 1e-3 * x;                                               // nearly at rest
    if (kind == 4 || kind == 5) speed *= 2 * x;
    const double t = std::pow(10, 4 * signed_(random_)) * std::pow(r, 1.5) * (signed_(random_) > 0 ? 1 : -1);
    return {{Column(r * along), Column(speed * way.normalized())}, t, kind};
  }

 private:
  std::mt19937_64 random_{7};
  std::uniform_real_distribution<double> signed_{-1, 1};
  std::normal_distribution<double> normal_;
  int count_ = 0;
};

/// The error of Kepler's flow over a time t from z, in changes that roundings of the numbers that go in make.
double error_beyond_data(Point<double> z, double t) {
  Point<Wide> start;
  start.vector() = z.vector().cast<Wide>();
  REQUIRE(move(KeplerFlow<double, 3>{1}, z, t) == Status::success);
  const Point<Wide> right = by_elements(start, Wide(1), Wide(t));
  const Wide epsilon = std::numeric_limits<double>::epsilon();
  Vector<Wide, 6> allowed = epsilon * right.vector().cwiseAbs();
  const auto add = [&](const Point<Wide>& other) { allowed += (other.vector() - right.vector()).cwiseAbs(); };
  for (int k = 0; k < 6; ++k) {
    Point<Wide> near = start;
    near.vector()[k] += epsilon * (k < 3 ? start.q() : start.p()).norm();
    add(by_elements(near, Wide(1), Wide(t)));
  }
  add(by_elements(start, Wide(1), Wide(t) * (1 + epsilon)));
  const Wide q_error = (z.q().cast<Wide>() - right.q()).norm() / allowed.head(3).norm(),
             p_error = (z.p().cast<Wide>() - right.p()).norm() / allowed.tail(3).norm();
  return std::max(q_error, p_error).convert_to<double>();
}

double energy(const Point<double>& z, double gm) { return z.p().squaredNorm() / 2 - gm / z.q().norm(); }

double drift(double e, double h, int flows) {
  Point<double> z({1 - e, 0, 0}, {0, std::sqrt((1 + e) / (1 - e)), 0});
  const double before = energy(z, 1);
  const KeplerFlow<double, 3> flow{1};
  for (int i = 0; i < flows; ++i) (void)move(flow, z, h);
  return energy(z, 1) / before - 1;
}

}  // namespace

TEST_CASE("A million orbits of every kind are moved without a failure", "[kepler][long]") {
  States states;
  const KeplerFlow<double, 3> flow{1};
  int failures = 0, wrong = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const States::State s = states.next();
    Point<double> z = s.z;
    if (move(flow, z, s.t) != Status::success || !z.vector().allFinite()) {
      ++failures;
      continue;
    }
    // Angular momentum to the rounding of the terms that q' and p' are made of.
    const Column before = Column(s.z.q()).cross(Column(s.z.p())), after = Column(z.q()).cross(Column(z.p()));
    const double size = (z.q().norm() + s.z.q().norm()) * (z.p().norm() + s.z.p().norm());
    wrong += !((after - before).norm() <= 1e-12 * size * (1 + s.z.q().norm() / z.q().norm()));
  }
  CHECK(failures == 0);
  CHECK(wrong == 0);
}

TEST_CASE("Kepler's motion agrees with a solution by elements in 50 digits as far as its data determine it",
          "[kepler][long]") {
  States states;
  double worst[States::kinds] = {};
  for (int i = 0; i < 280; ++i) {
    const States::State s = states.next();
    worst[s.kind] = std::max(worst[s.kind], error_beyond_data(s.z, s.t));
  }
  for (const double error : worst) CHECK(error < 10);
}

TEST_CASE("A body that falls in fast and flies past the centre is where its data say", "[kepler][long]") {
  const Column along = Column(3, -2, 5).normalized(), across = along.cross(Column(1, 1, 0)).normalized();
  for (const double v : {3.0, 30.0, 1e3, 1e6})
    for (const double b : {1e-1, 1e-3, 1e-5, 1e-8})
      for (const double t : {1.0 / v, 2.0 / v, 100.0 / v}) {
        CAPTURE(v, b, t);
        CHECK(error_beyond_data({Column(along + b * across), Column(-v * along)}, t) < 4);
        CHECK(error_beyond_data({Column(along + b * across), Column(v * along)}, -t) < 4);
        // Along an axis, where the state holds the distance of the flyby to a rounding.
        CHECK(error_beyond_data({Column(1, b, 0), Column(-v, 0, 0)}, t) < 4);
      }
  // A distance that neither holds: nothing is known of the way out.
  Point<double> z({1, 0, 0}, {-1, 0, 0});
  CHECK(move(KeplerFlow<double, 3>{1e-30}, z, 2.0) == Status::no_convergence);
}

TEST_CASE("Kepler's flow takes no other root where a step vanishes by accident", "[kepler]") {
  CHECK(error_beyond_data({Column(1.1844402020327778, 1.1109455193973683, 0),
                           Column(-1.1858700212377027, -0.1631109945252458, 0)},
                          2.3260658173787201) < 10);
  // Hyperbolas on their way in: in float there are many such accidents, and double tells them.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  int moved = 0, wrong = 0;
  for (int i = 0; i < 200'000; ++i) {
    const double nearest = std::pow(10, 3 * part(random) - 2), v = std::pow(10, 1.5 * part(random) - 0.5),
                 r = nearest * (1 + std::pow(10, 2.5 * part(random))), speed = std::sqrt(v * v + 2 / r),
                 across = nearest / r * std::sqrt(v * v + 2 / nearest), t = 3 * part(random) * r / speed;
    PhasePoint<float, 2> z(
        {static_cast<float>(r), 0},
        {static_cast<float>(-std::sqrt(speed * speed - across * across)), static_cast<float>(across)});
    PhasePoint<double, 2> right;
    right.vector() = z.vector().cast<double>();
    if (move(KeplerFlow<float, 2>{1}, z, static_cast<float>(t)) != Status::success) continue;
    REQUIRE(move(KeplerFlow<double, 2>{1}, right, static_cast<double>(static_cast<float>(t))) ==
            Status::success);
    ++moved;
    wrong += !((z.q().cast<double>() - right.q()).norm() < 0.01 * (r + right.q().norm()));
  }
  CHECK(moved > 190'000);
  CHECK(wrong == 0);
}

TEST_CASE("Kepler's flow is the same in all units that the numbers can hold", "[kepler]") {
  // About 1; metres and seconds about the Sun; astronomical units and days about a small asteroid. Powers of
  // two, which change no digit.
  const auto moved = [](int length, int time, const PhasePoint<float, 2>& start, float t) {
    const float speed = std::ldexp(1.0F, length - time);
    PhasePoint<float, 2> z = start;
    z.q() *= std::ldexp(1.0F, length);
    z.p() *= speed;
    const Status status = move(KeplerFlow<float, 2>{std::ldexp(1.0F, 3 * length - 2 * time)}, z,
                               static_cast<float>(std::ldexp(t, time)));
    z.q() *= std::ldexp(1.0F, -length);
    z.p() *= 1 / speed;
    return std::pair(status, Vector<float, 4>(z.vector()));
  };
  for (const float vx : {-8.0F, -3.0F, -1.5F, -0.3F, 0.7F, 2.0F})
    for (const float vy : {0.0F, 1e-3F, 0.03F, 0.9F})
      for (const float t : {0.01F, 0.4F, 3.0F, 40.0F}) {
        CAPTURE(vx, vy, t);
        const PhasePoint<float, 2> z({1, 0}, {vx, vy});
        const auto usual = moved(0, 0, z, t);
        CHECK(moved(37, 22, z, t) == usual);
        CHECK(moved(-20, 8, z, t) == usual);
      }
  // Steps on the way overshoot to distances whose squares are infinite.
  PhasePoint<float, 2> z({1.496e10F, 0}, {-148.967F, 1.54757F});
  PhasePoint<double, 2> right;
  right.vector() = z.vector().cast<double>();
  const float gm = 1.327e11F, t = 2.00839e8F;
  REQUIRE(move(KeplerFlow<float, 2>{gm}, z, t) == Status::success);
  REQUIRE(move(KeplerFlow<double, 2>{gm}, right, double(t)) == Status::success);
  CHECK((z.q().cast<double>() - right.q()).norm() < 0.01 * right.q().norm());
}

TEST_CASE("The energy of a million flows of Kepler's motion walks without drifting", "[kepler][long]") {
  for (const double e : {0.0, 0.2, 0.6})
    for (const double h : {0.07, 0.5, 1.5}) {
      INFO("e = " << e << ", h = " << h);
      CHECK(std::abs(drift(e, h, 1'000'000)) < 1e-11);  // a bias of one rounding in ten would be 1e-11
    }
  CHECK(std::abs(drift(0.9, 0.5, 1'000'000)) < 5e-11);
}

TEST_CASE("The energy of ten million flows of Kepler's motion walks without drifting", "[.][kepler]") {
  for (const double e : {0.0, 0.2, 0.6, 0.9})
    for (const double h : {0.07, 0.5, 1.5}) {
      const double found = drift(e, h, 10'000'000);
      WARN("e = " << e << ", h = " << h << ": " << found);
      CHECK(std::abs(found) < (e > 0.8 ? 5e-10 : 1e-10));
    }
}

TEST_CASE("Kepler's motion back undoes Kepler's motion", "[kepler]") {
  const KeplerFlow<double, 3> flow{2.5};
  for (const double speed : {0.3, 1.0, 1.5, 2.2360679774997896, 4.0}) {
    Point<double> z({1, 0.1, -0.2}, {0.1, speed, 0.2});
    const Point<double> start = z;
    for (const double t : {0.3, 3.0}) {
      REQUIRE(move(flow, z, t) == Status::success);
      REQUIRE(move(flow, z, -t) == Status::success);
      CHECK((z.vector() - start.vector()).norm() < 1e-12);
    }
  }
}

TEST_CASE("A period brings an ellipse back, and so do many", "[kepler]") {
  const double gm = 3;
  const KeplerFlow<double, 3> flow{gm};
  const Point<double> start({1, 0.2, 0.3}, {0.1, 1.2, -0.4});
  const double a = 1 / (2 / start.q().norm() - start.p().squaredNorm() / gm),
               period = 2 * std::acos(-1.0) * std::sqrt(a * a * a / gm);
  for (const int periods : {1, -1, 7, 1000}) {
    Point<double> z = start;
    REQUIRE(move(flow, z, periods * period) == Status::success);
    CHECK((z.vector() - start.vector()).norm() < 1e-14 * (10 + 10 * std::abs(periods)));
  }
}

TEST_CASE("On a straight line Kepler's motion turns back at the centre, as the narrowest ellipses do",
          "[kepler]") {
  const KeplerFlow<double, 2> flow{1};
  PhasePoint<double, 2> line({1, 0}, {0, 0}), ellipse({1, 0}, {0, 1e-7});
  REQUIRE(move(flow, line, 1.5) == Status::success);  // half a period, to the centre, is 1.11
  REQUIRE(move(flow, ellipse, 1.5) == Status::success);
  CHECK(line.q()[0] > 0.3);
  CHECK((line.vector() - ellipse.vector()).norm() < 1e-5);
  CHECK(line.p().squaredNorm() / 2 - 1 / line.q().norm() == Approx(-1));
}

TEST_CASE("Kepler's flow from the centre, or from what is no number, is refused", "[kepler]") {
  const KeplerFlow<double, 2> flow{1};
  PhasePoint<double, 2> at_centre({0, 0}, {1, 0});
  CHECK(move(flow, at_centre, 0.1) == Status::not_finite);
  PhasePoint<double, 2> no_number({1, 0}, {std::nan(""), 0});
  CHECK(move(flow, no_number, 0.1) == Status::not_finite);
  PhasePoint<double, 2> infinite({1, 0}, {0, 1});
  CHECK(move(flow, infinite, std::numeric_limits<double>::infinity()) == Status::not_finite);
}

TEST_CASE("Kepler's flow without a force is a straight line, and with a repelling one a hyperbola",
          "[kepler]") {
  PhasePoint<double, 2> z({1, 0.5}, {-0.3, 0.2});
  REQUIRE(move(KeplerFlow<double, 2>{0}, z, 2.0) == Status::success);
  CHECK(z.q()[0] == Approx(0.4));
  CHECK(z.q()[1] == Approx(0.9));
  CHECK(z.p()[0] == Approx(-0.3));
  for (const double t : {-2.5, 0.5, 1.5, 2.5, 1e5}) {  // through the centre, at t = 1
    PhasePoint<double, 2> straight({1, 0}, {-1, 0});
    REQUIRE(move(KeplerFlow<double, 2>{0}, straight, t) == Status::success);
    CHECK(straight.q()[0] == 1 - t);
    CHECK(straight.p()[0] == -1);
  }
  z = PhasePoint<double, 2>({1, 0.5}, {-2, 0.2});
  const double before = z.p().squaredNorm() / 2 + 0.7 / z.q().norm();
  const KeplerFlow<double, 2> repelling{-0.7};
  for (int i = 0; i < 50; ++i) REQUIRE(move(repelling, z, 0.3) == Status::success);
  CHECK(z.q().norm() > 10);
  CHECK(z.p().squaredNorm() / 2 + 0.7 / z.q().norm() == Approx(before).epsilon(1e-12));
}

TEST_CASE("Kepler's flow has the accuracy of float, of long double and of 50 digits", "[kepler]") {
  const auto error = []<class Scalar>(Scalar) {
    Point<Scalar> z({Scalar(1), Scalar(0.25), Scalar(-0.5)}, {Scalar(0.125), Scalar(0.75), Scalar(0.5)});
    Point<Wide> wide;
    wide.vector() = z.vector().template cast<Wide>();
    REQUIRE(move(KeplerFlow<Scalar, 3>{Scalar(1)}, z, Scalar(3.5)) == Status::success);
    const Point<Wide> right = by_elements(wide, Wide(1), Wide(3.5));
    return (z.vector().template cast<Wide>() - right.vector()).norm().template convert_to<double>();
  };
  CHECK(error(1.0F) < 1e-5);
  CHECK(error(1.0) < 1e-14);
  CHECK(error(1.0L) < 1e-17);
  CHECK(error(Wide(1)) < 1e-44);
}

TEST_CASE("Free motion in a turning frame is a straight line seen from turning axes", "[kepler]") {
  const double omega = 0.7, t = 2.3, c = std::cos(omega * t), s = std::sin(omega * t);
  Point<double> z({1, -0.5, 0.3}, {0.2, 0.6, -0.1});
  const Column q = Column(z.q()) + t * Column(z.p()), p = z.p();
  REQUIRE(move(RotatingFlow<double, 3>{omega}, z, t) == Status::success);
  CHECK((Column(z.q()) - Column(c * q[0] + s * q[1], c * q[1] - s * q[0], q[2])).norm() < 1e-15);
  CHECK((Column(z.p()) - Column(c * p[0] + s * p[1], c * p[1] - s * p[0], p[2])).norm() < 1e-15);
}

TEST_CASE("Kepler's motion in a turning frame is Kepler's motion seen from turning axes", "[kepler]") {
  const double omega = -0.4, t = 1.7, c = std::cos(omega * t), s = std::sin(omega * t);
  PhasePoint<double, 2> z({1, -0.5}, {0.2, 0.9}), at_rest = z;
  REQUIRE(move(KeplerFlow<double, 2>{1.1}, at_rest, t) == Status::success);
  REQUIRE(move(RotatingKeplerFlow<double, 2>{{1.1}, omega}, z, t) == Status::success);
  const auto q = at_rest.q(), p = at_rest.p();
  CHECK((z.q() - Vector<double, 2>(c * q[0] + s * q[1], c * q[1] - s * q[0])).norm() < 1e-15);
  CHECK((z.p() - Vector<double, 2>(c * p[0] + s * p[1], c * p[1] - s * p[0])).norm() < 1e-15);
}

}  // namespace test_kepler_flow
