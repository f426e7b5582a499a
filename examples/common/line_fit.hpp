#pragma once

namespace examples {

/// The sums of which the least squares of a line are made.
struct LineFit {
  double count = 0, t = 0, tt = 0, y = 0, ty = 0;

  void add(double at, double value) { count += 1, t += at, tt += at * at, y += value, ty += at * value; }
  LineFit operator+(const LineFit& b) const {
    return {count + b.count, t + b.t, tt + b.tt, y + b.y, ty + b.ty};
  }
  double slope() const { return (count * ty - t * y) / (count * tt - t * t); }
};

}  // namespace examples
