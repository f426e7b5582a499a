#pragma once

/// Hamiltonians put together from effects, and what each effect is worth.

#include <semiexplicit/scene/any_effect.hpp>
#include <semiexplicit/scene/audit.hpp>
#include <semiexplicit/scene/audit_report.hpp>
#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/scene/effects/black_hole.hpp>
#include <semiexplicit/scene/effects/charges.hpp>
#include <semiexplicit/scene/effects/electrostatics.hpp>
#include <semiexplicit/scene/effects/lattice.hpp>
#include <semiexplicit/scene/effects/orbits.hpp>
#include <semiexplicit/scene/effects/post_newtonian.hpp>
#include <semiexplicit/scene/effects/vortex_walls.hpp>
#include <semiexplicit/scene/effects/vortices.hpp>
#include <semiexplicit/scene/nearest_names.hpp>
#include <semiexplicit/scene/runtime_scene.hpp>
#include <semiexplicit/scene/scene.hpp>
#include <semiexplicit/steppers/stepper_for.hpp>
