// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/feedback.hpp"

namespace eha::ident {

std::string_view text(FeedbackKind kind) {
  for (const auto& [name, value] : kFeedbackKinds) {
    if (value == kind) return name;
  }
  return "?";
}

bool integrates(FeedbackKind kind) {
  return kind == FeedbackKind::pi || kind == FeedbackKind::pid || kind == FeedbackKind::fopid;
}

bool differentiates(FeedbackKind kind) {
  return kind == FeedbackKind::pd || kind == FeedbackKind::pid || kind == FeedbackKind::fopid;
}

std::complex<double> frequency_response(const Feedback& c, std::complex<double> s) {
  std::complex<double> value = c.kp;
  if (c.ki > 0.0) value += c.ki * std::pow(s, -c.integral_order);
  if (c.kd > 0.0) value += c.kd * std::pow(s, c.derivative_order);
  const std::complex<double> x = s * c.filter_s;
  return value / (1.0 + x + 0.5 * x * x);
}

}  // namespace eha::ident
