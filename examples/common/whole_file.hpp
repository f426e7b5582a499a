#pragma once

#include <filesystem>
#include <locale>
#include <sstream>

#include <semiexplicit/io/durable_file.hpp>

namespace examples {

/// Writes what write(out) puts out to a file, which gets its name when it is whole; numbers have a decimal point in any
/// locale. Throws std::runtime_error where that fails.
template <class Write>
void write_whole(const std::filesystem::path& path, const Write& write) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  write(out);
  semiexplicit::write_durably(path, out.view());
}

}  // namespace examples
