#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <exception>
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

#include <semiexplicit/checkpoint/file.hpp>

namespace semiexplicit {

/// Writes a table of doubles as CSV: a header, then rows, each number with as many digits as it takes to read it back
/// exactly. The rows go to `path` + ".part"; commit() gives the file its name, so that a file of that name is always whole.
/// Without commit() nothing is left behind, except where an exception ends the run or a checkpoint counts on the rows: they are
/// then in the .part. Throws std::runtime_error, naming the file, where writing fails.
class CsvWriter {
 public:
  static constexpr const char* name = "CsvWriter";

  CsvWriter(std::filesystem::path path, const std::vector<std::string>& columns)
      : path_(std::move(path)),
        part_(path_.string() + ".part"),
        columns_(columns.size()),
        out_(part_, std::ios::app) {  // what is there may be gone on with
    for (std::size_t i = 0; i < columns.size(); ++i) line_ += (i > 0 ? "," : "") + columns[i];
    line_ += '\n';
    require("cannot be written; check that the folder exists and is writable");
  }
  ~CsvWriter() {
    if (committed_) return;
    out_.close();
    std::error_code ignored;
    if (saved_) return;
    const bool own = begun_ ? std::uncaught_exceptions() <= exceptions_
                            : std::filesystem::file_size(part_, ignored) == 0;  // not an earlier run's
    if (own) std::filesystem::remove(part_, ignored);
  }
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  void row(std::span<const double> values) {
    if (values.size() != columns_)
      throw std::invalid_argument(path_.string() + ": a row of " + std::to_string(values.size()) +
                                  " numbers for " + std::to_string(columns_) + " columns");
    begin();
    line_.clear();
    for (const double value : values) {
      char digits[32];
      const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
      if (!line_.empty()) line_ += ',';
      line_.append(digits, end);
    }
    line_ += '\n';
    out_ << line_;
    require("cannot be written; is the disk full?");
  }
  void row(std::initializer_list<double> values) {
    row(std::span<const double>(values.begin(), values.size()));
  }

  /// Whether there are no rows yet: a run that goes on would lose those of its beginning.
  bool fresh() const { return !begun_; }

  /// Ends the file and gives it its name.
  void commit() {
    begin();
    out_.close();
    require("cannot be closed; is the disk full?");
    std::error_code failure;
    std::filesystem::rename(part_, path_, failure);
    if (failure) throw std::runtime_error(path_.string() + ": " + failure.message());
    committed_ = true;
  }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("columns", columns_);
  }
  /// How long the .part is, and its checksum; see CheckpointMemory. What is saved is on the disk first. What is put back
  /// cuts the .part of the earlier run to that length and goes on there; throws std::invalid_argument where it is
  /// not what it was.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    if (begun_) {
      out_.flush();
      if (!out_ || !detail::sync_to_disk(part_)) require_not("cannot be written; is the disk full?");
      take_in(std::filesystem::file_size(part_));
    }
    std::uint64_t length = length_, sum = sum_;
    visit(length);
    visit(sum);
    if (length != length_ || sum != sum_) go_on_from(length, sum);
    saved_ = begun_;
  }

 private:
  void require(const char* remedy) const {
    if (!out_) require_not(remedy);
  }
  [[noreturn]] void require_not(const char* remedy) const {
    throw std::runtime_error(path_.string() + ": " + remedy);
  }

  /// Starts the file with the header, unless it goes on from an earlier run.
  void begin() {
    if (begun_) return;
    begun_ = true;
    out_.close();
    out_.open(part_);
    out_ << line_;
    require("cannot be written; is the disk full?");
  }

  /// Brings length_ and sum_ up to the first `length` bytes of the .part. False: it has not so many.
  bool take_in(std::uint64_t length) {
    std::ifstream in(part_, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(length_));
    std::string piece;
    while (in && length_ < length) {
      piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(length - length_, 1 << 20)));
      if (!in.read(piece.data(), static_cast<std::streamsize>(piece.size()))) return false;
      sum_ = detail::checksum(piece, sum_);
      length_ += piece.size();
    }
    return length_ == length;
  }

  void go_on_from(std::uint64_t length, std::uint64_t sum) {
    length_ = 0;
    sum_ = detail::checksum("");
    if (!take_in(length) || sum_ != sum)
      throw std::invalid_argument(
          part_.string() +
          " is not what it was when the checkpoint was written; start anew without the checkpoint");
    out_.close();
    std::error_code failure;
    std::filesystem::resize_file(part_, length, failure);
    if (!failure) out_.open(part_, std::ios::app);
    if (failure) require_not("its .part cannot be cut to the length at the checkpoint");
    require("cannot be written; check that the folder is writable");
    begun_ = true;
  }

  std::filesystem::path path_, part_;
  std::size_t columns_;
  std::ofstream out_;
  std::string line_;  ///< the header, until that is written
  bool begun_ = false, committed_ = false;
  bool saved_ = false;  ///< whether a checkpoint counts on what is there
  int exceptions_ = std::uncaught_exceptions();
  std::uint64_t length_ = 0, sum_ = detail::checksum("");  ///< of the .part when it was last saved
};

/// An observer that writes the trajectory, as doubles: t, q0, q1, ..., p0, p1, .... Call commit() after the run.
class CsvTrajectory {
 public:
  static constexpr const char* name = "CsvTrajectory";

  CsvTrajectory(const std::filesystem::path& path, Eigen::Index dof) : writer_(path, columns(dof)) {}

  template <class Scalar, class State>
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
    std::vector<std::string> names{"t"};
    for (const char* half : {"q", "p"})
      for (Eigen::Index i = 0; i < dof; ++i) names.push_back(half + std::to_string(i));
    return names;
  }

  CsvWriter writer_;
  std::vector<double> values_;
};

}  // namespace semiexplicit
