// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of all models.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>

#include "core/capitalised.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

using ident::Model;

/// Returns the score of a model's prediction: on samples that did not estimate it.
const ident::Score* validating_score(const Model& model) {
  return model.validation ? &model.validation->score : nullptr;
}

std::string unit_of(const ident::Criterion& criterion, const Model& model) {
  if (criterion.kind == ident::CriterionKind::coefficient_interval) {
    const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                                 [&](const ident::ParameterEstimate& p) { return p.name == criterion.parameter; });
    return at == model.parameters.end() ? std::string() : ident::unit_of(*at, model);
  }
  switch (traits_of(criterion.kind).unit) {
    case ident::CriterionUnit::percent:
      return "%";
    case ident::CriterionUnit::radian:
      return "deg";  // as the section on stability has it
    case ident::CriterionUnit::output:
      return model.output_unit;
    case ident::CriterionUnit::none:
      break;
  }
  return {};
}

constexpr std::string_view kProbability = ", p";  // at the end of the words of a test

/// What a model fails in or is not judged in, in few words.
std::string short_note(const ident::Criterion& criterion) {
  if (criterion.judged) return note_of(criterion);
  const std::string words = words_of(criterion);
  if (!words.ends_with(kProbability)) return "not judged: " + words;
  return "not judged whether " + words.substr(0, words.size() - kProbability.size());
}

/// The first of what a model fails in or is not judged in.
std::string short_notes(const ident::Verdict& verdict) {
  constexpr std::size_t kMost = 3;
  std::vector<std::string> words;
  // The measured noise shows what a missing part of the plant leaves, whatever the test is too weak for.
  const bool misses_a_part =
      fails_any(verdict, {ident::CriterionKind::error_over_noise, ident::CriterionKind::far_error_over_noise});
  for (const ident::Criterion& criterion : verdict.criteria) {
    const bool is_known = misses_a_part && !criterion.judged && criterion.kind == ident::CriterionKind::residual_input;
    if (!criterion.passed && !is_known) words.push_back(short_note(criterion));
  }
  const std::size_t more = words.size() > kMost ? words.size() - kMost : 0;
  words.resize(std::min(words.size(), kMost));
  return fmt::format("{}{}", fmt::join(words, "; "), more > 0 ? fmt::format("; {} more", more) : "");
}

/// A value of the table of criteria. Of a probability no more than its first digits matter.
std::string criterion_value(const ident::Criterion& criterion, double value) {
  constexpr double kLeastProbability = 1e-4;
  if (!std::isfinite(value)) return "-";
  if (criterion.kind == ident::CriterionKind::r2) return ident::percent_text(value);
  if (name_of(criterion).ends_with("_p")) {
    return value < kLeastProbability ? "< 0.0001" : fmt::format("{:.2g}", value);
  }
  if (traits_of(criterion.kind).unit == ident::CriterionUnit::radian) value *= 180.0 / std::numbers::pi;
  return fmt::format("{:.4g}", value);
}

}  // namespace

Section models_section(const Subject& subject) {
  Section section{.title = "Models"};
  if (subject.models.empty()) return section;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::vector<std::string>> more;
  const auto percent = [](double value, int decimals) {
    return std::isfinite(value) ? ident::percent_text(value, decimals) : std::string("-");
  };
  for (const ReportedModel& reported : subject.models) {
    const Model& model = reported.model;
    const ident::Score* unseen = validating_score(model);
    rows.push_back({model.name, model.verdict ? std::string(ident::verdict_word(*model.verdict)) : "not judged",
                    unseen != nullptr ? percent(unseen->fit_percent, 1) : "-",
                    unseen != nullptr ? percent(unseen->r2_percent, 2) : "-",
                    unseen != nullptr
                        ? ident::error_figure(std::max(std::abs(unseen->error_min), std::abs(unseen->error_max)))
                        : "-",
                    model.verdict ? short_notes(*model.verdict) : ""});
    const bool has_criterion = model.estimation && model.estimation->information;
    const double ar_bic = has_criterion ? model.estimation->information->ar_bic : std::nan("");
    more.push_back({model.name, model.estimation ? percent(model.estimation->score.r2_percent, 2) : "-",
                    has_criterion ? fmt::format("{}", model.estimation->information->parameters) : "-",
                    std::isfinite(ar_bic) ? fmt::format("{:.1f}", ar_bic) : "-",
                    !model.stability          ? "unknown"
                    : model.stability->stable ? "yes"
                                              : "no"});
  }
  const std::string unit = subject.models.front().model.output_unit;
  Item overview{.heading = ""};
  overview.html = table({{"model"},
                         {"verdict"},
                         {"fit %", Column::number},
                         {"R2 %", Column::number},
                         {"largest error [" + unit + "]", Column::number},
                         {"notes", Column::wide_text}},
                        rows);
  overview.html += paragraph(
      "Fit, R2 and error are of the unseen part; fit and R2 are 100 % for a perfect model. Notes: what a model fails "
      "in or is not judged in.");
  if (const auto pictured = subject.pictured(); pictured.size() < subject.models.size()) {
    const std::string shown =
        pictured.size() == 1
            ? fmt::format("the recommended model, {}, alone", pictured.front()->model.name)
            : fmt::format("{}, {}, and {}, {}, alone",
                          subject.has_recommendation ? "the recommended model" : "the first model",
                          pictured[0]->model.name, subject.has_recommendation ? "its runner-up" : "the second",
                          pictured[1]->model.name);
    overview.html += paragraph("The pictures show " + shown +
                               ". `eha report` with the files of one or two other models draws those.");
  }
  for (const std::string_view word : ident::kWordsBesideGrades) {
    if (std::none_of(rows.begin(), rows.end(), [&](const auto& row) { return row[1] == word; })) continue;
    std::string sentence = fmt::format("{}: {}.", word, ident::meaning_of(word));
    if (word != ident::kOutdone) {
      sentence += " No controller should rest on it, so in a run its file lies in models/rejected.";
    }
    overview.html += paragraph(capitalised(sentence));
  }
  section.items.push_back(std::move(overview));
  Item choice{.heading = "Estimating part, parameters and AR-BIC of every model", .folded = true};
  choice.html =
      table({{"model"},
             {"R2 %, estimating part", Column::number},
             {"parameters", Column::number},
             {"AR-BIC", Column::number},
             {"stable"}},
            more) +
      paragraph("AR-BIC weighs error against number of parameters; lower is better, and a difference of 10 is clear.");
  section.items.push_back(std::move(choice));
  const Model& first = subject.models.front().model;
  if (!first.verdict || first.verdict->criteria.empty()) return section;
  Item checks{.heading = "Every check of " + first.name, .folded = true};
  std::vector<std::vector<std::string>> criteria;
  for (const ident::Criterion& criterion : first.verdict->criteria) {
    criteria.push_back({words_of(criterion), criterion_value(criterion, criterion.value),
                        criterion_value(criterion, criterion.limit), unit_of(criterion, first),
                        !criterion.judged  ? "not judged"
                        : criterion.passed ? "passed"
                        : ident::traits_of(criterion.kind).weight == ident::CriterionWeight::rejects
                            ? "FAILED"
                            : "noted",  // it lowers the verdict
                        name_of(criterion)});
  }
  checks.html = table(
      {{"check"}, {"value", Column::number}, {"limit", Column::number}, {"unit"}, {"result"}, {"in files"}}, criteria);
  checks.html += paragraph(
      "FAILED rejects a model, noted lowers its verdict. p: probability of what was seen if the check's statement "
      "holds.");
  section.items.push_back(std::move(checks));
  return section;
}

Section other_models_section(const Subject& subject) {
  Section section{.title = "The other models"};
  for (const ReportedModel& reported : subject.models) {
    if (&reported == &subject.models.front()) continue;  // the box has its equation and reasons
    const Model& model = reported.model;
    section.items.push_back(
        {.heading = model.name + (model.verdict ? ": " + std::string(ident::verdict_word(*model.verdict)) : ""),
         .html = equation(model) + (model.verdict ? list(model.verdict->reasons) : "")});
  }
  return section;
}

}  // namespace eha::report
