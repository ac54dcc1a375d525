// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::place {

/// Sums of a line y over x by least squares, in which older samples count less. Real-time safe; cost: some ten
/// operations. Not thread-safe.
class ForgettingLine {
 public:
  /// @param kept  of the sums so far, 0 to 1   @param period_s  weight of this sample
  void add(double kept, double period_s, double x, double y) noexcept {
    const auto sum = [&](double& total, double value) { total = kept * total + period_s * value; };
    sum(weight_s_, 1.0);
    sum(x_, x);
    sum(y_, y);
    sum(xx_, x * x);
    sum(xy_, x * y);
    sum(yy_, y * y);
  }

  // The following need a weight above 0.
  [[nodiscard]] double weight_s() const noexcept { return weight_s_; }
  [[nodiscard]] double mean_x() const noexcept { return x_ / weight_s_; }
  [[nodiscard]] double mean_y() const noexcept { return y_ / weight_s_; }
  [[nodiscard]] double variance_x() const noexcept { return xx_ / weight_s_ - mean_x() * mean_x(); }
  [[nodiscard]] double variance_y() const noexcept { return yy_ / weight_s_ - mean_y() * mean_y(); }
  [[nodiscard]] double covariance() const noexcept { return xy_ / weight_s_ - mean_x() * mean_y(); }
  [[nodiscard]] double slope() const noexcept { return covariance() / variance_x(); }

 private:
  double weight_s_ = 0.0;
  double x_ = 0.0;
  double y_ = 0.0;
  double xx_ = 0.0;
  double xy_ = 0.0;
  double yy_ = 0.0;
};

}  // namespace eha::place
