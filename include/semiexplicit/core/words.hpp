#pragma once

#include <locale>
#include <sstream>
#include <string>

#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// A number with so many digits, in the C locale.
template <class Scalar>
SEMIEXPLICIT_COLD std::string in_words(const Scalar& x, int digits) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(digits);
  out << static_cast<long double>(x);
  return out.str();
}

}  // namespace semiexplicit::detail
