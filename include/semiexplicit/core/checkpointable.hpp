#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/memory.hpp>
#include <semiexplicit/core/referred.hpp>
#include <semiexplicit/core/words.hpp>

namespace semiexplicit {

namespace detail {

/// What describe() is handed, for the test whether there is one.
class AnyList {
 public:
  AnyList(const AnyList&) = delete;  // a list by value would be lost
  template <class T>
  void operator()(std::string_view what, const T& value);
  template <class F>
  void function(std::string_view what, const F& f);
};

}  // namespace detail

/// A class that says what it is, so that a run is not resumed with another one: `static constexpr const char*
/// name` and
///
///     template <class List>
///     void describe(List& list) const {
///       list("damping", damping_);          // a number, an enum, a text, a vector of numbers, or what has
///                                           // a describe() of its own
///       list.function("surface", surface_);  // a function of (q, p): by its value where it was saved
///     }
template <class T>
concept Describable = requires(const T& t, detail::AnyList& list) {
  { t.name } -> std::convertible_to<std::string_view>;
  t.describe(list);
};

/// What a checkpoint can keep: a class that is Describable and has memory, the numbers that go on from step
/// to step, which may be none: `template <class Visitor> void visit_memory(Visitor&& visit)`, see
/// CheckpointMemory. An observer may also say `bool fresh() const`: whether it has seen nothing yet and must
/// not be left out where a run is resumed.
template <class T>
concept Checkpointable = Describable<T> && HasMemory<T>;

namespace detail {

template <class T>
inline constexpr bool is_bool = std::is_same_v<std::remove_cvref_t<T>, bool>;
template <class T>
concept TellsWhetherFresh = requires(const T& observer) {
  requires is_bool<decltype(observer.fresh())>;
};
/// Whether an observer that has memory has seen nothing yet and must not be left out where a run is resumed.
template <class O>
bool is_fresh(const O& observer) {
  using T = Referred<O>;
  static_assert(TellsWhetherFresh<T> || !HasMemory<T> ||
                    !(
                        requires(T & mine) { mine.fresh(); } || requires { &T::fresh; }),
                "fresh() of this observer cannot be called: write `bool fresh() const`");
  if constexpr (HasMemory<T> && TellsWhetherFresh<T>)
    return referred(observer).fresh();
  else
    return false;
}

/// Compiles for what a checkpoint can keep; of anything else the compiler says what is missing.
template <class T>
consteval bool is_checkpointable() {
  static_assert(!VisitsByValue<T>,
                "visit_memory() takes its visitor by value, so that nothing is saved: write `template <class "
                "Visitor> void visit_memory(Visitor&& visit)`");
  static_assert(HasMemory<T> || VisitsByValue<T>,
                "what a checkpoint is to keep shows its memory: write `template <class Visitor> void "
                "visit_memory(Visitor&& visit) { visit(count_); }` in it, with nothing to visit where it "
                "remembers nothing");
  if constexpr (HasMemory<T>)
    static_assert(Describable<T>,
                  "what a checkpoint is to keep lists its options, or a run could be resumed with others: "
                  "write `static constexpr const char* name = \"Mine\";` and `template <class List> void "
                  "describe(List& list) const { list(\"damping\", damping); }` in it");
  return Checkpointable<T>;
}

/// Compiles for what lists its options; of anything else the compiler says what is missing.
template <class T>
consteval bool is_describable() {
  static_assert(Describable<T>,
                "this part of a run that is saved does not list its options, so it could be resumed with "
                "others: write `static constexpr const char* name = \"Mine\";` and `template <class List> "
                "void describe(List& list) const { list(\"damping\", damping); }` in it");
  return Describable<T>;
}

/// An observer that another one calls: its options and its memory, where it has any.
template <class T>
consteval bool remembers() {
  if constexpr (HasMemory<T> || VisitsByValue<T> || Describable<T>)
    return is_checkpointable<T>();
  else
    return false;
}
template <class List, class T>
void describe_inner(List& list, const T& observer) {
  if constexpr (remembers<Referred<T>>()) list("observer", referred(observer));
}
template <class Visitor, class T>
void visit_inner(Visitor&& visit, T& observer) {
  if constexpr (remembers<Referred<T>>()) referred(observer).visit_memory(visit);
}

/// What describe() lists, as lines "what: value". Two runs whose lines differ are different runs.
class OptionText {
 public:
  OptionText() = default;
  OptionText(const OptionText&) = delete;  // as AnyList

  template <class T>
  void operator()(std::string_view what, const T& value) {
    if constexpr (requires { value.describe(*this); }) {
      if constexpr (is_describable<T>()) {
        line(what, std::string(value.name));
        const std::string outer = std::exchange(prefix_, prefix_ + std::string(what) + " ");
        value.describe(*this);
        prefix_ = outer;
      }
    } else if constexpr (std::is_enum_v<T>) {
      line(what, std::to_string(static_cast<std::underlying_type_t<T>>(value)));
    } else if constexpr (std::is_integral_v<T>) {
      line(what, std::to_string(value));
    } else if constexpr (std::is_convertible_v<const T&, std::string_view>) {
      line(what, std::string(std::string_view(value)));
    } else if constexpr (requires { value[0], value.size(); }) {
      std::string all = std::to_string(value.size()) + " numbers";
      for (std::size_t i = 0; i < static_cast<std::size_t>(value.size()); ++i) all += " " + digits(value[i]);
      line(what, all);
    } else if constexpr (std::numeric_limits<T>::is_specialized) {
      line(what, digits(value));
    } else {
      static_assert(is_describable<T>());
    }
  }
  template <class F>
  void function(std::string_view what, const F&) {
    line(what, "a function");
  }

  const std::string& text() const { return text_; }

 private:
  template <class Scalar>
  static std::string digits(const Scalar& x) {
    if constexpr (std::is_integral_v<Scalar>)
      return std::to_string(x);
    else
      return in_words(x, std::numeric_limits<Scalar>::max_digits10);
  }
  void line(std::string_view what, std::string value) {
    for (char& c : value)
      if (c == '\n') c = ' ';
    text_ += prefix_ + std::string(what) + ": " + value + "\n";
  }

  std::string text_, prefix_;
};

/// The first lines in which two texts differ, "nothing" beyond an end; empty: the texts are the same.
inline std::pair<std::string, std::string> first_other_lines(const std::string& text,
                                                             const std::string& other) {
  std::istringstream a(text), b(other);
  std::string line_a, line_b;
  for (;;) {
    const bool more_a = static_cast<bool>(std::getline(a, line_a));
    const bool more_b = static_cast<bool>(std::getline(b, line_b));
    if (!more_a && !more_b) return {};
    if (line_a != line_b || more_a != more_b)
      return {more_a ? line_a : "nothing", more_b ? line_b : "nothing"};
  }
}

/// That in words; empty: nowhere. Of long lists, with commas, the first entry that differs.
inline std::string difference_of_lines(const std::string& there, const std::string& here) {
  auto [line_there, line_here] = first_other_lines(there, here);
  if (line_there.empty()) return "";
  constexpr std::size_t is_long = 80;
  if (std::max(line_there.size(), line_here.size()) > is_long) {
    const auto other =
        std::mismatch(line_there.begin(), line_there.end(), line_here.begin(), line_here.end());
    const auto equal = static_cast<std::size_t>(other.first - line_there.begin());
    const std::size_t comma = equal == 0 ? std::string::npos : line_there.find_last_of(",;", equal - 1);
    const std::size_t begin = comma == std::string::npos ? 0 : line_there.find_first_not_of(' ', comma + 1);
    const auto separates = [&](const std::string& line) {  // or ends
      return equal >= line.size() || line[equal] == ',' || line[equal] == ';';
    };
    const std::size_t at = equal + (separates(line_there) && separates(line_here) ? 1 : 0);
    for (std::string* const line : {&line_there, &line_here})
      *line =
          line->substr(std::min(begin, line->size()), std::max(line->find_first_of(",;", at), begin) - begin);
  }
  return "'" + line_there + "' there, '" + line_here + "' here";
}

/// The values of all functions that describe() lists, at one state.
template <class State>
class FunctionValues {
 public:
  using Scalar = typename State::Scalar;
  /// What a function throws is thrown on, or gives NaN.
  enum class Throwing { on, nan };
  explicit FunctionValues(const State& z, Throwing throwing = Throwing::on) : z_(z), throwing_(throwing) {}

  template <class T>
  void operator()(std::string_view, [[maybe_unused]] const T& value) {
    if constexpr (requires { value.describe(*this); }) value.describe(*this);
  }
  template <class F>
  void function(std::string_view what, const F& f) {
    names_.emplace_back(what);
    try {
      values_.push_back(static_cast<Scalar>(f(z_.q(), z_.p())));
    } catch (...) {
      if (throwing_ == Throwing::on) throw;
      values_.push_back(std::numeric_limits<Scalar>::quiet_NaN());
    }
  }

  const std::vector<std::string>& names() const { return names_; }
  const std::vector<Scalar>& values() const { return values_; }

 private:
  const State& z_;
  Throwing throwing_;
  std::vector<std::string> names_;
  std::vector<Scalar> values_;
};

}  // namespace detail
}  // namespace semiexplicit
