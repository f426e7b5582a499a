#pragma once

/// The derivative of a step, Lyapunov exponents, alignment indices.

#include <semiexplicit/chaos/alignment.hpp>
#include <semiexplicit/chaos/lyapunov.hpp>
#include <semiexplicit/chaos/tangent_map.hpp>
#include <semiexplicit/chaos/tangent_vectors.hpp>
