#include "catch.hpp"

#include <cmath>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "folder.hpp"
#include "henon_heiles.hpp"
#include "refusal.hpp"

namespace test_alignment {

// Alignment indices, and the series of finite-time exponents.

namespace {

using namespace semiexplicit;

const Semiexplicit stepper(HenonHeilesWithProduct{}, schemes::low_defect6_s13());
constexpr double chaotic = -0.25;

}  // namespace

TEST_CASE("Alignment indices are the volumes of the vectors themselves", "[alignment]") {
  AlignmentIndex gali(stepper, 4);
  CHECK(gali.index(2) == 1);
  CHECK(gali.smaller() == Approx(std::sqrt(2.0)));
  // The same vectors, carried without being made orthonormal; they agree in some digits only at the end.
  LyapunovExponents start(stepper, 4);
  TangentVectors tangents(stepper, 4);
  tangents.vectors() = start.vectors();
  auto own = stepper;
  auto z = HenonHeiles::point(chaotic);
  for (int n = 0; n < 500; ++n) {
    gali(0.2 * n, z);
    REQUIRE(tangents.advance(z, 0.2).ok());
    REQUIRE(own.step(z, 0.2).ok());
  }
  gali(100, z);
  const Eigen::Matrix4d v = tangents.vectors().colwise().normalized();
  for (const int k : {2, 3}) {
    const auto gram = (v.leftCols(k).transpose() * v.leftCols(k)).eval();
    CHECK(gali.index(k) == Approx(std::sqrt(gram.determinant())).epsilon(1e-4));
  }
  const double together = (v.col(0) - v.col(1)).norm(), apart = (v.col(0) + v.col(1)).norm();
  CHECK(gali.smaller() == Approx(std::min(together, apart)).epsilon(1e-4));
  CHECK(gali.index(2) < 0.1);
}

TEST_CASE("As many vectors as there are begin orthonormal, also in float", "[alignment][lyapunov]") {
  // Equal oscillators turn them: no exponent, and volumes that stay.
  const auto check = [](auto h) {
    using Scalar = typename decltype(h)::Scalar;
    constexpr int d = decltype(h)::Dof;
    const Scalar rounding = 20 * Eigen::NumTraits<Scalar>::epsilon();
    Semiexplicit step(h, schemes::low_defect6_s13<Scalar>());
    LyapunovExponents exponents(step);
    AlignmentIndex gali(step, 2 * d);
    const auto v = exponents.vectors();
    CHECK((v.transpose() * v - v.Identity(2 * d, 2 * d)).cwiseAbs().maxCoeff() < rounding);
    PhasePoint<Scalar, d> z;
    z.vector().setLinSpaced(Scalar(-0.3), Scalar(0.7));
    integrate(step, z, {.dt = Scalar(0.1), .steps = 100}, exponents, gali);
    CHECK(std::abs(exponents.exponents().minCoeff()) < 10 * rounding);
    CHECK(std::abs(gali.index(2 * d) - 1) < 100 * rounding);
  };
  const auto oscillators = [](const auto& q, const auto& p) {
    return (q.squaredNorm() + p.squaredNorm()) / 2;
  };
  check(from_energy<2, float>(oscillators));
  check(from_energy<5, float>(oscillators));
  check(from_energy<7, float>(oscillators));
  check(from_energy<12, float>(oscillators));
  check(from_energy<12>(oscillators));
}

TEST_CASE("Alignment indices say what they cannot do", "[alignment]") {
  CHECK(refuses([] { AlignmentIndex(stepper, 1); }, "1 vectors asked for; there are 2 to 4"));
  CHECK(refuses([] { AlignmentIndex(stepper, 5); }, "5 vectors asked for"));
  const AlignmentIndex gali(stepper, 2);
  CHECK(refuses([&] { (void)gali.index(3); }, "GALI_3 of 2 vectors"));
  CHECK(refuses([&] { (void)gali.index(1); }, "GALI_1"));
}

TEST_CASE("The series of finite-time exponents is that of the estimates on the way", "[lyapunov]") {
  for (const double dt : {0.1, -0.1}) {
    LyapunovExponents lyapunov(stepper, 2);
    auto own = stepper;
    auto z = HenonHeiles::point(chaotic);
    std::vector<Eigen::VectorXd> all;
    integrate(own, z, {.dt = dt, .steps = 3000, .t0 = 7}, lyapunov,
              [&](double, const auto&) { all.push_back(lyapunov.exponents()); });
    const auto& t = lyapunov.times();
    REQUIRE(t.size() > 50);
    REQUIRE(t.size() < 70);
    CHECK(t.front() == dt);
    CHECK(std::abs(t.back()) > 260);
    for (std::size_t i = 0; i < t.size(); ++i) {
      const auto n = static_cast<std::size_t>(std::lround(t[i] / dt));
      for (const int j : {0, 1}) CHECK(lyapunov.series(j)[i] == all[n][j]);
      if (i > 0) CHECK(t[i] / t[i - 1] > 1);
      if (i > 20) CHECK(t[i] / t[i - 1] < 1.2);
    }
  }
}

TEST_CASE("A run that is resumed gives the same indices and the same series", "[alignment]") {
  const Folder folder;
  const auto go = [&](std::int64_t stop_at) {
    auto own = stepper;
    AlignmentIndex gali(own, 3);
    LyapunovExponents lyapunov(own, 1);
    auto z = HenonHeiles::point(chaotic);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 1000};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 100}, own, options, gali, lyapunov);
    options.done = checkpoints.resume(z);
    integrate(own, z, options, gali, lyapunov, checkpoints,
              [&](double, const auto&, const IntegrationReport& so_far) { return so_far.steps != stop_at; });
    auto list = lyapunov.series();
    list.push_back(gali.log_index(2));
    list.push_back(gali.log_index(3));
    return list;
  };
  const auto whole = go(-1);
  std::filesystem::remove(folder.path / "run.checkpoint");
  go(450);
  CHECK(go(-1) == whole);
}

}  // namespace test_alignment
