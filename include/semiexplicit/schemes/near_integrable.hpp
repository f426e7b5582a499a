#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/schemes/order_conditions.hpp>
#include <semiexplicit/schemes/scheme.hpp>

namespace semiexplicit {

/// A splitting for H = A + εB with a small ε: the flows A(a0) B(b0) A(a1) ... B(b_{n-1}) A(a_n), in units of
/// the step. Of generalised order (n₁, n₂, ...) is a list whose error is ε h^n₁ + ε² h^n₂ + ...; the last
/// order holds for all higher powers of ε. An ordinary Scheme is one, too, of generalised order (order):
/// where B is not small.
///
/// A Runge-Kutta-Nyström list is for an A that is quadratic in p and a B that depends on q alone, small or
/// not. Then [B, [B, [B, A]]] = 0, and a list needs fewer conditions for its order: at order 6 two of eight
/// and ten.
///
/// Sources: R. McLachlan, BIT 35 (1995) 258; Nyström: S. Blanes and P. C. Moan, J. Comput. Appl. Math. 142
/// (2002) 313.
template <class ScalarType>
struct NearIntegrable {
  using Scalar = ScalarType;

  /// Throws std::invalid_argument, with the remedy, unless the list is finite, palindromic, sums to one in a
  /// and in b, and satisfies the conditions of the generalised order (at the precision of Scalar).
  NearIntegrable(std::string called, std::vector<int> claimed, std::vector<ScalarType> a_flows,
                 std::vector<ScalarType> b_flows, std::string taken_from = "", bool for_nystrom = false)
      : name(std::move(called)),
        orders(std::move(claimed)),
        a(std::move(a_flows)),
        b(std::move(b_flows)),
        source(std::move(taken_from)),
        nystrom(for_nystrom) {
    check();
  }

  /// An ordinary scheme. Throws std::invalid_argument for one that reaches its order with the projection only
  /// (low_defect6_*), for the flows of A and B are no copies of each other.
  NearIntegrable(const Scheme<ScalarType>& scheme)  // NOLINT: a Scheme may stand where a list is asked for
      : name(scheme.name), orders{scheme.explicit_order}, a(scheme.a), b(scheme.b), source(scheme.source) {
    if (scheme.explicit_order < scheme.order)
      throw std::invalid_argument(detail::scheme_called(name) + "has order " + std::to_string(scheme.order) +
                                  " with the projection only, and order " +
                                  std::to_string(scheme.explicit_order) +
                                  " as a splitting into two flows; take another one (blanes_moan6, say)");
    check();
  }

  /// Throws std::invalid_argument if the members, which anybody may edit, no longer fit together.
  SEMIEXPLICIT_COLD void check() const {
    const std::string owner = detail::scheme_called(name);
    if (b.empty() || a.size() != b.size() + 1)
      throw std::invalid_argument(owner + "a has " + std::to_string(a.size()) + " entries and b has " +
                                  std::to_string(b.size()) +
                                  "; A B A ... B A needs at least one B and one A more than B");
    detail::check_list(owner, "a", a);
    detail::check_list(owner, "b", b);
    for (std::size_t k = 0; k < orders.size(); ++k)
      if (orders[k] < 2 || orders[k] % 2 != 0 || orders[k] > max_scheme_order ||
          (k > 0 && orders[k] > orders[k - 1]))
        throw std::invalid_argument(owner + "the generalised order is even numbers from 2 to " +
                                    std::to_string(max_scheme_order) + " that do not grow, as {8, 2}");
    if (orders.empty())
      throw std::invalid_argument(owner + "no order is claimed; give the generalised order, as {8, 2}");
    if (nystrom && orders.front() > 6)
      throw std::invalid_argument(owner +
                                  "the conditions of a Nyström list are known here up to order 6; "
                                  "claim that, or give a list for any A and B");
    check_conditions(owner);
  }

  /// (8,2), say.
  std::string order_in_words() const {
    std::string text;
    for (const int order : orders) {
      text += text.empty() ? '(' : ',';
      text += std::to_string(order);
    }
    text += ')';
    return text;
  }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("a", a);
    list("b", b);
  }

  std::string name;
  std::vector<int> orders;  ///< of the powers of ε, the last one also of all higher ones
  std::vector<Scalar> a, b;
  std::string source;    ///< where the coefficients come from
  bool nystrom = false;  ///< holds only where A is quadratic in p and B depends on q alone

 private:
  /// In the logarithm of the product of the flows the words with k letters B belong to ε^k.
  SEMIEXPLICIT_COLD void check_conditions(const std::string& owner) const {
    using Work = detail::ConditionScalar<Scalar>;
    const int degree = orders.front();
    const std::vector<Work> work_a(a.begin(), a.end()), work_b(b.begin(), b.end());
    const auto log = detail::log_of_kicks(work_a, work_b, degree);
    const auto bounds =
        detail::degree_defects(work_a, work_b, std::min(degree, 2), Work(detail::machine_epsilon<Scalar>()));
    const Work longest = std::max(detail::reach(work_a), detail::reach(work_b));
    Work tolerance = bounds.back().tolerance / longest;
    for (int n = 2; n <= degree; ++n) {
      tolerance = tolerance * longest;
      for (std::size_t w = detail::words(n); w < detail::words(n + 1); ++w) {
        const auto letters = static_cast<std::size_t>(std::popcount(w)) - 1;  // without the leading bit
        if (letters == 0 || n > orders[std::min(letters, orders.size()) - 1]) continue;
        Work size = detail::magnitude(log[w]);
        if (nystrom && n == 5 && letters >= 3) {
          // Four letters B: only [B, [B, [B, [B, A]]]] = 0. Three: what is no multiple of [A, [B, [B, [B,
          // A]]]].
          constexpr std::size_t aabbb = 0b1'00111, ababb = 0b1'01011;
          if (w != ababb) continue;
          size = detail::magnitude(Work(Work(3) * log[aabbb] + log[ababb]));
        }
        if (!(size <= tolerance))
          throw std::invalid_argument(owner + "the generalised order " + order_in_words() +
                                      " is claimed, but a condition of degree " + std::to_string(n) +
                                      " in h and " + std::to_string(letters) + " in epsilon is violated by " +
                                      detail::in_words(size, 3) + " where rounding explains " +
                                      detail::in_words(tolerance, 1) +
                                      "; check the digits of a and b, or claim less");
      }
    }
  }
};

namespace detail {

/// The whole of a list from its first half.
template <class Scalar>
SEMIEXPLICIT_COLD NearIntegrable<Scalar> near_integrable(const char* name, std::vector<int> orders,
                                                         std::initializer_list<const char*> half_a,
                                                         std::initializer_list<const char*> half_b,
                                                         int stages, const char* source,
                                                         bool nystrom = false) {
  const auto whole = [](std::initializer_list<const char*> half, int size) {
    std::vector<Scalar> list;
    for (const char* digits : half) list.push_back(decimal<Scalar>(digits));
    for (int i = static_cast<int>(list.size()); i < size; ++i)
      list.push_back(Scalar(list[static_cast<std::size_t>(size - 1 - i)]));
    return list;
  };
  return {name, std::move(orders), whole(half_a, stages + 1), whole(half_b, stages), source, nystrom};
}

}  // namespace detail

namespace schemes {

/// (8,2), four kicks: the choice for perturbations below 1e-4 or so.
///
/// Sources: R. McLachlan, BIT 35 (1995) 258; J. Laskar and P. Robutel, Celest. Mech. Dyn. Astron. 80 (2001)
/// 39, SABA4.
template <class Scalar = double>
NearIntegrable<Scalar> aba82() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba82", {8, 2},
      {"0.06943184420297371238802675555359524745214", "0.2605776340045981552106403648947824089476",
       "0.3399810435848562648026657591032446872006"},
      {"0.1739274225687269286865319746109997036177", "0.3260725774312730713134680253890002963823"}, 4,
      "McLachlan, BIT 35 (1995) 258; Laskar and Robutel (2001), SABA4");
}

/// (8,4), five kicks. Source: R. McLachlan, BIT 35 (1995) 258.
template <class Scalar = double>
NearIntegrable<Scalar> aba84() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba84", {8, 4},
      {"0.07534696026989288841652780368347445", "0.5179168546882567823007739784963157",
       "-0.09326381495814967071730178217979014"},
      {"0.1902259393736766192452307627384538", "0.8465240704435262570550805446647778",
       "-1.073500019634405752600622614770459"},
      5, "McLachlan, BIT 35 (1995) 258");
}

/// (10,4), seven kicks. Source: S. Blanes, F. Casas, A. Farrés, J. Laskar, J. Makazaga and A. Murua, Appl.
/// Numer. Math. 68 (2013) 58.
template <class Scalar = double>
NearIntegrable<Scalar> aba104() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba104", {10, 4},
      {"0.04706710064597250612947887637243678556564", "0.1847569354170881069247376193702960568574",
       "0.2827060056798362053243616565541452479160", "-0.01453004174289681837857815229683813033908"},
      {"0.1188819173681970199453503950853885936957", "0.2410504605515015657441667865901651105675",
       "-0.2732866667053238060543113981664559460630", "0.8267085775712504407295884329818044835997"},
      7, "Blanes, Casas, Farrés, Laskar, Makazaga and Murua (2013)");
}

/// (8,6,4), seven kicks: the choice for perturbations of 1e-3. Source: as aba104.
template <class Scalar = double>
NearIntegrable<Scalar> aba864() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba864", {8, 6, 4},
      {"0.0711334264982231177779387300061549964174", "0.241153427956640098736487795326289649618",
       "0.521411761772814789212136078067994229991", "-0.333698616227678005726562603400438876027"},
      {"0.183083687472197221961703757166430291072", "0.310782859898574869507522291054262796375",
       "-0.0265646185119588006972121379164987592663", "0.0653961422823734184559721793911134363710"},
      7, "Blanes, Casas, Farrés, Laskar, Makazaga and Murua (2013)");
}

/// (10,6,4), eight kicks. Source: as aba104.
template <class Scalar = double>
NearIntegrable<Scalar> aba1064() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba1064", {10, 6, 4},
      {"0.03809449742241219545697532230863756534060", "0.1452987161169137492940200726606637497442",
       "0.2076276957255412507162056113249882065158", "0.4359097036515261592231548624010651844006",
       "-0.6538612258327867093807117373907094120024"},
      {"0.09585888083707521061150377145884776921872", "0.2044461531429987806805077839164344779763",
       "0.2170703479789911017143385924306336714532", "-0.01737538195906509300561788011852699719871"},
      8, "Blanes, Casas, Farrés, Laskar, Makazaga and Murua (2013)");
}

/// Blanes and Moan's Nyström list of order 6 with fourteen kicks: for potentials, small or not.
///
/// Source: S. Blanes and P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 3, SRKN14a; the digits
/// beyond the fifteen published ones by Newton's method on the order conditions.
template <class Scalar = double>
NearIntegrable<Scalar> blanes_moan_nystrom6() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "blanes_moan_nystrom6", {6},
      {"0.037859319840611016286515980919063229069013", "0.10263563310243660560858469162030149560601",
       "-0.025867888266558350325440151671851956948952", "0.31424140307144640930866778586752865090561",
       "-0.13014445951741519701579108534430112387501", "0.1064177003695418294877994883146706911741",
       "-0.0087942431285101746326385125639109495977582", "0.20730506905689572256460360571699992733398"},
      {"0.09171915262446217541522945138967862951231", "0.1839831700050048822786243402697313139212",
       "-0.056534365832889169261431764862599719308469", "0.0049146887747118131180839830495930232189775",
       "0.14376112716836184196926823851991299029696", "0.32856769374680345735665232145063305511564",
       "-0.19641146648645500087642656981694929275661"},
      14, "Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 3, SRKN14a", true);
}

}  // namespace schemes
}  // namespace semiexplicit
