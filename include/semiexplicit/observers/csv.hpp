#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/io/checkpoint_file.hpp>
#include <semiexplicit/io/checksum.hpp>
#include <semiexplicit/io/durable_file.hpp>

namespace semiexplicit {

/// Writes a table of doubles as CSV: a header, then rows, each number with as many digits as it takes to read
/// it back exactly, with a decimal point in any locale. The rows go to `path` + ".part", each as row()
/// returns; commit() gives the file its name, so that a file of that name is always whole. Without commit(),
/// forgotten or not reached, the rows stay in the .part, and a line on stderr says so; the next run's first
/// row moves them to `path` + ".part.1", or the next free number, unless they are there already. Links,
/// devices, locks and what is thrown: DurableFile.
class CsvWriter {
 public:
  static constexpr const char* name = "CsvWriter";

  /// Throws std::invalid_argument where the name of a column would make two of it, and std::runtime_error
  /// where `path` is a checkpoint; see DurableFile for the rest.
  CsvWriter(std::filesystem::path path, const std::vector<std::string>& columns)
      : path_(path), columns_(columns.size()), file_(std::move(path), DurableFile::Uncommitted::kept) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].find_first_of(",\"\r\n") != std::string::npos)
        throw std::invalid_argument(path_.string() + ": the name of column " + std::to_string(i + 1) +
                                    " holds a comma, a quote or the end of a line; give another one");
      header_ += (i > 0 ? "," : "") + columns[i];
    }
    header_ += '\n';
    refuse_checkpoint();
  }

  /// Throws std::invalid_argument where the number of values is not that of the columns, and
  /// std::runtime_error where they cannot be written: the rows before are kept then, and nothing of this one.
  void row(std::span<const double> values) {
    if (values.size() != columns_)
      throw std::invalid_argument(path_.string() + ": a row of " + std::to_string(values.size()) +
                                  " numbers for " + std::to_string(columns_) + " columns");
    line_ = fresh() ? header_ : "";
    const char* separator = "";
    for (const double value : values) {
      char digits[32];
      line_ += std::exchange(separator, ",");
      line_.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    }
    line_ += '\n';
    file_.write(line_);
  }
  void row(std::initializer_list<double> values) {
    row(std::span<const double>(values.begin(), values.size()));
  }

  /// Whether there are no rows yet: a run that goes on would lose those of its beginning.
  bool fresh() const { return file_.length() == 0; }

  /// Ends the file and gives it its name. Throws std::runtime_error where a checkpoint has that by now.
  void commit() {
    refuse_checkpoint();
    if (fresh()) file_.write(header_);
    file_.commit();
  }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("columns", header_.substr(0, header_.size() - 1));
  }
  /// How long the .part is, and its checksum; see CheckpointMemory. What is saved is on the disk first. After
  /// what is put back the next row follows that length of the .part of the earlier run, and replaces the
  /// rest; throws std::invalid_argument where it is not what it was. What was written to a device or a pipe
  /// cannot be looked at again: the next row follows it.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    if (!fresh()) {
      file_.sync();
      saved_ = beginning(file_.length(), saved_);
    }
    Beginning wanted = saved_;
    visit(wanted.length);
    visit(wanted.sum);
    if (wanted != saved_) go_on_from(wanted);
  }

 private:
  void refuse_checkpoint() const {
    if (!file_.direct() && !file_.committed()) detail::refuse_checkpoint(path_, file_.destination());
  }

  /// The first bytes of a file, by their number and checksum.
  struct Beginning {
    std::uint64_t length = 0, sum = semiexplicit::checksum("");
    bool operator==(const Beginning&) const = default;
  };

  /// So many bytes of the .part, or as many as there are; those of `known` are not read again.
  Beginning beginning(std::uint64_t length, Beginning known) const {
    if (file_.direct()) return {.length = length};
    std::string piece;
    while (known.length < length) {
      piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(length - known.length, 1 << 20)));
      if (!file_.read(known.length, piece.data(), piece.size())) break;
      known = {.length = known.length + piece.size(), .sum = semiexplicit::checksum(piece, known.sum)};
    }
    return known;
  }

  void go_on_from(const Beginning& wanted) {
    const auto take = [&](const std::filesystem::path& from) {
      const std::string rows = beginning_of(from, wanted.length);
      if (semiexplicit::checksum(rows) != wanted.sum) return false;
      file_.go_on_after(0);
      file_.write(rows);
      return true;
    };
    // Moved away by another run, which may have begun with the same rows, or committed by one that was killed
    // before the end of its checkpoints.
    bool found = false;
    for (int n = 1; wanted.length > 0 && !found && std::filesystem::exists(file_.earlier(n)); ++n)
      found = take(file_.earlier(n));
    if (!found && beginning(wanted.length, {}) == wanted) {
      found = true;
      file_.go_on_after(wanted.length);
    }
    if (!found && !take(file_.destination()))
      throw std::invalid_argument(file_.part().string() +
                                  " is not what it was when the checkpoint was written; give the output of "
                                  "then, or start anew without the checkpoint");
    saved_ = wanted;
  }

  /// The first bytes of a file; nothing where it is shorter.
  static std::string beginning_of(const std::filesystem::path& file, std::uint64_t length) {
    std::error_code failure;
    const std::uintmax_t size = std::filesystem::file_size(file, failure);
    if (failure || size < length) return {};
    std::string bytes;
    bytes.resize(length);
    std::ifstream(file, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(length));
    return bytes;
  }

  std::filesystem::path path_;
  std::size_t columns_;
  std::string header_, line_;
  DurableFile file_;
  Beginning saved_;  ///< what was in the .part when it was last saved
};

/// An observer that writes the trajectory, as doubles: t, q0, q1, ..., p0, p1, .... Call commit() after the
/// run.
class CsvTrajectory {
 public:
  static constexpr const char* name = "CsvTrajectory";

  /// Throws std::invalid_argument where dof is negative; see DurableFile for the rest.
  CsvTrajectory(const std::filesystem::path& path, Eigen::Index dof) : writer_(path, columns(dof)) {}

  template <class Scalar, detail::HasHalves State>
  void operator()(const Scalar& t, const State& state) {
    values_.assign(1, static_cast<double>(t));
    for (const auto& q : state.q()) values_.push_back(static_cast<double>(q));
    for (const auto& p : state.p()) values_.push_back(static_cast<double>(p));
    writer_.row(values_);
  }
  void commit() { writer_.commit(); }
  bool fresh() const { return writer_.fresh(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    writer_.describe(list);
  }
  /// See CsvWriter.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    writer_.visit_memory(visit);
  }

 private:
  static std::vector<std::string> columns(Eigen::Index dof) {
    if (dof < 0)
      throw std::invalid_argument("CsvTrajectory: dof is negative (" + std::to_string(dof) +
                                  "); give that of the state, z.dof()");
    std::vector<std::string> names{"t"};
    for (const char* half : {"q", "p"})
      for (Eigen::Index i = 0; i < dof; ++i) names.push_back(half + std::to_string(i));
    return names;
  }

  CsvWriter writer_;
  std::vector<double> values_;
};

}  // namespace semiexplicit
