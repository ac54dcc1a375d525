// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/better_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

std::string times_text(double error, double of) {
  return of > 0.0 ? fmt::format(", {} times as much", ident::figure_text(error / of)) : std::string();
}

constexpr std::size_t kMostModels = 2;

/// "; fo (0.0042 in) is rejected": of each that is not to be used, or of many their number.
std::string others_text(const std::vector<RankedModel>& models, const std::string& unit) {
  const auto others = std::count_if(models.begin(), models.end(), [](const auto& model) { return !model.but.empty(); });
  if (others > static_cast<std::ptrdiff_t>(kMostModels)) {
    return fmt::format("; {} of {} are not to be used", others, models.size());
  }
  std::string text;
  for (const RankedModel& model : models) {
    if (model.but.empty()) continue;
    text += fmt::format("; {} ({}) is {}", model.label, ident::error_text(model.rms_error, unit), model.but);
  }
  return text;
}

}  // namespace

std::size_t estimated_parameters(const ident::Model& model) {
  if (model.estimation && model.estimation->information) return model.estimation->information->parameters;
  return static_cast<std::size_t>(std::count_if(model.parameters.begin(), model.parameters.end(),
                                                [](const ident::ParameterEstimate& p) { return !p.fixed; }));
}

std::string better_model(std::vector<RankedModel> models, const std::string& unit) {
  std::stable_sort(models.begin(), models.end(),
                   [](const RankedModel& a, const RankedModel& b) { return a.rms_error < b.rms_error; });
  std::vector<const RankedModel*> usable;
  for (const RankedModel& model : models) {
    if (model.but.empty()) usable.push_back(&model);
  }
  if (usable.empty()) return "use none of them" + (models.size() > kMostModels ? "" : others_text(models, unit));
  const RankedModel& best = *usable.front();
  std::vector<const RankedModel*> alike;
  for (const RankedModel* model : usable) {
    if (model->rms_error <= ident::kGreatestErrorOverRefit * best.rms_error) alike.push_back(model);
  }
  const RankedModel& smallest = **std::min_element(
      alike.begin(), alike.end(), [](const auto* a, const auto* b) { return a->parameters < b->parameters; });
  std::string text = fmt::format("use {}: rms error {}", smallest.label, ident::error_text(smallest.rms_error, unit));
  std::vector<std::string> as_good;
  bool has_more = true;
  for (const RankedModel* model : alike) {
    if (model == &smallest) continue;
    has_more = has_more && model->parameters > smallest.parameters;
    if (as_good.size() == kMostModels) continue;
    as_good.push_back(fmt::format("{} {} with {} parameters", model->label, ident::error_text(model->rms_error, unit),
                                  model->parameters));
  }
  if (const std::size_t more = alike.size() - 1 - as_good.size(); more > 0) {
    as_good.push_back(fmt::format("{} more", more));
  }
  if (!as_good.empty()) {
    text += fmt::format(" with {} parameters, {}: errors within {:g} times are alike, and {}", smallest.parameters,
                        fmt::join(as_good, ", "), ident::kGreatestErrorOverRefit,
                        has_more ? "it has the fewest parameters" : "none has fewer parameters");
  }
  if (usable.size() > alike.size()) {
    const RankedModel& next = *usable[alike.size()];
    text += fmt::format("{} {} {}{}", as_good.empty() ? "," : "; the next,", next.label,
                        ident::error_text(next.rms_error, unit), times_text(next.rms_error, smallest.rms_error));
  }
  return text + others_text(models, unit);
}

}  // namespace eha::report
