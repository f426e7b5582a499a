#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>

namespace semiexplicit::detail {

/// What core/simd.hpp takes for std::experimental::simd where the standard library has none: as much of its
/// interface as the library and a gradient of packs need, on a plain array, lane by lane.
template <class Scalar, std::size_t Width>
class ArrayPack {
 public:
  using value_type = Scalar;
  struct mask_type {
    std::array<bool, Width> lanes{};

    mask_type() = default;
    explicit mask_type(bool all) { lanes.fill(all); }
    template <class Flags>
    mask_type(const bool* from, Flags) {
      for (std::size_t k = 0; k < Width; ++k) lanes[k] = from[k];
    }
    static constexpr std::size_t size() { return Width; }
    bool& operator[](std::size_t k) { return lanes[k]; }
    bool operator[](std::size_t k) const { return lanes[k]; }
    mask_type operator!() const {
      return of([&](std::size_t k) { return !lanes[k]; });
    }
    friend mask_type operator&&(const mask_type& x, const mask_type& y) {
      return of([&](std::size_t k) { return x[k] && y[k]; });
    }
    friend mask_type operator||(const mask_type& x, const mask_type& y) {
      return of([&](std::size_t k) { return x[k] || y[k]; });
    }
    friend bool any_of(const mask_type& x) {
      bool any = false;
      for (const bool lane : x.lanes) any = any || lane;
      return any;
    }
    friend bool all_of(const mask_type& x) { return !any_of(!x); }
    friend bool none_of(const mask_type& x) { return !any_of(x); }

    template <class F>
    static mask_type of(const F& f) {
      mask_type mask;
      for (std::size_t k = 0; k < Width; ++k) mask[k] = f(k);
      return mask;
    }
  };

  ArrayPack() = default;
  /// The same in every lane.
  template <class Number>
  requires std::convertible_to<Number, Scalar> ArrayPack(const Number& all) {
    lanes_.fill(static_cast<Scalar>(all));
  }
  /// f(0), f(1), ..., called with integral constants.
  template <class F>
  requires std::invocable<const F&, std::integral_constant<std::size_t, 0>>
  explicit ArrayPack(const F& f) : ArrayPack(f, std::make_index_sequence<Width>()) {}

  static constexpr std::size_t size() { return Width; }
  Scalar& operator[](std::size_t k) { return lanes_[k]; }
  Scalar operator[](std::size_t k) const { return lanes_[k]; }
  template <class Flags>
  void copy_to(Scalar* to, Flags) const {
    for (std::size_t k = 0; k < Width; ++k) to[k] = lanes_[k];
  }
  template <class Flags>
  void copy_from(const Scalar* from, Flags) {
    for (std::size_t k = 0; k < Width; ++k) lanes_[k] = from[k];
  }

  ArrayPack operator-() const {
    return map(*this, [](const Scalar& x) { return -x; });
  }
  friend ArrayPack operator+(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return x[k] + y[k]; });
  }
  friend ArrayPack operator-(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return x[k] - y[k]; });
  }
  friend ArrayPack operator*(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return x[k] * y[k]; });
  }
  friend ArrayPack operator/(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return x[k] / y[k]; });
  }
  ArrayPack& operator+=(const ArrayPack& y) { return *this = *this + y; }
  ArrayPack& operator-=(const ArrayPack& y) { return *this = *this - y; }
  ArrayPack& operator*=(const ArrayPack& y) { return *this = *this * y; }
  ArrayPack& operator/=(const ArrayPack& y) { return *this = *this / y; }

  friend mask_type operator==(const ArrayPack& x, const ArrayPack& y) {
    return mask_type::of([&](std::size_t k) { return x[k] == y[k]; });
  }
  friend mask_type operator!=(const ArrayPack& x, const ArrayPack& y) { return !(x == y); }
  friend mask_type operator<(const ArrayPack& x, const ArrayPack& y) {
    return mask_type::of([&](std::size_t k) { return x[k] < y[k]; });
  }
  friend mask_type operator<=(const ArrayPack& x, const ArrayPack& y) {
    return mask_type::of([&](std::size_t k) { return x[k] <= y[k]; });
  }
  friend mask_type operator>(const ArrayPack& x, const ArrayPack& y) { return y < x; }
  friend mask_type operator>=(const ArrayPack& x, const ArrayPack& y) { return y <= x; }

  friend ArrayPack max(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return x[k] < y[k] ? y[k] : x[k]; });
  }
  friend ArrayPack min(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return y[k] < x[k] ? y[k] : x[k]; });
  }
  friend Scalar reduce(const ArrayPack& x) {
    Scalar sum(0);
    for (const Scalar& lane : x.lanes_) sum += lane;
    return sum;
  }
  friend mask_type isfinite(const ArrayPack& x) {
    return mask_type::of([&](std::size_t k) { return std::isfinite(x[k]); });
  }
#define SEMIEXPLICIT_LANE_BY_LANE(function)                                \
  friend ArrayPack function(const ArrayPack& x) {                          \
    return map(x, [](const Scalar& lane) { return std::function(lane); }); \
  }
  SEMIEXPLICIT_LANE_BY_LANE(abs)
  SEMIEXPLICIT_LANE_BY_LANE(sqrt)
  SEMIEXPLICIT_LANE_BY_LANE(exp)
  SEMIEXPLICIT_LANE_BY_LANE(log)
  SEMIEXPLICIT_LANE_BY_LANE(sin)
  SEMIEXPLICIT_LANE_BY_LANE(cos)
  SEMIEXPLICIT_LANE_BY_LANE(tan)
  SEMIEXPLICIT_LANE_BY_LANE(sinh)
  SEMIEXPLICIT_LANE_BY_LANE(cosh)
  SEMIEXPLICIT_LANE_BY_LANE(tanh)
#undef SEMIEXPLICIT_LANE_BY_LANE
  friend ArrayPack pow(const ArrayPack& x, const ArrayPack& y) {
    return of([&](std::size_t k) { return std::pow(x[k], y[k]); });
  }

 private:
  template <class F, std::size_t... K>
  ArrayPack(const F& f, std::index_sequence<K...>)
      : lanes_{static_cast<Scalar>(f(std::integral_constant<std::size_t, K>()))...} {}
  template <class F>
  static ArrayPack of(const F& f) {
    ArrayPack pack;
    for (std::size_t k = 0; k < Width; ++k) pack[k] = f(k);
    return pack;
  }
  template <class F>
  static ArrayPack map(const ArrayPack& x, const F& f) {
    return of([&](std::size_t k) { return f(x[k]); });
  }

  alignas(Width * sizeof(Scalar)) std::array<Scalar, Width> lanes_{};
};

}  // namespace semiexplicit::detail
