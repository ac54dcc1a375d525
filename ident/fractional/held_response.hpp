// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "ident/fractional/alias_sum.hpp"
#include "ident/fractional/transfer_columns.hpp"
#include "ident/signal/edge_thinning.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {

/// Selects the outputs of a held-input simulation.
struct OutputSelection {
  std::size_t samples = 0;  ///< N, inputs simulated
  double step_s = 0.0;      ///< sample period [s]
  std::size_t first = 0;    ///< first requested output
  std::size_t every = 1;    ///< distance of the requested outputs [samples]
  std::size_t count = 0;    ///< number of requested outputs
  /// Symmetric filter applied to the output before rows are picked: taps at -m..m, odd length; empty for none.
  std::vector<double> filter_taps;
  /// Allowed error in the aliases of a sharp resonance, relative to the response's size. A coarse search allows more
  /// than a report.
  double resolved = 1e-11;

  bool operator==(const OutputSelection&) const = default;
};

/// Spectrum of an input's increments for one selection (filter, shift and contour included).
using InputSpectrum = std::vector<std::complex<double>>;

/// Value of a response at a jump: just before it (a held input that takes effect after the sample is read) or just
/// after it (the response to a state at t = 0).
enum class AtJump { before, after };

/// A requested response: a column of TransferColumns driven by an input.
struct ResponseRequest {
  std::size_t column;
  const InputSpectrum* input;
  AtJump at_jump = AtJump::before;
};

/// Exact responses of fractional transfer functions to held inputs, by the aliased sum on a circle |z| = rho < 1:
///   Y(z) = [F(p) + S(theta) + ...] (1 - z) U(z),  p = -ln z = sigma + i theta,
/// inverted by one short inverse FFT a response. Tables that depend on the record alone are computed once, here.
/// The models must be stable: the contour does not represent growth. Error about 1e-10 of max|y| with the default
/// guard. Thread-safe after construction. Cost of a response O(L log L), L about guard * N.
class HeldResponse {
 public:
  static constexpr double kDefaultGuard = 2.0;

  /// @param guard  length of the transform over N; 2 for 1e-10, 1.5 for 1e-9
  explicit HeldResponse(const OutputSelection& selection, double guard = kDefaultGuard);

  /// The same for callers that simulate one record again and again: the tables of the last few selections are kept,
  /// but for those of very long records. Thread-safe. Cost at the first call for a selection O(L), else O(taps).
  static std::shared_ptr<const HeldResponse> of(const OutputSelection& selection);

  [[nodiscard]] const OutputSelection& selection() const noexcept { return selection_; }
  [[nodiscard]] std::size_t count() const noexcept { return selection_.count; }
  [[nodiscard]] std::size_t samples() const noexcept { return selection_.samples; }
  [[nodiscard]] double step_s() const noexcept { return selection_.step_s; }
  [[nodiscard]] double spacing_s() const noexcept { return selection_.step_s * static_cast<double>(selection_.every); }
  /// Returns the number of points at which a response is computed; serves to compare the cost of selections.
  [[nodiscard]] std::size_t effort() const noexcept { return bins_ + short_fft_.length(); }
  /// Returns the same number for a selection of every sample.
  [[nodiscard]] static std::size_t effort_of(std::size_t samples, double guard);

  /// @param input  N samples, at rest before the first
  [[nodiscard]] InputSpectrum input_spectrum(const Eigen::Ref<const Eigen::VectorXd>& input) const;
  /// Returns the spectrum to 1e-10 of the input's size; several times as fast if the filter leaves low frequencies
  /// only.
  [[nodiscard]] InputSpectrum quick_input_spectrum(const Eigen::Ref<const Eigen::VectorXd>& input) const;
  /// Thins parts of an input that follows `before` samples at rest, for thinned_input_spectrum(). Cost O(N taps/8).
  [[nodiscard]] EdgeThinning edge_thinning(const Eigen::Ref<const Eigen::VectorXd>& input, std::size_t before) const;
  /// Returns the spectrum of what one of that thinning's functions returned, as quick_input_spectrum() of the whole.
  /// Cost of an eighth of that.
  [[nodiscard]] InputSpectrum thinned_input_spectrum(const Eigen::VectorXd& thinned) const;
  /// A unit step at sample `at`.
  [[nodiscard]] InputSpectrum step_spectrum(std::size_t at = 0) const;

  /// Returns one column of count() values a request. @param delay_s  common transport delay [s]
  [[nodiscard]] Eigen::MatrixXd respond(const TransferColumns& columns, double delay_s,
                                        std::span<const ResponseRequest> requests) const;

 private:
  struct Scratch;
  struct Column;
  struct Aliases;
  struct QuickTables;
  [[nodiscard]] Scratch main_columns(const TransferColumns& columns) const;
  void add_aliases(const TransferColumns& columns, double x, Scratch& main) const;
  void add_near_aliases(const TransferColumns& columns, double x, int aliases, Scratch& scratch) const;
  [[nodiscard]] std::vector<std::complex<double>> delay_factors(double delay, double whole, double x) const;
  void fold(const Column& column, const InputSpectrum& input, const std::vector<std::complex<double>>& shift,
            std::vector<std::complex<double>>& folded) const;
  [[nodiscard]] const QuickTables& quick_tables() const;
  void weigh(InputSpectrum& spectrum) const;

  OutputSelection selection_;
  std::size_t length_;  ///< L
  double sigma_;        ///< -ln rho
  std::size_t bins_;    ///< bins that carry signal: the filter's stopband is left out
  AliasSum aliases_;
  RealFft short_fft_;
  LaplacePoints points_;
  std::vector<double> inverse_re_;  ///< 1/p
  std::vector<double> inverse_im_;
  InputSpectrum selection_factor_;      ///< filter and shift to the first output
  Eigen::VectorXd growth_;              ///< rho^-n of every output over L
  std::shared_ptr<Aliases> nearest_;    ///< points of k = +-1 to +-7, made when a model first needs them
  std::shared_ptr<QuickTables> quick_;  ///< see quick_tables()
};

}  // namespace eha::ident
