#pragma once

/// Ready Hamiltonians.

#include <semiexplicit/systems/nls_lattice.hpp>
#include <semiexplicit/systems/point_vortices.hpp>
#include <semiexplicit/systems/product.hpp>
