#include "fuzz.hpp"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "vortices/file.hpp"

// A file of vortices: refused with file, line and reason, or read into vortices that can be.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using examples::Vortices;
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  Vortices vortices;
  try {
    vortices = examples::read_vortices(in, "f.csv");
  } catch (const std::invalid_argument& refusal) {
    const std::string what = refusal.what();
    promise(what.starts_with("f.csv:"), "a refusal names the file");
    promise(what == "f.csv: no vortices in it; give lines x,y,gamma" || (what[6] >= '1' && what[6] <= '9'),
            "a refusal names the line");
    return 0;
  }
  const auto n = vortices.x.size();
  promise(n > 0 && vortices.y.size() == n && vortices.circulation.size() == n, "three columns of a length");
  promise(vortices.x.allFinite() && vortices.y.allFinite() && vortices.circulation.allFinite(), "numbers");
  promise((vortices.circulation.array() != 0).all(), "no circulation is zero");
  std::stringstream again;
  again.precision(std::numeric_limits<double>::max_digits10);
  for (Eigen::Index i = 0; i < n; ++i)
    again << vortices.x[i] << ',' << vortices.y[i] << ',' << vortices.circulation[i] << '\n';
  const Vortices same = examples::read_vortices(again, "again");
  promise(same.x == vortices.x && same.y == vortices.y && same.circulation == vortices.circulation,
          "what is written is read again");
  return 0;
}
