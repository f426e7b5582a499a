// case no_option: compiles
// case optimised -O3: compiles
// case fast_math -ffast-math: compile it without -ffast-math and -Ofast
// case fastest -Ofast: compile it without -ffast-math and -Ofast
// case finite_math_only -ffinite-math-only: compile it without -ffast-math and -Ofast
// case matrices_by_rows -DEIGEN_DEFAULT_TO_ROW_MAJOR: compile it without EIGEN_DEFAULT_TO_ROW_MAJOR
#include <semiexplicit/core/vector.hpp>
