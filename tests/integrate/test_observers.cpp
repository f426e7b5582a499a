#include "catch.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#if !defined(_WIN32)
#include <unistd.h>
#endif

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_observers {

namespace {

using namespace semiexplicit;
namespace fs = std::filesystem;
using Point = PhasePoint<double, 1>;

/// A folder of its own that goes away with the test.
struct Folder {
  Folder() {
    static int number = 0;
    for (int tries = 0; tries < 1000; ++tries) {
      path = fs::temp_directory_path() / ("semiexplicit-test-" + std::to_string(number++));
      if (fs::create_directory(path)) return;
    }
    FAIL("no folder for temporary files");
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path path;
};

std::string contents(const fs::path& path) {
  std::ifstream in(path);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

std::vector<std::vector<double>> numbers(const fs::path& path) {
  std::ifstream in(path);
  std::string line, cell;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    rows.emplace_back();
    std::istringstream cells(line);
    while (std::getline(cells, cell, ',')) rows.back().push_back(std::strtod(cell.c_str(), nullptr));
  }
  return rows;
}

template <class Error, class Action>
std::string message(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace

TEST_CASE("Record keeps times and states", "[observers]") {
  Record<double, 1> record;
  record(0.0, Point(1, 2));
  record(0.5, Point(3, 4));
  CHECK(record.t == std::vector<double>{0, 0.5});
  REQUIRE(record.z.size() == 2);
  CHECK(record.z[1].vector() == Eigen::Vector2d(3, 4));

  Record<double, Eigen::Dynamic> dynamic;
  dynamic(1.0, PhasePoint<double, Eigen::Dynamic>({1, 2, 3}, {4, 5, 6}));
  CHECK(dynamic.z[0].dof() == 3);
}

TEST_CASE("A Record refuses states of two sizes", "[observers]") {
  using State = PhasePoint<double, Eigen::Dynamic>;
  Record<double, Eigen::Dynamic> record;
  record(0.0, State(2));
  CHECK(refuses(
      [&] { record(1.0, State(1)); },
      "Record: a state with 1 degrees of freedom after one with 2; give each run a Record of its own"));
  REQUIRE(record.z.size() == 1);
  record(1.0, State(2));

  CheckpointMemory memory;
  record.z[1] = State(1);  // by hand
  CHECK(refuses([&] { record.visit_memory(memory); },
                "Record: a state with 1 degrees of freedom after one with 2"));
  record.z.pop_back();
  CHECK(refuses([&] { record.visit_memory(memory); }, "Record: there are 2 times and 1 states"));
  record.t.pop_back();

  CheckpointMemory saved;
  record.visit_memory(saved);
  Record<double, Eigen::Dynamic> back;
  back.visit_memory(CheckpointMemory(saved.bytes(), CheckpointMemory::Read::restore));
  REQUIRE(back.z.size() == 1);
  CHECK(back.z[0].dof() == 2);
}

TEST_CASE("Invariants keep the worst and the last error, relative to the first value", "[observers]") {
  Invariants<double, 1> errors;
  errors.add("q", [](const auto& q, const auto&) { return q[0]; }).add("p", [](const auto&, const auto& p) {
    return p[0];
  });
  errors(0.0, Point(-2, 0));
  errors(1.0, Point(-3, 0.25));
  errors(2.0, Point(-1, -0.5));
  errors(3.0, Point(-2.5, 0.125));
  CHECK(errors["q"].initial == -2);
  CHECK(errors["q"].worst == 0.5);
  CHECK(errors["q"].worst_time == 1);  // when it was first seen
  CHECK(errors["q"].final == 0.25);
  // A first value of zero: absolute.
  CHECK(errors["p"].initial == 0);
  CHECK(errors["p"].worst == 0.5);
  CHECK(errors["p"].worst_time == 2);
  CHECK(errors["p"].final == 0.125);
  CHECK(errors.rows().size() == 2);
  CHECK(errors.rows()[1].name == "p");
  CHECK(says(message<std::out_of_range>([&] { errors["energy"]; }), "'energy'"));
}

TEST_CASE("A NaN is the worst error, and stays so", "[observers]") {
  Invariants<double, 1> errors;
  errors.add("q", [](const auto& q, const auto&) { return q[0]; });
  errors(0.0, Point(1, 0));
  errors(1.0, Point(1.5, 0));
  errors(2.0, Point(std::nan(""), 0));
  CHECK(std::isnan(errors["q"].worst));
  CHECK(errors["q"].worst_time == 2);
  errors(3.0, Point(100, 0));
  errors(4.0, Point(std::nan(""), 0));
  CHECK(std::isnan(errors["q"].worst));
  CHECK(errors["q"].worst_time == 2);

  Invariants<double, 1> from_nan;
  from_nan.add("q", [](const auto& q, const auto&) { return q[0]; });
  from_nan(0.0, Point(std::nan(""), 0));
  from_nan(1.0, Point(1, 0));
  CHECK(std::isnan(from_nan["q"].worst));
}

TEST_CASE("Invariants follow the energy of a Hamiltonian", "[observers]") {
  Invariants errors(systems::Product<double>{});
  errors(0.0, Point(1, 0));
  errors(0.5, Point(1, 1));
  CHECK(errors["energy"].initial == 1);
  CHECK(errors["energy"].worst == 1);
}

TEST_CASE("Invariants refuse the states of a system of another size", "[observers]") {
  Semiexplicit stepper(systems::NlsLattice<double>(5));
  PhasePoint<double, Eigen::Dynamic> z(5);
  z.vector().setConstant(0.1);
  Invariants of_another(systems::NlsLattice<double>(7));
  CHECK(refuses([&] { integrate(stepper, z, {.dt = 0.1, .steps = 2}, of_another); },
                "Invariants: the state has 5 degrees of freedom and the Hamiltonian 7"));
}

TEST_CASE("Observers of fixed size refuse longer states, and Invariants a name that is there",
          "[observers]") {
  PhasePoint<double, Eigen::Dynamic> three(3);
  three.q() << 1, 2, 3;
  Record<double, 2> record;
  CHECK(refuses([&] { record(0.0, three); }, "Record: the state has 3 degrees of freedom"));
  Invariants<double, 2> two;
  two.add("f", [](const auto& q, const auto&) { return q.norm(); });
  CHECK(refuses([&] { two(0.0, three); }, "Invariants: the state has 3 degrees of freedom"));
  CHECK(refuses([&] { two.add("f", [](const auto& q, const auto&) { return q[0]; }); },
                "a function named 'f' already"));
  two(0.0, PhasePoint<double, 2>({1, 2}, {0, 0}));
  CHECK_FALSE(two.fresh());
  two.add("g", [](const auto& q, const auto&) { return q[0]; });
  CHECK(two.fresh());  // a run that is resumed would take its error from there
}

TEST_CASE("A first value that is zero up to rounding is not what errors are relative to", "[observers]") {
  // A light ray: H = 0, and -1.5e-16 in numbers, of terms of size one.
  const effects::black_hole::Schwarzschild<> hole;
  const Scene light(hole);
  const double r = 20, L = 6, f = 1 - 2 / r, pr = -std::sqrt((1 / f - L * L / (r * r)) / f);
  PhasePoint<double, 4> z({0, r, std::acos(0.0), 0}, {-1, pr, 0, L});
  Invariants errors(light);
  Semiexplicit stepper(light, schemes::low_defect8_s20());
  integrate(stepper, z, {.dt = 0.1, .steps = 200}, errors);
  CHECK(errors["energy"].initial != 0);
  CHECK_FALSE(errors["energy"].relative);
  CHECK(errors["energy"].unit == 1);
  CHECK(errors["energy"].worst < 1e-12);

  // An angular momentum whose two terms cancel but for a digit, in three kinds of number.
  const auto spin = []<class Scalar>(Scalar third, double momentum) {
    Invariants<Scalar, 2> all;
    all.add("L", [](const auto& q, const auto& p) { return q[0] * p[1] - q[1] * p[0]; });
    PhasePoint<Scalar, 2> at({third, 3}, {third * third, Scalar(momentum)});
    all(0, at);
    at.q()[0] += Scalar(0.125);
    all(1, at);
    return all.rows().front();
  };
  for (const double rounding : {0.0, 2e-16, 1e-15}) CHECK_FALSE(spin(1.0 / 3, 1 + rounding).relative);
  CHECK_FALSE(spin(1.0f / 3, 1 + 1e-6).relative);
  CHECK_FALSE(spin(1.0L / 3, 1).relative);
  CHECK(spin(1.0 / 3, 1 + 1e-9).relative);
  CHECK(spin(1.0f / 3, 1.01).relative);
  CHECK(spin(1.0 / 3, 1 + 1e-15).worst == Approx(0.125));
  CHECK(spin(1.0 / 3, 2).worst == Approx(0.75));

  // A small oscillation far from the origin: its energy is far above what rounding of q makes of it.
  const auto spring = []<class Scalar>(Scalar far) {
    Invariants<Scalar, 1> all;
    all.add("E",
            [far](const auto& q, const auto& p) { return (p[0] * p[0] + (q[0] - far) * (q[0] - far)) / 2; });
    const Scalar size = far * 2000 * Eigen::NumTraits<Scalar>::epsilon();
    all(0, PhasePoint<Scalar, 1>(far + size, 0));
    all(1, PhasePoint<Scalar, 1>(far + size / 2, 0));
    return all.rows().front();
  };
  CHECK(spring(1e6).relative);
  CHECK(spring(1e6).worst == Approx(0.75).epsilon(0.01));
  CHECK(spring(1e3f).worst == Approx(0.75).epsilon(0.01));
}

TEST_CASE("A CSV file reads back exactly", "[observers]") {
  const Folder folder;
  const fs::path path = folder.path / "table.csv";
  const std::vector<std::vector<double>> rows{{0, 0.1, 1.0 / 3},
                                              {-1e-300, 5e-324, std::numeric_limits<double>::max()},
                                              {1e22, -0.0, 123456789.123456789}};
  {
    CsvWriter writer(path, {"t", "x", "y"});
    for (const auto& row : rows) writer.row(row);
    CHECK_FALSE(fs::exists(path));  // not before it is whole
    writer.commit();
  }
  CHECK(fs::exists(path));
  CHECK_FALSE(fs::exists(path.string() + ".part"));
  CHECK(says(contents(path), "t,x,y\n0,0.1,0.3333333333333333\n"));
  const auto read = numbers(path);
  REQUIRE(read.size() == 3);
  CHECK(read[0] == rows[0]);
  CHECK(read[2] == rows[2]);
  std::ifstream in(path);
  std::string line;
  for (int n = 0; n < 3; ++n) std::getline(in, line);
  CHECK(line == "-1e-300,5e-324,1.7976931348623157e+308");

  // A second one takes its place.
  CsvWriter second(path, {"only"});
  second.row({7});
  second.commit();
  CHECK(contents(path) == "only\n7\n");
}

TEST_CASE("What cannot be written is named", "[observers]") {
  const Folder folder;
  const fs::path nowhere = folder.path / "no" / "such" / "folder.csv";
  CHECK(says(message<std::runtime_error>([&] { CsvWriter writer(nowhere, {"t"}); }), nowhere.string()));
  CHECK(
      says(message<std::runtime_error>([&] { CsvTrajectory trajectory(nowhere, 2); }), "cannot be written"));

  const fs::path path = folder.path / "rows.csv";
  CsvWriter writer(path, {"t", "x"});
  const std::string text = message<std::invalid_argument>([&] { writer.row({1, 2, 3}); });
  CHECK(says(text, path.string()));
  CHECK(says(text, "a row of 3 numbers for 2 columns"));
  CHECK(says(message<std::invalid_argument>([&] { writer.row({}); }), "0 numbers"));
  writer.row({1, 2});
  writer.commit();
  CHECK(contents(path) == "t,x\n1,2\n");

  // The name is taken by a folder.
  const fs::path taken = folder.path / "taken";
  fs::create_directory(taken);
  std::ofstream(taken / "file") << "x";
  CHECK(says(message<std::runtime_error>([&] { CsvWriter other(taken, {"t"}); }), taken.string()));
}

TEST_CASE("A trajectory is written with its columns named", "[observers]") {
  const Folder folder;
  const fs::path path = folder.path / "trajectory.csv";
  PhasePoint<double, 2> z({1, 0.5}, {0.2, -0.3});
  Semiexplicit stepper(systems::NlsLattice<double, 2>{}, schemes::blanes_moan4());
  Record<double, 2> record;
  CsvTrajectory trajectory(path, 2);
  integrate(stepper, z, {.dt = 0.1, .steps = 5}, trajectory, record);
  trajectory.commit();
  CHECK(says(contents(path), "t,q0,q1,p0,p1\n"));
  const auto rows = numbers(path);
  REQUIRE(rows.size() == 6);
  for (std::size_t n = 0; n < 6; ++n) {
    const auto v = record.z[n].vector();
    CHECK(rows[n] == std::vector<double>{record.t[n], v[0], v[1], v[2], v[3]});
  }
}

#if !defined(_WIN32)
TEST_CASE("The progress bar is silent where stderr is no terminal", "[observers]") {
  const Folder folder;
  const fs::path path = folder.path / "stderr.txt";
  std::fflush(stderr);
  const int saved = dup(STDERR_FILENO);
  REQUIRE(saved >= 0);
  REQUIRE(std::freopen(path.c_str(), "w", stderr) != nullptr);
  {
    Progress progress(1.0, "run");
    const auto start = std::chrono::steady_clock::now();
    // Longer than the tenth of a second between two drawings.
    for (int n = 0; std::chrono::steady_clock::now() - start < std::chrono::milliseconds(250); ++n)
      progress(1e-6 * n, Point(0, 0));
  }
  std::fflush(stderr);
  dup2(saved, STDERR_FILENO);
  close(saved);
  CHECK(contents(path).empty());
}

}  // namespace test_observers

#endif
