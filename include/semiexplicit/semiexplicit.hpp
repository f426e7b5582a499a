#pragma once

/// What a run of one's own Hamiltonian needs. Each room beyond has its header: scene.hpp, systems.hpp,
/// accuracy.hpp, ensemble.hpp, checkpoint.hpp, chaos.hpp, time.hpp, derivatives.hpp.

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/report.hpp>
#include <semiexplicit/derivatives/from_energy.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/observers/csv.hpp>
#include <semiexplicit/observers/dense_output.hpp>
#include <semiexplicit/observers/error_estimate.hpp>
#include <semiexplicit/observers/events.hpp>
#include <semiexplicit/observers/every.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/observers/poincare_section.hpp>
#include <semiexplicit/observers/progress.hpp>
#include <semiexplicit/observers/record.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/solvers/broyden.hpp>
#include <semiexplicit/solvers/newton_krylov.hpp>
#include <semiexplicit/solvers/robust.hpp>
#include <semiexplicit/solvers/simplified_newton.hpp>
#include <semiexplicit/steppers/explicit_splitting.hpp>
#include <semiexplicit/steppers/gauss_legendre.hpp>
#include <semiexplicit/steppers/midpoint_projection.hpp>
#include <semiexplicit/steppers/pihajoki.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>
#include <semiexplicit/steppers/stepper_for.hpp>
#include <semiexplicit/steppers/tao.hpp>
#include <semiexplicit/version.hpp>
