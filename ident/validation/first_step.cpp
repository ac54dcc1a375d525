// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/first_step.hpp"

#include <algorithm>

#include "ident/validation/error_cause.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using Kind = CriterionKind;

// R2 at which the input has no part in the output. A model of noise adds some to what it did not see.
constexpr double kNoMotion_percent = 5.0;
constexpr double kAddedNoise_percent = -20.0;

bool fails(const Model& model, std::initializer_list<Kind> kinds) {
  return model.verdict && fails_any(*model.verdict, kinds);
}

/// What a model's provenance says under a key; empty without it.
std::string told(const Model& model, const char* key) {
  const auto at = model.provenance.find(key);
  return at == model.provenance.end() ? std::string() : at->second;
}

bool has_no_part(const Score& score) {
  return score.r2_percent < kNoMotion_percent && score.r2_percent > kAddedNoise_percent;
}

/// Whether the input has no part in the output, on either part of the record.
bool explains_nothing(const Model& model) {
  return model.validation && model.estimation && has_no_part(model.validation->score) &&
         has_no_part(model.estimation->score);
}

}  // namespace

bool shows_no_motion(const Model& model, const Verdict& verdict) {
  return explains_nothing(model) && error_cause(model, verdict) == ErrorCause::white_noise;
}

NextStep next_step(const std::vector<const Model*>& models, std::string_view recommended) {
  std::vector<const Model*> counted;
  for (const Model* model : models) {
    if (recommended.empty() || model->name == recommended) counted.push_back(model);
  }
  if (counted.empty()) return {};
  const auto any = [&](const auto& is) { return std::any_of(counted.begin(), counted.end(), is); };
  const auto all = [&](const auto& is) { return std::all_of(counted.begin(), counted.end(), is); };
  // Of a dead sensor's models some find a correlation by chance; none follows the output.
  if (recommended.empty() && all([](const Model* model) { return explains_nothing(*model); }) &&
      any([](const Model* model) { return model->verdict && shows_no_motion(*model, *model->verdict); })) {
    return {FirstStep::look_at_sensor};
  }
  if (any([](const Model* model) { return model->provenance.contains(kWrongInput); })) return {FirstStep::mend_input};
  if (any([](const Model* model) {
        return model->verdict && error_cause(*model, *model->verdict) == ErrorCause::moved_rows;
      })) {
    return {FirstStep::take_rows_as_even};
  }
  for (const Model* model : counted) {
    if (const std::string cut = told(*model, kCutOfRecord); !cut.empty()) return {FirstStep::cut, cut};
  }
  for (const Model* model : counted) {
    if (model->verdict && error_cause(*model, *model->verdict) == ErrorCause::frozen) {
      return {FirstStep::cut, told(*model, kWithoutFrozen)};
    }
  }
  if (const auto stop = end_stop_of(models, recommended)) {
    const std::string cut = cut_options(*stop);
    return {cut.empty() && !stop->does_not_answer ? FirstStep::smaller_amplitude : FirstStep::cut, cut};
  }
  for (const Model* model : counted) {
    const std::string cut = told(*model, kWithoutGaps);
    // What the input did in a gap shifts a rod, which looks like a part of the plant or a bend of it.
    const bool is_off = fails(*model, kShownBesideGaps) || fails(*model, {Kind::interpolated, Kind::unmeasured});
    if (is_off && !cut.empty()) return {FirstStep::cut, cut};
  }
  if (all([](const Model* model) {
        return fails(*model, {Kind::interpolated, Kind::unmeasured}) && !told(*model, kAgainstLostRows).empty();
      })) {
    return {FirstStep::against_lost_rows};
  }
  // What a controller does is in the whole record.
  if (any([](const Model* model) { return model->provenance.contains(kLoopOfRecord); })) return {};
  // Of rejected models the one that errs least tells most of the record.
  const Model& nearest = **std::min_element(
      counted.begin(), counted.end(), [](const Model* a, const Model* b) { return shown_mse(*a) < shown_mse(*b); });
  if ((nearest.validation && nearest.validation->jump) || nearest.provenance.contains(kGainChanged)) {
    return {FirstStep::cut, told(nearest, kLongerPart)};
  }
  if (all([](const Model* model) {
        return fails(*model, {Kind::saturated, Kind::far_saturated}) && told(*model, kWithinDeadBand).empty();
      })) {
    return {FirstStep::smaller_amplitude};
  }
  const bool is_short =
      !recommended.empty() && counted.front()->verdict && needs_longer_record(*counted.front()->verdict);
  return {is_short ? FirstStep::longer_record : FirstStep::none};
}

}  // namespace eha::ident
