#pragma once

/// Ready Hamiltonians, and the effects that scenes of each physics are put together from.

#include <semiexplicit/systems/black_hole.hpp>
#include <semiexplicit/systems/charge_along_path.hpp>
#include <semiexplicit/systems/charges.hpp>
#include <semiexplicit/systems/dissipation.hpp>
#include <semiexplicit/systems/electrostatics.hpp>
#include <semiexplicit/systems/field_from.hpp>
#include <semiexplicit/systems/geodesics.hpp>
#include <semiexplicit/systems/kepler_flow.hpp>
#include <semiexplicit/systems/magnets.hpp>
#include <semiexplicit/systems/nbody.hpp>
#include <semiexplicit/systems/nbody_flow.hpp>
#include <semiexplicit/systems/nbody_relativity.hpp>
#include <semiexplicit/systems/nls_lattice.hpp>
#include <semiexplicit/systems/orbital_elements.hpp>
#include <semiexplicit/systems/orbits.hpp>
#include <semiexplicit/systems/post_newtonian.hpp>
#include <semiexplicit/systems/product.hpp>
#include <semiexplicit/systems/relativistic_charges.hpp>
#include <semiexplicit/systems/rotating_flow.hpp>
#include <semiexplicit/systems/spin_orbit.hpp>
#include <semiexplicit/systems/vortex_walls.hpp>
#include <semiexplicit/systems/vortices.hpp>
