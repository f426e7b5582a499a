#pragma once

#include <algorithm>
#include <concepts>
#include <type_traits>
#include <vector>

#include <semiexplicit/ensemble/pack_point.hpp>

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

/// The Hamiltonians of all members: a family and its parameters, a column a member.
template <class Family>
struct MemberHamiltonians {
  Family family;
  Eigen::MatrixXd parameters;

  /// A member's own, of plain numbers.
  auto plain(Eigen::Index member) const { return family(parameters.col(member).data()); }

  /// The parameters of the members from `first` on, a lane each; or of that one alone in all lanes.
  std::vector<Many> packs(Eigen::Index first, bool alone = false) const {
    std::vector<Many> columns(static_cast<std::size_t>(std::max<Eigen::Index>(parameters.rows(), 1)),
                              Many(0.0));
    for (Eigen::Index i = 0; i < parameters.rows(); ++i)
      for (Eigen::Index k = 0; k < pack_width; ++k)
        columns[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
            parameters(i, alone ? first : std::min(first + k, parameters.cols() - 1));
    return columns;
  }
};

}  // namespace semiexplicit::detail
