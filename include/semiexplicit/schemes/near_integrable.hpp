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

/// The whole of a list from its first half. The digits beyond the published ones are by Newton's method on
/// the conditions, to sixty, for wide types.
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
      {"0.06943184420297371238802675555359524745213731018514118119213904",
       "0.260577634004598155210640364894782408947574754929401642511384",
       "0.339981043584856264802665759103244687200575869770914352592954"},
      {"0.1739274225687269286865319746109997036176743479169467702462647",
       "0.3260725774312730713134680253890002963823256520830532297537353"},
      4, "McLachlan, BIT 35 (1995) 258; Laskar and Robutel (2001), SABA4");
}

/// (8,4), five kicks. Source: R. McLachlan, BIT 35 (1995) 258.
template <class Scalar = double>
NearIntegrable<Scalar> aba84() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba84", {8, 4},
      {"0.07534696026989288841652780368347446437265266455407906314097205",
       "0.5179168546882567823007739784963156443238474478219809150257193",
       "-0.09326381495814967071730178217979010869650011237605997816669131"},
      {"0.1902259393736766192452307627384538974612036199048726446865669",
       "0.8465240704435262570550805446467758341771137423946828545559245",
       "-1.073500019634405752600622614770459463276634724599110998484983"},
      5, "McLachlan, BIT 35 (1995) 258");
}

/// (10,4), seven kicks. Source: S. Blanes, F. Casas, A. Farrés, J. Laskar, J. Makazaga and A. Murua, Appl.
/// Numer. Math. 68 (2013) 58.
template <class Scalar = double>
NearIntegrable<Scalar> aba104() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba104", {10, 4},
      {"0.04706710064597250612947887637243678561673273505634138294735775",
       "0.1847569354170881069247376193702560971543340933391503449611205",
       "0.2827060056798362053243616565541452512662420032244916478878914",
       "-0.01453004174289681837857815229683813403730883161998337579636957"},
      {"0.1188819173681970199453503950853885938319925890484696553350594",
       "0.2410504605515015657441667865901651111479933944812422045900038",
       "-0.2732866667053238060543113981664558979771282607317919641132997",
       "0.826708577571250440729588432981804385994284554404160208376473"},
      7, "Blanes, Casas, Farrés, Laskar, Makazaga and Murua (2013)");
}

/// (8,6,4), seven kicks: the choice for perturbations of 1e-3. Source: as aba104.
template <class Scalar = double>
NearIntegrable<Scalar> aba864() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba864", {8, 6, 4},
      {"0.07113342649822311777793873000615499641740229592373960669585825",
       "0.2411534279566400987364877953262896496178146780493351792558809",
       "0.521411761772814789212136078067994229991436478850263542789578",
       "-0.3336986162276780057265626034004388760266534528233383287413172"},
      {"0.1830836874721972219617037571664302910726241265515976167936269",
       "0.3107828598985748695075222910542627963751573211162577268415869",
       "-0.02656461851195880069721213791649875926632977285254758519243949",
       "0.06539614228237341845597217939161134363709665036938448311445144"},
      7, "Blanes, Casas, Farrés, Laskar, Makazaga and Murua (2013)");
}

/// (10,6,4), eight kicks. Source: as aba104.
template <class Scalar = double>
NearIntegrable<Scalar> aba1064() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "aba1064", {10, 6, 4},
      {"0.03809449742241219545697532230863756534066006039580697016391452",
       "0.1452987161169137492940200726606637497443088851461260236627279",
       "0.2076276957255412507162056113249882065158369684461609150767143",
       "0.4359097036515261592231548624010651844006887964943272549633534",
       "-0.6538612258327867093807117373907094120029894209648423277334203"},
      {"0.09585888083707521061077150377145884776934222604071470032783603",
       "0.2044461531429987806805077839164344779763299586173710678411193",
       "0.2170703479789911017143385924306336714529759820421083216185765",
       "-0.01737538195906509300561788011852699719864816670019408978753186"},
      8, "Blanes, Casas, Farrés, Laskar, Makazaga and Murua (2013)");
}

/// Blanes and Moan's Nyström list of order 6 with fourteen kicks: for potentials, small or not.
///
/// Source: S. Blanes and P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 3, SRKN14a, with
/// fifteen digits.
template <class Scalar = double>
NearIntegrable<Scalar> blanes_moan_nystrom6() {
  return semiexplicit::detail::near_integrable<Scalar>(
      "blanes_moan_nystrom6", {6},
      {"0.03785931984061101628651598091906322906901233045759424525889233",
       "0.102635633102436605608584691620301495606008731144423058401863",
       "-0.02586788826655835032544015167185195694895213567519774974104741",
       "0.3142414030714464093086677858675286509056096258982307011031473",
       "-0.1301444595174151970157910853443011238750107144104581091268636",
       "0.1064177003695418294877994883146706911741004736849462320478974",
       "-0.008794243128510174632638512563910949597758292994134812512579272",
       "0.2073050690568957225646036057169999273339799637891928691373805"},
      {"0.0917191526244621754152294513896786295123090234176026019203028",
       "0.1839831700050048822786243402697313139211992288187358507220388",
       "-0.05653436583288916926143176486259971930846964620779856169383816",
       "0.004914688774711813118083983049593023218977758536542698460082269",
       "0.1437611271683618419692682385199129902969574011615013680712072",
       "0.3285676937468034573566523214506330551156381008650877431154052",
       "-0.196411466486455000876426569816949292756611866591671700595198"},
      14, "Blanes and Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 3, SRKN14a", true);
}

}  // namespace schemes
}  // namespace semiexplicit
