#include "catch.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "forward_gradient.hpp"
#include "gradient_of.hpp"
#include "lattice_energy.hpp"

namespace test_terms {

// Sums of terms: against gradients by hand and against dual numbers.

namespace {

using namespace semiexplicit;
using Eigen::Index;

template <class Scalar = double>
PhasePoint<Scalar, Eigen::Dynamic> some_point(Index dof) {
  PhasePoint<Scalar, Eigen::Dynamic> z(dof);
  for (Index i = 0; i < 2 * dof; ++i)
    z.vector()[i] = Scalar(std::sin(1.0 + 1.7 * static_cast<double>(i)) + 0.01 * static_cast<double>(i % 7));
  return z;
}

/// How far the gradient of that energy is from its derivatives one by one, at the first call and later,
/// relative to its size.
template <class Energy, class Scalar, int Dof>
double error_at(const Energy& energy, const PhasePoint<Scalar, Dof>& z) {
  const auto h = from_energy<Scalar>(z.dof(), energy);
  const auto right = forward_gradient(energy, PhasePoint<Scalar, Eigen::Dynamic>(z.q(), z.p()));
  double worst = 0;
  for (int call = 0; call < 3; ++call) {
    const Scalar off =
        detail::norm(gradient_of(h, PhasePoint<Scalar, Eigen::Dynamic>(z.q(), z.p())) - right) /
        (1 + detail::norm(right));
    worst = std::max(worst, static_cast<double>(off));
  }
  return worst;
}
template <class Energy>
double error_of(Index dof, const Energy& energy) {
  return error_at(energy, some_point(dof));
}

/// A Fermi-Pasta-Ulam-Tsingou chain in a ring.
auto ring(Index n) {
  return [n](const auto& q, const auto& p) {
    return sum_over(n, [&](auto i) { return p[i] * p[i] / 2; }) + sum_over(n, [&](auto i) {
             const auto r = q[(i + 1) % n] - q[i];
             return r * r / 2 + 0.25 * r * r * r / 3 + 0.1 * r * r * r * r / 4;
           });
  };
}

}  // namespace

TEST_CASE("A lattice by its sites and bonds has the gradient by hand, whatever its size", "[terms]") {
  for (Index n = 1; n <= 70; n += n < 20 ? 1 : 7) {
    CAPTURE(n);
    const auto z = some_point(n);
    const systems::NlsLattice<double> hand(n);
    const auto h = from_energy(n, lattice_by_terms(n));
    CHECK((gradient_of(h, z) - gradient_of(hand, z)).norm() <= 1e-14 * gradient_of(hand, z).norm() + 1e-15);
    CHECK(h.energy(z.q(), z.p()) == Approx(hand.energy(z.q(), z.p())).epsilon(1e-13));
  }
  const auto fixed = from_energy<40>(lattice_by_terms(40));
  const PhasePoint<double, 40> z(some_point(40).q(), some_point(40).p());
  CHECK((gradient_of(fixed, z) - gradient_of(systems::NlsLattice<double, 40>(), z)).norm() <= 1e-13);
  CHECK(error_of(300, lattice_by_terms(300)) <= 1e-15);
}

TEST_CASE("A ring of any length has the gradient by hand", "[terms]") {
  for (Index n = 9; n <= 45; ++n) {
    CAPTURE(n);
    const auto z = some_point(n);
    Eigen::VectorXd hand(2 * n);
    hand.setZero();
    for (Index i = 0; i < n; ++i) {
      const double r = z.q()[(i + 1) % n] - z.q()[i];
      const double force = r + 0.25 * r * r + 0.1 * r * r * r;
      hand[(i + 1) % n] += force;
      hand[i] -= force;
      hand[n + i] = z.p()[i];
    }
    CHECK((gradient_of(from_energy(n, ring(n)), z) - hand).norm() <= 1e-14 * hand.norm());
  }
}

TEST_CASE("Vortices by pairs have the gradient by hand", "[terms]") {
  for (const Index n : {3, 9, 17, 40}) {
    CAPTURE(n);
    Eigen::VectorXd gamma(n), x_per_q(n), y_per_p(n);
    for (Index i = 0; i < n; ++i) {
      gamma[i] = std::cos(3.0 * static_cast<double>(i)) + 1.5 * (i % 2 == 0 ? 1 : -1);
      x_per_q[i] = 1 / std::sqrt(std::abs(gamma[i]));
      y_per_p[i] = std::copysign(x_per_q[i], gamma[i]);
    }
    const auto z = some_point(n);
    const auto right = gradient_of(systems::PointVortices<double>(gamma), z);
    const auto pairs = [&](const auto& parameter) {
      return from_energy(n, [=](const auto& q, const auto& p) {
        using std::log;
        return sum_over_pairs(n,
                              [&](auto i, auto j) {
                                const auto dx = q[i] * parameter(x_per_q, i) - q[j] * parameter(x_per_q, j);
                                const auto dy = p[i] * parameter(y_per_p, i) - p[j] * parameter(y_per_p, j);
                                return parameter(gamma, i) * parameter(gamma, j) * log(dx * dx + dy * dy);
                              }) /
               (-4 * std::numbers::pi);
      });
    };
    const auto by_at = pairs([](const auto& array, auto i) { return at(array, i); });
    const auto by_index = pairs([](const auto& array, auto i) { return array[i]; });
    CHECK((gradient_of(by_at, z) - right).norm() <= 1e-13 * right.norm());
    CHECK((gradient_of(by_index, z) - right).norm() <= 1e-13 * right.norm());
  }
}

TEST_CASE("Particles in space, three coordinates each, have the gradient by hand", "[terms]") {
  const Index n = 14;
  const std::vector<double> mass{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  const auto z = some_point(3 * n);
  const auto h = from_energy(3 * n, [=](const auto& q, const auto& p) {
    using std::sqrt;
    const auto kinetic = sum_over(n, [&](auto i) {
      return (p[3 * i] * p[3 * i] + p[3 * i + 1] * p[3 * i + 1] + p[3 * i + 2] * p[3 * i + 2]) /
             (2 * at(mass, i));
    });
    return kinetic + sum_over_pairs(n, [&](auto i, auto j) {
             auto square = 0 * q[3 * i] + 0.01;  // softened
             for (int k = 0; k < 3; ++k) {
               const auto distance = q[3 * i + k] - q[3 * j + k];
               square += distance * distance;
             }
             return -at(mass, i) * at(mass, j) / sqrt(square);
           });
  });
  Eigen::VectorXd hand(6 * n);
  hand.setZero();
  for (Index i = 0; i < n; ++i) {
    const double m = mass[std::size_t(i)];
    hand.segment(3 * n + 3 * i, 3) = z.p().segment(3 * i, 3) / m;
    for (Index j = 0; j < n; ++j) {
      if (j == i) continue;
      const Eigen::Vector3d r = z.q().segment(3 * i, 3) - z.q().segment(3 * j, 3);
      hand.segment(3 * i, 3) += m * mass[std::size_t(j)] * r / std::pow(r.squaredNorm() + 0.01, 1.5);
    }
  }
  CHECK((gradient_of(h, z) - hand).norm() <= 1e-13 * hand.norm());
}

TEST_CASE("Parameters come from arrays of any kind", "[terms]") {
  const Index n = 37;
  std::vector<double> plain(std::size_t(n), 0.0);
  std::vector<float> small(std::size_t(n), 0.0f);
  Eigen::VectorXd column(n);
  std::array<int, 37> whole{};
  Eigen::VectorXi whole_column(n);
  for (Index i = 0; i < n; ++i) {
    plain[std::size_t(i)] = std::sin(static_cast<double>(i));
    small[std::size_t(i)] = static_cast<float>(i);
    column[i] = 1.0 / static_cast<double>(i + 1);
    whole_column[i] = whole[std::size_t(i)] = static_cast<int>(i % 5);
  }
  const double* const pointer = plain.data();
  const Eigen::MatrixXd coupling = column * column.transpose();
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(n, [&](auto i) {
            return at(plain, i) * q[i] * q[i] + at(small, i) * p[i] + at(column, i) * q[i] * p[i] +
                   at(whole, i) * p[i] * p[i] + at(whole_column, i) * q[i] + at(pointer, i) +
                   at(column.reverse(), i) * q[i];
          });
        }) <= 1e-15);
  // Neighbours' parameters, in a ring, too, and a number a pair.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(
                     n,
                     [&](auto i) { return at(plain, (i + 1) % n) * q[i] * p[(i + 1) % n] * at(column, i); }) +
                 sum_over_pairs(n, [&](auto i, auto j) { return at(coupling.col(j), i) * q[i] * p[j]; });
        }) <= 1e-15);
  // A column and a row of a matrix of parameters.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(
              n, [&](auto i) { return at(coupling, i, 0) * q[i] * q[i] + at(coupling, 2, i) * p[i] * p[i]; });
        }) <= 1e-15);
  // Plain arrays have one number at a time.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(n, [&](auto i) { return pointer[i] * q[i] * q[i] + column[i] * p[i] + i * q[i]; }) +
                 sum_over_pairs(n,
                                [&](auto i, auto j) { return at(coupling, i, j) * q[i] * p[j] * (j - i); });
        }) <= 1e-15);
}

TEST_CASE("Functions of two arguments take numbers, parameters and coordinates in either place", "[terms]") {
  const Index n = 23;
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(n, 0.3, 1.7);
  const auto next = [](Index i) { return (7 * i + 2) % n; };
  Eigen::Matrix<Index, Eigen::Dynamic, 1> table(n);
  for (Index i = 0; i < n; ++i) table[i] = next(i);
  const auto energy = [&](const auto& q, const auto& p) {
    using std::atan2, std::hypot, std::pow;
    return sum_over(n, [&](auto i) {
      return q[i] * (pow(0.6, at(a, i)) + hypot(0.6, at(a, i)) + hypot(at(a, i), 2) + atan2(0.6, at(a, i)) +
                     atan2(at(a, i), 0.6) + pow(at(a, i), 1.5) + pow(at(a, i), -2)) +
             p[i] * p[i] + pow(2 + q[table[i]], p[i]) + pow(2 + q[i], p[table[i]]) + pow(1.5, p[i]);
    });
  };
  const auto h = from_energy(n, energy);
  const auto z = some_point(n);
  Eigen::VectorXd right(2 * n);
  right.setZero();
  for (Index i = 0; i < n; ++i) {
    const Index j = next(i);
    const double A = a[i], x = 2 + z.q()[i], y = 2 + z.q()[j], X = z.p()[i], Y = z.p()[j];
    right[i] += std::pow(0.6, A) + std::hypot(0.6, A) + std::hypot(A, 2) + std::atan2(0.6, A) +
                std::atan2(A, 0.6) + std::pow(A, 1.5) + 1 / (A * A) + Y * std::pow(x, Y - 1);
    right[j] += X * std::pow(y, X - 1);
    right[n + i] += 2 * X + std::log(y) * std::pow(y, X) + std::log(1.5) * std::pow(1.5, X);
    right[n + j] += std::log(x) * std::pow(x, Y);
  }
  CHECK((gradient_of(h, z) - right).norm() < 1e-14 * right.norm());
}

TEST_CASE("Integers of an array are integers in the gradient, too", "[terms]") {
  const Index n = 37;
  std::vector<int> kind(std::size_t(n), 0);
  std::vector<unsigned> label(std::size_t(n), 0u);
  Eigen::VectorXi column(n);
  Eigen::MatrixXi table(n, n);
  for (Index i = 0; i < n; ++i) {
    kind[std::size_t(i)] = static_cast<int>(1 + i % 5);
    label[std::size_t(i)] = static_cast<unsigned>(i % 3);
    column[i] = static_cast<int>(i % 7);
    for (Index j = 0; j < n; ++j) table(i, j) = static_cast<int>((3 * i + j) % 5);
  }
  const int* const pointer = kind.data();
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(n, [&](auto i) {
            return (at(kind, i) / 2) * q[i] * q[i] + q[i] * p[i] * (at(column, i) / at(kind, i)) +
                   p[i] * p[i] * (7 / at(pointer, i)) + q[i] * ((at(kind, i) + i) / 2) +
                   p[i] * (at(column, i) % 2);
          });
        }) <= 1e-15);
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(n - 1, [&](auto i) {
            return 1e-9 * (at(label, i) - at(label, i + 1)) * q[i] * q[i + 1] + p[i] * p[i];
          });
        }) <= 1e-15);
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over_pairs(n, [&](auto i, auto j) {
            return (at(kind, j) / 2) * q[i] * p[j] + p[i] * p[j] * (at(kind, i) / at(kind, j)) +
                   q[i] * q[j] * (at(table, i, j) / 2) + q[i] * (at(table, j, 1) / 3) +
                   q[j] * (at(table, 2, i) / 3);
          });
        }) <= 1e-15);
}

TEST_CASE("Terms may branch", "[terms]") {
  const Index n = 50;
  const auto by_value = [=](const auto& q, const auto& p) {
    using std::abs;
    return sum_over(n, [&](auto i) {
      if (q[i] < 0.3) return q[i] * q[i] * p[i];
      return abs(p[i]) * q[i];
    });
  };
  CHECK(error_of(n, by_value) <= 1e-15);
  auto all_low = some_point(n), all_high = all_low;
  all_low.q().array() -= 5;
  all_high.q().array() += 5;
  CHECK(error_at(by_value, all_low) <= 1e-15);
  CHECK(error_at(by_value, all_high) <= 1e-15);
  const auto by_index = [=](const auto& q, const auto& p) {
    const auto bond = [&](auto i, auto k) { return q[i] * p[k] + q[k] * q[k]; };
    return sum_over(n, [&](auto i) { return i == 0 || i >= n - 2 ? bond(i, 3) : bond(i - 1, i + 2); }) +
           sum_over(n, [&](auto i) { return i % 2 == 0 ? q[i] * q[i] : -p[i] * p[i]; }) +
           sum_over(n, [&](auto i) { return q[i] * q[i + 1 < n ? i + 1 : Index(0)]; });
  };
  CHECK(error_of(n, by_index) <= 1e-15);
  // From some term on another place, another distance, none at all, or beyond the end were it not for that.
  const auto changing = [=](const auto& q, const auto& p) {
    return sum_over(n, [&](auto i) { return p[i] * (i < 32 ? q[i + 1] : q[i - 7]); }) +
           sum_over(n, [&](auto i) { return p[i] * (i < 32 ? q[i] : q[2 * i - 64]); }) +
           sum_over(n, [&](auto i) { return i < 16 ? q[i] * q[i] : p[i] * q[i] * 2; }) +
           sum_over(n, [&](auto i) { return p[i] * p[i] * (i < 32 ? q[i + 18] : q[i - 32]); });
  };
  CHECK(error_of(n, changing) <= 1e-15);
  // An iteration that takes as long as the term's value asks for.
  const auto root = [=](const auto& q, const auto& p) {
    return sum_over(n, [&](auto i) {
      auto x = 1 + q[i] * q[i];
      const auto square = x;
      for (int k = 0; k < 60 && (x * x - square > 1e-15 || square - x * x > 1e-15); ++k)
        x = (x + square / x) / 2;
      return x * p[i];
    });
  };
  CHECK(error_of(n, root) <= 1e-12);
  const auto cut = [=](const auto& q, const auto& p) {
    using std::max, std::min;
    return sum_over_pairs(n, [&](auto i, auto j) {
      const auto near = max(1 - (q[i] - q[j]) * (q[i] - q[j]), 0.0);
      return near * near + min(p[i], p[j]);
    });
  };
  CHECK(error_of(n, cut) <= 1e-14);
}

TEST_CASE("A guarded term gets no numbers that are not there", "[terms]") {
  // The last terms' lanes reach beyond the end: what a branch keeps from there may throw, go on, or not
  // exist.
  for (const Index n : {5, 8, 32, 50}) {
    CAPTURE(n);
    PhasePoint<double, Eigen::Dynamic> positive = some_point(n);
    positive.vector().array() += 1.5;
    const auto throwing = [=](const auto& q, const auto&) {
      using std::log;
      return sum_over(n, [&](auto i) {
        auto sum = q[i] * q[i];
        if (i >= n - 1) return sum;
        const auto next = q[i + 1];
        if (!(next > 0)) throw std::domain_error("q is not positive");
        return sum + log(next) * q[i];
      });
    };
    CHECK(error_at(throwing, positive) <= 1e-15);
    const auto iterating = [=](const auto& q, const auto&) {
      return sum_over(n, [&](auto i) {
        auto sum = q[i] * q[i];
        if (i < n - 1) {  // Heron's root of the next
          const auto next = q[i + 1];
          auto x = next;
          for (int k = 0; x * x - next > 1e-14 || next - x * x > 1e-14; ++k) {
            if (k == 100) throw std::runtime_error("the iteration does not end");
            x = (x + next / x) / 2;
          }
          sum += q[i] * x;
        }
        return sum;
      });
    };
    PhasePoint<double, Eigen::Dynamic> equal(n);
    equal.vector().setConstant(2.5);
    CHECK(error_at(iterating, equal) <= 1e-12);
    CHECK(error_at(iterating, positive) <= 1e-12);
    // Behind the n - 1 constants lies what no constant is.
    std::vector<double> bonds(static_cast<std::size_t>(n), 0.5);
    bonds.back() = std::nan("");
    const std::span<const double> there(bonds.data(), bonds.size() - 1);
    const Eigen::Map<const Eigen::VectorXd> mapped(bonds.data(), n - 1);
    const auto bond = [=](const auto& constants) {
      return [=](const auto& q, const auto&) {
        return sum_over(n, [&](auto i) {
          auto sum = q[i] * q[i];
          if (i < n - 1) {
            const auto k = at(constants, i);
            if (!(k > 0.4)) throw std::runtime_error("a constant that is none");
            sum += k * (q[i + 1] - q[i]) * (q[i + 1] - q[i]);
          }
          return sum;
        });
      };
    };
    CHECK(error_of(n, bond(there)) <= 1e-15);
    CHECK(error_of(n, bond(mapped)) <= 1e-15);
  }
}

TEST_CASE("A term may reach far and touch many variables", "[terms]") {
  const Index n = 60;
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(n - 12, [&](auto i) {
            auto sum = q[i] * p[i];
            for (int k = 1; k <= 12; ++k) sum += q[i + k] * p[i] / k;
            return sum * sum;
          });
        }) <= 1e-14);
  for (const Index reach : {1, 2, 5, 8, 11}) {
    CAPTURE(reach);
    CHECK(error_of(n, [=](const auto& q, const auto& p) {
            return sum_over(n, [&](auto i) {
              const auto before = (i + n - reach) % n, behind = (i + reach) % n;
              return q[i] * q[behind] * p[before] + q[before] * q[i] * p[i] * p[behind];
            });
          }) <= 1e-15);
  }
  // Every term touches everything.
  CHECK(error_of(14, [](const auto& q, const auto& p) {
          return sum_over(14, [&](auto i) {
            auto product = q[i] * p[i];
            for (Index k = 0; k < 14; ++k) product *= 1 + q[k] * p[k] / 10;
            return product;
          });
        }) <= 1e-14);
  // Places out of a table, backwards, and every other one.
  const std::vector<Index> table{3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5, 8, 9, 7, 9, 3, 2, 3, 8, 4};
  CHECK(error_of(41, [=](const auto& q, const auto& p) {
          return sum_over(20, [&](auto i) { return q[table[std::size_t(i)]] * p[i] * q[i]; }) +
                 sum_over(41, [&](auto i) { return q[40 - i] * p[i]; }) +
                 sum_over(20, [&](auto i) { return q[2 * i] * p[2 * i + 1] * q[i] * p[40 - 2 * i]; });
        }) <= 1e-15);
}

TEST_CASE("Sums go together with other terms and with each other", "[terms]") {
  const Index n = 30;
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return 2 * sum_over(n, [&](auto i) { return q[i] * q[i]; }) + q[0] * p[3] -
                 q.squaredNorm() / sum_over(n, [&](auto i) { return 1 + p[i] * p[i]; });
        }) <= 1e-14);
  // A mean field: a square and a root of sums, whose values are needed.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          using std::cos, std::sin, std::sqrt;
          const auto c = sum_over(n, [&](auto i) { return cos(q[i]); });
          const auto s = sum_over(n, [&](auto i) { return sin(q[i]); });
          const auto kinetic = sum_over(n, [&](auto i) { return p[i] * p[i] / 2; });
          return kinetic - (c * c + s * s) / (2.0 * n) + sqrt(1 + kinetic);
        }) <= 1e-14);
  // One whose value decides.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          const auto sum = sum_over(n, [&](auto i) { return q[i] * p[i]; });
          return sum > 0 ? sum : -3 * sum;
        }) <= 1e-14);
  // Relative to the mean, which is computed before.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          const auto mean = q.sum() / n;
          return sum_over(n, [&](auto i) { return (q[i] - mean) * (q[i] - mean) * p[i]; });
        }) <= 1e-14);
  // A sum in a sum, and a sum that starts as a number of the column.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          typename std::decay_t<decltype(q)>::Scalar total(1);
          total += sum_over(
              n, [&](auto i) { return sum_over(n, [&](auto j) { return q[i] * q[j] * p[j]; }) * p[i]; });
          total += sum_over(5, [&](auto i) {
            return p[i] * sum_over(3, [&](auto k) { return q[i] * (1.0 + static_cast<double>(k)); });
          });
          total += sum_over(n, [&](auto i) {
            typename std::decay_t<decltype(q)>::Scalar inner(0);
            inner += q[i] * p[i];
            return inner;
          });
          return total;
        }) <= 1e-14);
  // Nothing to add, numbers only.
  CHECK(error_of(n, [=](const auto& q, const auto& p) {
          return sum_over(0, [&](auto i) { return q[i]; }) +
                 sum_over_pairs(1, [&](auto i, auto) { return q[i]; }) +
                 sum_over(n, [](auto) { return 2.0; }) + p[1];
        }) <= 1e-15);
}

TEST_CASE("An energy may change from one way to the other between calls", "[terms]") {
  // Whether the value of a sum is needed is remembered, and may be wrong.
  const Index n = 20;
  double bound = 1e9;
  const auto energy = [&bound, n](const auto& q, const auto& p) {
    const auto sum = sum_over(n, [&](auto i) { return q[i] * q[i] * p[i] * p[i]; });
    return bound > 1 ? sum : sum * sum;
  };
  const auto h = from_energy(n, energy);
  const auto z = some_point(n);
  for (const double now : {1e9, 1e9, 0.0, 0.0, 1e9, 0.0}) {
    bound = now;
    const auto right = forward_gradient(energy, z);
    CHECK((gradient_of(h, z) - right).norm() <= 1e-14 * right.norm());
  }
}

TEST_CASE("Terms have the precision of their numbers", "[terms]") {
  const auto precise = []<class Scalar>(Scalar) {
    const auto off = error_at(ring(19), some_point<Scalar>(19));
    const auto pairs = error_at(
        [](const auto& q, const auto& p) {
          using std::sqrt;
          return sum_over_pairs(15, [&](auto i, auto j) {
            return 1 / sqrt(1 + (q[i] - q[j]) * (q[i] - q[j]) + p[i] * p[j] * p[i] * p[j]);
          });
        },
        some_point<Scalar>(15));
    return std::max(off, pairs) / static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());
  };
  CHECK(precise(1.0f) <= 20);
  CHECK(precise(1.0) <= 20);
  CHECK(precise(1.0L) <= 20);
  CHECK(precise(boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                              boost::multiprecision::et_off>(1)) <= 20);
}

TEST_CASE("A number that is multiplied by 0 is the same one in all terms", "[terms]") {
  const auto z = some_point(32);
  for (const int stride : {0, 1}) {
    const auto energy = [stride](const auto& q, const auto& p) {
      return sum_over(24, [&, stride](auto i) {
        return p[i] * p[i] * (1 + p[stride * i + 7] * q[stride * i + 6]) + q[stride * i + 5] * q[i + 4];
      });
    };
    const auto right = forward_gradient(energy, z);
    CHECK((gradient_of(from_energy(32, energy), z) - right).norm() <= 1e-13 * right.norm());
  }
}

TEST_CASE("Roots at the ends of the range are the same in lanes as one by one", "[terms]") {
  for (const float scale : {1e-22F, 3e-20F, 1.0F, 1e18F}) {
    PhasePoint<float, Eigen::Dynamic> z(16);
    for (Index i = 0; i < 16; ++i) {
      z.q()[i] = scale * (1 + 0.37F * static_cast<float>(i));
      z.p()[i] = scale * (2 - 0.11F * static_cast<float>(i));
    }
    const auto lanes = gradient_of(
        from_energy<float>(16,
                           [](const auto& q, const auto& p) {
                             return sum_over(16, [&](auto i) { return sqrt(q[i] * q[i] + p[i] * p[i]); });
                           }),
        z);
    const auto single = gradient_of(
        from_energy<float>(16,
                           [](const auto& q, const auto& p) {
                             return sum_over(16, [&](Index i) { return sqrt(q[i] * q[i] + p[i] * p[i]); });
                           }),
        z);
    CAPTURE(scale);
    if (scale > 1e-21F) CHECK((lanes - single).norm() <= 1e-5F * single.norm());
    CHECK(lanes.allFinite() == single.allFinite());
  }
}

TEST_CASE("a power of a term by a float is as exact as that by the same double", "[terms]") {
  const int n = 16;
  const auto energy = [n](auto power) {
    return from_energy(n, [=](const auto& q, const auto& p) {
      using std::pow;
      return sum_over(n, [&](auto i) { return p[i] * p[i] / 2 + pow(q[i] * q[i] + 1, power); });
    });
  };
  for (const float power : {0.1f, 0.7f, -2.7f}) {
    CAPTURE(power);
    const Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(n, 0.5, 7), p = q;
    Eigen::VectorXd dHdq(n), dHdp(n), by_double(n);
    energy(power).gradient(q, p, dHdq, dHdp);
    energy(double(power)).gradient(q, p, by_double, dHdp);
    CHECK((dHdq - by_double).cwiseQuotient(by_double).norm() < 1e-15);
  }
}

}  // namespace test_terms
