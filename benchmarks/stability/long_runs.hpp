#pragma once

#include <cstdint>
#include <filesystem>

namespace stability {

/// The rounding errors of energy and quadratic invariants over `steps` steps of the solvable problem and a
/// tenth of that of NLS, from several starts, and the exponent of their growth; CSV, a table and a picture.
void run_rounding(std::int64_t steps, const std::filesystem::path& folder, bool plot);

/// How far quadratic invariants drift in n steps, for several tolerances τ of the product rule: a table of
/// drift/(τ n).
void run_drift(const std::filesystem::path& folder);

/// A step with compensated summation against one with plain, in alternating batches.
void run_summation_cost(const std::filesystem::path& folder);

/// Every solver on a stiff lattice at ever larger steps: evaluations a step.
void run_solvers(const std::filesystem::path& folder);

}  // namespace stability
