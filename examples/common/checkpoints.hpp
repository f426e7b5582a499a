#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "whole_file.hpp"

namespace examples {

/// A checksum of bytes: FNV-1a with 64 bits (G. Fowler, L. C. Noll, K.-P. Vo, IETF draft-eastlake-fnv).
inline std::uint64_t checksum(const std::string& bytes) {
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return sum;
}

inline std::string hexadecimal(std::uint64_t number) {
  std::ostringstream out;
  out << std::hex;
  out.width(16);
  out.fill('0');
  out << number;
  return out.str();
}

/// The finished blocks of a long computation, a file each, in a folder whose name tells which computation: `settings` is
/// all that the numbers depend on, in words. A file has a first line of words (format and version, settings, block, how
/// many numbers, checksum) and then the numbers as they are in memory; it gets its name when it is whole. Files are for the
/// kind of machine that wrote them.
class Checkpoints {
 public:
  Checkpoints(const std::filesystem::path& beside, const std::string& settings)
      : settings_(hexadecimal(checksum(settings))),
        folder_(beside.string() + "-" + settings_ + ".checkpoints") {
    static_assert(std::endian::native == std::endian::little || std::endian::native == std::endian::big);
  }

  const std::filesystem::path& folder() const { return folder_; }

  void save(std::int64_t block, const std::vector<double>& numbers) const {
    const std::string bytes(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
    write_whole(file(block), [&](std::ostream& out) { out << head(block, bytes) << bytes; });
  }

  /// The numbers of a block, or nothing where there is no such file yet. Throws std::runtime_error, with the reason, where
  /// there is one that is not what save() wrote.
  std::optional<std::vector<double>> load(std::int64_t block) const {
    if (!std::filesystem::exists(file(block))) return {};
    std::ifstream in(file(block), std::ios::binary);
    std::string first;
    std::getline(in, first);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (first + '\n' != head(block, bytes) || bytes.size() % sizeof(double) != 0)
      throw std::runtime_error(file(block).string() +
                               " is damaged, or another version wrote it: size or checksum do not fit");
    std::vector<double> numbers(bytes.size() / sizeof(double));
    bytes.copy(reinterpret_cast<char*>(numbers.data()), bytes.size());
    return numbers;
  }

  /// How many blocks there are, damaged ones included.
  std::int64_t count() const {
    std::int64_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      files += entry.path().extension() == ".block" ? 1 : 0;
    return files;
  }

 private:
  std::filesystem::path file(std::int64_t block) const {
    return folder_ / (std::to_string(block) + ".block");
  }

  std::string head(std::int64_t block, const std::string& bytes) const {
    return std::string("semiexplicit block 1 ") +
           (std::endian::native == std::endian::little ? "little-endian " : "big-endian ") + settings_ + ' ' +
           std::to_string(block) + ' ' + std::to_string(bytes.size()) + ' ' + hexadecimal(checksum(bytes)) +
           '\n';
  }

  std::string settings_;
  std::filesystem::path folder_;
};

}  // namespace examples
