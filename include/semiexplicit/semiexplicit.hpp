#pragma once

/// Everything of the library. Each header also stands alone.

#include <semiexplicit/baseline/gauss_lanes.hpp>
#include <semiexplicit/baseline/gauss_legendre.hpp>
#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/report.hpp>
#include <semiexplicit/cost/cost_of_accuracy.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/observers.hpp>
#include <semiexplicit/projection/midpoint.hpp>
#include <semiexplicit/projection/semiexplicit.hpp>
#include <semiexplicit/solver/broyden.hpp>
#include <semiexplicit/solver/simplified_newton.hpp>
#include <semiexplicit/splitting/pihajoki.hpp>
#include <semiexplicit/splitting/schemes.hpp>
#include <semiexplicit/splitting/tao.hpp>
#include <semiexplicit/systems/nls_lattice.hpp>
#include <semiexplicit/systems/point_vortices.hpp>
#include <semiexplicit/systems/product.hpp>
#include <semiexplicit/version.hpp>
