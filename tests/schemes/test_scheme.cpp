#include "catch.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_dec_float.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <locale>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/schemes/scheme.hpp>

#include "refusal.hpp"

namespace test_scheme {

namespace {

using namespace semiexplicit;
using Wide = boost::multiprecision::cpp_bin_float_50;

template <class T>
T size_of(const T& x) {
  return x < T(0) ? T(-x) : x;
}

/// The precision of S in the type that the conditions of S are computed in.
template <class S>
detail::ConditionScalar<S> epsilon() {
  return detail::ConditionScalar<S>(std::numeric_limits<S>::epsilon());
}

/// a0, b0, a1, ... of a scheme, in the type that its conditions are computed in.
template <class S>
std::vector<detail::ConditionScalar<S>> interleaved(const Scheme<S>& s) {
  std::vector<detail::ConditionScalar<S>> c;
  for (std::size_t i = 0; i < s.a.size(); ++i) {
    c.emplace_back(s.a[i]);
    if (i < s.b.size()) c.emplace_back(s.b[i]);
  }
  return c;
}

/// The coefficient of one word in the product of the exponentials, by counting how the kicks can share the
/// word among them: no series and no logarithm, so independent of the library's own computation. Bit i of
/// `word` is letter i, 0 for A.
template <class T>
T word_coefficient(const std::vector<T>& kicks, unsigned word, unsigned length) {
  std::vector<T> done(length + 1, T(0));  // done[j]: the first j letters are used up
  done[0] = T(1);
  for (std::size_t i = 0; i < kicks.size(); ++i) {
    for (unsigned j = length; j > 0; --j) {
      T power(1);
      for (unsigned k = 1; k <= j && ((word >> (j - k)) & 1U) == (i & 1U); ++k) {
        power = power * kicks[i] / T(static_cast<int>(k));
        done[j] += power * done[j - k];
      }
    }
  }
  return done[length];
}

/// 2-norms of the parts of log(scheme) of one degree: all, even and odd under the exchange of A and B.
std::array<double, 3> error_constants(const Scheme<double>& s, int degree) {
  const std::vector<double> log = detail::log_of_kicks(s.a, s.b, degree);
  double even = 0, odd = 0;
  const std::size_t first = std::size_t{1} << degree;
  for (std::size_t w = first; w < 2 * first; ++w) {
    const double exchanged = log[w ^ (first - 1)];
    even += std::pow((log[w] + exchanged) / 2, 2);
    odd += std::pow((log[w] - exchanged) / 2, 2);
  }
  return {std::sqrt(even + odd), std::sqrt(even), std::sqrt(odd)};
}

/// Half a unit of the last of `digits` printed digits, and a little.
bool agrees(double value, double printed, int digits) {
  const double unit = std::pow(10.0, std::floor(std::log10(printed)) - (digits - 1));
  return std::abs(value - printed) <= 0.51 * unit;
}

bool says_all(const std::string& message, const std::vector<std::string>& parts) {
  bool all = true;
  for (const std::string& part : parts) all = all && says(message, part);
  if (!all) UNSCOPED_INFO("the message is: " << message);
  return all;
}

const double jump = 1 / (2 - std::cbrt(2.0));

Scheme<double> good() {
  return {"good", 4, {jump / 2, (1 - jump) / 2, (1 - jump) / 2, jump / 2}, {jump, 1 - 2 * jump, jump}};
}

}  // namespace

TEMPLATE_TEST_CASE("Named schemes satisfy their order conditions at the precision of the scalar",
                   "[scheme][long]", float, double, long double, Wide) {
  using T = detail::ConditionScalar<TestType>;
  for (const std::string& name : schemes::names()) {
    CAPTURE(name);
    const Scheme<TestType> s = schemes::by_name<TestType>(name);
    const std::vector<T> kicks = interleaved(s);
    T length(0);
    for (const T& c : kicks) length += size_of(c);
    const T tolerance = T(4) * length * epsilon<TestType>();

    T inverse_factorial(1);
    const int highest = std::is_same_v<TestType, Wide> && s.kicks() > 100 ? 6 : s.order;  // for the run time
    // The low-defect schemes have only their even part of this order.
    const int no_defect = name.rfind("low_defect", 0) == 0 ? 4 : s.order;
    for (int n = 1; n <= highest; ++n) {
      inverse_factorial /= T(n);
      T even(0), odd(0);
      for (unsigned w = 0; w < 1U << n; ++w) {
        const auto letters = static_cast<unsigned>(n);
        const T direct = word_coefficient(kicks, w, letters);
        const T exchanged = word_coefficient(kicks, w ^ ((1U << n) - 1), letters);
        even = std::max(even, size_of(T((direct + exchanged) / T(2) - inverse_factorial)));
        odd = std::max(odd, size_of(T((direct - exchanged) / T(2))));
      }
      CAPTURE(n, even, odd, tolerance);
      // Partial sums of the triple jump leave [0, 1] far behind: rounding grows with the degree.
      const T allowed = name == "triple_jump8" ? T(100) * tolerance : tolerance;
      CHECK(even <= allowed);
      if (n <= no_defect) CHECK(odd <= allowed);
    }
    CHECK_NOTHROW(s.check());
  }
}

TEMPLATE_TEST_CASE("The weights of the compositions have vanishing odd power sums", "[scheme]", float, double,
                   long double, Wide) {
  using T = detail::ConditionScalar<TestType>;
  for (const char* name : {"triple_jump4", "triple_jump6", "triple_jump8", "suzuki4", "suzuki6", "suzuki8",
                           "yoshida6", "kahan_li6", "kahan_li8", "suzuki_umeno8", "sofroniou_spaletta6",
                           "sofroniou_spaletta8", "sofroniou_spaletta10"}) {
    CAPTURE(name);
    const Scheme<TestType> s = schemes::by_name<TestType>(name);
    T first(0);
    for (const TestType& w : s.b) first += T(w);
    for (int power = 1; power < s.order; power += 2) {
      T sum(0), length(0);
      for (const TestType& w : s.b) {
        T term(w);
        for (int i = 1; i < power; ++i) term *= T(w);
        sum += term;
        length += T(power) * size_of(term);
      }
      CAPTURE(power);
      CHECK(size_of(T(sum - T(power == 1 ? 1 : 0))) <= T(2) * length * epsilon<TestType>());
    }
    // A Strang stage: the half kicks of neighbours make up the A list.
    REQUIRE(s.a.size() == s.b.size() + 1);
    for (std::size_t i = 0; i + 1 < s.b.size(); ++i) {
      const T merged = (T(s.b[i]) + T(s.b[i + 1])) / T(2);
      CHECK(size_of(T(T(s.a[i + 1]) - merged)) <= T(4) * epsilon<TestType>());
    }
  }
}

TEST_CASE("Leading error constants are the known ones", "[scheme]") {
  struct Row {
    const char* name;
    double all, even, odd;
  };
  for (const Row& row : {Row{"strang", 2.282e-01, 7.217e-02, 2.165e-01},
                         {"mclachlan2", 2.095e-02, 2.084e-02, 2.126e-03},
                         {"triple_jump4", 1.841e-01, 1.617e-01, 8.797e-02},
                         {"suzuki4", 9.166e-03, 1.962e-03, 8.953e-03},
                         {"blanes_moan4", 4.612e-04, 2.082e-04, 4.116e-04},
                         {"blanes_moan6", 3.092e-05, 2.153e-05, 2.219e-05},
                         {"yoshida6", 1.218e-02, 1.119e-02, 4.816e-03},
                         {"kahan_li6", 1.445e-03, 1.323e-03, 5.799e-04},
                         {"sofroniou_spaletta6", 8.079e-05, 2.587e-05, 7.653e-05},
                         {"suzuki_umeno8", 1.313e-04, 1.018e-04, 8.295e-05},
                         {"kahan_li8", 1.326e-05, 9.788e-06, 8.945e-06},
                         {"sofroniou_spaletta8", 1.660e-06, 1.135e-06, 1.211e-06},
                         {"sofroniou_spaletta10", 1.984e-08, 1.396e-08, 1.410e-08}}) {
    CAPTURE(row.name);
    const Scheme<double> s = schemes::by_name(row.name);
    const auto [all, even, odd] = error_constants(s, s.order + 1);
    CAPTURE(all, even, odd);
    CHECK(agrees(all, row.all, 4));
    CHECK(agrees(even, row.even, 4));
    CHECK(agrees(odd, row.odd, 4));
  }
}

TEST_CASE("The low-defect schemes have the small defects that they were made for", "[scheme]") {
  struct Row {
    const char* name;
    std::array<double, 4> even, odd;  // degrees 3, 5, 7, 9
  };
  for (const Row& row :
       {Row{"low_defect4_s7", {0, 5.4e-04, 1.1e-04, 2.2e-05}, {0, 7.2e-09, 1.3e-06, 7.3e-07}},
        {"low_defect4_s11", {0, 1.5e-05, 7.9e-06, 2.0e-06}, {0, 1.6e-09, 1.2e-07, 1.8e-07}},
        {"low_defect4_s12", {0, 7.2e-06, 6.4e-06, 1.5e-06}, {0, 4.5e-08, 2.4e-07, 1.0e-07}},
        {"low_defect6_s13", {0, 0, 3.8e-06, 8.4e-07}, {0, 4.7e-08, 2.4e-06, 4.9e-07}},
        {"low_defect6_s15", {0, 0, 3.8e-07, 1.1e-07}, {0, 4.0e-06, 2.0e-06, 4.9e-07}},
        {"low_defect8_s20", {0, 0, 0, 1.4e-07}, {0, 7.1e-07, 1.2e-05, 2.7e-06}}}) {
    const Scheme<double> s = schemes::by_name(row.name);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto [all, even, odd] = error_constants(s, static_cast<int>(2 * i) + 3);
      CAPTURE(row.name, 2 * i + 3, all, even, odd);
      CHECK((row.even[i] > 0 ? agrees(even, row.even[i], 2) : even <= 1e-14));
      CHECK((row.odd[i] > 0 ? agrees(odd, row.odd[i], 2) : odd <= 1e-14));
    }
  }
}

TEST_CASE("Orders and numbers of kicks", "[scheme]") {
  struct Row {
    int order, explicit_order;
    std::size_t kicks;
  };
  const std::map<std::string, Row> table{{"strang", {2, 2, 3}},
                                         {"mclachlan2", {2, 2, 5}},
                                         {"triple_jump4", {4, 4, 7}},
                                         {"triple_jump6", {6, 6, 19}},
                                         {"triple_jump8", {8, 8, 55}},
                                         {"suzuki4", {4, 4, 11}},
                                         {"suzuki6", {6, 6, 51}},
                                         {"suzuki8", {8, 8, 251}},
                                         {"blanes_moan4", {4, 4, 13}},
                                         {"blanes_moan6", {6, 6, 21}},
                                         {"yoshida6", {6, 6, 15}},
                                         {"kahan_li6", {6, 6, 19}},
                                         {"kahan_li8", {8, 8, 35}},
                                         {"suzuki_umeno8", {8, 8, 31}},
                                         {"sofroniou_spaletta6", {6, 6, 27}},
                                         {"sofroniou_spaletta8", {8, 8, 43}},
                                         {"sofroniou_spaletta10", {10, 10, 71}},
                                         {"low_defect4_s7", {4, 4, 15}},
                                         {"low_defect4_s11", {4, 4, 23}},
                                         {"low_defect4_s12", {4, 4, 25}},
                                         {"low_defect6_s13", {6, 4, 27}},
                                         {"low_defect6_s15", {6, 4, 31}},
                                         {"low_defect8_s20", {8, 4, 41}}};
  CHECK(table.size() == schemes::names().size());
  for (const auto& [name, row] : table) {
    CAPTURE(name);
    const Scheme<double> s = schemes::by_name(name);
    CHECK(s.name == name);
    CHECK_FALSE(s.source.empty());
    CHECK(s.order == row.order);
    CHECK(s.explicit_order == row.explicit_order);
    CHECK(s.kicks() == row.kicks);
    CHECK(s.a.size() + s.b.size() == row.kicks);

    const Scheme<double> found = make_scheme(name, s.a, s.b);
    CHECK(found.order == row.order);
    CHECK(found.explicit_order == row.explicit_order);
    CHECK(make_scheme<long double>(name, schemes::by_name<long double>(name).a,
                                   schemes::by_name<long double>(name).b)
              .explicit_order == row.explicit_order);
  }
  CHECK(schemes::triple_jump(2).a == schemes::strang().a);
  CHECK(schemes::suzuki(2).b == schemes::strang().b);
  CHECK(schemes::triple_jump(10).kicks() == 163);
  CHECK(schemes::triple_jump<float>(10).order == 10);
  CHECK(schemes::triple_jump<Wide>(10).order == 10);
  for (const int order : {-2, 0, 1, 3, 5, 12})
    CHECK(says_all(refusal([&] { schemes::triple_jump(order); }),
                   {"triple_jump", std::to_string(order), "from 2 to 10"}));
  for (const int order : {0, 7, 10})
    CHECK(
        says_all(refusal([&] { schemes::suzuki(order); }), {"suzuki", std::to_string(order), "from 2 to 8"}));
}

TEST_CASE("A defect of degree r limits the projected order to 2r", "[scheme]") {
  // Even parts that vanish up to degree 9, odd ones from degree 3 on: order 6 and no more.
  std::vector<detail::DegreeDefect<double>> defects(11, {0, 0, 1e-15});
  CHECK(detail::orders(defects).projected == 10);
  defects[3].odd = 1e-3;
  CHECK(detail::orders(defects).projected == 6);
  CHECK(detail::orders(defects).explicit_order == 2);
  defects[5].even = 1e-3;
  CHECK(detail::orders(defects).projected == 4);
  defects[5].even = std::numeric_limits<double>::quiet_NaN();
  CHECK(detail::orders(defects).projected == 4);
}

TEST_CASE("compose() makes the known compositions and finds their order", "[scheme]") {
  const Scheme<double> triple = compose(schemes::strang(), {jump, 1 - 2 * jump, jump}, "mine", "me");
  const Scheme<double> known = schemes::triple_jump(4);
  CHECK(triple.name == "mine");
  CHECK(triple.source == "me");
  CHECK(triple.order == 4);
  CHECK(triple.explicit_order == 4);
  REQUIRE(triple.a.size() == known.a.size());
  REQUIRE(triple.b.size() == known.b.size());
  for (std::size_t i = 0; i < known.a.size(); ++i) CHECK(std::abs(triple.a[i] - known.a[i]) <= 1e-15);
  for (std::size_t i = 0; i < known.b.size(); ++i) CHECK(std::abs(triple.b[i] - known.b[i]) <= 1e-15);

  const double g = 1 / (2 - std::pow(2.0, 1.0 / 5));
  const Scheme<double> six = compose(schemes::blanes_moan4(), {g, 1 - 2 * g, g});
  CHECK(six.order == 6);
  CHECK(six.kicks() == 3 * 12 + 1);
  CHECK(says_all(six.name, {"3 stages of blanes_moan4"}));
  CHECK_FALSE(six.source.empty());

  CHECK(compose(schemes::strang(), schemes::sofroniou_spaletta10().b).order == 10);
  CHECK(compose(schemes::strang<long double>(), schemes::kahan_li8<long double>().b).order == 8);
  CHECK(compose(schemes::strang<Wide>(), schemes::yoshida6<Wide>().b).order == 6);
  CHECK(compose(schemes::strang<float>(), schemes::yoshida6<float>().b).order == 6);
  CHECK(compose(schemes::strang(), {1}).kicks() == 3);
  CHECK(compose(schemes::strang(), {0.5, 0.5}).order == 2);

  const auto composed = [](const std::vector<double>& weights) {
    return refusal([&] { compose(schemes::strang(), weights, "w"); });
  };
  CHECK(says_all(composed({}), {"\"w\"", "weights is empty"}));
  CHECK(says_all(composed({0.25, 0.75}),
                 {"weights is not palindromic", "weights[0] = 0.25", "weights[1] = 0.75"}));
  CHECK(says_all(composed({0.5, 0.25, 0.5}), {"weights sums to 1.25", "0.25"}));
  CHECK(says_all(composed({NAN, 1, NAN}), {"weights[0] is NaN or Inf"}));
  Scheme<double> edited = schemes::strang();
  edited.b[0] = 0.9;
  CHECK(says_all(refusal([&] { compose(edited, {1.0}); }), {"\"strang\"", "b sums to 0.9"}));
}

TEST_CASE("Every kind of wrong list is refused, with its name and the remedy", "[scheme]") {
  using List = std::vector<double>;
  const auto built = [](int order, const List& a, const List& b) {
    return refusal([&] { Scheme<double>("mine", order, a, b); });
  };
  CHECK(good().order == 4);
  CHECK(says_all(built(2, {0.5, 0.5}, {0.5, 0.5}),
                 {"Scheme \"mine\"", "a has 2 entries", "b has 2", "one A more"}));
  CHECK(says_all(built(2, {1}, {}), {"a has 1 entries", "b has 0"}));
  CHECK(says_all(built(2, {}, {}), {"a has 0 entries", "b has 0"}));
  CHECK(says_all(built(2, {NAN, 0.5}, {1}), {"a[0] is NaN or Inf", "give finite"}));
  CHECK(says_all(built(2, {0.5, 0.5}, {INFINITY}), {"b[0] is NaN or Inf"}));
  CHECK(says_all(built(2, {0.25, 0.75}, {1}),
                 {"a is not palindromic", "a[0] = 0.25", "a[1] = 0.75", "make the two equal"}));
  CHECK(says_all(built(2, {0.25, 0.5, 0.25}, {0.4, 0.6}),
                 {"b is not palindromic", "b[0] = 0.4", "b[1] = 0.6"}));
  CHECK(says_all(built(2, {0.5, 0.5}, {0.99}),
                 {"b sums to 0.99", "not to one", "-0.01", "divide it by its sum"}));
  CHECK(says_all(built(2, {0.5, 0.25, 0.5}, {0.5, 0.5}), {"a sums to 1.25", "0.25"}));
  CHECK(says_all(built(2, {1e200, 1 - 2e200, 1e200}, {0.5, 0.5}),
                 {"hold only up to order 0", "check the digits"}));
  CHECK(says_all(built(4, {0.5, 0.5}, {1}),
                 {"order 4 is claimed", "only up to order 2", "degree 3", "claim order 2"}));
  CHECK(says_all(built(6, good().a, good().b),
                 {"order 6 is claimed", "only up to order 4", "degree 5", "claim order 4"}));
  for (const int order : {-2, 0, 1, 3, 14, 1000, std::numeric_limits<int>::max()})
    CHECK(says_all(built(order, {0.5, 0.5}, {1}),
                   {"cannot claim order " + std::to_string(order), "2, 4, ..., 12"}));
  CHECK(says_all(built(12, schemes::sofroniou_spaletta10().a, schemes::sofroniou_spaletta10().b),
                 {"only up to order 10"}));

  // Less than the true order may be claimed.
  CHECK(Scheme<double>("modest", 2, good().a, good().b).explicit_order == 2);
  CHECK(refusal([] {
          make_scheme<double>("x", {0.5, 0.4}, {1});
        }).find("not palindromic") != std::string::npos);
  CHECK(says_all(refusal([] { Scheme<float>("f", 4, {0.5F, 0.5F}, {1.0F}); }), {"only up to order 2"}));
}

TEST_CASE("check() finds what was edited afterwards", "[scheme]") {
  const auto edited = [](const std::function<void(Scheme<double>&)>& edit) {
    Scheme<double> s = schemes::blanes_moan6();
    s.check();
    edit(s);
    return refusal([&] { s.check(); });
  };
  using S = Scheme<double>;
  CHECK(says_all(edited([](S& s) { s.a.pop_back(); }), {"\"blanes_moan6\"", "a has 10 entries"}));
  CHECK(says_all(edited([](S& s) { s.b[2] = NAN; }), {"b[2] is NaN"}));
  CHECK(says_all(edited([](S& s) { s.a[0] += 1e-10; }), {"a is not palindromic"}));
  CHECK(says_all(edited([](S& s) { s.b[0] = s.b.back() = 0.2; }), {"b sums to"}));
  CHECK(says_all(edited([](S& s) { s.order = 8; }), {"order 8 is claimed", "only up to order 6"}));
  CHECK(says_all(edited([](S& s) { s.order = 5; }), {"cannot claim order 5"}));
  CHECK(says_all(edited([](S& s) { s.explicit_order = 8; }), {"explicit_order = 8"}));
  CHECK(says_all(edited([](S& s) { s.explicit_order = 1 << 30; }), {"explicit_order = "}));
  CHECK(edited([](S& s) { s.order = 4; }) == accepted);
  CHECK(edited([](S& s) { s.name = "another"; }) == accepted);

  Scheme<double> s = schemes::low_defect6_s13();
  s.explicit_order = 6;
  CHECK(says_all(refusal([&] { s.check(); }), {"explicit_order = 6"}));
}

TEST_CASE("A coefficient that is off in the tenth digit is refused", "[scheme]") {
  // The sums and the symmetry are kept, so only the order conditions can tell.
  const auto shift = [](std::vector<double> list, std::size_t from, std::size_t to, double change) {
    for (const std::size_t i : {from, list.size() - 1 - from}) list[i] += change;
    for (const std::size_t i : {to, list.size() - 1 - to}) list[i] -= change;
    return list;
  };
  for (const std::string& name : schemes::names()) {
    const Scheme<double> right = schemes::by_name(name);
    if (right.order < 4) continue;
    for (const double change : {1e-6, -1e-10}) {
      for (const bool in_a : {true, false}) {
        Scheme<double> wrong = right;
        (in_a ? wrong.a : wrong.b) =
            shift(in_a ? right.a : right.b, 0, in_a ? 1 : right.b.size() / 2, change);
        CAPTURE(name, change, in_a);
        CHECK(says_all(refusal([&] { wrong.check(); }), {name}));
        const Scheme<double> found = make_scheme("wrong", wrong.a, wrong.b);
        CHECK(found.order + found.explicit_order < right.order + right.explicit_order);

        // In a list made of Strang steps a shift between A kicks changes the even part to second order only:
        // for the projected method of order 4, one of 1e-10 is no error at all, and a new Scheme may say so.
        const bool harmless = in_a && change == -1e-10 && (name == "triple_jump4" || name == "suzuki4");
        const std::string claim = refusal([&] { Scheme<double>("again", right.order, wrong.a, wrong.b); });
        CHECK(says_all(claim, {harmless ? accepted : "is claimed"}));
      }
    }
  }
}

TEST_CASE("The coefficients carry the digits of a wide type", "[scheme]") {
  const bool wider = std::numeric_limits<long double>::digits > std::numeric_limits<double>::digits;
  for (const std::string& name : schemes::names()) {
    if (name == "strang") continue;
    CAPTURE(name);
    const Scheme<double> d = schemes::by_name<double>(name);
    const Scheme<long double> l = schemes::by_name<long double>(name);
    const Scheme<Wide> w = schemes::by_name<Wide>(name);
    const Scheme<float> f = schemes::by_name<float>(name);
    int more = 0;
    for (std::size_t i = 0; i < w.a.size(); ++i) {
      more += l.a[i] != static_cast<long double>(d.a[i]);
      // Each is the number closest to the true one; the merged kicks of a composition in the widest built-in
      // type have two roundings.
      const long double rounding = std::numeric_limits<long double>::epsilon();
      CHECK(size_of(l.a[i] - static_cast<long double>(w.a[i])) <= rounding);
      if (wider) CHECK(d.a[i] == static_cast<double>(w.a[i]));
      CHECK(f.a[i] == static_cast<float>(w.a[i]));
      CHECK(size_of(Wide(w.a[i] - w.a[w.a.size() - 1 - i])) == 0);
    }
    if (wider) CHECK(more > 0);
    const auto defects = detail::degree_defects<Wide>(w.a, w.b, 4, std::numeric_limits<Wide>::epsilon());
    if (w.order >= 4) {
      CHECK(defects[3].even <= Wide("1e-45"));
      CHECK(defects[3].odd <= Wide("1e-45"));
    }
  }
  // 1/(2 - 2^(1/3)), from another source.
  const Wide g("1.35120719195965763404768780897146082692199938");
  CHECK(size_of(Wide(schemes::triple_jump<Wide>(4).b[0] - g)) <= Wide("1e-44"));
  // McLachlan's closed form.
  const Wide y = cbrt(Wide(2 * sqrt(Wide(326)) - 36));
  CHECK(size_of(Wide(schemes::mclachlan2<Wide>().a[0] - (y * y + 6 * y - 2) / (12 * y))) <= Wide("1e-48"));
}

TEST_CASE("Coefficients do not depend on the locale of the program", "[scheme]") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const Scheme<double> before = schemes::blanes_moan4();
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const Scheme<double> after = schemes::blanes_moan4();
  const std::string message = refusal([] { Scheme<double>("mine", 2, {0.5, 0.5}, {0.75}); });
  std::locale::global(old);
  CHECK(before.a == after.a);
  CHECK(before.b == after.b);
  CHECK(says_all(message, {"b sums to 0.75"}));
}

TEST_CASE("Schemes by name", "[scheme]") {
  const std::vector<std::string> names = schemes::names();
  CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
  for (const std::string& name : names) CHECK(schemes::by_name<float>(name).name == name);
  CHECK(schemes::by_name("low_defect6_s13").a == schemes::low_defect6_s13().a);
  const std::string message = refusal([] { schemes::by_name("rk4"); });
  CHECK(says_all(message, {"\"rk4\"", "strang", "triple_jump8", "suzuki4", "sofroniou_spaletta10"}));
}

TEST_CASE("Decimal multiprecision works as well", "[scheme]") {
  using Decimal = boost::multiprecision::cpp_dec_float_50;
  CHECK(schemes::low_defect8_s20<Decimal>().explicit_order == 4);
  CHECK(schemes::triple_jump<Decimal>(6).order == 6);
  const Decimal half("0.5"), third = Decimal(1) / 3;
  CHECK(Scheme<Decimal>("thirds", 2, {third, third, third}, {half, half}).order == 2);
  CHECK(says_all(refusal([&] {
                   Scheme<Decimal>("d", 2, {half, half}, {Decimal("1") + Decimal("1e-30")});
                 }),
                 {"b sums to 1,", "off by 1e-30"}));
}

}  // namespace test_scheme
