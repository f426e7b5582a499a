#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

/// The product system with a fault at one call of its gradient.
struct Faulty {
  using Scalar = double;
  static constexpr int Dof = 1;

  enum class Fault { none, nan_q, nan_p, infinite_q, infinite_p, raise };
  struct Plan {
    std::int64_t calls = 0, at = -1;
    Fault fault = Fault::none;
  };

  void gradient(semiexplicit::In<double, 1> q, semiexplicit::In<double, 1> p,
                semiexplicit::Out<double, 1> dHdq, semiexplicit::Out<double, 1> dHdp) const {
    const semiexplicit::systems::Product<double> system;
    system.gradient(q, p, dHdq, dHdp);
    if (plan->calls++ != plan->at) return;
    switch (plan->fault) {
      case Fault::none:
        return;
      case Fault::nan_q:
        dHdq[0] = std::numeric_limits<double>::quiet_NaN();
        return;
      case Fault::nan_p:
        dHdp[0] = std::numeric_limits<double>::quiet_NaN();
        return;
      case Fault::infinite_q:
        dHdq[0] = std::numeric_limits<double>::infinity();
        return;
      case Fault::infinite_p:
        dHdp[0] = -std::numeric_limits<double>::infinity();
        return;
      case Fault::raise:
        throw std::domain_error("no gradient here");
    }
  }

  std::shared_ptr<Plan> plan = std::make_shared<Plan>();  // copies share it
};
