// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>
#include <string_view>
#include <utility>

namespace eha::ident {

/// Kinds of feedback, the simplest first.
enum class FeedbackKind { p, pi, pd, pid, fopid };

inline constexpr std::array<std::pair<std::string_view, FeedbackKind>, 5> kFeedbackKinds{
    {{"p", FeedbackKind::p},
     {"pi", FeedbackKind::pi},
     {"pd", FeedbackKind::pd},
     {"pid", FeedbackKind::pid},
     {"fopid", FeedbackKind::fopid}}};
[[nodiscard]] std::string_view text(FeedbackKind kind);
[[nodiscard]] bool integrates(FeedbackKind kind);
[[nodiscard]] bool differentiates(FeedbackKind kind);

/// C(s) = F(s) (kp + ki / s^lambda + kd s^mu), F(s) = 1 / (1 + s filter_s + (s filter_s)^2 / 2).
/// C maps [e] to [w]; the caller defines w and e.
struct Feedback {
  double kp = 0.0;                ///< [w/e]
  double ki = 0.0;                ///< [w/(e s^lambda)]
  double kd = 0.0;                ///< [w s^mu/e]
  double integral_order = 1.0;    ///< lambda, above 0 and below 2
  double derivative_order = 1.0;  ///< mu, above 0 and below 2
  double filter_s = 0.0;          ///< of the measurement [s]; 0: none

  bool operator==(const Feedback&) const = default;
};

/// Returns C(s), s != 0.
[[nodiscard]] std::complex<double> frequency_response(const Feedback& c, std::complex<double> s);

}  // namespace eha::ident
