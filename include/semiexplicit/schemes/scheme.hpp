#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/words.hpp>
#include <semiexplicit/schemes/order_conditions.hpp>

namespace semiexplicit {

/// The highest order that can be claimed, since it has to be checked: the work doubles with every degree.
inline constexpr int max_scheme_order = 12;

/// The highest order that make_scheme() and compose() look for.
inline constexpr int max_detected_order = 10;

namespace detail {

/// Beginning of every message about a scheme.
SEMIEXPLICIT_COLD inline std::string scheme_called(const std::string& name) {
  return "Scheme \"" + name + "\": ";
}

/// A list that is finite, palindromic and sums to one; throws std::invalid_argument otherwise. `what` names
/// it in the message.
template <class Scalar>
SEMIEXPLICIT_COLD void check_list(const std::string& owner, const std::string& what,
                                  const std::vector<Scalar>& list) {
  using Work = ConditionScalar<Scalar>;
  const auto entry = [&](std::size_t i) { return what + "[" + std::to_string(i) + "]"; };
  Work sum(0), length(0), largest(0);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Scalar zero = list[i] - list[i];  // NaN for NaN and Inf, in any number type
    if (!(zero == Scalar(0)))
      throw std::invalid_argument(owner + entry(i) + " is NaN or Inf; give finite coefficients");
    const Work c(list[i]);
    sum += c;
    length += magnitude(c);
    largest = std::max(largest, magnitude(c));
  }
  const Work epsilon(machine_epsilon<Scalar>());
  for (std::size_t i = 0, j = list.size(); i < j--; ++i) {
    const Work difference = Work(list[i]) - Work(list[j]);
    if (!(magnitude(difference) <= Work(16) * epsilon * largest))
      throw std::invalid_argument(owner + what + " is not palindromic: " + entry(i) + " = " +
                                  in_words(list[i], 15) + " but " + entry(j) + " = " + in_words(list[j], 15) +
                                  " (difference " + in_words(difference, 3) +
                                  "); the projected method needs a symmetric list, make the two equal");
  }
  const Work excess = sum - Work(1);
  if (!(magnitude(excess) <= Work(16) * epsilon * length))
    throw std::invalid_argument(owner + what + " sums to " + in_words(sum, 15) + ", not to one (off by " +
                                in_words(excess, 3) + "); check its digits, or divide it by its sum");
}

}  // namespace detail

/// A splitting: the sizes, in units of the time step, of the kicks A(a0) B(b0) A(a1) ... B(b_{n-1}) A(a_n)
/// that make up one sweep over the doubled phase space. A plain value; a stepper that takes one calls
/// check(), so an edited list is tested like a new one.
///
///     const double g = 1 / (2 - std::cbrt(2.0));
///     Scheme<double> s("jump", 4, {g / 2, (1 - g) / 2, (1 - g) / 2, g / 2}, {g, 1 - 2 * g, g});
template <class ScalarType>
struct Scheme {
  using Scalar = ScalarType;

  /// Throws std::invalid_argument, with the remedy, unless the list is finite, palindromic, sums to one in a
  /// and in b, and satisfies the order conditions (at the precision of Scalar) up to the claimed order.
  Scheme(std::string called, int claimed, std::vector<ScalarType> a_kicks, std::vector<ScalarType> b_kicks,
         std::string taken_from = "")
      : name(std::move(called)),
        order(claimed),
        a(std::move(a_kicks)),
        b(std::move(b_kicks)),
        source(std::move(taken_from)) {
    explicit_order = checked(std::min(order, max_scheme_order)).explicit_order;
  }

  /// Throws std::invalid_argument if the members, which anybody may edit, no longer fit together.
  SEMIEXPLICIT_COLD void check() const {
    const int degree = std::min(std::max(order, explicit_order), max_scheme_order);
    if (checked(degree).explicit_order < explicit_order)
      throw std::invalid_argument(
          detail::scheme_called(name) + "explicit_order = " + std::to_string(explicit_order) +
          " does not belong to these coefficients; build a new Scheme from an edited list");
  }

  /// The number of kicks, which is the number of gradient calls a sweep. A zero in the list is paid for like
  /// any other entry: leave none in.
  std::size_t kicks() const { return a.size() + b.size(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("a", a);
    list("b", b);
  }

  std::string name;
  int order;  ///< of the method with the symmetric projection; even
  std::vector<Scalar> a, b;
  std::string source;  ///< where the coefficients come from

  /// The order of the bare map, used without projection: at most `order`. Found from the coefficients, so a
  /// violation that is below the rounding of Scalar does not show.
  int explicit_order = 0;

 private:
  /// Throws as check() does, apart from explicit_order; gives the orders found up to the degree.
  SEMIEXPLICIT_COLD detail::Orders checked(int degree) const {
    const std::string owner = detail::scheme_called(name);
    if (b.empty() || a.size() != b.size() + 1)
      throw std::invalid_argument(owner + "a has " + std::to_string(a.size()) + " entries and b has " +
                                  std::to_string(b.size()) +
                                  "; a sweep A B A ... B A needs at least one B and one A more than B");
    detail::check_list(owner, "a", a);
    detail::check_list(owner, "b", b);
    if (order < 2 || order % 2 != 0 || order > max_scheme_order)
      throw std::invalid_argument(owner + "cannot claim order " + std::to_string(order) +
                                  "; the order of a palindromic list is even, and can be checked up to " +
                                  std::to_string(max_scheme_order) + ": claim one of 2, 4, ..., " +
                                  std::to_string(max_scheme_order));
    using Work = detail::ConditionScalar<Scalar>;
    const auto defects = detail::degree_defects<Work>({a.begin(), a.end()}, {b.begin(), b.end()}, degree,
                                                      Work(detail::machine_epsilon<Scalar>()));
    const detail::Orders found = detail::orders(defects);
    if (found.projected < order) throw std::invalid_argument(owner + unsatisfied(defects, found.projected));
    return found;
  }

  template <class Work>
  SEMIEXPLICIT_COLD std::string unsatisfied(const std::vector<detail::DegreeDefect<Work>>& defects,
                                            int found) const {
    std::string text = "order " + std::to_string(order) +
                       " is claimed, but the order conditions hold only up to order " + std::to_string(found);
    for (std::size_t n = 2; n < defects.size(); ++n) {
      const auto& [even, odd, tolerance] = defects[n];
      const bool even_fails = !(even <= tolerance);
      if (!even_fails && (odd <= tolerance || 2 * static_cast<int>(n) >= order)) continue;
      text += " (degree " + std::to_string(n) + ": " + detail::in_words(even_fails ? even : odd, 3) +
              " where rounding explains " + detail::in_words(tolerance, 1) + ")";
      break;
    }
    text += "; check the digits of a and b";
    return found < 2 ? text : text + ", or claim order " + std::to_string(found);
  }
};

/// A scheme whose order is found from the coefficients: the highest up to max_detected_order. Throws
/// std::invalid_argument where Scheme would, apart from the claim.
template <class Scalar>
SEMIEXPLICIT_COLD Scheme<Scalar> make_scheme(std::string name, std::vector<Scalar> a, std::vector<Scalar> b,
                                             std::string source = "") {
  Scheme<Scalar> scheme(std::move(name), 2, std::move(a), std::move(b), std::move(source));
  using Work = detail::ConditionScalar<Scalar>;
  const detail::Orders found = detail::orders(
      detail::degree_defects<Work>({scheme.a.begin(), scheme.a.end()}, {scheme.b.begin(), scheme.b.end()},
                                   max_detected_order, Work(detail::machine_epsilon<Scalar>())));
  scheme.order = found.projected;
  scheme.explicit_order = found.explicit_order;
  return scheme;
}

namespace detail {

template <class Scalar>
struct Kicks {
  std::vector<Scalar> a, b;
};

/// The kicks base(w1) base(w2) ... in a row. The A that ends one stage and the A that begins the next are one
/// kick.
template <class Scalar>
SEMIEXPLICIT_COLD Kicks<Scalar> composed_kicks(const Kicks<Scalar>& base,
                                               const std::vector<Scalar>& weights) {
  Kicks<Scalar> all{{Scalar(0)}, {}};
  for (const Scalar& w : weights) {
    all.a.back() += w * base.a.front();
    for (std::size_t i = 0; i < base.b.size(); ++i) {
      all.b.push_back(w * base.b[i]);
      all.a.push_back(w * base.a[i + 1]);
    }
  }
  return all;
}

}  // namespace detail

/// The symmetric composition base(w1 h) base(w2 h) ... base(ws h), with neighbouring A kicks merged: a base
/// of k kicks gives s(k - 1) + 1. `weights` is the full list. The order is found from the coefficients.
/// Throws std::invalid_argument unless the weights are finite, palindromic and sum to one.
template <class Scalar>
SEMIEXPLICIT_COLD Scheme<Scalar> compose(const Scheme<Scalar>& base, const std::vector<Scalar>& weights,
                                         std::string name = "", std::string source = "") {
  base.check();
  if (name.empty()) name = std::to_string(weights.size()) + " stages of " + base.name;
  if (source.empty()) source = "composition of " + base.name;
  if (weights.empty())
    throw std::invalid_argument(detail::scheme_called(name) + "weights is empty; give at least one stage");
  detail::check_list(detail::scheme_called(name), "weights", weights);
  detail::Kicks<Scalar> all = detail::composed_kicks<Scalar>({base.a, base.b}, weights);
  return make_scheme<Scalar>(std::move(name), std::move(all.a), std::move(all.b), std::move(source));
}

}  // namespace semiexplicit
