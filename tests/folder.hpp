#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

/// A folder of a test's own, gone with the test.
struct Folder {
  Folder() : path(std::filesystem::temp_directory_path() / ("semiexplicit-test-" + unique())) {
    std::filesystem::create_directories(path);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  static std::string unique() {
    return std::to_string(std::chrono::steady_clock::now().time_since_epoch().count());
  }
  std::filesystem::path path;
};

/// All of a file.
inline std::string contents(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}
