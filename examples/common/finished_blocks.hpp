#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <semiexplicit/io/checksum.hpp>
#include <semiexplicit/io/durable_file.hpp>

namespace examples {

/// The finished blocks of a long computation, a file each, in a folder whose name tells which computation:
/// `settings` is all that the numbers depend on, in words. A file is whole or not there; it holds the
/// settings, the number of the block, the numbers as they are in memory, and the checksum of all that.
class FinishedBlocks {
 public:
  FinishedBlocks(const std::filesystem::path& beside, std::string settings)
      : settings_(std::move(settings)),
        folder_(beside.string() + "-" + std::to_string(semiexplicit::checksum(settings_)) + ".checkpoints") {}

  const std::filesystem::path& folder() const { return folder_; }

  /// Keeps other runs away from the folder while what is given lives: the first of them to end would take
  /// away what the others count on. Lies beside the folder, since that goes first. Throws std::runtime_error
  /// where another run has it.
  std::unique_ptr<semiexplicit::DurableFile> lock() const {
    return std::make_unique<semiexplicit::DurableFile>(folder_.string() + ".lock");
  }

  void save(std::int64_t block, const std::vector<double>& numbers) const {
    std::string bytes = head(block);
    bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
    semiexplicit::write_durably(file(block), bytes + tail(bytes));
  }

  /// The numbers of a block, or nothing where there is no such file yet. Throws std::runtime_error where
  /// there is one that is not what save() wrote.
  std::optional<std::vector<double>> load(std::int64_t block) const {
    std::ifstream in(file(block), std::ios::binary);
    std::error_code failure;
    if (!in && !std::filesystem::exists(file(block), failure)) return {};
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const std::string first = head(block);
    const std::size_t size = bytes.size() - std::min(bytes.size(), tail("").size());
    const std::string last = bytes.substr(size);
    bytes.resize(size);
    if (!bytes.starts_with(first) || last != tail(bytes))
      throw std::runtime_error(file(block).string() + ": is damaged, or belongs to another computation");
    std::vector<double> numbers((size - first.size()) / sizeof(double));
    std::memcpy(numbers.data(), bytes.data() + first.size(), numbers.size() * sizeof(double));
    return numbers;
  }

  /// The same; a damaged file is told of on stderr and counts as none.
  std::optional<std::vector<double>> load_if_sound(std::int64_t block) const {
    try {
      return load(block);
    } catch (const std::runtime_error& damage) {
      // In one piece: mpirun mixes what processes write.
      std::cerr << std::string(damage.what()) + "; this block is computed anew\n";
      return {};
    }
  }

  /// Takes the blocks away, and the folder unless it holds something else: the computation is done.
  void remove() const {
    std::error_code ignored;
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_, ignored))
      if (is_block(entry.path())) files.push_back(entry.path());
    for (const std::filesystem::path& file : files) std::filesystem::remove(file, ignored);
    std::filesystem::remove(folder_, ignored);
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
  /// 12.block, or what a run that was killed left beside it, 12.block.part.
  static bool is_block(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
    return digits > 0 && name.substr(digits).starts_with(".block");
  }
  std::string head(std::int64_t block) const {
    return settings_ + ", number " + std::to_string(block) + '\n';
  }
  static std::string tail(const std::string& bytes) {
    const std::uint64_t sum = semiexplicit::checksum(bytes);
    return {reinterpret_cast<const char*>(&sum), sizeof sum};
  }

  std::string settings_;
  std::filesystem::path folder_;
};

}  // namespace examples
