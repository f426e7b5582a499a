#pragma once

/// Hamiltonians that depend on the time, and steps that follow the motion.

#include <semiexplicit/time/autonomous.hpp>
#include <semiexplicit/time/monitors.hpp>
#include <semiexplicit/time/reversible_steps.hpp>
#include <semiexplicit/time/time_transformed.hpp>
