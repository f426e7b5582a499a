#pragma once

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#if defined(_WIN32)
#include <io.h>
#else
#include <poll.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace semiexplicit::detail {

/// What the operating system refused, as std::runtime_error: the path, the reason and what to do.
[[noreturn]] inline void throw_file_error(const std::filesystem::path& path, const std::string& what,
                                          int reason) {
  const char* remedy = "check the path";
  if (reason == ENOENT || reason == ENOTDIR) remedy = "check that the folder exists and is writable";
  if (reason == EACCES || reason == EPERM || reason == EROFS) remedy = "check that the folder is writable";
  if (reason == ENOSPC || reason == EFBIG) remedy = "is the disk full?";
#if defined(EDQUOT)
  if (reason == EDQUOT) remedy = "is the disk quota used up?";
#endif
  throw std::runtime_error(path.string() + ": " + what + " (" + std::generic_category().message(reason) +
                           "); " + remedy);
}

/// An open file of the operating system. The members give false, and errno, where it refuses. Closing ends
/// the lock.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept { *this = std::move(other); }
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
#if !defined(_WIN32)
    std::swap(locked_, other.locked_);
#endif
    return *this;
  }
  ~Descriptor() { close(); }

  explicit operator bool() const { return number_ >= 0; }

#if defined(_WIN32)
  /// For writing at the end, and reading; made where there is none.
  static Descriptor open_part(const std::filesystem::path& path, unsigned) {
    return Descriptor(_wopen(path.c_str(), _O_RDWR | _O_APPEND | _O_CREAT | _O_BINARY | _O_NOINHERIT,
                             _S_IREAD | _S_IWRITE));
  }
  static Descriptor open_direct(const std::filesystem::path& path) {
    return Descriptor(_wopen(path.c_str(), _O_WRONLY | _O_APPEND | _O_BINARY | _O_NOINHERIT));
  }
  bool write(const char* bytes, std::size_t size) {
    while (size > 0) {
      const int done = _write(number_, bytes, static_cast<unsigned>(std::min<std::size_t>(size, 1 << 30)));
      if (done < 0) return false;
      bytes += done;
      size -= static_cast<std::size_t>(done);
    }
    return true;
  }
  bool read(std::uint64_t at, char* bytes, std::size_t size) const {
    return _lseeki64(number_, static_cast<__int64>(at), SEEK_SET) >= 0 &&
           _read(number_, bytes, static_cast<unsigned>(size)) == static_cast<int>(size);
  }
  bool cut(std::uint64_t length) { return _chsize_s(number_, static_cast<__int64>(length)) == 0; }
  bool sync() { return _commit(number_) == 0; }
  bool close() { return number_ < 0 || _close(std::exchange(number_, -1)) == 0; }
  bool regular() const { return true; }
  bool is(const std::filesystem::path&) const { return number_ >= 0; }
  bool room_for(std::uint64_t) const { return true; }
  bool lock() { return true; }  // an open file cannot be renamed or deleted there
#else
  /// For writing at the end, and reading; made with these permissions where there is none.
  static Descriptor open_part(const std::filesystem::path& path, unsigned mode) {
    return above_streams(
        ::open(path.c_str(), O_RDWR | O_APPEND | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, mode));
  }
  /// For writing to what is there, be it a device.
  static Descriptor open_direct(const std::filesystem::path& path) {
    return above_streams(::open(path.c_str(), O_WRONLY | O_APPEND | O_NOCTTY | O_CLOEXEC));
  }
  /// For a lock on what is there.
  static Descriptor open_existing(const std::filesystem::path& path) {
    return above_streams(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  }
  /// One that this process has open already, for writing.
  static Descriptor duplicate(int number) {
    const int flags = fcntl(number, F_GETFL);
    if (flags >= 0 && (flags & O_ACCMODE) == O_RDONLY) {
      errno = EBADF;
      return {};
    }
    return Descriptor(fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  }

  bool write(const char* bytes, std::size_t size) {
    while (size > 0) {
      const ssize_t done = ::write(number_, bytes, size);
      if (done >= 0) {
        bytes += done;
        size -= static_cast<std::size_t>(done);
      } else if (errno == EAGAIN) {  // a pipe that somebody else has made non-blocking
        pollfd ready{number_, POLLOUT, 0};
        poll(&ready, 1, -1);
      } else if (errno != EINTR) {
        return false;
      }
    }
    return true;
  }
  bool read(std::uint64_t at, char* bytes, std::size_t size) const {
    while (size > 0) {
      const ssize_t done = ::pread(number_, bytes, size, static_cast<off_t>(at));
      if (done == 0 || (done < 0 && errno != EINTR)) return false;
      if (done < 0) continue;
      bytes += done;
      at += static_cast<std::uint64_t>(done);
      size -= static_cast<std::size_t>(done);
    }
    return true;
  }
  bool cut(std::uint64_t length) { return ::ftruncate(number_, static_cast<off_t>(length)) == 0; }
  bool sync() { return ::fsync(number_) == 0 || errno == EINVAL; }  // some file systems cannot
  bool close() {
    if (std::exchange(locked_, false)) {
      const std::lock_guard guard(held().mutex);
      held().files.erase(identity());
    }
    return number_ < 0 || ::close(std::exchange(number_, -1)) == 0;
  }
  bool regular() const {
    struct stat of_this;
    return ::fstat(number_, &of_this) == 0 && S_ISREG(of_this.st_mode);
  }
  /// Whether that name leads to this file now.
  bool is(const std::filesystem::path& path) const {
    struct stat of_this, of_path;
    return number_ >= 0 && ::fstat(number_, &of_this) == 0 && ::stat(path.c_str(), &of_path) == 0 &&
           of_this.st_dev == of_path.st_dev && of_this.st_ino == of_path.st_ino;
  }
  /// Owner, where this process may set it, and permissions of another file.
  bool take_permissions_of(const std::filesystem::path& path) {
    struct stat other;
    if (::stat(path.c_str(), &other) != 0) return true;
    [[maybe_unused]] const int only_root_may = ::fchown(number_, other.st_uid, other.st_gid);
    return ::fchmod(number_, other.st_mode & 07777) == 0;
  }
  /// Whether the limit of the process lets a file be so long. Asked first, since to exceed it is a signal
  /// that kills.
  bool room_for(std::uint64_t length) const {
    rlimit limit;
    if (getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || length <= limit.rlim_cur)
      return true;
    errno = EFBIG;
    return false;
  }
  /// Locks it for this process. False: another one, or another part of this one, has it.
  bool lock() {
    if (::flock(number_, LOCK_EX | LOCK_NB) != 0) return errno != EWOULDBLOCK;
    const std::lock_guard guard(held().mutex);
    locked_ = true;
    held().files.insert(identity());
    return true;
  }
  /// Whether this process itself has the lock.
  bool locked_here() const {
    const std::lock_guard guard(held().mutex);
    return held().files.contains(identity());
  }
#endif

 private:
#if !defined(_WIN32)
  /// Not by the number of a standard stream, where that is closed: what is printed would go to the file.
  static Descriptor above_streams(int number) {
    if (number < 0 || number > STDERR_FILENO) return Descriptor(number);
    const int above = fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1), reason = errno;
    ::close(number);
    errno = reason;
    return Descriptor(above);
  }
  /// The files that this process has locked.
  struct Held {
    std::mutex mutex{};
    std::set<std::pair<dev_t, ino_t>> files{};
  };
  static Held& held() {
    static Held* const all = new Held;  // for objects that are destroyed at exit, too
    return *all;
  }
  std::pair<dev_t, ino_t> identity() const {
    struct stat of_this {};
    ::fstat(number_, &of_this);
    return {of_this.st_dev, of_this.st_ino};
  }
  bool locked_ = false;
#endif
  int number_ = -1;
};

[[noreturn]] inline void throw_other_run(const std::filesystem::path& path) {
  throw std::runtime_error(path.string() +
                           ": another run has it open; wait for its end, or give this run another file");
}

/// Locks the file that a name leads to, so that others are refused; empty where there is none, none that is
/// to be locked, or, with `shared`, where another part of this process has locked it. Throws
/// std::runtime_error where anybody else has it.
inline Descriptor lock_existing([[maybe_unused]] const std::filesystem::path& path,
                                [[maybe_unused]] bool shared) {
#if !defined(_WIN32)
  while (Descriptor file = Descriptor::open_existing(path)) {
    if (!file.regular()) break;
    if (!file.lock()) {
      if (shared && file.locked_here()) break;
      throw_other_run(path);
    }
    if (file.is(path)) return file;  // it was not replaced meanwhile
  }
#endif
  return {};
}

}  // namespace semiexplicit::detail
