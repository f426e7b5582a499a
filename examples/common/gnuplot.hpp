#pragma once

#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <system_error>

#include <semiexplicit/io/durable_file.hpp>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace examples {

/// A text as gnuplot reads it literally.
inline std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "''" : std::string(1, c);
  return result + "'";
}

/// Lines every script begins with. `output` may be given from outside.
inline std::string gnuplot_prologue(const std::filesystem::path& png, int width, int height) {
  const std::string size = " size " + std::to_string(width) + "," + std::to_string(height);
  return "# Draws the picture again: gnuplot " + std::filesystem::path(png).replace_extension("gp").string() +
         "\nif (!exists('output')) output = " + quoted(png.string()) +
         "\nif (strstrt(GPVAL_TERMINALS, 'pngcairo')) {\n  set terminal pngcairo font 'sans,15'" + size +
         "\n} else {\n  set terminal png font 'arial,15'" + size +
         "\n}\nset output output\nset datafile separator ','\nset encoding utf8\n";
}

/// Runs gnuplot on a script, and takes the picture from it through a pipe, since it does not notice a full disk; its exit
/// code, or -1 where there is no gnuplot. Without a shell: no name needs quoting.
inline int run_gnuplot(const std::string& script, std::string& picture) {
  int ends[2];
  if (pipe(ends) != 0) throw std::system_error(errno, std::generic_category(), "a pipe for gnuplot");
  fcntl(ends[0], F_SETFD, FD_CLOEXEC);
  fcntl(ends[1], F_SETFD, FD_CLOEXEC);
  posix_spawn_file_actions_t pipe_as_output;
  posix_spawn_file_actions_init(&pipe_as_output);
  posix_spawn_file_actions_adddup2(&pipe_as_output, ends[1], STDOUT_FILENO);
  std::string command = "output = '/dev/stdout'", file = script, name = "gnuplot", option = "-e";
  char* const arguments[] = {name.data(), option.data(), command.data(), file.data(), nullptr};
  pid_t child = 0;
  const bool started = posix_spawnp(&child, "gnuplot", &pipe_as_output, nullptr, arguments, environ) == 0;
  posix_spawn_file_actions_destroy(&pipe_as_output);
  close(ends[1]);
  picture.clear();
  char piece[1 << 16];
  for (ssize_t size = 1; started && size != 0;) {
    size = read(ends[0], piece, sizeof piece);
    if (size > 0) picture.append(piece, static_cast<std::size_t>(size));
    if (size < 0 && errno != EINTR) break;
  }
  close(ends[0]);
  if (!started) return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "waiting for gnuplot");
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Leaves the script beside the picture `png`, and draws it. The picture gets its name when it is whole. Without
/// gnuplot there is a hint and no picture.
inline void draw(const std::filesystem::path& png, const std::string& script) {
  const std::filesystem::path script_path = std::filesystem::path(png).replace_extension("gp");
  semiexplicit::DurableFile::remove(png);  // an older one would belong to other data
  semiexplicit::write_durably(script_path, script);

  std::string picture;
  const int code = run_gnuplot(script_path.string(), picture);
  if (code == 0) {
    semiexplicit::write_durably(png, picture);
    std::cout << "picture: " << png.string() << '\n';
    return;
  }
  if (code > 0) throw std::runtime_error("gnuplot failed on " + script_path.string());
  std::cerr
      << "No picture: gnuplot is not installed (Debian, Ubuntu: apt-get install gnuplot-nox). Then: gnuplot "
      << script_path.string() << '\n';
}

}  // namespace examples
