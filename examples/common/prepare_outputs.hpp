#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <semiexplicit/io/durable_file.hpp>

#include "arguments.hpp"
#include "output.hpp"

namespace examples {

/// Where a name leads behind links, also where there is nothing yet.
inline std::filesystem::path behind_links(std::filesystem::path path) {
  std::error_code failure;
  for (int links = 0; links < 40 && std::filesystem::is_symlink(path, failure); ++links)
    path = path.parent_path() / std::filesystem::read_symlink(path, failure);
  const std::filesystem::path whole = std::filesystem::absolute(path, failure),
                              plain = std::filesystem::weakly_canonical(whole, failure);
  return plain.empty() ? whole : plain;
}

/// Makes the folder of the outputs of a run, a picture with its script. Throws std::runtime_error where one
/// of them cannot be written, which would be told behind the run only, and std::invalid_argument where one is
/// the file of the checkpoint, which would be lost when that is removed, or one that the user gave.
inline void prepare_outputs(const Settings& settings, const std::vector<std::filesystem::path>& outputs,
                            const std::filesystem::path& checkpoint = {}) {
  std::vector<std::filesystem::path> all;
  for (const auto& output : outputs) {
    const bool picture = output.extension() == ".png";
    if (picture && settings.no_plot) {  // nor is its script written
      tell_of_earlier_picture(output);
      continue;
    }
    all.push_back(output);
    if (picture) all.push_back(std::filesystem::path(output).replace_extension("gp"));
  }
  const auto one_file = [](const std::filesystem::path& a, const std::filesystem::path& b) {
    std::error_code none;
    return behind_links(a) == behind_links(b) ||
           (std::filesystem::equivalent(a, b, none) && std::filesystem::is_regular_file(a, none));
  };
  for (const auto& input : settings.inputs)
    if (const std::string part = checkpoint.string() + ".part"; !checkpoint.empty() && one_file(input, part))
      throw std::invalid_argument("--checkpoint: " + part +
                                  " is a file that the run reads; give another name");
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const auto& input : settings.inputs)
      for (const std::string& written : {all[i].string(), all[i].string() + ".part"})  // until it is whole
        if (one_file(input, written))
          throw std::invalid_argument("--output: " + written +
                                      " is a file that the run reads; give another folder");
    if (!checkpoint.empty() && one_file(checkpoint, all[i]))
      throw std::invalid_argument("--checkpoint: '" + checkpoint.string() + "' is where " + all[i].string() +
                                  " goes, a result of the run; give another name");
    for (std::size_t k = 0; k < i; ++k)
      if (one_file(all[k], all[i]))
        throw std::invalid_argument("--output: " + all[k].string() + " and " + all[i].string() +
                                    " are one file by a link; remove it");
  }
  settings.make_output_folder();
  std::error_code looping;  // a link to itself, of which the file tells
  for (const auto& output : all)
    if (!std::filesystem::is_fifo(output, looping))  // its reader would take this for the end
      DurableFile(output, DurableFile::Uncommitted::kept);
}

}  // namespace examples
