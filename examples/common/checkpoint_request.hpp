#pragma once

#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "arguments.hpp"

namespace examples {

/// The options --checkpoint, save the run there and go on from there, and --checkpoint-every.
struct CheckpointRequest {
  std::filesystem::path file{};
  std::int64_t every = 0;
  std::ostringstream run{};  ///< what makes this run this run; whoever starts it writes it here

  bool wanted() const { return !file.empty(); }
  semiexplicit::CheckpointOptions options() const { return {.every = every, .run = run.str()}; }

  /// The run is done and its files are there.
  void finish() const {
    if (wanted()) semiexplicit::DurableFile::remove(file);
  }
};

inline void add_checkpoint(CLI::App& app, CheckpointRequest& request) {
  auto* const file = app.add_option("--checkpoint", request.file,
                                    "file to save the run in from time to time; where it is there and fits, "
                                    "the run goes on from it")
                         ->type_name("FILE")
                         ->check(CLI::Validator(
                             [](const std::string& text) -> std::string {
                               const std::filesystem::path path(text), folder = path.parent_path();
                               if (std::filesystem::is_directory(path) || !path.has_filename())
                                 return "'" + text + "' is a folder; give the name of a file in it";
                               if (!folder.empty() && !std::filesystem::is_directory(folder))
                                 return "the folder " + folder.string() + " is not there; make it first";
                               return "";
                             },
                             "", "file"))
                         ->excludes("--cost")
                         ->excludes("--accuracy");
  app.add_option("--checkpoint-every", request.every, "steps from one to the next; without it, a minute")
      ->check(whole_number(1, 1'000'000'000'000'000))
      ->type_name("N")
      ->needs(file);
}

}  // namespace examples
