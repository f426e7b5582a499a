#pragma once

#include <charconv>
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

namespace semiexplicit {

/// Writes a table of doubles as CSV: a header, then rows, each number with as many digits as it takes to read it back
/// exactly. The rows go to `path` + ".part"; commit() gives the file its name, so that a file of that name is always whole.
/// Without commit() nothing is left behind. Throws std::runtime_error, naming the file, where writing fails.
class CsvWriter {
 public:
  CsvWriter(std::filesystem::path path, const std::vector<std::string>& columns)
      : path_(std::move(path)), part_(path_.string() + ".part"), columns_(columns.size()), out_(part_) {
    for (std::size_t i = 0; i < columns.size(); ++i) out_ << (i > 0 ? "," : "") << columns[i];
    out_ << '\n';
    require("cannot be written; check that the folder exists and is writable");
  }
  ~CsvWriter() {
    if (committed_) return;
    out_.close();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  void row(std::span<const double> values) {
    if (values.size() != columns_)
      throw std::invalid_argument(path_.string() + ": a row of " + std::to_string(values.size()) +
                                  " numbers for " + std::to_string(columns_) + " columns");
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

  /// Ends the file and gives it its name.
  void commit() {
    out_.close();
    require("cannot be closed; is the disk full?");
    std::error_code failure;
    std::filesystem::rename(part_, path_, failure);
    if (failure) throw std::runtime_error(path_.string() + ": " + failure.message());
    committed_ = true;
  }

 private:
  void require(const char* remedy) const {
    if (!out_) throw std::runtime_error(path_.string() + ": " + remedy);
  }

  std::filesystem::path path_, part_;
  std::size_t columns_;
  std::ofstream out_;
  std::string line_;
  bool committed_ = false;
};

/// An observer that writes the trajectory, as doubles: t, q0, q1, ..., p0, p1, .... Call commit() after the run.
class CsvTrajectory {
 public:
  CsvTrajectory(const std::filesystem::path& path, Eigen::Index dof) : writer_(path, columns(dof)) {}

  template <class Scalar, class State>
  void operator()(const Scalar& t, const State& state) {
    values_.assign(1, static_cast<double>(t));
    for (const auto& q : state.q()) values_.push_back(static_cast<double>(q));
    for (const auto& p : state.p()) values_.push_back(static_cast<double>(p));
    writer_.row(values_);
  }
  void commit() { writer_.commit(); }

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
