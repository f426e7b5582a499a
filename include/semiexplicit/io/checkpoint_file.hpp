#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <semiexplicit/io/checksum.hpp>
#include <semiexplicit/io/durable_file.hpp>

namespace semiexplicit::detail {

/// The format of checkpoints: a line that says what it is, byte order, version, length, contents, checksum of
/// all that.
struct CheckpointFrame {
  static constexpr std::string_view magic = "semiexplicit checkpoint\n";
  static constexpr std::uint32_t byte_order = 0x01020304, foreign_order = 0x04030201, version = 8;
  static constexpr std::size_t head = magic.size() + 2 * sizeof(std::uint32_t) + sizeof(std::uint64_t);
  static constexpr std::size_t tail = sizeof(std::uint64_t);

  static std::string pack(std::string_view contents) {
    std::string file(magic);
    append(file, byte_order);
    append(file, version);
    const std::uint64_t length = contents.size();
    append(file, length);
    file += contents;
    append(file, checksum(file));
    return file;
  }

  /// The contents of a file. Throws std::invalid_argument that says what is wrong with it.
  static std::string unpack(std::string_view file) {
    const auto refuse = [](const std::string& why) { throw std::invalid_argument(why); };
    if (!file.starts_with(magic))
      refuse("is not a checkpoint; give the name of one, or of no file to start anew");
    if (file.size() < head) refuse("is cut short; start anew without it, or from a copy");
    const auto order = number<std::uint32_t>(file, magic.size());
    if (order == foreign_order)
      refuse("was written on a machine of another byte order; go on there, or start anew without it");
    if (order != byte_order) refuse("is damaged in its head; start anew without it, or from a copy");
    const auto written = number<std::uint32_t>(file, magic.size() + sizeof order);
    if (written != version)
      refuse("has the format " + std::to_string(written) + ", and this program reads the format " +
             std::to_string(version) +
             "; go on with the version of semiexplicit that wrote it, or start anew without it");
    const auto length = number<std::uint64_t>(file, head - sizeof(std::uint64_t));
    if (file.size() < head + tail || length != file.size() - head - tail)
      refuse(
          "has not the length that it says; it was cut short or lengthened: start anew without it, or "
          "from a copy");
    if (number<std::uint64_t>(file, file.size() - tail) != checksum(file.substr(0, file.size() - tail)))
      refuse("is damaged: its checksum does not fit; start anew without it, or from a copy");
    return std::string(file.substr(head, static_cast<std::size_t>(length)));
  }

 private:
  template <class T>
  static void append(std::string& to, T value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  static T number(std::string_view file, std::size_t at) {
    T value;
    std::memcpy(&value, file.data() + at, sizeof value);
    return value;
  }
};

/// As much of a regular file as tells whether it is a checkpoint; nothing where it cannot be opened.
inline std::optional<std::string> head_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in.is_open()) return {};
  std::string head(CheckpointFrame::magic.size(), '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

/// Throws std::runtime_error, in the name of what is to be written, where a checkpoint has the name of that.
inline void refuse_checkpoint(const std::filesystem::path& name, const std::filesystem::path& there) {
  if (head_of(there) == CheckpointFrame::magic)
    throw std::runtime_error(name.string() + ": a checkpoint is there; give another name, or move it away");
}

/// All of a file, or nothing where there is none. Throws std::runtime_error where it cannot be read.
inline std::optional<std::string> read_if_there(const std::filesystem::path& path) {
  std::error_code failure;
  const auto type = std::filesystem::status(path, failure).type();  // a link to nothing is nothing
  if (type == std::filesystem::file_type::not_found) return {};
  std::string bytes;
  std::ifstream in;
  if (type == std::filesystem::file_type::regular) in.open(path, std::ios::binary);
  if (in.is_open()) bytes.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  if (!in.is_open() || in.bad())
    throw std::runtime_error("checkpoint " + path.string() +
                             ": cannot be read; check what it is and who may read it");
  return bytes;
}

/// The file of a run, which is locked from the first time that it is read or written on, as long as this
/// object lives: before there is one, by the .part of the first that is to come.
class CheckpointFile {
 public:
  explicit CheckpointFile(const std::filesystem::path& path) : path_(fixed(path)) {}

  /// Throws where no file of that name can be written, as read() and write() do, or another run has it open,
  /// and leaves all as it was: a .part that it makes is gone at once. A name that is empty is for those to
  /// refuse.
  void require_place() const {
    if (path_.empty()) return;
    refuse_device();
    refuse_other_kind();
    const std::filesystem::path part = Destination(path_).part();
    std::error_code failure;
    if (std::filesystem::file_size(part, failure) != 0 || Destination::is_other_than_file(part))
      take_place();  // which would remove an empty file
  }

  /// Hands the contents to restore(), and gives false where there is no such file. What that throws as
  /// std::invalid_argument gets the name of the file; the file is not locked then. Throws std::runtime_error
  /// where it cannot be read or written, or another run that is alive has it open.
  template <class Restore>
  bool read(const Restore& restore) {
    refuse_device();  // opening a pipe would wait for its other end
    Place place = take_place();
    try {
      const auto file = read_if_there(path_);
      if (!file) {
        first_ = place.first;
        return false;
      }
      restore(CheckpointFrame::unpack(*file));
    } catch (const std::invalid_argument& reason) {
      throw std::invalid_argument("checkpoint " + path_.string() + ": " + reason.what());
    }
    if (!place.mine) lock_ = std::move(place.lock);  // one on a file that was replaced since is worth nothing
    takes_over_ = !place.mine && !lock_;
    return true;
  }

  /// Takes the place of what is there, whole. Throws std::runtime_error where that is a file of another kind,
  /// or cannot be read.
  void write(std::string_view contents) {
    refuse_other_kind();
    take();  // see read()
    const auto file = first_file(path_);
    first_.reset();
    take();
    file->go_on_after(0);
    file->write(CheckpointFrame::pack(contents));
    file->commit();
    lock_ = file->release();
    takes_over_ = false;
  }

  /// Does nothing where there is none. Throws std::runtime_error where another run has it open, or it is a
  /// file of another kind.
  void remove() {
    refuse_other_kind();
    take();
    DurableFile::remove(path_);
    lock_ = {};
    first_.reset();
  }

 private:
  struct Place {
    bool mine;          ///< this object has the lock on the file already
    Descriptor lock{};  ///< on the file, unless this process has it
    std::shared_ptr<DurableFile> first{};
  };
  /// What cannot be written is said here, before the run.
  Place take_place() const {
    const Destination refuses_bad_names(path_);
    // Who is to be refused must not touch the .part, which another run is about to write.
    Place place{.mine = lock_.is(path_)};
    if (!place.mine) place.lock = lock_existing(path_, true);
    place.first = first_file(path_);
    if (!place.mine && !place.lock)
      place.lock = lock_existing(path_, true);  // the other run may just have saved for the first time
    return place;
  }

  /// What is to have that name: all objects of this process share what has not got it yet.
  static std::shared_ptr<DurableFile> first_file(const std::filesystem::path& path) {
    static std::mutex mutex;
    static std::map<std::filesystem::path, std::weak_ptr<DurableFile>> files;
    const std::lock_guard guard(mutex);
    std::erase_if(files, [](const auto& one) { return one.second.expired(); });
    const auto there = files[path].lock();
    if (there && !there->committed()) return there;
    const auto made = std::make_shared<DurableFile>(path);
    files[path] = made;
    return made;
  }

  /// Of another object in this process only what was read from it: that one is then refused.
  void take() {
    if (!lock_.is(path_)) lock_ = lock_existing(path_, takes_over_);
  }

  void refuse_device() const {
    std::error_code failure;
    if (std::filesystem::is_other(path_, failure))
      throw std::invalid_argument("checkpoint " + path_.string() +
                                  ": is a pipe or a device; give the name of a file");
  }

  /// Results may have been put there since, in place of the checkpoint or over it.
  void refuse_other_kind() const {
    const Destination to(path_);
    if (to.direct) return;
    const auto head = head_of(to.path);
    std::error_code failure;
    if (!head && std::filesystem::exists(to.path, failure))
      throw std::runtime_error("checkpoint " + path_.string() +
                               ": a file that cannot be read is there; give another name, or move it away");
    if (head && !head->empty() && *head != CheckpointFrame::magic)
      throw std::runtime_error("checkpoint " + path_.string() +
                               ": a file of another kind is there; give another name, or move it away");
  }

  std::filesystem::path path_;
  std::shared_ptr<DurableFile> first_{};  ///< that will have the name
  Descriptor lock_{};
  bool takes_over_ = false;  ///< the file was read while another object of this process had it
};

}  // namespace semiexplicit::detail

namespace semiexplicit {

/// Takes away the checkpoint of a run that is done, as Checkpoints::remove() does, where that object is no
/// longer there.
inline void remove_checkpoint(const std::filesystem::path& file) { detail::CheckpointFile(file).remove(); }

}  // namespace semiexplicit
