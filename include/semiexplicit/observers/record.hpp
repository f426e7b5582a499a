#pragma once

#include <vector>

#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// An observer that keeps the times and the states it sees, in memory. Of an ExtendedPoint it keeps (q, p).
template <class Scalar, int Dof>
struct Record {
  template <class State>
  void operator()(const Scalar& time, const State& state) {
    t.push_back(time);
    z.emplace_back(state.q(), state.p());
  }

  std::vector<Scalar> t;
  std::vector<PhasePoint<Scalar, Dof>> z;
};

}  // namespace semiexplicit
