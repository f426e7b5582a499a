#pragma once

#include <exception>

#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

/// Runs action() in a process of its own, which ends with the exit code that it returns; 99 where it throws.
template <class Action>
pid_t start_child(const Action& action) {
  const pid_t child = fork();
  if (child != 0) return child;
  int code = 99;
  try {
    code = action();
  } catch (const std::exception&) {
  }
  _exit(code);
}

/// The exit code of a child; that of a killed one is 128 and the signal.
inline int exit_code(pid_t child) {
  int status = 0;
  if (waitpid(child, &status, 0) != child) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// By which one process waits for another.
class Signal {
 public:
  Signal() : open_(pipe(ends_) == 0) {}
  ~Signal() {
    close(ends_[0]);
    close(ends_[1]);
  }
  Signal(const Signal&) = delete;
  Signal& operator=(const Signal&) = delete;
  bool give() { return open_ && write(ends_[1], "1", 1) == 1; }
  bool wait() {
    char byte = 0;
    return open_ && read(ends_[0], &byte, 1) == 1;
  }

 private:
  int ends_[2] = {-1, -1};
  bool open_;
};
