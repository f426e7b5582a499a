#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace semiexplicit {

/// What visit_memory() of a stepper or an observer hands its numbers to, one after the other: numbers,
/// vectors and matrices (Eigen's, whose size is fixed by then), std::vectors of numbers and texts. One list
/// serves three ends: to save the numbers, to check whether saved ones would fit, and to put them back.
///
///     template <class Visitor>
///     void visit_memory(Visitor&& visit) {
///       visit(sum_);
///       visit(count_);
///     }
///
/// Which numbers there are must not depend on their values. Bytes are those of this machine; see
/// io/checkpoint_file.hpp.
class CheckpointMemory {
 public:
  /// Collects.
  CheckpointMemory() = default;
  /// Reads what another one collected: either only checks, or puts the values back. Throws
  /// std::invalid_argument where the kind or the number of values differs.
  enum class Read { check, restore };
  CheckpointMemory(std::string bytes, Read mode)
      : bytes_(std::move(bytes)), reading_(true), restoring_(mode == Read::restore) {}
  /// What a copy is handed is lost: a visit_memory() that takes one by value does not compile.
  CheckpointMemory(const CheckpointMemory&) = delete;
  CheckpointMemory& operator=(const CheckpointMemory&) = delete;

  template <class T>
  requires std::is_arithmetic_v<T>
  void operator()(T& value) {
    tag<T>('1');
    numbers(&value, 1);
  }
  template <class Derived>
  void operator()(Eigen::PlainObjectBase<Derived>& matrix) {
    tag<typename Derived::Scalar>('m');
    if (count(matrix.size()) != matrix.size()) refuse();
    numbers(matrix.derived().data(), matrix.size());
  }
  template <class T>
  void operator()(std::vector<T>& list) {
    sequence(list);
  }
  void operator()(std::string& text) { sequence(text); }
  // What is const, or a temporary, cannot be put back.
  template <class T>
  requires std::is_arithmetic_v<T>
  void operator()(const T&) { refuse_constant<T>(); }
  template <class Derived>
  void operator()(const Eigen::PlainObjectBase<Derived>&) {
    refuse_constant<Derived>();
  }
  template <class T>
  void operator()(const std::vector<T>&) {
    refuse_constant<T>();
  }
  template <std::same_as<std::string> T>
  void operator()(const T&) {
    refuse_constant<T>();
  }

  const std::string& bytes() const { return bytes_; }
  /// How many of them have been read.
  std::size_t position() const { return at_; }
  /// Whether all that was saved has been read.
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  /// The bytes of a number that have a meaning: of the 16 of an x87 long double these are ten.
  template <class T>
  static constexpr std::size_t size_of = std::is_same_v<T, long double>&& std::numeric_limits<T>::digits == 64
                                             ? 10
                                             : sizeof(T);

  template <class T>
  static void refuse_constant() {
    static_assert(
        !std::same_as<T, T>,
        "visit_memory() visits what is const, or a temporary, so that nothing can be put back: leave "
        "`const` out behind its parameters, and visit members themselves");
  }

  template <class List>
  void sequence(List& list) {
    using T = typename List::value_type;
    static_assert(!std::is_same_v<T, bool>, "a std::vector<bool> has no elements to visit");
    tag<T>('v');
    const std::int64_t size = count(static_cast<std::int64_t>(list.size()));
    if (!reading_) return numbers(list.data(), size);
    if (size < 0 || static_cast<std::size_t>(size) > (bytes_.size() - at_) / size_of<T>) refuse();
    if (restoring_) list.resize(static_cast<std::size_t>(size));
    numbers(list.data(), size);
  }

  /// Says what comes: one number, a matrix or a list, of which type.
  template <class T>
  void tag(char kind) {
    static_assert(std::is_arithmetic_v<T>,
                  "only float, double, long double, integers and bool can be saved in a checkpoint");
    char written[3] = {kind, std::is_floating_point_v<T> ? 'f' : 'i', static_cast<char>(size_of<T>)};
    char found[3];
    std::copy(written, written + 3, found);
    bytes(found, 3);
    if (!std::equal(found, found + 3, written)) refuse();
  }

  std::int64_t count(std::int64_t size) {
    bytes(reinterpret_cast<char*>(&size), sizeof size);
    return size;
  }

  template <class T>
  void numbers(T* values, std::int64_t n) {
    for (std::int64_t i = 0; i < n; ++i) {
      if (reading_ && !restoring_) {
        T unused{};
        number(unused);
      } else {
        number(values[i]);
      }
    }
  }
  template <class T>
  void number(T& value) {
    if constexpr (std::is_same_v<T, bool>) {  // one that is neither 0 nor 1 must not come to be
      char byte = value ? 1 : 0;
      bytes(&byte, 1);
      if (byte != 0 && byte != 1) refuse();
      value = byte == 1;
    } else {
      bytes(reinterpret_cast<char*>(&value), size_of<T>);
    }
  }

  void bytes(char* data, std::size_t size) {
    if (!reading_) {
      bytes_.append(data, size);
      return;
    }
    if (size > bytes_.size() - at_) refuse();
    std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }

  [[noreturn]] static void refuse() {
    throw std::invalid_argument(
        "it holds other numbers than are asked for; give the same steppers and observers as the run that "
        "wrote it");
  }

  std::string bytes_;
  std::size_t at_ = 0;
  bool reading_ = false, restoring_ = false;
};

/// T has memory that a checkpoint can keep.
template <class T>
concept HasMemory = requires(T& t, CheckpointMemory& memory) {
  t.visit_memory(memory);
};

namespace detail {

/// A visitor that can be copied, and of which one by value can be made.
struct AnyVisitor {
  operator CheckpointMemory() const;
  template <class T>
  void operator()(T& value);
};
/// visit_memory() takes its visitor by value, so what it visits is lost.
template <class T>
concept VisitsByValue = !HasMemory<T> && requires(T & t, AnyVisitor& visit) {
  t.visit_memory(visit);
};

}  // namespace detail

}  // namespace semiexplicit
