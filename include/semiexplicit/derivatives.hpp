#pragma once

/// Gradients from energies, and whether a gradient is right.

#include <semiexplicit/derivatives/check_gradient.hpp>
#include <semiexplicit/derivatives/dual.hpp>
#include <semiexplicit/derivatives/from_energy.hpp>
#include <semiexplicit/derivatives/terms.hpp>
