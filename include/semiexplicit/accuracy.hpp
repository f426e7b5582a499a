#pragma once

/// What accuracy costs in time.

#include <semiexplicit/accuracy/cost_of_accuracy.hpp>
