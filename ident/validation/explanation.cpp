// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/explanation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <string_view>
#include <system_error>

#include "ident/validation/error_cause.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

constexpr const char* kKind = "explained_by_kind";
constexpr std::array<std::string_view, 4> kKindNames{"structure", "limit", "power", "play"};
constexpr const char* kHas = "explained_by";
constexpr const char* kOptions = "explained_by_options";
constexpr const char* kRatio = "explained_by_error_ratio";

/// Files of before have no kind: a limit had a part of the record or no options.
ExplanationKind kind_of(const Model& model, const std::string& options) {
  const auto kind = model.provenance.find(kKind);
  if (kind != model.provenance.end()) {
    const auto* const found = std::find(kKindNames.begin(), kKindNames.end(), kind->second);
    if (found != kKindNames.end()) return static_cast<ExplanationKind>(found - kKindNames.begin());
  }
  const bool is_limit = options.empty() || options.starts_with("--from") || options.starts_with("--to");
  return is_limit ? ExplanationKind::limit : ExplanationKind::structure;
}

}  // namespace

void note_explanation(Model& model, const Explanation& explanation) {
  model.provenance[kKind] = kKindNames.at(static_cast<std::size_t>(explanation.kind));
  model.provenance[kHas] = explanation.has;
  model.provenance[kOptions] = explanation.options;
  model.provenance[kRatio] = explanation.ratio;
}

std::optional<Explanation> explanation(const Model& model) {
  const auto has = model.provenance.find(kHas);
  const auto options = model.provenance.find(kOptions);
  const auto ratio = model.provenance.find(kRatio);
  const auto end = model.provenance.end();
  if (has == end || options == end || ratio == end) return std::nullopt;
  return Explanation{kind_of(model, options->second), has->second, options->second, ratio->second};
}

std::optional<Explanation> explanation_of(const Model& model, const Verdict& verdict) {
  using Kind = CriterionKind;
  const bool misses = fails_any(verdict, {Kind::r2, Kind::residual_input, Kind::nonlinearity, Kind::error_over_noise,
                                          Kind::far_error_over_noise});
  if (!misses) return std::nullopt;
  const ErrorCause cause = error_cause(model, verdict);
  if (cause == ErrorCause::wrong_input || cause == ErrorCause::moved_rows || cause == ErrorCause::frozen ||
      cause == ErrorCause::slow_rows || cause == ErrorCause::feedback) {
    return std::nullopt;
  }
  return explanation(model);
}

void forget_explanation(Model& model) {
  for (const char* key : {kKind, kHas, kOptions, kRatio}) model.provenance.erase(key);
}

std::optional<double> explained_factor(const Explanation& explanation) {
  double ratio = 0.0;
  const char* const end = explanation.ratio.data() + explanation.ratio.size();
  const auto [rest, error] = std::from_chars(explanation.ratio.data(), end, ratio);
  const bool is_ratio = error == std::errc() && rest == end && ratio > 0.0 && ratio <= 1.0;
  return is_ratio ? std::optional(1.0 / ratio) : std::nullopt;
}

std::string sentence_of(const Explanation& explanation) {
  switch (explanation.kind) {
    case ExplanationKind::play:
      return fmt::format(
          "There is a play (backlash, hysteresis) of about {}: with it a structure errs {} times as much on unseen "
          "data, and no structure here has it; mend what is loose there and record again. The time constants, dead "
          "times and "
          "dead band of this model hold a part of it.",
          explanation.has, explanation.ratio);
    case ExplanationKind::power:
      return fmt::format(
          "The plant's gain is curved: behind the power sign(u) |u|^{} of the input a structure errs {} times as much "
          "on unseen data, and no structure here has that power; use the model at the recorded amplitudes, or apply "
          "the "
          "power to the column of the input and fit that.",
          explanation.has, explanation.ratio);
    case ExplanationKind::limit:
      return fmt::format(
          "The plant saturates beyond about {} of the input: with the input limited to that a structure errs {} times "
          "as much on unseen data; record smaller amplitudes{}.",
          explanation.has, explanation.ratio,
          explanation.options.empty() ? "; this record stays within that nowhere for long"
                                      : fmt::format(", or cut to a part with such ({})", explanation.options));
    case ExplanationKind::structure:
      break;
  }
  return fmt::format(
      "A structure with {} (`eha fit {}`) passes the checks and errs {} times as much on unseen data: fit it; what "
      "this one leaves over is mostly what it lacks of that.",
      explanation.has, explanation.options, explanation.ratio);
}

}  // namespace eha::ident
