#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/derivatives/functions.hpp>

namespace semiexplicit::detail::autodiff {

/// Set where the terms in the lanes part ways, or one asks for what only a single term has: they are then
/// evaluated one by one.
inline bool& lanes_part() {
  thread_local constinit bool part = false;
  return part;
}

/// Lanes in a register: packs are vectors of g++ and clang++, and need no header. 0: none.
#if defined(__GNUC__)
#if defined(__AVX512F__)
inline constexpr int register_bytes = 64;
#elif defined(__AVX__)
inline constexpr int register_bytes = 32;
#else
inline constexpr int register_bytes = 16;
#endif
#else
inline constexpr int register_bytes = 0;
#endif
template <class S>
inline constexpr int lanes_of = std::same_as<S, double> || std::same_as<S, float>
                                    ? register_bytes / int(sizeof(S))
                                    : 0;

/// A value for each of some neighbouring terms of a sum. A comparison is that of the first lane, and
/// lanes_part() where another's is different.
template <class S>
struct LanePack {
#if defined(__GNUC__)
  typedef S Lanes
      __attribute__((vector_size(lanes_of<S> * sizeof(S))));  // NOLINT: no alias of such a type in a template
#else
  using Lanes = S;
#endif
  static constexpr int size = lanes_of<S>;
  Lanes lanes;

  LanePack() = default;
  SEMIEXPLICIT_INTO_TERM LanePack(const Lanes& from) : lanes(from) {}  // NOLINT
  template <class U>
  requires(std::is_arithmetic_v<U>) SEMIEXPLICIT_INTO_TERM LanePack(const U& all)
      : lanes(static_cast<S>(all) - Lanes{}) {}  // NOLINT: the same in all lanes

  /// The numbers of the terms themselves.
  template <class Index>
  requires requires(const Index& i) { i.place().of_lane(0); }
  SEMIEXPLICIT_INTO_TERM LanePack(const Index& i) {  // NOLINT
    for (int k = 0; k < size; ++k) lanes[k] = static_cast<S>(i.place().of_lane(k));
  }

  static SEMIEXPLICIT_INTO_TERM LanePack load(const S* from) {
    LanePack x;
    __builtin_memcpy(&x.lanes, from, sizeof(Lanes));
    return x;
  }
  SEMIEXPLICIT_INTO_TERM void store(S* to) const { __builtin_memcpy(to, &lanes, sizeof(Lanes)); }
  template <class F>
  static SEMIEXPLICIT_INTO_TERM LanePack of(const F& f) {
    LanePack x;
    for (int k = 0; k < size; ++k) x.lanes[k] = f(k);
    return x;
  }
  /// The first lane's, for what takes no pack.
  operator S() const {  // NOLINT
    lanes_part() = true;
    return lanes[0];
  }

#define SEMIEXPLICIT_ON_LANES(op)                                                                           \
  friend SEMIEXPLICIT_INTO_TERM LanePack operator op(const LanePack& x, const LanePack& y) {                \
    return LanePack(x.lanes op y.lanes);                                                                    \
  }                                                                                                         \
  template <class U>                                                                                        \
  requires(std::is_arithmetic_v<U>) friend SEMIEXPLICIT_INTO_TERM LanePack operator op(const LanePack& x,   \
                                                                                       const U& y) {        \
    return LanePack(x.lanes op LanePack(y).lanes);                                                          \
  }                                                                                                         \
  template <class U>                                                                                        \
  requires(std::is_arithmetic_v<U>) friend SEMIEXPLICIT_INTO_TERM LanePack operator op(const U& x,          \
                                                                                       const LanePack& y) { \
    return LanePack(LanePack(x).lanes op y.lanes);                                                          \
  }                                                                                                         \
  friend SEMIEXPLICIT_INTO_TERM LanePack& operator op##=(LanePack& x, const LanePack& y) {                  \
    return x = x op y;                                                                                      \
  }
  SEMIEXPLICIT_ON_LANES(+)
  SEMIEXPLICIT_ON_LANES(-)
  SEMIEXPLICIT_ON_LANES(*)
  SEMIEXPLICIT_ON_LANES(/)
#undef SEMIEXPLICIT_ON_LANES
  friend SEMIEXPLICIT_INTO_TERM LanePack operator-(const LanePack& x) { return LanePack(-x.lanes); }
  friend SEMIEXPLICIT_INTO_TERM LanePack operator+(const LanePack& x) { return x; }

#define SEMIEXPLICIT_ON_LANES(op)                                                            \
  friend bool operator op(const LanePack& x, const LanePack& y) {                            \
    return agreed([&](int k) { return x.lanes[k] op y.lanes[k]; });                          \
  }                                                                                          \
  template <class U>                                                                         \
  requires(std::is_arithmetic_v<U>) friend bool operator op(const LanePack& x, const U& y) { \
    return x op LanePack(y);                                                                 \
  }                                                                                          \
  template <class U>                                                                         \
  requires(std::is_arithmetic_v<U>) friend bool operator op(const U& x, const LanePack& y) { \
    return LanePack(x) op y;                                                                 \
  }
  SEMIEXPLICIT_ON_LANES(==)
  SEMIEXPLICIT_ON_LANES(!=)
  SEMIEXPLICIT_ON_LANES(<)
  SEMIEXPLICIT_ON_LANES(<=)
  SEMIEXPLICIT_ON_LANES(>)
  SEMIEXPLICIT_ON_LANES(>=)
#undef SEMIEXPLICIT_ON_LANES
  template <class F>
  static SEMIEXPLICIT_INTO_TERM bool agreed(const F& f) {
    const bool first = f(0);
    for (int k = 1; k < size; ++k)
      if (f(k) != first) lanes_part() = true;
    return first;
  }

  friend SEMIEXPLICIT_INTO_TERM LanePack sqrt(const LanePack& x) {
    Eigen::Array<S, size, 1> root_of;
    for (int k = 0; k < size; ++k) root_of[k] = x.lanes[k];
    root_of = root_of.sqrt().eval();
    // Eigen makes it from 1/√x where that is faster, which is wrong at the ends of the range.
#ifdef EIGEN_VECTORIZE_AVX512
    constexpr bool is_exact = false;
#else
    constexpr bool is_exact = !std::is_same_v<S, float>;
#endif
    using Limits = std::numeric_limits<S>;
    for (int k = 0; !is_exact && k < size; ++k)
      if (const S at = x.lanes[k]; !(at >= Limits::min() && at <= Limits::max())) root_of[k] = std::sqrt(at);
    LanePack root = load(root_of.data());
    return root;
  }
  friend SEMIEXPLICIT_INTO_TERM LanePack abs(const LanePack& x) {
    return LanePack(x.lanes < Lanes{} ? -x.lanes : x.lanes - Lanes{});
  }
  friend SEMIEXPLICIT_INTO_TERM LanePack sign_of(const LanePack& x) {
    return LanePack(x.lanes < Lanes{} ? LanePack(-1).lanes : LanePack(1).lanes);
  }
  friend SEMIEXPLICIT_INTO_TERM LanePack max(const LanePack& x, const LanePack& y) {
    return LanePack(x.lanes < y.lanes ? y.lanes : x.lanes);
  }
  friend SEMIEXPLICIT_INTO_TERM LanePack min(const LanePack& x, const LanePack& y) {
    return LanePack(y.lanes < x.lanes ? y.lanes : x.lanes);
  }

  // Lane by lane. `const`: the logarithm of a distance, whose slope alone is wanted, is then not computed.
#define SEMIEXPLICIT_LANE_BY_LANE(function)                                 \
  [[gnu::const, gnu::noinline]] static LanePack function##_of(LanePack x) { \
    return of([&](int k) { return std::function(x.lanes[k]); });            \
  }                                                                         \
  friend SEMIEXPLICIT_INTO_TERM LanePack function(const LanePack& x) { return function##_of(x); }
  SEMIEXPLICIT_LANE_BY_LANE(cbrt)
  SEMIEXPLICIT_LANE_BY_LANE(exp)
  SEMIEXPLICIT_LANE_BY_LANE(exp2)
  SEMIEXPLICIT_LANE_BY_LANE(expm1)
  SEMIEXPLICIT_LANE_BY_LANE(log)
  SEMIEXPLICIT_LANE_BY_LANE(log2)
  SEMIEXPLICIT_LANE_BY_LANE(log10)
  SEMIEXPLICIT_LANE_BY_LANE(log1p)
  SEMIEXPLICIT_LANE_BY_LANE(sin)
  SEMIEXPLICIT_LANE_BY_LANE(cos)
  SEMIEXPLICIT_LANE_BY_LANE(tan)
  SEMIEXPLICIT_LANE_BY_LANE(asin)
  SEMIEXPLICIT_LANE_BY_LANE(acos)
  SEMIEXPLICIT_LANE_BY_LANE(atan)
  SEMIEXPLICIT_LANE_BY_LANE(sinh)
  SEMIEXPLICIT_LANE_BY_LANE(cosh)
  SEMIEXPLICIT_LANE_BY_LANE(tanh)
  SEMIEXPLICIT_LANE_BY_LANE(asinh)
  SEMIEXPLICIT_LANE_BY_LANE(acosh)
  SEMIEXPLICIT_LANE_BY_LANE(atanh)
  SEMIEXPLICIT_LANE_BY_LANE(erf)
  SEMIEXPLICIT_LANE_BY_LANE(erfc)
#undef SEMIEXPLICIT_LANE_BY_LANE
#define SEMIEXPLICIT_LANE_BY_LANE(function)                                                              \
  [[gnu::const, gnu::noinline]] static LanePack function##_of(LanePack x, LanePack y) {                  \
    return of([&](int k) { return std::function(x.lanes[k], y.lanes[k]); });                             \
  }                                                                                                      \
  friend SEMIEXPLICIT_INTO_TERM LanePack function(const LanePack& x, const LanePack& y) {                \
    return function##_of(x, y);                                                                          \
  }                                                                                                      \
  template <class U>                                                                                     \
  requires(std::is_arithmetic_v<U>) friend SEMIEXPLICIT_INTO_TERM LanePack function(const LanePack& x,   \
                                                                                    const U& c) {        \
    return function##_of(x, static_cast<S>(c));                                                          \
  }                                                                                                      \
  template <class U>                                                                                     \
  requires(std::is_arithmetic_v<U>) friend SEMIEXPLICIT_INTO_TERM LanePack function(const U& c,          \
                                                                                    const LanePack& y) { \
    return function##_of(static_cast<S>(c), y);                                                          \
  }
  SEMIEXPLICIT_LANE_BY_LANE(atan2)
  SEMIEXPLICIT_LANE_BY_LANE(hypot)
  SEMIEXPLICIT_LANE_BY_LANE(pow)
#undef SEMIEXPLICIT_LANE_BY_LANE
  /// Small whole powers by multiplication, as one would write them.
  static SEMIEXPLICIT_INTO_TERM LanePack pow_of(const LanePack& x, S c) {
    const int whole = c >= S(-8) && c <= S(8) ? static_cast<int>(c) : 0;
    if (c != static_cast<S>(whole)) return pow_of(x, LanePack(c));
    LanePack result(1);
    for (int k = 0; k < (whole < 0 ? -whole : whole); ++k) result = result * x;
    return whole < 0 ? 1 / result : result;
  }
  friend bool isfinite(const LanePack& x) {
    return agreed([&](int k) { return std::isfinite(x.lanes[k]); });
  }
  friend bool isnan(const LanePack& x) {
    return agreed([&](int k) { return std::isnan(x.lanes[k]); });
  }
};

template <class S>
struct PlainOf<LanePack<S>> : PlainOf<S> {};

}  // namespace semiexplicit::detail::autodiff

template <class S>
class std::numeric_limits<semiexplicit::detail::autodiff::LanePack<S>> : public std::numeric_limits<S> {};

namespace Eigen {
template <class S>
struct NumTraits<semiexplicit::detail::autodiff::LanePack<S>>
    : GenericNumTraits<semiexplicit::detail::autodiff::LanePack<S>> {
  using Real = semiexplicit::detail::autodiff::LanePack<S>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = S;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 0 };
  enum { ReadCost = 1, AddCost = 1, MulCost = 1 };
};
}  // namespace Eigen
