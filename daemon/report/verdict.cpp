// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/verdict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "core/capitalised.hpp"
#include "core/shell_word.hpp"
#include "core/time_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/next_text.hpp"
#include "daemon/report/section.hpp"
#include "daemon/report/sheet_comparison.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::report {
namespace {

using ident::Grade;
using ident::Model;
using nlohmann::ordered_json;

/// Returns the score of a model's prediction: on samples that did not estimate it.
const ident::Score* unseen_score(const Model& model) { return model.validation ? &model.validation->score : nullptr; }

/// The errors, and what they are of.
std::string error_sentence(const Model& model) {
  const ident::Score* unseen = unseen_score(model);
  if (unseen == nullptr && !model.estimation) return "It holds no scores.";
  const ident::Score& score = unseen != nullptr ? *unseen : model.estimation->score;
  const std::string& unit = model.output_unit;
  const double most = std::max(std::abs(score.error_min), std::abs(score.error_max));
  // Files of models do not hold the greatest error of the rows that estimated them.
  const std::string errors = fmt::format("rms error {}{}", ident::error_text(std::sqrt(score.mse), unit),
                                         most > 0.0 ? ", at most " + ident::error_text(most, unit) : "");
  return unseen != nullptr
             ? fmt::format("On the {} samples that did not estimate it: {}.", score.samples, errors)
             : fmt::format("On the samples that estimated it: {}; there are no others to test it on.", errors);
}

/// The scores in percent.
std::string scores_sentence(const Model& model) {
  const ident::Score* unseen = unseen_score(model);
  if (unseen == nullptr && !model.estimation) return {};
  const ident::Score& score = unseen != nullptr ? *unseen : model.estimation->score;
  return fmt::format(
      "Fit {} %, R2 {} % {} (100 % is perfect; a record that moves far gives a high R2 to a poor model too).",
      ident::percent_text(score.fit_percent, 1), ident::percent_text(score.r2_percent),
      unseen != nullptr ? "on unseen samples" : "on the samples that estimated it");
}

/// What limits the use of an accepted model.
std::string limits_html(const ident::Verdict& verdict) {
  std::vector<std::string> limits;
  for (const std::string& reason : verdict.reasons) limits.push_back(ident::in_few_words(reason));
  if (verdict.grade == Grade::good) {
    return paragraph(limits.empty() ? "Good: it passes every check." : "Good: it passes every check. To know:") +
           list(limits);
  }
  return paragraph(limits.empty() ? "Usable: no check rejects it, but not all of them could be made."
                                  : "Usable: no check rejects it, but these findings limit its use:") +
         list(limits);
}

std::string band_sentence(const ReportedModel& reported) {
  const auto band = reported.usable_band();
  if (!band) {
    return "Usable band: none. The record determines the response at none of the excited frequencies: record longer, "
           "or with more tones.";
  }
  std::string text = fmt::format("Usable from {:.3g} to {:.3g} Hz", band->lowest_Hz, band->highest_Hz);
  const auto& criteria = reported.model.verdict->criteria;
  const bool misses_input = std::any_of(criteria.begin(), criteria.end(), [](const ident::Criterion& c) {
    return c.kind == ident::CriterionKind::residual_input && has_failed(c);
  });
  return text +
         (misses_input ? " by intervals of the noise alone; the response can be off by what the model misses." : ".");
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
      return "rad";
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
  return "not judged: " +
         words.substr(0, words.ends_with(kProbability) ? words.size() - kProbability.size() : words.size());
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
  return fmt::format("{:.4g}", value);
}

std::string box(const char* kind, const std::string& heading, const std::string& html) {
  return fmt::format("<section class=\"verdict {}\"><h2>{}</h2>\n{}</section>\n", kind, escaped(heading), html);
}

/// The note on a map that shows no dead band, as a sentence.
std::string map_sentence(const Model& model) { return capitalised(ident::map_note(model)) + "."; }

/// What to know of a map in whose dead band the rod moves; empty for another map.
/// @param sheet  null: none is known   @param leaks  by the valve sheet, which is said already
std::string caution_of_map(const Model& model, const SheetComparison* sheet, bool leaks) {
  if (ident::unfound_dead_band(model) != nullptr) return paragraph(map_sentence(model));
  const std::optional<double> shift = model.input_map ? ident::noted_shift(model) : std::nullopt;
  if (!shift) return {};
  const std::string moves =
      leaks ? std::string()
            : "The rod moves within that dead band, as where oil leaks past the piston or friction bends the edges; ";
  if (sheet != nullptr && sheet->confirms_edges) {
    return paragraph((leaks ? "" : moves) + "the valve sheet has the same null and dead band all the same.");
  }
  return fmt::format(
      "<p><strong>Null and half dead band are the fit&#39;s, not the valve&#39;s: each may be up to {:.2g} {} "
      "off.</strong> {}</p>\n",
      *shift, escaped(model.input_unit),
      leaks ? "That is the leak's doing." : with_code(moves + "`eha characterise` measures the valve's own."));
}

/// Gain, time constants and map in figures; of a fractional order the equation.
std::string in_figures(const Model& model) {
  const std::string form = ident::engineering_form(model, ident::half_width_sign(model, "±"));
  if (form.empty()) return equation(model);
  std::string text = form;
  if (model.input_map) {
    const std::string unit = ident::after_number(model.input_unit);
    text += fmt::format("; behind a valve with null {:.3f}{}", model.input_map->null, unit);
    if (ident::unfound_dead_band(model) == nullptr) {
      text += fmt::format(" and half dead band {:.3f}{}", model.input_map->dead_band, unit);
    }
  }
  return paragraph(text + ".");
}

/// HTML that is closed until its heading is clicked.
std::string folded(const char* heading, const std::string& html) {
  return fmt::format("<details>\n<summary>{}</summary>\n{}</details>\n", escaped(heading), html);
}

/// What an accepted model is and is good for, then folded how that is known.
std::string of_accepted(const Subject& subject, const ReportedModel& reported, const std::string& reason) {
  const Model& model = reported.model;
  const std::optional<SheetComparison> sheet = model.input_map ? compare_with_sheet(subject, model) : std::nullopt;
  const bool has_changed = sheet && !sheet->headline.empty();
  std::string html = has_changed ? "<p><strong>" + escaped(sheet->headline) + "</strong></p>\n" : std::string();
  if (subject.leak && model.input_map) {
    html += "<p><strong>" + with_code(leak_finding(*subject.leak, subject.unit)) + "</strong></p>\n";
  }
  html += paragraph(error_sentence(model) + " " + band_sentence(reported)) + in_figures(model) +
          caution_of_map(model, sheet ? &*sheet : nullptr, subject.leak.has_value());
  html += limits_html(*model.verdict) + paragraph(next_steps(subject, reported, has_changed));
  std::string why = list(model.verdict->reasons);
  if (const std::string sight = sight_of(model, *model.verdict); !sight.empty()) why += paragraph(sight);
  if (const std::string scores = scores_sentence(model); !scores.empty()) why += paragraph(scores);
  return html + folded("How that is known, with figures, and what to do", why + reason + equation(model));
}

/// What a rejected model is.
std::string of_rejected(const Model& model) {
  return paragraph(error_sentence(model) + " " + scores_sentence(model)) + equation(model);
}

/// What the import said of the record, for a person to look at.
std::string remarks_on_record(const Model& model) {
  const auto remarks = model.provenance.find("remarks");
  if (remarks == model.provenance.end()) return {};
  std::vector<std::string> sentences;
  for (std::size_t at = 0; at < remarks->second.size();) {
    const std::size_t end = std::min(remarks->second.find('\n', at), remarks->second.size());
    sentences.push_back(remarks->second.substr(at, end - at));
    at = end + 1;
  }
  return paragraph("Of the record itself:") + list(sentences);
}

/// Returns the reason for which a run has no models: it did not complete, or its identification failed.
std::string without_models(const Subject& subject) {
  const ordered_json& outcome = subject.part("outcome");
  const ordered_json& description = subject.part("report", "description");
  const ordered_json& error = subject.part("identification", "error");
  std::string html;
  if (error.is_string()) html += paragraph("The identification failed: " + error.get<std::string>());
  if (description.is_string() && !description.get_ref<const std::string&>().empty()) {
    const std::string end = description.get<std::string>();
    // What the record shows of the cause replaces a list of what is likely.
    const bool is_known = !subject.trial_stood.empty() || (subject.leak && !subject.trial_changes.empty());
    html += paragraph(is_known ? record::without_causes(end) : end);
  }
  const bool is_trial = subject.part("experiment", "track").is_string();
  const bool is_broken = is_trial && outcome == "faulted";
  if (!subject.trial_stood.empty()) html += paragraph(capitalised(subject.trial_stood) + ".");
  if (!subject.trial_changes.empty()) {
    html += paragraph("Until then the moving rod shows:") + list(subject.trial_changes);
  }
  if (subject.leak) {
    html += paragraph((is_broken ? "The promise is not kept. " : "") + leak_finding(*subject.leak, subject.unit));
  } else if (is_broken && !subject.trial_changes.empty()) {
    html += paragraph(
        "The promise is not kept: the valve is not the one that the controller was made for. `eha characterise`, then "
        "`eha tune`.");
  }
  if (outcome == "completed") {
    if (!error.is_string()) {
      html += paragraph(fmt::format(
          "`eha fit {0}` fits models; of a run that measured the valve `eha characterise {0}` shows the sheet.",
          folder_word(subject)));
    } else if (subject.is_constant()) {
      html += paragraph("Next: `eha read` shows whether the reading follows the rod; once it does, record again.");
    }
    return box("none", "No model in this run", html);
  }
  const std::string_view again =
      outcome == "interrupted" ? "record again, to the end" : "correct what ended the run and record again";
  html += paragraph(
      is_trial ? fmt::format("It is a controller's trial: no model is fitted to a record in closed loop.{}",
                             subject.trial_changes.empty() && is_broken && !subject.leak
                                 ? fmt::format(" `eha track {}` says what the rod showed of the valve until then.",
                                               folder_word(subject))
                                 : "")
      : !subject.record || subject.record->output.size() == 0
          ? "The run ended before its first row: there is nothing to fit or to draw. Correct what ended it and record "
            "again."
      : fit_of_part(subject).empty()
          ? fmt::format("Next: {}. The part before, shown below, is too short to fit.", again)
          : fmt::format("Next: {}. Only completed runs are fitted automatically; `{}` fits the part before, which is "
                        "shown below.",
                        again, fit_of_part(subject)));
  if (is_trial) {
    const std::string when = subject.trip_s() ? fmt::format(" at {} s", time_text(*subject.trip_s())) : std::string();
    const std::string first = !is_broken     ? std::string()
                              : subject.leak ? fmt::format("Next: {}; ", ident::kRepairFirst)
                                             : std::string(
                                                   "Next: correct what ended the trial, then play it again with "
                                                   "`eha track`; ");
    html += paragraph(fmt::format("{}`eha plot {}` shows it until then.",
                                  is_broken ? first : "Next: `eha track` plays it again; ", folder_word(subject)));
    return box("none",
               is_broken ? fmt::format("The trial tripped{}: the promise is not kept", when)
                         : std::string("The trial was stopped: nothing is judged"),
               html);
  }
  if (has_tripped(subject)) {
    return box("none",
               subject.trip_s() ? fmt::format("The run tripped at {} s: no model", time_text(*subject.trip_s()))
                                : std::string("The run tripped: no model"),
               html);
  }
  return box("none",
             fmt::format("No model: the run ended as \"{}\"",
                         outcome.is_string() ? outcome.get<std::string>() : std::string("unknown")),
             html);
}

/// Why the run of the record ended before its time; empty for one that completed, and without a run.
std::string early_end(const Subject& subject) {
  const ordered_json& outcome = subject.part("outcome");
  if (!outcome.is_string() || record::is_whole(outcome.get<std::string>())) return {};
  const ordered_json& description = subject.part("report", "description");
  std::string end = description.is_string() ? description.get<std::string>() : std::string();
  const std::string word = outcome.get<std::string>();
  // "interrupted by a stop request" needs no "interrupted" before it.
  if (!end.starts_with(word)) end = end.empty() ? word : word + ": " + end;
  return paragraph(fmt::format("The run did not complete ({}); the models are of the part that was recorded.", end));
}

/// Before the name of a model in the heading: that the run tripped, and when.
std::string of_part(const Subject& subject) {
  if (!has_tripped(subject)) return {};
  return fmt::format("The run tripped{}; of the part before: ",
                     subject.trip_s() ? fmt::format(" at {} s", time_text(*subject.trip_s())) : "");
}

}  // namespace

std::string verdict(const Subject& subject) {
  if (subject.models.empty()) return without_models(subject);
  const ReportedModel& main = subject.models.front();
  const Grade grade = main.model.verdict ? main.model.verdict->grade : Grade::rejected;
  const std::string graded = std::string(ident::text(grade));
  std::string reason =
      subject.reason.empty() ? "" : paragraph("Reason: " + subject.reason + (subject.reason.ends_with('.') ? "" : "."));
  const std::string ended = early_end(subject);
  if (subject.reason.find("AR-BIC") != std::string::npos) {
    reason += paragraph(
        "AR-BIC weighs error against number of parameters; lower is better, and a difference of 10 is clear.");
  }
  if (subject.part("identification", "recommendation", "needs_fresh_record") == true) {
    reason += paragraph(
        "The validation part took part in this choice. Only another record shows how well the model predicts: record "
        "again and use `eha validate`.");
  }
  const ordered_json& accepted = subject.part("identification", "recommendation", "accepted_instead");
  if (accepted.is_string()) reason += paragraph(fmt::format("Not rejected: {}.", accepted.get<std::string>()));
  if (subject.has_recommendation) {
    return box("some",
               fmt::format("{} {} ({})", has_tripped(subject) ? of_part(subject) + "model" : "Recommended model:",
                           main.model.name, graded),
               ended + of_accepted(subject, main, reason) + remarks_on_record(main.model));
  }
  if (subject.next_step().first == ident::FirstStep::look_at_sensor) {
    const auto still = std::find_if(subject.models.begin(), subject.models.end(), [](const ReportedModel& reported) {
      return reported.model.verdict && shows_no_motion(reported.model, *reported.model.verdict);
    });
    return box("none", of_part(subject) + "No model: the sensor shows no motion",
               ended + list({still->model.verdict->reasons.front()}) + next_of_none(subject));
  }
  if (grade == Grade::rejected) {
    const std::vector<std::string> none;
    const std::vector<std::string>& reasons = main.model.verdict ? main.model.verdict->reasons : none;
    // The reason why none is recommended may begin the list.
    const bool is_listed =
        !reasons.empty() && subject.reason.find(ident::statement_of(reasons.front())) != std::string::npos;
    std::string html = ended + (is_listed ? "" : reason);
    // The first reason with what to do, which tends to mend the others, too.
    const std::vector<std::string> others(reasons.begin() + (reasons.empty() ? 0 : 1), reasons.end());
    if (main.model.verdict) {
      std::vector<std::string> shown(reasons.begin(), reasons.end() - static_cast<std::ptrdiff_t>(others.size()));
      for (const std::string& other : others) shown.push_back(ident::in_few_words(other));
      html += paragraph(fmt::format("The nearest one, {}, is {} for this:", main.model.name,
                                    ident::verdict_word(*main.model.verdict))) +
              list(shown);
    }
    return box("none", of_part(subject) + (has_tripped(subject) ? "no model can be used" : "No model can be used"),
               html + next_of_none(subject) + remarks_on_record(main.model) +
                   folded("That model, and the further reasons with figures", list(others) + of_rejected(main.model)));
  }
  const bool is_alone = subject.models.size() == 1;
  return box("some",
             fmt::format("{}{}: {} ({})", of_part(subject),
                         has_tripped(subject) ? "model"
                         : is_alone           ? "Model"
                                              : "Best model",
                         main.model.name, graded),
             ended + of_accepted(subject, main, reason) + remarks_on_record(main.model));
}

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
    const ident::Score* unseen = unseen_score(model);
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
                         {"grade"},
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
                            : "noted",  // it lowers the grade
                        name_of(criterion)});
  }
  checks.html = table(
      {{"check"}, {"value", Column::number}, {"limit", Column::number}, {"unit"}, {"result"}, {"in files"}}, criteria);
  checks.html += paragraph(
      "FAILED rejects a model, noted lowers its grade. p: probability of what was seen if the check's statement "
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
