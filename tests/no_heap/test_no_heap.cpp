// A program of its own: Eigen's check below is a macro, on which all files of a program must agree.

#include <cstddef>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

// Eigen's own allocations are reported by an assertion, which is made to throw, in release builds, too.
#define EIGEN_RUNTIME_NO_MALLOC
#define eigen_assert(condition)                                     \
  do {                                                              \
    if (!(condition)) throw std::logic_error("Eigen: " #condition); \
  } while (false)

#include "catch.hpp"

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "../properties/methods.hpp"

// Sanitizers have allocators of their own, which are not to be replaced; there Eigen's check is all.
#if defined(__SANITIZE_ADDRESS__)
#define SEMIEXPLICIT_TEST_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SEMIEXPLICIT_TEST_SANITIZED
#endif
#endif

namespace {
long allocations = 0;  // of any kind, counted by the replacements below
}

#if !defined(SEMIEXPLICIT_TEST_SANITIZED)
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

// Where the C library lets a program replace malloc, whatever calls it is counted.
#if defined(__GLIBC__) && !defined(SEMIEXPLICIT_TEST_SANITIZED)
#define SEMIEXPLICIT_TEST_COUNTS_MALLOC
extern "C" {
void* __libc_malloc(std::size_t size);                     // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);  // NOLINT
void* __libc_realloc(void* memory, std::size_t size);      // NOLINT
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
}
#endif

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;

/// How often action() allocates; throws where Eigen does.
template <class Action>
long allocations_of(const Action& action) {
  const long before = allocations;
  Eigen::internal::set_is_malloc_allowed(false);
  try {
    action();
  } catch (...) {
    Eigen::internal::set_is_malloc_allowed(true);
    throw;
  }
  Eigen::internal::set_is_malloc_allowed(true);
  return allocations - before;
}

template <Hamiltonian H>
void steps_use_no_heap(const H& h, const PhasePoint<double, H::Dof>& start) {
  methods::Choice choice;
  choice.stop = StoppingRule::paper(1e-13);
  methods::for_each(h, choice, [&](const methods::Claim& claim, auto stepper) {
    // The factorisation of Newton's method may allocate.
    if (claim.name.starts_with("Gauss") && claim.name.ends_with("Newton")) return;
    CAPTURE(claim.name);
    typename decltype(stepper)::State state(start);
    StepReport report;
    long count = 0;
    REQUIRE_NOTHROW(count = allocations_of([&] {
                      for (const double dt : {0.02, 0.02, -0.01}) report = stepper.step(state, dt);
                    }));
    CHECK(report.ok());
    CHECK(count == 0);

    // Nor where a step fails.
    REQUIRE_NOTHROW(count = allocations_of([&] {
                      report = stepper.step(state, 1e3);
                      stepper.step(state, 0.0);
                    }));
    CHECK(count == 0);
  });
}

/// A Hamiltonian that allocates.
struct Wasteful {
  using Scalar = double;
  static constexpr int Dof = 2;
  bool with_eigen = false;

  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq = q;
    dHdp = p;
    if (with_eigen) {
      Eigen::VectorXd copy = q;
      dHdq = copy;
    } else {
      auto* const volatile copy = new double(q[0]);
      dHdq[0] = *copy;
      delete copy;
    }
  }
};

}  // namespace

TEST_CASE("A step does not touch the heap", "[heap]") {
  steps_use_no_heap(systems::NlsLattice<double, 5>{}, {{3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}});
  PhasePoint<double, Eigen::Dynamic> z(40);
  z.q()[0] = 1;
  z.p()[39] = -0.5;
  steps_use_no_heap(systems::NlsLattice<double>(40), z);
  steps_use_no_heap(systems::NlsLattice<double, 20>(), {z.q().head(20).eval(), z.p().tail(20).eval()});

  Eigen::VectorXd circulations = Eigen::VectorXd::LinSpaced(18, 1, 2),
                  x = Eigen::VectorXd::LinSpaced(18, -4, 4);
  const systems::PointVortices<double> vortices(circulations);
  steps_use_no_heap(vortices, vortices.phase_point(x, x.cwiseAbs2()));
  steps_use_no_heap(systems::Product<double>{}, {-1.0, 0.3});
}

TEST_CASE("Nor does a step of a scene, doubled or not, chosen at compile time or at run time", "[heap]") {
  const auto uses_none = [](auto stepper, auto state) {
    StepReport report;
    long count = 0;
    REQUIRE_NOTHROW(count = allocations_of([&] {
                      for (const double dt : {0.02, 0.02, -0.01}) report = stepper.step(state, dt);
                    }));
    CHECK(report.ok());
    CHECK(count == 0);
  };
  const PhasePoint<double, 2> orbit({1, 0}, {0, 1});
  const Scene plain(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{});
  uses_none(stepper_for(plain), orbit);
  uses_none(stepper_for(SeparableRuntimeScene(RuntimeScene(plain))), orbit);
  uses_none(stepper_for(RuntimeScene(plain)), orbit);
  PhasePoint<double, Eigen::Dynamic> wave(30);
  wave.q()[3] = 1;
  const Scene lattice(lattice::Hopping<>{.sites = 30}, lattice::Disorder<>(Eigen::VectorXd::Ones(30)));
  uses_none(stepper_for(lattice), wave);
  uses_none(stepper_for(SeparableRuntimeScene(RuntimeScene(lattice))), wave);
  uses_none(stepper_for(Scene(lattice::Hopping<>{.sites = 30}, lattice::OnSite<>{.sites = 30})), wave);

  const nbody::Bodies<double> bodies({39, 1e-3, 3e-2, 1e-3});
  const Scene planets(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                      nbody::Interaction<double>{bodies}, nbody::Oblateness<double>{bodies, 1e-3, 0.1},
                      nbody::PostNewtonian1<double>{bodies, 1e3},
                      nbody::EinsteinInfeldHoffmann<double>(bodies, 1e3));
  const auto system = bodies.jacobi({{0, 0, 0}, {1, 0, 0}, {0, 3, 0}, {-6, 0, 0}},
                                    {{0, 0, 0}, {0, 6, 0}, {-3.5, 0, 0.1}, {0, -2.5, 0}});
  uses_none(stepper_for(planets, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>()), system);
  uses_none(stepper_for(planets), system);
}

TEST_CASE("Nor do forces of their own, and the books of their work", "[heap]") {
  const Scene scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{},
                    orbits::Drag<double, 2>{.linear = 0.1}, orbits::RadiationReaction<double, 2>{.c = 10});
  auto stepper = stepper_for(scene);
  PhasePoint<double, 2> z({1, 0}, {0, 1});
  Books books(scene);
  CHECK(allocations_of([&] {
          for (int i = 0; i < 12; ++i) {
            books(0.01 * i, z);
            stepper.step(z, 0.01);
          }
        }) == 0);
  CHECK(std::abs(books.difference()) < 1e-12);
}

TEST_CASE("Nor does a step that follows a monitor function, the first one included", "[heap]") {
  const auto uses_none = [](auto stepper, auto state) {
    long count = 0;
    StepReport report;
    REQUIRE_NOTHROW(count = allocations_of([&] {
                      for (const double dt : {0.02, 0.02, -0.01}) report = stepper.step(state, dt);
                      stepper.step_until(state, 0.02, stepper.time() + 0.03);
                      stepper.step(state, 0.0);
                    }));
    CHECK(report.ok());
    CHECK(count == 0);
  };
  PhasePoint<double, Eigen::Dynamic> z(40);
  z.q()[0] = 1;
  z.p()[39] = -0.5;
  const systems::NlsLattice<double> lattice(40);
  uses_none(ReversibleSteps(Semiexplicit(lattice, schemes::blanes_moan6()), monitors::FieldSize(lattice)), z);
  uses_none(ReversibleSteps(Semiexplicit(lattice, schemes::blanes_moan6()),
                            [](const auto& q, const auto& p) { return 1 / (1 + q.squaredNorm() + p[0]); }),
            z);
}

TEST_CASE("Nor do automatic derivatives, of fixed or dynamic size", "[heap]") {
  const auto energy = [](const auto& q, const auto& p) { return q.squaredNorm() * p.squaredNorm() + q[0]; };
  const auto derivatives_use_no_heap = [](const auto& h) {
    PhasePoint<double, std::decay_t<decltype(h)>::Dof> z(dof_of(h)), gradient = z;
    z.q()[1] = 2;
    Eigen::Matrix<double, twice(std::decay_t<decltype(h)>::Dof), twice(std::decay_t<decltype(h)>::Dof)>
        hessian;
    hessian.resize(2 * dof_of(h), 2 * dof_of(h));
    long count = 0;
    REQUIRE_NOTHROW(count = allocations_of([&] {
                      h.gradient(z.q(), z.p(), gradient.q(), gradient.p());
                      h.hessian(z.q(), z.p(), hessian);
                    }));
    CHECK(count == 0);
    CHECK(gradient.q()[0] == 1);
    CHECK(hessian(0, 0) == 0);
    CHECK(hessian(2 * dof_of(h) - 1, 2 * dof_of(h) - 1) == 8);
  };
  derivatives_use_no_heap(from_energy<3>(energy));
  derivatives_use_no_heap(from_energy(9, energy));
  derivatives_use_no_heap(from_energy<20>(energy));
  derivatives_use_no_heap(from_energy(30, [](const auto& q, const auto& p) {
    const auto square = [](const auto& x) { return sum_over(30, [&](auto i) { return x[i] * x[i]; }); };
    return square(q) * square(p) + q[0];
  }));
}

TEST_CASE("Nor does a step of a pack", "[heap]") {
  const auto uses_none = [](auto pack, auto point) {
    PackReport report{};
    CHECK(allocations_of([&] {
            for (const double dt : {0.05, 0.05, -0.02}) report = pack.step(point, dt);
          }) == 0);
    CHECK(report[0].evaluations > 1);
    CHECK(allocations_of([&] { report = pack.step(point, 1e3); }) == 0);
    CHECK_FALSE(report[0].ok());
  };
  const SimplifiedNewton solver{.stop = StoppingRule::paper(1e-13)};
  PackPoint<5> few(5);
  PackPoint<Eigen::Dynamic> many(20);
  for (std::size_t k = 0; k < std::size_t(pack_width); ++k) {
    few.set_lane(k, {{1, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}});
    PhasePoint<double, Eigen::Dynamic> z(20);
    z.q()[3] = z.p()[4] = 1;
    many.set_lane(k, z);
  }
  uses_none(SemiexplicitPack(systems::NlsLattice<double, 5>{}, schemes::yoshida6<double>(), solver), few);
  uses_none(SemiexplicitPack(systems::NlsLattice<double>(20), schemes::yoshida6<double>(), solver), many);
}

/// How often an observer of such steps allocates in each of the first ten.
template <class H, class MakeObserver>
long allocations_along(const H& h, PhasePoint<double, H::Dof> z, const MakeObserver& make) {
  Semiexplicit stepper(h, schemes::strang());
  auto observer = make(stepper);
  observer(0.0, z);
  long count = 0;
  for (int n = 1; n <= 10; ++n) {
    REQUIRE(stepper.step(z, 0.01).ok());
    REQUIRE_NOTHROW(count += allocations_of([&] { observer(0.01 * n, z); }));
  }
  return count;
}

TEST_CASE("Nor does the tangent map of a fixed size", "[heap]") {
  TangentMap tangent(systems::Product<double>(), schemes::strang());
  long count = 0;
  REQUIRE_NOTHROW(count = allocations_of([&] { (void)tangent.at({-3, 0}, 0.01); }));
  CHECK(count == 0);
}

TEST_CASE("Nor do tangent vectors of any size, wherever their second derivatives come from", "[heap]") {
  const auto exponents = [](const auto& stepper) { return LyapunovExponents(stepper, 2); };
  CHECK(allocations_along(systems::Product<double>(), {-3, 0}, exponents) == 0);
  PhasePoint<double, Eigen::Dynamic> z(10);
  z.q().setConstant(0.1);
  z.q()[3] = 1;
  const systems::NlsLattice<double> lattice(10);
  CHECK(allocations_along(lattice, z, exponents) == 0);
  CHECK(allocations_along(lattice, z, [](const auto& s) { return AlignmentIndex(s, 3); }) == 0);
  const auto by_differences = make_hamiltonian<double>(
      10, [](const auto&, const auto&) { return 0.0; },
      [lattice](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        lattice.gradient(q, p, dHdq, dHdp);
      });
  CHECK(allocations_along(by_differences, z, exponents) == 0);
}

TEST_CASE("A run allocates nothing a step", "[heap]") {
  systems::NlsLattice<double> h(10);
  PhasePoint<double, Eigen::Dynamic> z(10);
  z.q()[3] = 1;
  z.p()[4] = 0.5;
  Semiexplicit stepper(h, schemes::low_defect4_s7(), Broyden{});
  Invariants errors(h);
  auto sparse = every(10, errors);
  integrate(stepper, z, {.dt = 0.01, .steps = 1}, sparse);  // room for the last state
  CHECK(allocations_of([&] { integrate(stepper, z, {.dt = 0.01, .steps = 1000}, sparse); }) == 0);
}

TEST_CASE("An allocation would be seen", "[heap]") {
  PhasePoint<double, 2> z({1, 0}, {0, 1});
  Semiexplicit with_new(Wasteful{}, schemes::strang());
#if !defined(SEMIEXPLICIT_TEST_SANITIZED)
  CHECK(allocations_of([&] { with_new.step(z, 0.1); }) >= 3);
#endif
  Semiexplicit with_eigen(Wasteful{true}, schemes::strang());
  CHECK_THROWS_AS(allocations_of([&] { with_eigen.step(z, 0.1); }), std::logic_error);
#ifdef SEMIEXPLICIT_TEST_COUNTS_MALLOC
  CHECK(allocations_of([] {
          void* volatile memory =
              std::malloc(100 + static_cast<std::size_t>(allocations % 7));  // clang++ would leave it out
          std::free(memory);
        }) == 1);
#endif
}
