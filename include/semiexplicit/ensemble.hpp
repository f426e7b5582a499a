#pragma once

/// Many trajectories at once, in registers and threads, with checkpoints; the stages of Gauss methods in registers.

#include <semiexplicit/ensemble/ensemble.hpp>
#include <semiexplicit/ensemble/ensemble_checkpoints.hpp>
#include <semiexplicit/steppers/gauss_legendre_lanes.hpp>
