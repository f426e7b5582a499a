#pragma once

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace examples {

/// Writes what write(out) puts out to a file, which gets its name when it is whole. Throws std::runtime_error where that
/// fails.
template <class Write>
void write_whole(const std::filesystem::path& path, const Write& write) {
  const std::filesystem::path part = path.string() + ".part";
  std::ofstream out(part);
  write(out);
  out.close();
  if (!out) throw std::runtime_error(part.string() + ": cannot be written; is the disk full?");
  std::filesystem::rename(part, path);
}

}  // namespace examples
