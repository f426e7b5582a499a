#pragma once

#include <semiexplicit/observers/csv.hpp>
#include <semiexplicit/observers/dense_output.hpp>
#include <semiexplicit/observers/every.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/observers/poincare_section.hpp>
#include <semiexplicit/observers/progress.hpp>
#include <semiexplicit/observers/record.hpp>
