#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint/file.hpp>
#include <semiexplicit/io/durable_file.hpp>

namespace examples {

/// The finished blocks of a long computation, a file each, in a folder whose name tells which computation: `settings` is
/// all that the numbers depend on, in words. A file is a checkpoint in the format of the library, whole or not there; its
/// contents are the settings, the number of the block, and the numbers as they are in memory.
class FinishedBlocks {
 public:
  FinishedBlocks(const std::filesystem::path& beside, std::string settings)
      : settings_(std::move(settings)),
        folder_(beside.string() + "-" + std::to_string(semiexplicit::detail::checksum(settings_)) +
                ".checkpoints") {}

  const std::filesystem::path& folder() const { return folder_; }

  void save(std::int64_t block, const std::vector<double>& numbers) const {
    std::string contents = head(block);
    contents.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
    semiexplicit::write_durably(file(block), semiexplicit::detail::CheckpointFrame::pack(contents));
  }

  /// The numbers of a block, or nothing where there is no such file yet. Throws std::runtime_error, with the reason, where
  /// there is one that is not what save() wrote.
  std::optional<std::vector<double>> load(std::int64_t block) const try {
    const auto bytes = semiexplicit::detail::read_if_there(file(block));
    if (!bytes) return {};
    const std::string contents = semiexplicit::detail::CheckpointFrame::unpack(*bytes), first = head(block);
    if (!contents.starts_with(first)) throw std::invalid_argument("belongs to another computation or block");
    std::vector<double> numbers((contents.size() - first.size()) / sizeof(double));
    std::memcpy(numbers.data(), contents.data() + first.size(), numbers.size() * sizeof(double));
    return numbers;
  } catch (const std::invalid_argument& reason) {
    throw std::runtime_error(file(block).string() + ": " + reason.what());
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
  std::string head(std::int64_t block) const {
    return settings_ + ", number " + std::to_string(block) + '\n';
  }

  std::string settings_;
  std::filesystem::path folder_;
};

}  // namespace examples
