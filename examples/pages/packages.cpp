// Which version is this, and may the compiler use the SIMD registers of this processor?
#include <iostream>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/version.hpp>

int main() {
  std::cout << "semiexplicit " << SEMIEXPLICIT_VERSION_MAJOR << '.' << SEMIEXPLICIT_VERSION_MINOR << '.'
            << SEMIEXPLICIT_VERSION_PATCH << " with Eigen " << EIGEN_WORLD_VERSION << '.'
            << EIGEN_MAJOR_VERSION << '.' << EIGEN_MINOR_VERSION << '\n'
            << "numbers in a register: " << semiexplicit::pack_width << '\n';
  return SEMIEXPLICIT_VERSION_MAJOR >= 0 && semiexplicit::pack_width > 0 ? 0 : 1;
}
