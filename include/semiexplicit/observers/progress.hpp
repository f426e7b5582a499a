#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>

#if defined(_WIN32)
#include <io.h>
#else
#include <unistd.h>
#endif

namespace semiexplicit {

namespace detail {
inline bool is_terminal(std::FILE* stream) {
#if defined(_WIN32)
  return _isatty(_fileno(stream)) != 0;
#else
  return isatty(fileno(stream)) != 0;
#endif
}
}  // namespace detail

/// An observer that draws a progress bar on stderr, if that is a terminal, at most ten times a second, and
/// takes it away with the last step, or where the run ends early, when it is destroyed. Elsewhere it does
/// nothing. `t_end` is the time at which the run will be done. The time left is reckoned from the pace since
/// the first call, so that a run which is resumed does not count the steps of an earlier one.
class Progress {
 public:
  explicit Progress(double t_end, std::string label = "", double t_begin = 0)
      : begin_(t_begin), end_(t_end), label_(std::move(label)), shown_(detail::is_terminal(stderr)) {}
  ~Progress() { take_away(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  template <class Scalar, class State>
  void operator()(const Scalar& t, const State&) {
    if (!shown_) return;
    see(static_cast<double>(t));
  }

 private:
  using Clock = std::chrono::steady_clock;

  void see(double t) {
    if (calls_++ == 0) {
      first_t_ = before_ = t;
      start_ = last_ = Clock::now();
    }
    // Another such step would lie farther from the end than this one: it is the last.
    const bool last = std::abs(end_ - t) <= std::abs(t - before_) / 2;
    before_ = t;
    if (last)
      take_away();
    else if (calls_ >= next_)
      look_at_clock(t);
  }

  void take_away() {
    if (std::exchange(drawn_, false)) std::fputs("\r\x1b[K", stderr);
  }

  // Reading the clock costs as much as a small step: the number of calls that pass unlooked follows the pace
  // of the run.
  void look_at_clock(double t) {
    const auto now = Clock::now();
    const double since = std::chrono::duration<double>(now - last_).count();
    const std::int64_t passed = std::max<std::int64_t>(calls_ - last_calls_, 1);
    next_ = calls_ + (since < 0.05 ? std::min<std::int64_t>(2 * passed, std::int64_t{1} << 30) : passed);
    if (since < 0.1) return;
    draw(t, std::chrono::duration<double>(now - start_).count());
    next_ = calls_ + std::max<std::int64_t>(passed / 4, 1);
    last_ = now;
    last_calls_ = calls_;
  }

  void draw(double t, double elapsed) {
    constexpr int width = 40;
    const double fraction = end_ != begin_ ? std::clamp((t - begin_) / (end_ - begin_), 0.0, 1.0) : 1.0;
    const int full = static_cast<int>(fraction * width);
    const std::string bar = std::string(static_cast<std::size_t>(full), '#') +
                            std::string(static_cast<std::size_t>(width - full), '.');
    const double left = t != first_t_ ? std::max(elapsed * (end_ - t) / (t - first_t_), 0.0) : 0.0;
    // The cursor stays at the begin of the line: what a run that fails says is not written behind the bar.
    std::fprintf(stderr, "\r%s [%s] %3.0f%%  t = %.6g  %.0f s left\x1b[K\r", label_.c_str(), bar.c_str(),
                 100 * fraction, t, left);
    std::fflush(stderr);
    drawn_ = true;
  }

  double begin_, end_, first_t_ = 0, before_ = 0;
  std::string label_;
  bool shown_, drawn_ = false;
  std::int64_t calls_ = 0, next_ = 0, last_calls_ = 0;
  Clock::time_point start_{}, last_{};
};

}  // namespace semiexplicit
