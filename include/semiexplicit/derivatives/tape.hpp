#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/derivatives/dual.hpp>

namespace semiexplicit::detail::autodiff {

/// What a number of type T is made of: `planes` numbers of type Plain, each of which arrays keep apart.
template <class T>
struct Planes {
  using Plain = T;
  static constexpr int planes = 1;
  static T join(const T* from, Eigen::Index) { return *from; }
  static const T& plain(const T& x) { return x; }
};
template <class T>
struct Planes<Dual<T, 1>> {
  using Plain = T;
  static constexpr int planes = 2;
  static Dual<T, 1> join(const T* from, Eigen::Index distance) {
    Dual<T, 1> x(*from);
    x.derivative[0] = from[distance];
    return x;
  }
  static const T& plain(const Dual<T, 1>& x) { return x.value; }
};

template <class T>
class Tape;

/// A number whose computation a tape records, to be gone through backwards: one evaluation then gives the
/// derivatives in all variables, at a cost that does not depend on their number.
///
/// Source: Griewank, Walther, Evaluating Derivatives, 2nd ed. (SIAM 2008), section 3.2.
template <class T>
struct Traced : Operators<Traced<T>, T> {
  T value = T(0);
  Tape<T>* tape = nullptr;
  std::int32_t index = 0;  ///< of its adjoint; 0: a constant
  bool of_sum = false;     ///< linear in a sum_over(), whose value need not be known: see Tape::values

  Traced() = default;
  template <class U>
  requires(std::convertible_to<U, T>) Traced(const U& number)
      : value(static_cast<T>(number)) {}  // NOLINT: a number is a constant
  Traced(const T& number, Tape<T>* on, std::int32_t at, bool linear = false)
      : value(number), tape(on), index(at), of_sum(linear) {}

  SEMIEXPLICIT_INTO_TERM Traced chain(const T& f, const T& slope) const {
    if (index == 0) return f;
    use();
    return tape->record(f, slope, index, T(0), 0);
  }
  static SEMIEXPLICIT_INTO_TERM Traced chain(const T& f, const T& slope_x, const Traced& x, const T& slope_y,
                                             const Traced& y) {
    if (x.index == 0 && y.index == 0) return f;
    x.use();
    y.use();
    return tape_of(x, y)->record(f, slope_x, x.index, slope_y, y.index);
  }
  static Traced chain_if_varying(const T& f, const T& slope_x, const Traced& x, const T& slope_y,
                                 const Traced& y) {
    return chain(f, slope_x, x, slope_y, y);  // the adjoint of a constant nobody reads
  }
  static SEMIEXPLICIT_INTO_TERM Traced plus(const Traced& x, const Traced& y) {
    return linear(x.value + y.value, x, y, T(1));
  }
  static SEMIEXPLICIT_INTO_TERM Traced minus(const Traced& x, const Traced& y) {
    return linear(x.value - y.value, x, y, T(-1));
  }
  SEMIEXPLICIT_INTO_TERM Traced shifted(const T& f) const { return {f, tape, index, of_sum}; }
  SEMIEXPLICIT_INTO_TERM Traced scaled(const T& f, const T& factor) const {
    if (index == 0) return f;
    Traced result = tape->record(f, factor, index, T(0), 0);
    result.of_sum = of_sum;
    return result;
  }
  SEMIEXPLICIT_INTO_TERM const T& compared() const {
    use();
    return value;
  }

 private:
  SEMIEXPLICIT_INTO_TERM void use() const {
    if (of_sum) tape->values_used = true;
  }
  static Tape<T>* tape_of(const Traced& x, const Traced& y) { return x.index != 0 ? x.tape : y.tape; }
  static SEMIEXPLICIT_INTO_TERM Traced linear(const T& f, const Traced& x, const Traced& y,
                                              const T& slope_y) {
    if (y.index == 0) return x.shifted(f);
    if (x.index == 0 && slope_y == T(1)) return y.shifted(f);
    Traced result = tape_of(x, y)->record(f, T(1), x.index, slope_y, y.index);
    result.of_sum = x.of_sum || y.of_sum;
    return result;
  }
};

/// Every operation on numbers that depend on the variables, with its slopes, and the gradients of sums that
/// sum_over() has found on its own. Memory is kept from call to call; there is one tape a thread.
///
/// Not a library: ADOL-C, a library of Debian, has double only, global tapes by number, and allocates in
/// every sweep.
template <class T>
class Tape {
 public:
  using Plain = typename Planes<T>::Plain;

  bool values = true;        ///< find the values of sums, too
  bool values_used = false;  ///< a value of a sum was needed

  /// With which weight every sum is expected to enter the result: it can then be added to the result at once.
  struct Weights {
    static constexpr std::size_t most = 4;
    double of[most] = {1, 1, 1, 1};
  };

  /// Starts over for so many variables. With `weights` gradients of sums go to the outputs at once.
  void start(Eigen::Index variables, Plain* to_q, Plain* to_p, const Weights* weights) {
    variables_ = variables;
    weights_ = weights;
    outputs_[0] = to_q;
    outputs_[1] = to_p;
    if (weights != nullptr)
      for (Plain* const to : outputs_) std::fill(to, to + variables / 2, Plain(0));
    rewind(0);
    sums_.clear();
    gradients_.clear();
    values_used = false;
    read_ = false;
  }
  Eigen::Index variables() const { return variables_; }

  /// Variable number k.
  SEMIEXPLICIT_INTO_TERM Traced<T> variable(const T& value, Eigen::Index k) {
    read_ = true;
    return {value, this, static_cast<std::int32_t>(k + 1)};
  }
  SEMIEXPLICIT_INTO_TERM Traced<T> record(const T& f, const T& slope_x, std::int32_t x, const T& slope_y,
                                          std::int32_t y) {
    if (length_ == steps_.size()) [[unlikely]]
      grow();
    steps_[length_++] = {slope_x, slope_y, x, y};
    return {f, this, static_cast<std::int32_t>(variables_ + static_cast<Eigen::Index>(length_))};
  }
  /// How many operations there are, and those beyond that many forgotten.
  std::size_t length() const { return length_; }
  void rewind(std::size_t length) { length_ = length; }

  /// A place for the gradient of a sum: in every plane a half for q and one for p. It may move when the next
  /// one is made.
  std::size_t new_sum() {
    const bool direct = weights_ != nullptr && sums_.size() < Weights::most;
    const std::size_t weight = sums_.size(), at = gradients_.size();
    sums_.push_back({0, at, direct, direct ? Plain(weights_->of[weight]) : Plain(1)});
    if (!direct)
      gradients_.resize(at + static_cast<std::size_t>(Planes<T>::planes * 2 * distance()), Plain(0));
    return sums_.size() - 1;
  }
  Plain* gradient_of(std::size_t sum, Eigen::Index plane, Eigen::Index half) {
    if (sums_[sum].direct) return outputs_[half];
    return gradients_.data() + sums_[sum].gradient + (2 * plane + half) * distance();
  }
  /// What the gradient is to be multiplied with before.
  const Plain& weight_of(std::size_t sum) const { return sums_[sum].weight; }
  /// The sum, whose gradient is there now.
  Traced<T> finished(std::size_t sum, const T& value) {
    Traced<T> result = record(value, T(0), 0, T(0), 0);
    result.of_sum = true;
    sums_[sum].index = result.index;
    return result;
  }

  /// Finds what the result changes by with every operation. False where a sum has entered it with another
  /// weight than expected; `found` then has the right ones.
  bool sweep(const Traced<T>& result, Weights& found) {
    const std::size_t first = static_cast<std::size_t>(variables_) + 1;
    if (adjoint_.size() < first + length_) adjoint_.resize(first + length_);
    const auto steps_begin = adjoint_.begin() + static_cast<std::ptrdiff_t>(first);
    std::fill(steps_begin, steps_begin + static_cast<std::ptrdiff_t>(length_), T(0));
    if (read_) std::fill(adjoint_.begin(), steps_begin, T(0));
    adjoint_[static_cast<std::size_t>(result.index)] = T(1);
    for (std::size_t k = length_; k-- > 0;) {
      const T weight = adjoint_[first + k];
      // What the result does not depend on may have slopes that are infinite.
      if (is_constant_zero(weight)) continue;
      const Step& step = steps_[k];
      adjoint_[static_cast<std::size_t>(step.x)] += step.slope_x * weight;
      adjoint_[static_cast<std::size_t>(step.y)] += step.slope_y * weight;
    }
    bool as_expected = true;
    if constexpr (std::is_floating_point_v<T>)
      for (std::size_t k = 0; k < sums_.size() && sums_[k].direct; ++k) {
        const T weight = sums_[k].index == 0 ? T(0) : adjoint_[static_cast<std::size_t>(sums_[k].index)];
        if (sums_[k].index == 0 || weight == sums_[k].weight) continue;
        found.of[k] = static_cast<double>(weight);
        as_expected = false;
      }
    return as_expected;
  }

  /// Writes the derivatives of the result after sweep(), of duals those along the direction.
  void write() const {
    write(0, outputs_[0]);
    write(1, outputs_[1]);
  }

  /// Memory for such a computation, so that it takes none from the heap.
  void reserve(Eigen::Index variables, std::size_t steps, std::size_t sums) {
    const auto n = static_cast<std::size_t>(variables);
    if (steps_.size() < steps) steps_.resize(steps);
    adjoint_.reserve(n + 1 + steps);
    sums_.reserve(sums);
    gradients_.reserve(sums * (n + 32) * std::size_t(Planes<T>::planes));
  }

  /// Calls work(tape) with this thread's tape, or with one of its own where that is in use: inside of an
  /// energy.
  template <class Work>
  static void use(const Work& work) {
    struct Turn {
      Tape* before;
      explicit Turn(Tape* now) : before(current()) { current() = now; }
      ~Turn() { current() = before; }
    };
    if (current() == nullptr) {
      Tape& kept = of_this_thread();
      const Turn turn(&kept);
      work(kept);
    } else {
      Tape own;
      const Turn turn(&own);
      work(own);
    }
  }
  /// The one in use, in this thread.
  static Tape*& current() {
    thread_local constinit Tape* tape = nullptr;
    return tape;
  }

 private:
  Eigen::Index distance() const { return (variables_ / 2 + 15) / 16 * 16; }  // whole cache lines

  static Tape& of_this_thread() {
    thread_local Tape tape;
    return tape;
  }

  struct Step {
    T slope_x, slope_y;
    std::int32_t x, y;  // 0: no number, whose adjoint nobody reads
  };
  struct Sum {
    std::int32_t index;    // 0: not finished
    std::size_t gradient;  // where it is, unless direct
    bool direct;
    Plain weight;
  };

  void write(Eigen::Index half, Plain* __restrict to) const {
    const Eigen::Index count = variables_ / 2;
    const auto outward = [](const T& x) -> const Plain& {
      if constexpr (Planes<T>::planes == 1)
        return x;
      else
        return x.derivative[0];
    };
    if (weights_ == nullptr) std::fill(to, to + count, Plain(0));
    if (read_) {
      const T* const from = adjoint_.data() + 1 + half * count;
      for (Eigen::Index k = 0; k < count; ++k) to[k] += outward(from[k]);
    }
    for (const Sum& sum : sums_) {
      if (sum.direct || sum.index == 0) continue;
      const T weight = adjoint_[static_cast<std::size_t>(sum.index)];
      const Plain* const __restrict from = gradients_.data() + sum.gradient + half * distance();
      if constexpr (Planes<T>::planes == 1) {
        for (Eigen::Index k = 0; k < count; ++k) to[k] += weight * from[k];
      } else {
        const Plain* const __restrict tangent = from + 2 * distance();
        const Plain plain = weight.value, slope = weight.derivative[0];
        for (Eigen::Index k = 0; k < count; ++k) to[k] += plain * tangent[k] + slope * from[k];
      }
    }
  }

  SEMIEXPLICIT_COLD void grow() {
    const std::size_t most =
        static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() - variables_ - 1);
    if (steps_.size() >= most)
      throw std::length_error(
          "from_energy: an energy of more than 2^31 operations; write it with sum_over()");
    steps_.resize(std::min(most, std::max<std::size_t>(1024, 2 * steps_.size())));
  }

  Eigen::Index variables_ = 0;
  Plain* outputs_[2] = {nullptr, nullptr};
  const Weights* weights_ = nullptr;
  bool read_ = false;        ///< some variable, not by terms in lanes
  std::vector<Step> steps_;  ///< the first length_ of them
  std::size_t length_ = 0;
  std::vector<T> adjoint_;  ///< of nothing, the variables, and the results of the steps
  std::vector<Sum> sums_;
  std::vector<Plain, Eigen::aligned_allocator<Plain>> gradients_;
};

}  // namespace semiexplicit::detail::autodiff

namespace semiexplicit::detail {
using autodiff::Tape;
using autodiff::Traced;
}  // namespace semiexplicit::detail

template <class T>
class std::numeric_limits<semiexplicit::detail::Traced<T>> : public std::numeric_limits<T> {};

// What Eigen has to know, so that q.squaredNorm(), q.dot(p) and 2.0 * q work.
namespace Eigen {

template <class T>
struct NumTraits<semiexplicit::detail::Traced<T>> : NumTraits<T> {
  using Real = semiexplicit::detail::Traced<T>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = Real;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
  enum { ReadCost = 4, AddCost = 8, MulCost = 8 };
};
template <class T, class Operation>
struct ScalarBinaryOpTraits<semiexplicit::detail::Traced<T>, T, Operation> {
  using ReturnType = semiexplicit::detail::Traced<T>;
};
template <class T, class Operation>
struct ScalarBinaryOpTraits<T, semiexplicit::detail::Traced<T>, Operation> {
  using ReturnType = semiexplicit::detail::Traced<T>;
};

}  // namespace Eigen
