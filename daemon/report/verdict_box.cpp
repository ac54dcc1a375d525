// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/verdict_box.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <string_view>

#include "core/capitalised.hpp"
#include "core/shell_word.hpp"
#include "core/time_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/next_text.hpp"
#include "daemon/report/section.hpp"
#include "daemon/report/sheet_comparison.hpp"
#include "ident/model/band_text.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict.hpp"
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
std::string limits_html(const Model& model) {
  const ident::Verdict& verdict = *model.verdict;
  std::vector<std::string> limits;
  for (const std::string& reason : verdict.reasons) limits.push_back(ident::in_few_words(reason));
  if (const auto also = ident::also_shown_in(model, verdict); !also.empty()) {
    limits.push_back(fmt::format("By the same cause {}.", fmt::join(also, ", ")));
  }
  if (verdict.grade == Grade::good) {
    return paragraph(limits.empty() ? "Good: it passes every check." : "Good: it passes every check. To know:") +
           list(limits);
  }
  return paragraph(limits.empty() ? "Usable: no check rejects it, but not all of them could be made."
                                  : "Usable: no check rejects it, but these findings limit its use:") +
         list(limits);
}

/// Greatest speed of a record's output, by straight lines through its rows of 0.2 s each, five at least: single rows
/// have noise.
double greatest_speed(const std::vector<double>& time_s, const std::vector<double>& output) {
  constexpr double kLine_s = 0.2;
  constexpr std::size_t kFewest = 5;
  constexpr std::size_t kStarts = 8;  // a line begins so many times in its length
  const std::size_t rows = std::min(time_s.size(), output.size());
  if (rows < kFewest) return 0.0;
  const double step_s = (time_s[rows - 1] - time_s[0]) / static_cast<double>(rows - 1);
  if (!(step_s > 0.0)) return 0.0;
  const std::size_t length = std::clamp(static_cast<std::size_t>(std::lround(kLine_s / step_s)), kFewest, rows);
  const double middle = 0.5 * static_cast<double>(length - 1);
  const double squares = static_cast<double>(length * (length * length - 1)) / 12.0;  // of k - middle
  double greatest = 0.0;
  for (std::size_t first = 0; first + length <= rows; first += std::max<std::size_t>(1, length / kStarts)) {
    double rise = 0.0;
    for (std::size_t k = 0; k < length; ++k) rise += (static_cast<double>(k) - middle) * output[first + k];
    if (std::isfinite(rise)) greatest = std::max(greatest, std::abs(rise) / squares / step_s);
  }
  return greatest;
}

/// ", in the rows of the fit, one every 40 ms": between them a peak may be higher.
std::string rows_of(const identify::FitTable& fit) {
  if (fit.time_s.size() < 2) return {};
  return fmt::format(", in the rows of the fit, one every {:.4g} ms", 1e3 * (fit.time_s[1] - fit.time_s[0]));
}

/// The amplitudes that were recorded, within which a model is known to hold; empty without the rows of the fit.
std::string recorded_sentence(const Subject& subject) {
  const identify::FitTable& fit = subject.fit;
  if (fit.applied.empty() || fit.measured.empty()) return {};
  const auto range = [](const std::vector<double>& values, const std::string& unit) {
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    return fmt::format("{:.3g} to {:.3g}{}", *least, *greatest, ident::after_number(unit));
  };
  const std::string& unit = fit.output.unit;
  return fmt::format("{}, {}, up to {:.2g}{}{}.", range(fit.applied, fit.input.unit), range(fit.measured, unit),
                     greatest_speed(fit.time_s, fit.measured), unit.empty() ? " per s" : " " + unit + "/s",
                     rows_of(fit));
}

std::string band_sentence(const ReportedModel& reported) {
  const auto band = reported.usable_band();
  if (!band) {
    return "Usable band: none, as " + ident::no_band_text(reported.model.verdict.value_or(ident::Verdict{})) + ".";
  }
  const std::string text =
      (band->lowest_Hz < band->highest_Hz ? "Usable from " : "Usable at ") + ident::frequencies_text(*band);
  const auto& criteria = reported.model.verdict->criteria;
  const bool misses_input = std::any_of(criteria.begin(), criteria.end(), [](const ident::Criterion& c) {
    return c.kind == ident::CriterionKind::residual_input && has_failed(c);
  });
  return text + ": there the record shows gain and phase well enough" +
         (misses_input ? ", as far as noise goes; they can be off by what the model misses."
                       : ", as far as noise goes.");
}

/// How far off the model is predicted to be on a fresh input; empty where that is little, or not known.
std::string predicted_sentence(const Model& model) {
  const auto& criteria = model.verdict->criteria;
  const bool is_much = std::any_of(criteria.begin(), criteria.end(), [](const ident::Criterion& c) {
    return c.kind == ident::CriterionKind::predicted_error && has_failed(c);
  });
  if (!is_much || !model.validation || !model.validation->tests || !model.validation->tests->error) return {};
  const auto [lower, upper] = *model.validation->tests->error;
  return fmt::format(
      " Under a fresh input of the same kind expect it to be off by {:.2g} to {:.2g} % of how far the output moves "
      "(its standard deviation).",
      lower, upper);
}

/// A sentence, or several, behind the word that says what they are of.
std::string labelled(const char* what, const std::string& sentences) {
  return fmt::format("<p><strong>{}.</strong> {}</p>\n", what, with_code(sentences));
}

/// HTML that is closed until its heading is clicked.
std::string folded(const char* heading, const std::string& html) {
  return fmt::format("<details>\n<summary>{}</summary>\n{}</details>\n", escaped(heading), html);
}

/// What an accepted model is, how far to trust it and what to do next, then folded how that is known.
std::string of_accepted(const Subject& subject, const ReportedModel& reported, const std::string& reason) {
  const Model& model = reported.model;
  const std::optional<SheetComparison> sheet = model.input_map ? compare_with_sheet(subject, model) : std::nullopt;
  const bool has_changed = sheet && !sheet->headline.empty();
  std::string html = has_changed ? "<p><strong>" + escaped(sheet->headline) + "</strong></p>\n" : std::string();
  if (subject.leak && model.input_map) {
    html += "<p><strong>" + with_code(leak_finding(*subject.leak, subject.unit)) + "</strong></p>\n";
  }
  if (!subject.fit.time_s.empty()) {
    html += paragraph(fmt::format("From {} to {}:", axis_label(subject.fit.input), axis_label(subject.fit.output)));
  }
  html += equation(model) + labelled("Error", error_sentence(model) + predicted_sentence(model)) +
          labelled("Band", band_sentence(reported));
  if (const std::string recorded = recorded_sentence(subject); !recorded.empty())
    html += labelled("Recorded", recorded);
  // As the terminal has it. A leak, which is said above, moves them too.
  if (const std::string note = ident::map_note(model, subject.sheet_says); !note.empty() && !subject.leak) {
    html += "<p><strong>" + with_code(capitalised(note)) + ".</strong></p>\n";
  }
  html += limits_html(model) + paragraph(next_steps(subject, reported, has_changed));
  std::string why = list(model.verdict->reasons);
  if (const std::string sight = sight_of(model, *model.verdict); !sight.empty()) why += paragraph(sight);
  if (const std::string scores = scores_sentence(model); !scores.empty()) why += paragraph(scores);
  return html + folded("How that is known, with figures, and what to do", why + reason);
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

/// ", 3.04 s of 50.8 s"; empty where it is not known.
std::string length_of_part(const Subject& subject) {
  const ordered_json& rows = subject.part("samples_per_repetition");
  const ordered_json& repetitions = subject.part("repetitions");
  const ordered_json& step_s = subject.part("sample_period_s");
  if (!subject.record || !rows.is_number() || !repetitions.is_number() || !step_s.is_number()) return {};
  const double whole_s = rows.get<double>() * repetitions.get<double>() * step_s.get<double>();
  return fmt::format(", {:.3g} s of {:.3g} s",
                     static_cast<double>(subject.record->output.size()) * subject.record->step_s, whole_s);
}

/// Why the run of the record ended before its time; empty for one that completed, and without a run.
std::string early_end(const Subject& subject) {
  const ordered_json& outcome = subject.part("outcome");
  if (!outcome.is_string() || record::is_whole(outcome.get<std::string>())) return {};
  const ordered_json& description = subject.part("report", "description");
  std::string end = description.is_string() ? description.get<std::string>() : std::string();
  if (subject.cause) end = record::without_remedy(end);
  const std::string word = outcome.get<std::string>();
  // "interrupted by a stop request" needs no "interrupted" before it.
  if (!end.starts_with(word)) end = end.empty() ? word : word + ": " + end;
  return (subject.cause ? paragraph(capitalised(identify::sentence_of(*subject.cause, subject.unit)) + ".") : "") +
         paragraph(fmt::format("The run did not complete ({}); the models are of the part that was recorded{}.", end,
                               length_of_part(subject)));
}

/// Before the name of a model in the heading: that the run tripped, and when.
std::string of_part(const Subject& subject) {
  if (!has_tripped(subject)) return {};
  return fmt::format("The run tripped{}; of the part before: ",
                     subject.trip_s() ? fmt::format(" at {} s", time_text(*subject.trip_s())) : "");
}

}  // namespace

std::string box(const char* kind, const std::string& heading, const std::string& html) {
  return fmt::format("<section class=\"verdict {}\"><h2>{}</h2>\n{}</section>\n", kind, escaped(heading), html);
}

namespace {

/// The heading of a box about models that must not be used: of a run none of its models is left, of files no more is
/// known than of those.
std::string heading_of_none(const Subject& subject, const std::string& word) {
  if (!subject.is_of_files()) {
    return of_part(subject) + (has_tripped(subject) ? "no model can be used" : "No model can be used");
  }
  if (subject.models.size() > 1) return "None of these models can be used";
  return fmt::format("This model, {}, is {}", subject.models.front().model.name, word);
}

/// Which model is recommended of all of the record, where it is none of those that the report is of.
std::string beside_html(const Subject& subject) {
  if (!subject.beside) return {};
  const RecommendedBeside& best = *subject.beside;
  return paragraph(fmt::format("Of all models of this record in that folder {} ({}) is recommended: `eha report {}`.",
                               best.model, best.word, on_one_line(shell_word(best.file))));
}

/// Why a model must not be used, each remedy once: the first one tends to mend the rest, too. A reason with figures in
/// brackets stands in few words, and its whole is folded.
std::vector<std::string> shown_reasons(const std::vector<std::string>& reasons, std::vector<std::string>& folded) {
  std::vector<std::string> shown;
  std::set<std::string> remedies;
  for (const std::string& reason : reasons) {
    const std::string few = ident::in_few_words(reason);
    const bool has_figures = few != ident::statement_of(reason) + ".";
    const bool is_new = remedies.insert(reason.substr(std::min(reason.find(';'), reason.size()))).second;
    const bool is_whole = shown.empty() || (is_new && !has_figures);
    shown.push_back(is_whole ? reason : few);
    if (!is_whole && has_figures) folded.push_back(reason);
  }
  return shown;
}

}  // namespace

std::string verdict(const Subject& subject) {
  if (subject.models.empty()) return without_models(subject);
  const ReportedModel& main = subject.models.front();
  const Grade grade = main.model.verdict ? main.model.verdict->grade : Grade::rejected;
  const bool is_alone = subject.models.size() == 1;
  const std::string graded(main.model.verdict ? ident::verdict_word(*main.model.verdict) : ident::text(grade));
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
               ended + beside_html(subject) + of_accepted(subject, main, reason) + remarks_on_record(main.model));
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
    std::vector<std::string> others;
    if (main.model.verdict) {
      html += paragraph(subject.is_of_files() && is_alone
                            ? std::string("For this:")
                            : fmt::format("The nearest one, {}, is {} for this:", main.model.name, graded)) +
              list(shown_reasons(reasons, others));
    }
    return box("none", heading_of_none(subject, graded),
               html + beside_html(subject) + next_of_none(subject) + remarks_on_record(main.model) +
                   folded(others.empty() ? "That model in figures" : "That model, and the further reasons with figures",
                          list(others) + of_rejected(main.model)));
  }
  return box("some",
             fmt::format("{}{}: {} ({})", of_part(subject),
                         has_tripped(subject) ? "model"
                         : is_alone           ? "Model"
                                              : "Best model",
                         main.model.name, graded),
             ended + beside_html(subject) + of_accepted(subject, main, reason) + remarks_on_record(main.model));
}

}  // namespace eha::report
