#pragma once

/// Runs that are saved and resumed.

#include <semiexplicit/checkpoint/checkpoints.hpp>
