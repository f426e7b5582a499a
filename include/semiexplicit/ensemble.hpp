#pragma once

/// Many trajectories at once, in registers and threads; the stages of Gauss methods in registers.

#include <semiexplicit/ensemble/ensemble.hpp>
#include <semiexplicit/steppers/gauss_legendre_lanes.hpp>
