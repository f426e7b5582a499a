#pragma once

/// Hamiltonians put together from effects, and what each effect is worth.

#include <semiexplicit/scene/any_effect.hpp>
#include <semiexplicit/scene/audit.hpp>
#include <semiexplicit/scene/audit_report.hpp>
#include <semiexplicit/scene/books.hpp>
#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/scene/explain.hpp>
#include <semiexplicit/scene/nearest_names.hpp>
#include <semiexplicit/scene/runtime_scene.hpp>
#include <semiexplicit/scene/scene.hpp>
#include <semiexplicit/scene/split_scene.hpp>
#include <semiexplicit/steppers/flow_splitting.hpp>
#include <semiexplicit/steppers/stepper_for.hpp>
#include <semiexplicit/systems.hpp>
