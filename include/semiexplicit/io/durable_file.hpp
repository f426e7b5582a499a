#pragma once

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <ios>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <semiexplicit/io/descriptor.hpp>

namespace semiexplicit {

namespace detail {

/// The same file also after a change of the working directory.
inline std::filesystem::path fixed(const std::filesystem::path& name) {
  std::error_code failure;
  std::filesystem::path whole = name.has_filename() ? std::filesystem::absolute(name, failure) : name;
  return failure ? name : whole;
}

/// Where the name of an output leads.
struct Destination {
  std::filesystem::path path;  ///< behind all symbolic links, from the root on
  bool direct = false;         ///< something that is no regular file: to be written to, and never replaced
  int descriptor = -1;         ///< of this process, where it is the name of one: /dev/stdout, /dev/fd/3

  explicit Destination(const std::filesystem::path& name) : path(fixed(name)) {
    namespace fs = std::filesystem;
    if (name.empty()) throw std::runtime_error("a file to be written has no name; give one");
    std::error_code failure;
    for (int links = 0;; ++links) {
      if (in_folder_of_descriptors()) return;
      if (fs::symlink_status(path, failure).type() != fs::file_type::symlink) break;
      const fs::path next = links < 40 ? fs::read_symlink(path, failure) : fs::path();
      if (next.empty()) throw std::runtime_error(name.string() + ": the link leads nowhere; mend it");
      path = next.is_absolute() ? next : path.parent_path() / next;
    }
    const fs::file_status there = fs::status(path, failure);
    if (there.type() == fs::file_type::directory || !path.has_filename())
      throw std::runtime_error(name.string() + ": is a folder; give the name of a file in it");
    direct = fs::exists(there) && !fs::is_regular_file(there);
    // It may be that of another output, which would then lose what it has written.
    if (!direct && path.filename().string().ends_with(".part"))
      throw std::runtime_error(name.string() +
                               ": names in .part are for files that are being written; give another name");
  }

  /// Whether something is there itself, be it a link, that is no regular file.
  static bool is_other_than_file(const std::filesystem::path& path) {
    std::error_code failure;
    const auto there = std::filesystem::symlink_status(path, failure);
    return std::filesystem::exists(there) && !std::filesystem::is_regular_file(there);
  }

  /// Where an output is written until it has its name.
  std::filesystem::path part() const {
    std::filesystem::path whole = path;
    return whole += direct ? "" : ".part";
  }

 private:
  /// The links there are not to be followed by name: what they show may be a pipe, or a file that another has
  /// open.
  bool in_folder_of_descriptors() {
#if !defined(_WIN32)
    std::error_code failure;
    const std::string folder =
        std::filesystem::canonical(path.has_parent_path() ? path.parent_path() : ".", failure).string();
    const bool of_processes = folder.starts_with("/proc/") && folder.ends_with("/fd");
    if (failure || (!of_processes && folder != "/dev/fd")) return false;
    direct = true;
    if (!of_processes || folder.starts_with("/proc/" + std::to_string(getpid()) + "/")) {
      const std::string digits = path.filename().string();
      const char* const end = digits.data() + digits.size();
      if (std::from_chars(digits.data(), end, descriptor).ptr != end) descriptor = -1;
    }
    return true;
#else
    return false;
#endif
  }
};

}  // namespace detail

/// One output of a program, which is whole as soon as it has its name, and keeps what was written whatever
/// happens.
///
/// What is written goes to `name` + ".part", each write() to the operating system at once, so that it
/// outlives the process (kill -9). commit() waits until all is on the disk, and renames. Symbolic links are
/// followed; a file that is replaced hands on its permissions. What is no regular file (a device, a pipe,
/// /dev/stdout) is written to directly. The .part is locked until it is committed, where the operating system
/// has locks: a second object for the same name, in this process or another, is refused.
///
/// Whatever fails throws std::runtime_error that says which file, why and what to do; the earlier file of
/// that name stays.
class DurableFile {
 public:
  /// What happens to a .part that is not committed: it is announced on stderr and kept, or it is removed.
  /// It is always kept where something that is no file has taken the name meanwhile.
  enum class Uncommitted { kept, removed };

  /// Throws where the folder is missing or not writable, the name is a folder, a file that is write-protected
  /// or ends in ".part", or another run is writing it. What is in the .part already, from an earlier run,
  /// say, stays up to the first write(), which moves it to earlier(1), or the next free one, and says so on
  /// stderr; where what is not committed is removed, only what begins otherwise than that write, and is so no
  /// rest of an earlier one. Of two of which one begins with the other the longer one stays.
  explicit DurableFile(std::filesystem::path name, Uncommitted uncommitted = Uncommitted::removed)
      : name_(std::move(name)), to_(name_), part_(to_.part()), uncommitted_(uncommitted) {
    if (to_.direct)
      open_direct();
    else
      open_part();
  }
  ~DurableFile() {
    if (committed_ || to_.direct || !file_.is(part_)) return;
    std::error_code ignored;
    if (uncommitted_ == Uncommitted::kept && length_ > 0) {
      std::fprintf(stderr, "semiexplicit: %s was not committed; what was written is in %s\n",
                   name_.string().c_str(), part_.string().c_str());
      return;
    }
    if ((uncommitted_ == Uncommitted::kept || !begun_) && std::filesystem::file_size(part_, ignored) > 0)
      return;  // what was there before
#if defined(_WIN32)
    file_.close();
#endif
    std::filesystem::remove(part_, ignored);
  }
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  /// Appends all of these bytes, or none of them where it throws. The first call moves away, or drops, what
  /// an earlier run left; see the constructor.
  void write(std::string_view bytes) {
    if (committed_) throw std::logic_error(name_.string() + ": is committed, and nothing can be added");
    begin(bytes);
#if !defined(_WIN32)
    if (to_.descriptor == STDOUT_FILENO) std::fflush(stdout);  // what was printed before comes before
#endif
    const bool room = to_.direct || file_.room_for(length_ + bytes.size());
    if (!room || !file_.write(bytes.data(), bytes.size())) {
      const int reason = errno;
      if (!to_.direct) file_.cut(length_);
      fail("cannot be written", reason);
    }
    length_ += bytes.size();
  }

  /// Ends the file and gives it its name; what was there before is replaced. A second call does nothing.
  void commit() {
    if (committed_) return;
    begin();
    if (!to_.direct) {
      const auto there = std::filesystem::symlink_status(to_.path).type();
      if (there != std::filesystem::file_type::not_found && there != std::filesystem::file_type::regular) {
        uncommitted_ = Uncommitted::kept;
        throw std::runtime_error(name_.string() +
                                 ": something else has taken this name; what was written is in " +
                                 part_.string());
      }
      if (!file_.is(part_))
        throw std::runtime_error(part_.string() + ": was moved or removed while it was written");
#if defined(_WIN32)
      sync();
      file_.close();
#else
      if (!file_.take_permissions_of(to_.path)) fail("cannot be given its permissions", errno);
      sync();
#endif
      std::error_code failure;
      std::filesystem::rename(part_, to_.path, failure);
      if (failure) fail("cannot be given its name", failure.value());
      sync_folder();
    }
    committed_ = true;
  }

  /// Goes on with the first `length` bytes of what is in the .part, from an earlier run, say. The rest stays
  /// up to the next write().
  void go_on_after(std::uint64_t length) {
    begun_ = false;
    length_ = length;
  }

  /// Waits until all that was written is on the disk.
  void sync() {
    if (!to_.direct && !file_.sync()) fail("cannot be written", errno);
  }

  /// Reads what is in the .part; false where that is shorter.
  bool read(std::uint64_t at, char* bytes, std::size_t size) const { return file_.read(at, bytes, size); }

  /// The bytes that were written, or gone on with.
  std::uint64_t length() const { return length_; }
  /// Where they are until commit().
  const std::filesystem::path& part() const { return part_; }
  /// Where the n-th earlier run that did not end has its rows, n = 1, 2, ...
  std::filesystem::path earlier(int n) const { return part_.string() + "." + std::to_string(n); }
  /// And behind it.
  const std::filesystem::path& destination() const { return to_.path; }
  /// Whether this is no regular file, so that nothing can be read back.
  bool direct() const { return to_.direct; }

  bool committed() const { return committed_; }
  /// The file itself, open and locked; only after commit().
  detail::Descriptor release() { return std::move(file_); }

  /// Takes away the regular file that a name leads to, if there is one; links and devices stay.
  static void remove(const std::filesystem::path& name) {
    const detail::Destination to(name);
    std::error_code failure;
    if (!to.direct) std::filesystem::remove(to.path, failure);
    if (failure) throw std::runtime_error(name.string() + ": cannot be removed: " + failure.message());
  }

 private:
  [[noreturn]] void fail(const char* what, int reason) const {
    detail::throw_file_error(name_, what, reason);
  }

  void open_direct() {
#if !defined(_WIN32)
    if (to_.descriptor >= 0)
      file_ = detail::Descriptor::duplicate(to_.descriptor);
    else
#endif
      file_ = detail::Descriptor::open_direct(to_.path);
    if (!file_) fail("cannot be written", errno);
  }

  void open_part() {
    namespace fs = std::filesystem;
    unsigned mode = 0666;
    std::error_code failure;
    if (const fs::file_status there = fs::status(to_.path, failure); fs::exists(there)) {
      mode = static_cast<unsigned>(there.permissions()) & 0777;
#if !defined(_WIN32)
      if (access(to_.path.c_str(), W_OK) != 0) {
        const int reason = errno;
        if (reason == EACCES)
          throw std::runtime_error(name_.string() +
                                   ": is write-protected; allow writing, or give another name");
        fail("cannot be written", reason);
      }
#endif
    }
    do {
      file_ = detail::Descriptor::open_part(part_, mode | 0600);
      const int reason = errno;
      const bool other = file_ ? !file_.regular() : detail::Destination::is_other_than_file(part_);
      if (other) {
        file_.close();
        throw std::runtime_error(part_.string() + ": is in the way; remove it");
      }
      if (!file_) fail("cannot be written", reason);
      if (!file_.lock()) {
        file_.close();
        detail::throw_other_run(name_);
      }
    } while (!file_.is(part_));  // the other run has just given it its name
  }

  void begin(std::string_view bytes = {}) {
    if (begun_) return;
    if (!to_.direct && length_ == 0 && (uncommitted_ == Uncommitted::kept || !is_rest_of(bytes)))
      keep_earlier();
    if (!to_.direct && !file_.cut(length_)) fail("cannot be written", errno);
    begun_ = true;
  }
  void keep_earlier() {
    std::error_code failure;
    const std::uint64_t size = std::filesystem::file_size(part_, failure);
    if (failure || size == 0 || !file_.is(part_)) return;
    int n = 1;
    while (std::filesystem::exists(std::filesystem::symlink_status(earlier(n))) && !begins_like(earlier(n)))
      ++n;
    const std::uint64_t there = std::filesystem::file_size(earlier(n), failure);
    if (failure || there < size) {
#if defined(_WIN32)
      file_.close();
#endif
      std::filesystem::rename(part_, earlier(n), failure);
      if (failure) fail("has another file in the place of its .part, which cannot be moved", failure.value());
      file_.close();
      open_part();
    }
    std::fprintf(stderr, "semiexplicit: %s: %s in %s\n", name_.string().c_str(),
                 uncommitted_ == Uncommitted::kept ? "an earlier run did not end; its rows are"
                                                   : "another file had the name of its .part, and is",
                 earlier(n).string().c_str());
  }
  /// Whether the .part begins as these bytes do.
  bool is_rest_of(std::string_view bytes) const {
    std::error_code failure;
    std::string there(std::min<std::size_t>(bytes.size(), 16), '\0');
    there.resize(std::min<std::uintmax_t>(there.size(), std::filesystem::file_size(part_, failure)));
    return !there.empty() && read(0, there.data(), there.size()) && bytes.starts_with(there);
  }
  /// Whether the .part and another file are the same as far as both go: a run that is repeated writes the
  /// same again, and the longer one holds the rows of both.
  bool begins_like(const std::filesystem::path& other) const {
    std::error_code failure;
    if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(other)) ||
        std::filesystem::equivalent(other, part_, failure))
      return false;
    const std::uint64_t length =
        std::min(std::filesystem::file_size(other, failure), std::filesystem::file_size(part_, failure));
    std::ifstream file(other, std::ios::binary);
    std::string here, there;
    for (std::uint64_t at = 0; at < length; at += here.size()) {
      here.resize(static_cast<std::size_t>(std::min<std::uint64_t>(length - at, 1 << 20)));
      there.resize(here.size());
      if (!read(at, here.data(), here.size()) ||
          !file.read(there.data(), static_cast<std::streamsize>(there.size())) || here != there)
        return false;
    }
    return length > 0;
  }

  void sync_folder() {
#if !defined(_WIN32)
    const std::filesystem::path folder = to_.path.parent_path();
    detail::Descriptor names = detail::Descriptor::open_existing(folder.empty() ? "." : folder);
    if (names) names.sync();  // some file systems cannot, and need not
#endif
  }

  std::filesystem::path name_;
  detail::Destination to_;
  std::filesystem::path part_;
  Uncommitted uncommitted_;
  detail::Descriptor file_;
  bool begun_ = false, committed_ = false;
  std::uint64_t length_ = 0;
};

/// Writes a file that is there whole or not at all, even where the power fails; see DurableFile.
inline void write_durably(const std::filesystem::path& name, std::string_view bytes) {
  DurableFile file(name);
  file.write(bytes);
  file.commit();
}

}  // namespace semiexplicit
