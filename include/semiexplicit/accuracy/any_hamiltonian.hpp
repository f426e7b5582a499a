#pragma once

#include <semiexplicit/accuracy/setting.hpp>

namespace semiexplicit::detail {

/// A Hamiltonian with an energy whose type does not show, and the steppers for it: what uses one is compiled once for all of
/// the same size and numbers. Must not outlive the Hamiltonian.
template <class ScalarType, int D>
class AnyHamiltonian {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = D;
  using State = PhasePoint<Scalar, Dof>;

  template <class H>
  requires(!std::same_as<H, AnyHamiltonian>) explicit AnyHamiltonian(const H& hamiltonian)
      : hamiltonian_(&hamiltonian),
        dof_(dof_of(hamiltonian)),
        takes_packs_(HasPackGradient<H>),
        energy_([](const void* h, const Scalar* q, const Scalar* p, Eigen::Index dof) {
          return Scalar(static_cast<const H*>(h)->energy(InColumn<H>(q, dof), InColumn<H>(p, dof)));
        }),
        gradient_([](const void* h, const Scalar* q, const Scalar* p, Scalar* dHdq, Scalar* dHdp,
                     Eigen::Index dof) { gradient_at(*static_cast<const H*>(h), q, p, dHdq, dHdp, dof); }),
        stepper_([](const void* h, const Setting& setting) {
          return stepper_for(*static_cast<const H*>(h), setting);
        }) {}

  Eigen::Index dof() const { return dof_; }
  bool takes_packs() const { return takes_packs_; }
  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const {
    return energy_(hamiltonian_, q.data(), p.data(), dof_);
  }
  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdq,
                Out<Scalar, Dof> dHdp) const {
    gradient_(hamiltonian_, q.data(), p.data(), dHdq.data(), dHdp.data(), dof_);
  }
  AnyStepper<Scalar, Dof> stepper(const Setting& setting) const { return stepper_(hamiltonian_, setting); }

 private:
  const void* hamiltonian_;
  Eigen::Index dof_;
  bool takes_packs_;
  Scalar (*energy_)(const void*, const Scalar*, const Scalar*, Eigen::Index);
  void (*gradient_)(const void*, const Scalar*, const Scalar*, Scalar*, Scalar*, Eigen::Index);
  AnyStepper<Scalar, Dof> (*stepper_)(const void*, const Setting&);
};

}  // namespace semiexplicit::detail
