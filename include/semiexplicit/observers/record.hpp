#pragma once

#include <cstddef>
#include <vector>

#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// An observer that keeps the times and the states it sees, in memory. Of an ExtendedPoint it keeps (q, p). Named among the
/// observers of Checkpoints it is saved with all that it holds: for a long run let it see every hundredth step, say, or write a
/// CsvTrajectory.
template <class Scalar, int Dof>
struct Record {
  static constexpr const char* name = "Record";

  template <class State>
  void operator()(const Scalar& time, const State& state) {
    t.push_back(time);
    z.emplace_back(state.q(), state.p());
  }

  /// Whether it holds nothing yet: a resumed run would lack its beginning.
  bool fresh() const { return t.empty(); }

  /// It has no options; see Describable.
  template <class List>
  void describe(List&) const {}
  /// All that it holds; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    std::vector<Scalar> numbers;
    for (const auto& one : z) numbers.insert(numbers.end(), one.vector().begin(), one.vector().end());
    visit(t);
    visit(numbers);
    if (t.empty()) return z.clear();
    z.assign(t.size(), PhasePoint<Scalar, Dof>(static_cast<Eigen::Index>(numbers.size() / (2 * t.size()))));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::size_t length = numbers.size() / t.size();
      z[i / length].vector()[static_cast<Eigen::Index>(i % length)] = numbers[i];
    }
  }

  std::vector<Scalar> t;
  std::vector<PhasePoint<Scalar, Dof>> z;
};

}  // namespace semiexplicit
