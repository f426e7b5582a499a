#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// An observer that keeps the times and the states it sees, in memory. Of an ExtendedPoint it keeps (q, p).
/// Named among the observers of Checkpoints it is saved with all that it holds: for a long run let it see
/// every hundredth step, say, or write a CsvTrajectory. A state of another size than the first is refused
/// with std::invalid_argument.
template <class Scalar, int Dof>
struct Record {
  static constexpr const char* name = "Record";

  template <detail::HasHalves State>
  void operator()(const Scalar& time, const State& state) {
    static_assert(detail::is_state_of<State, Dof>());
    if constexpr (Dof != Eigen::Dynamic) detail::require_same_dof("Record", state.q().size(), "type", Dof);
    if (!z.empty()) refuse_other_size(state.q().size());
    t.push_back(time);
    z.emplace_back(state.q(), state.p());
  }

  /// Whether it holds nothing yet: a resumed run would lack its beginning.
  bool fresh() const { return t.empty(); }

  /// It has no options; see Describable.
  template <class List>
  void describe(List&) const {}
  /// All that it holds; see CheckpointMemory. Throws std::invalid_argument where t and z were changed and do
  /// not go together.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    std::vector<Scalar> numbers;
    if (t.size() != z.size())
      throw std::invalid_argument("Record: there are " + std::to_string(t.size()) + " times and " +
                                  std::to_string(z.size()) + " states; leave both as they were recorded");
    for (const auto& one : z) {
      refuse_other_size(one.dof());
      numbers.insert(numbers.end(), one.vector().begin(), one.vector().end());
    }
    visit(t);
    visit(numbers);
    const std::size_t length = t.empty() ? 0 : numbers.size() / t.size();
    if (numbers.size() != length * t.size() || length % 2 != 0)
      throw std::invalid_argument("Record: its times and states do not go together; start anew without it");
    if (t.empty()) return z.clear();
    z.assign(t.size(), PhasePoint<Scalar, Dof>(static_cast<Eigen::Index>(length / 2)));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      z[i / length].vector()[static_cast<Eigen::Index>(i % length)] = numbers[i];
  }

  std::vector<Scalar> t;
  std::vector<PhasePoint<Scalar, Dof>> z;

 private:
  void refuse_other_size(Eigen::Index dof) const {
    if (dof != z.front().dof())
      throw std::invalid_argument("Record: a state with " + std::to_string(dof) +
                                  " degrees of freedom after one with " + std::to_string(z.front().dof()) +
                                  "; give each run a Record of its own");
  }
};

}  // namespace semiexplicit
