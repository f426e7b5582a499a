#pragma once

/// The derivative of a step, and Lyapunov exponents.

#include <semiexplicit/chaos/lyapunov.hpp>
#include <semiexplicit/chaos/tangent_map.hpp>
