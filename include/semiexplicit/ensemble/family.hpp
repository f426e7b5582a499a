#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <type_traits>
#include <vector>

#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/ensemble/pack_point.hpp>
#include <semiexplicit/steppers/detail/kick.hpp>

namespace semiexplicit::detail {

/// The family whose members all have the same Hamiltonian.
template <class H>
struct SameHamiltonian {
  H hamiltonian;
  template <class S>
  const H& operator()(const S*) const {
    return hamiltonian;
  }
};

/// A family makes a Hamiltonian of a column of numbers, or of packs of them.
template <class Family, class Number>
using MadeOf = std::remove_cvref_t<std::invoke_result_t<const Family&, const Number*>>;
template <class Family>
concept MakesPacks = std::invocable<const Family&, const Many*> && PackHamiltonian<MadeOf<Family, Many>>;
template <class Family>
concept MakesPlain = std::invocable<const Family&, const double*> && HasScalar<MadeOf<Family, double>> &&
                     std::same_as < typename MadeOf<Family, double>::Scalar,
double > ;

/// One member of a Hamiltonian of packs that is the same in all lanes, in plain numbers.
template <class H>
struct FirstLane {
  using Scalar = double;
  static constexpr int Dof = H::Dof;
  const H& hamiltonian;

  Eigen::Index dof() const { return dof_of(hamiltonian); }
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    const Eigen::Index d = q.size();
    std::vector<Many> at(static_cast<std::size_t>(2 * d)), result = at;
    for (Eigen::Index i = 0; i < d; ++i)
      at[static_cast<std::size_t>(i)] = q[i], at[static_cast<std::size_t>(d + i)] = p[i];
    gradient_on(hamiltonian, at.data(), result.data(), d);
    for (Eigen::Index i = 0; i < d; ++i) {
      dHdq[i] = result[static_cast<std::size_t>(i)][0];
      dHdp[i] = result[static_cast<std::size_t>(d + i)][0];
    }
  }
};

/// The Hamiltonians of all members: a family and its parameters, a column a member.
template <class Family>
struct MemberHamiltonians {
  Family family;
  Eigen::MatrixXd parameters;

  /// A member's own, of plain numbers.
  auto plain(Eigen::Index member) const { return family(parameters.col(member).data()); }

  /// made(i), a Hamiltonian, of the first member i for which the family does not throw. Where it does for
  /// all, what it throws for the last one comes out.
  template <class Made>
  auto first(const Made& made) const {
    for (Eigen::Index i = 0; i + 1 < parameters.cols(); ++i) {
      try {
        return made(i);
      } catch (...) {  // run() tells of it
      }
    }
    return made(parameters.cols() - 1);
  }

  /// By its value one member's Hamiltonian is told from another at z.
  template <class State>
  double gradient_size(Eigen::Index member, const State& z) const {
    if constexpr (MakesPlain<Family>) {
      const auto own = plain(member);
      return GradientSize(own)(z.q(), z.p());
    } else {
      const std::vector<Many> numbers = packs(member, true);
      const auto own = family(numbers.data());
      return GradientSize(FirstLane<std::remove_cvref_t<decltype(own)>>{own})(z.q(), z.p());
    }
  }

  /// The parameters of the members from `first` on, a lane each; or of that one alone in all lanes. NaN where
  /// there is none.
  std::vector<Many> packs(Eigen::Index first, bool alone = false) const {
    std::vector<Many> columns(static_cast<std::size_t>(std::max<Eigen::Index>(parameters.rows(), 1)),
                              Many(std::numeric_limits<double>::quiet_NaN()));
    for (Eigen::Index i = 0; i < parameters.rows(); ++i)
      for (Eigen::Index k = 0; k < pack_width; ++k)
        columns[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
            parameters(i, alone ? first : std::min(first + k, parameters.cols() - 1));
    return columns;
  }
};

}  // namespace semiexplicit::detail
