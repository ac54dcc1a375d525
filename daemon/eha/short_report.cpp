// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/short_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/equation.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/model_list.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/record/own_file.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/suggest/commands.hpp"
#include "ident/model/band_text.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_name.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

using ident::Model;
using ident::Score;

constexpr std::size_t kMostReasons = 3;
constexpr double kAlike = 0.1;  // difference of errors that are alike, share
// Least change of the fit by a new offset that is reported [%].
constexpr double kSameFit = 0.1;

std::string line(const char* label, const std::string& text) {
  return fmt::format("{:<{}}{}\n", label, kLabelWidth, wrapped(text, kLabelWidth));
}

/// Whether a part of the record did not estimate the model.
bool has_unseen(const Model& model) { return model.validation.has_value(); }

/// Scores on the validation part, or on all samples if there is none.
std::optional<Score> shown_score(const Model& model) {
  if (has_unseen(model)) return model.validation->score;
  return model.estimation ? std::optional(model.estimation->score) : std::nullopt;
}

std::string fit_text(const Model& model) {
  const auto score = shown_score(model);
  if (!score) return "no figures";
  std::string text = fmt::format("fit {} %, R2 {} %", ident::percent_text(score->fit_percent, 1),
                                 ident::percent_text(score->r2_percent));
  if (!has_unseen(model)) {
    const bool rests = model.verdict && model.verdict->judging_part_rests;
    return text + (rests ? "; the part that would judge is at rest" : "; nothing was left unseen (--split 1)");
  }
  const auto& again = model.validation->offset_reestimated;
  if (again && std::abs(again->fit_percent - score->fit_percent) > kSameFit) {
    text += fmt::format(" (fit {:.1f} % with the offset estimated anew)", again->fit_percent);
  }
  return text;
}

std::optional<double> largest_error(const Model& model) {
  const auto score = shown_score(model);
  if (!score) return std::nullopt;
  return std::max(std::abs(score->error_min), std::abs(score->error_max));
}

/// Null if there is none.
const ident::FrequencyInterval* band_of(const Model& model) {
  return model.verdict && model.verdict->usable_band ? &*model.verdict->usable_band : nullptr;
}

std::string band_text(const Model& model) {
  const ident::FrequencyInterval* band = band_of(model);
  return band ? ident::frequencies_text(*band, " .. ")
              : "none: " + ident::no_band_text(model.verdict.value_or(ident::Verdict{}));
}

std::string grade_text(const Model& model) {
  return model.verdict ? std::string(ident::verdict_word(*model.verdict)) : "-";
}

/// The clauses of a reason that fit into three lines, at least one.
std::string brief(const std::string& reason, Reasons shown) {
  constexpr std::size_t kMost = 3 * (kPrintedWidth - kLabelWidth) - 12;  // lines break before a word
  constexpr std::string_view kMore = "; -v gives more";
  const auto clause_end = [&](std::size_t from) {
    return std::min({reason.find("; ", from), reason.find(", and ", from), reason.size()});
  };
  if (reason.size() <= kMost || shown == Reasons::all) return reason;
  std::size_t end = clause_end(0);
  while (end < reason.size() && clause_end(end + 1) + kMore.size() <= kMost) end = clause_end(end + 1);
  return end == reason.size() ? reason : reason.substr(0, end).append(kMore);
}

/// The first reason in full, two others without what to do; or all of them in full.
std::string reasons_of(const Model& model, Reasons shown) {
  std::string text;
  const std::vector<std::string> none;
  std::vector<std::string> reasons = model.verdict ? model.verdict->reasons : none;
  std::erase(reasons, ident::cancelling_sentence(model));  // which stands beside the figures
  const bool is_all = shown == Reasons::all;
  const std::size_t count = is_all ? reasons.size() : std::min(reasons.size(), kMostReasons);
  for (std::size_t i = 0; i < count; ++i)
    text += line(i == 0 ? "because" : "", i == 0 || is_all ? reasons[i] : ident::statement_of(reasons[i]) + ".");
  if (reasons.size() > count) text += line("", fmt::format("and {} more; -v gives all", reasons.size() - count));
  if (model.verdict && (is_all || reasons.size() < kMostReasons)) {
    if (const std::string sight = ident::sight_of(model, *model.verdict); !sight.empty())
      text += line(reasons.empty() ? "because" : "", sight);
  }
  return text;
}

/// Returns a sentence without its numbers.
std::string without_figures(const std::string& sentence) {
  std::string words;
  for (const char c : sentence) {
    if (std::string_view("0123456789.-+").find(c) == std::string_view::npos) words += c;
  }
  return words;
}

/// Writes the reasons for which each model is rejected. A reason that several models share except for its figures
/// appears once, after their names. @param given  already, and left out
std::string reasons_by_model(const std::vector<Model>& models, const std::string& given) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;
  for (const Model& model : models) {
    if (!model.verdict || model.verdict->reasons.empty()) continue;
    const std::string& reason = model.verdict->reasons.front();
    if (without_figures(reason) == without_figures(given)) continue;
    auto at = std::find_if(groups.begin(), groups.end(),
                           [&](const auto& group) { return without_figures(group.first) == without_figures(reason); });
    if (at == groups.end()) at = groups.insert(groups.end(), {reason, {}});
    at->second.push_back(model.name);
  }
  std::string text;
  for (const auto& [reason, names] : groups) {
    const bool fits = names.size() == 1 && names.front().size() < kLabelWidth;
    text += fits ? line(names.front().c_str(), reason)
                 : line(names.size() == 1 ? "" : fmt::format("{} models", names.size()).c_str(),
                        fmt::format("{}{}: {}", fmt::join(names, ", "),
                                    names.size() == 1 ? "" : " (figures of the first)", reason));
  }
  return text;
}

/// "null -0.1002 +- 0.0015 V; half dead band 0.1485 +- 0.0021 V", half the 95 % intervals of the map's parameters.
std::string map_text(const Model& model) {
  std::string text;
  for (const ident::ParameterEstimate& p : model.parameters) {
    if (!ident::is_of_map(p.role) || p.fixed) continue;
    if (&p == ident::unfound_dead_band(model)) {
      // A half width beside a value that is greater would say that one is found.
      text += fmt::format("{}no {} is found ({}{})", text.empty() ? "" : "; ", ident::shown_name(p.role, p.name),
                          ident::interval_text(p), ident::after_number(ident::unit_of(p, model)));
      continue;
    }
    const double half_width = 0.5 * (p.upper95 - p.lower95);
    const bool is_known = half_width > 0.0 && std::isfinite(half_width);
    text += fmt::format("{}{} {}{}", text.empty() ? "" : "; ", ident::shown_name(p.role, p.name),
                        is_known ? ident::with_half_width(p.value, half_width, ident::half_width_sign(model, "+-"))
                                 : fmt::format("{:.4g} (the record gives no interval)", p.value),
                        ident::after_number(ident::unit_of(p, model)));
  }
  return text;
}

/// What the intervals of a valve's null and dead band do not hold; empty where the map says more of them.
std::string map_caution(const Model& model) {
  const bool has_interval = std::any_of(model.parameters.begin(), model.parameters.end(), [](const auto& p) {
    using Role = ident::ParameterRole;
    return (p.role == Role::valve_null || p.role == Role::dead_band) && !p.fixed && p.upper95 > p.lower95;
  });
  if (!has_interval || model.input_unit != "V" || ident::unfound_dead_band(model)) return {};
  if (const std::string run = record_of(model); record::is_run_folder(run)) {
    const record::SheetBeside sheet = record::sheet_beside(run);
    if (sheet.valve && !sheet.leak && sheet.valve->is_one_with(model.input_map->null, model.input_map->dead_band)) {
      return fmt::format(
          "the newest valve sheet beside the run has a null of {:.4f} V and a half dead band of {:.4f} V: take those "
          "for the valve's",
          sheet.valve->zone.null_V, sheet.valve->zone.dead_band_V);
    }
  }
  if (const std::optional<double> shift = ident::noted_shift(model); shift && !ident::is_one_way(*model.input_map)) {
    const auto& test = model.validation->tests ? model.validation->tests->nonlinearity : std::nullopt;
    const bool is_of_level = test && test->test.p < ident::kNonlinearLevel && ident::is_of_bent_edges(model, *test);
    return fmt::format(
        "each may be up to {:.2g} V off the valve's, beside dry friction more{}, whatever its interval says: `eha "
        "characterise` measures them",
        *shift, is_of_level ? ", or there is no dead band and the gain grows with the opening" : "");
  }
  if (!ident::map_note(model).empty()) return {};
  constexpr double kSlow_Hz = 0.1;  // as of a triangle that measures a valve
  if (model.verdict && model.verdict->usable_band && model.verdict->usable_band->highest_Hz < kSlow_Hz) {
    return "null and dead band +- this record's noise; of so slow a motion they are the rod's: what dry friction "
           "takes, "
           "if there is any, stands in the dead band";
  }
  return "null and dead band +- this record's noise; friction and the structure shift them further: "
         "`eha characterise` measures them";
}

std::string what_it_is(const Model& model) {
  std::string text = line("recommended", fmt::format("{} ({})", model.name, grade_text(model)));
  text += line("equation", equation(model, 1.0, model.output_unit));
  if (const std::string form = ident::engineering_form(model, ident::half_width_sign(model, "+-")); !form.empty())
    text += line("in figures", form);
  if (const std::string pair = ident::cancelling_sentence(model); !pair.empty()) text += line("", pair);
  if (const std::string map = map_text(model); !map.empty()) text += line("valve map", map);
  if (const std::string caution = map_caution(model); !caution.empty()) text += line("", caution);
  text += line(has_unseen(model) ? "on unseen data" : "on its own data", fit_text(model));
  if (const auto error = largest_error(model))
    text += line("largest error", ident::error_text(*error, model.output_unit));
  return text + line("usable band", band_text(model));
}

std::ptrdiff_t estimated_count(const Model& model) {
  return std::count_if(model.parameters.begin(), model.parameters.end(), [](const auto& p) { return !p.fixed; });
}

/// "errs as little", or "errs 0.55 times as much on unseen data".
std::string errs_beside(const Model& other, const Model& chosen) {
  const double factor = std::sqrt(ident::shown_mse(other) / ident::shown_mse(chosen));
  if (std::abs(factor - 1.0) <= kAlike) return "errs as little";
  return fmt::format("errs {} times as much (rms{})", ident::figure_text(factor),
                     has_unseen(chosen) ? ", on unseen data" : "");
}

/// Why a model that errs less on unseen data than the recommended one is outdone by it; empty for any other model.
std::string why_outdone(const Model& other, const Model& chosen) {
  if (!other.verdict || ident::verdict_word(*other.verdict) != ident::kOutdone) return {};
  if (!(std::sqrt(ident::shown_mse(other) / ident::shown_mse(chosen)) < 1.0 - kAlike)) return {};
  const std::ptrdiff_t more = estimated_count(other) - estimated_count(chosen);
  return more > 0 ? fmt::format("for its {} parameter{} more", more, more == 1 ? "" : "s")
                  : std::string("by the estimating part");
}

/// The same behind the name of the model.
std::string outdone_note(const Model& other, const Model& chosen) {
  const std::string why = why_outdone(other, chosen);
  if (why.empty()) return {};
  return estimated_count(other) > estimated_count(chosen)
             ? fmt::format(" (outdone {}, which the part of the record that estimated it does not justify)", why)
             : " (outdone as it describes the part of the record that estimated it less well)";
}

/// The accepted model with the least error, where that is clearly less than the chosen one's.
const Model* closest(const std::vector<Model>& models, const Model& chosen) {
  const Model* best = nullptr;
  for (const Model& model : models) {
    if (!model.verdict || !model.verdict->accepted || ident::takes_in_a_drift(model)) continue;
    const double mse = ident::shown_mse(model);
    const double least =
        best == nullptr ? ident::shown_mse(chosen) / (ident::kAsWell * ident::kAsWell) : ident::shown_mse(*best);
    if (mse < least) best = &model;
  }
  return best;
}

/// The model behind a valve's map whose parameters the record does not determine, and which errs far less than a chosen
/// one without a map: the least of them.
const Model* undetermined_valve(const std::vector<Model>& models, const Model& chosen) {
  constexpr double kFarLess = 0.5;
  if (chosen.input_map) return nullptr;
  const Model* best = nullptr;
  double least = kFarLess * kFarLess * ident::shown_mse(chosen);
  for (const Model& model : models) {
    const bool is_meant = model.input_map && model.verdict && !model.verdict->accepted &&
                          ident::verdict_word(*model.verdict) == ident::kNotDetermined;
    if (!is_meant || !(ident::shown_mse(model) < least)) continue;
    least = ident::shown_mse(model);
    best = &model;
  }
  return best;
}

/// "the simplest of the 5 models, of 14, that err at most 1.5 times as much; the runner-up, lag, errs 1.3 times as much
/// on unseen data".
/// @param models  of which `chosen` is one
std::string chosen_as(const Model& chosen, const std::vector<Model>& models,
                      const ident::Recommendation& recommendation, Reasons shown) {
  if (models.size() < 2 || !(ident::shown_mse(chosen) > 0.0)) return brief(recommendation.reason, shown);
  const double most = ident::kAsWell * ident::kAsWell * ident::shown_mse(chosen);
  std::size_t alike = 0;
  bool is_simplest = true;
  const Model* next = nullptr;
  for (const Model& model : models) {
    if (ident::shown_mse(model) <= most) {
      ++alike;
      is_simplest = is_simplest && estimated_count(chosen) <= estimated_count(model);
    }
    if (model.name == recommendation.runner_up) next = &model;
  }
  std::string text =
      alike < 2 ? fmt::format("the one of {} models that describes the record", models.size())
      : is_simplest
          ? fmt::format("the simplest of the {} models, of {}, that err at most {:g} times as much", alike,
                        models.size(), ident::kAsWell)
          : fmt::format(
                "of the {} models, of {}, that err at most {:g} times as much, the one that says most with its "
                "parameters",
                alike, models.size(), ident::kAsWell);
  const bool is_only_one = std::none_of(models.begin(), models.end(), [&](const Model& model) {
    return model.name != chosen.name && model.verdict && model.verdict->accepted;
  });
  if (is_only_one) text += "; the checks let no other one pass";
  if (next != nullptr) {
    const std::string word = next->verdict && next->verdict->accepted ? "" : fmt::format(" ({})", grade_text(*next));
    text += fmt::format("; the runner-up, {}{}{}, {}{}", next->name, word, outdone_note(*next, chosen),
                        ident::shown_mse(*next) > most ? "is none of them: it " : "", errs_beside(*next, chosen));
  }
  if (const Model* other = closest(models, chosen)) {
    text += other == next ? ": take that to simulate"
                          : fmt::format("; {}{} {}: take that to simulate", other->name, outdone_note(*other, chosen),
                                        errs_beside(*other, chosen));
  }
  if (const Model* behind_valve = undetermined_valve(models, chosen)) {
    text += fmt::format(
        "; {} {}, so a valve's dead band or unequal gains are likely, which this input has too few "
        "levels to measure: record one of more levels, as a slow triangle",
        behind_valve->name, errs_beside(*behind_valve, chosen));
  }
  // One that errs clearly more on unseen data is told apart by that.
  const bool is_alike = next == nullptr || ident::shown_mse(*next) <= most;
  if (alike > 1 && recommendation.is_unclear && is_alike) {
    text += "; " + unclear_choice(recommendation) + ": record longer where the choice matters";
  }
  return text;
}

std::string why_it_is_recommended(const Model& model, const std::vector<Model>& models,
                                  const ident::Recommendation& recommendation, Reasons shown) {
  std::string text = line("chosen as", chosen_as(model, models, recommendation, shown));
  if (recommendation.validation_chose) {
    text += line("", "The validation part took part in the choice: confirm it on another record.");
  }
  return text + reasons_of(model, shown);
}

std::vector<std::string> row_for(const Model& model, const std::string& name) {
  const auto score = shown_score(model);
  const auto error = largest_error(model);
  const ident::FrequencyInterval* band = band_of(model);
  return {name,
          score ? ident::percent_text(score->fit_percent, 1) : "-",
          score ? ident::percent_text(score->r2_percent) : "-",
          error ? ident::error_figure(*error) : "-",
          band == nullptr                      ? "-"
          : band->lowest_Hz < band->highest_Hz ? fmt::format("{:.2g}..{:.2g}", band->lowest_Hz, band->highest_Hz)
                                               : fmt::format("{:.2g}", band->lowest_Hz),
          grade_text(model)};
}

/// Converts every length of the answer to the unit, also in the sentence of a model that the recommendation quotes at
/// its end.
Answer shown_answer(Answer answer, const DisplayUnit& unit) {
  for (std::vector<Model>* models : {&answer.models, &answer.paper}) {
    for (Model& model : *models) {
      Model shown = in_unit(model, unit);
      answer.recommendation.reason = requoted(std::move(answer.recommendation.reason), model, shown);
      model = std::move(shown);
    }
  }
  return answer;
}

}  // namespace

Answer answer_of(const identify::Identification& identification) {
  Answer answer;
  for (const auto& one : identification.models) answer.models.push_back(one.result.model);
  for (const auto& one : identification.paper) answer.paper.push_back(one.result.model);
  answer.recommendation = identification.recommendation;
  return answer;
}

Answer answer_of_run(const std::filesystem::path& folder, const record::Manifest& manifest) {
  Answer answer;
  if (!manifest.identification) return answer;
  const record::IdentificationEntry& entry = *manifest.identification;
  for (const record::ModelEntry& model : entry.models) {
    const std::filesystem::path file = record::listed_file(folder, model.file);
    answer.models.push_back(ident::model_from_text(os::read_file(file), file.string()));
  }
  if (entry.paper_procedure) {
    for (const auto& model : *entry.paper_procedure) {
      answer.paper.push_back(ident::model_from_text(model.dump(), (folder / "run.json").string()));
    }
  }
  if (entry.recommendation) answer.recommendation = *entry.recommendation;
  return answer;
}

bool print_answer(const std::filesystem::path& folder, const record::Manifest& manifest, const Console& console) {
  const std::vector<record::ModelEntry> models = record::models_of(manifest);
  if (models.empty()) return false;
  try {
    console.print(suggest::completed(
        short_report(answer_of_run(folder, manifest), console.unit(record::rig_units(manifest.other)),
                     console.verbose() ? Reasons::all : Reasons::first),
        suggest::with_fit_of(console.rig(), folder.string())));
    std::size_t rejected = 0;
    for (const record::ModelEntry& model : models) {
      const std::filesystem::path file = folder / model.file;
      if (!model.accepted && !console.verbose()) {
        ++rejected;
      } else {
        console.print(fmt::format("file     {}", file.string()));
      }
    }
    if (rejected > 0) {
      const std::string words = words_of_rejected(answer_of_run(folder, manifest).models);
      console.print(fmt::format("files    {} {} in {}{}", rejected, rejected == 1 ? "model" : "models",
                                (folder / record::kModelsFolder / record::kRejectedFolder).string(),
                                words.empty() ? "" : ": " + words));
    }
  } catch (const Error& error) {
    console.warning(error.what());
    print_model_list(models, console);
  }
  return true;
}

std::string words_of_rejected(const std::vector<Model>& models) {
  std::vector<std::pair<std::string_view, std::size_t>> counts;
  for (const Model& model : models) {
    if (!model.verdict || model.verdict->accepted) continue;
    const std::string_view word = ident::verdict_word(*model.verdict);
    const auto known =
        std::find_if(counts.begin(), counts.end(), [&](const auto& count) { return count.first == word; });
    if (known == counts.end()) {
      counts.emplace_back(word, 1);
    } else {
      ++known->second;
    }
  }
  std::string text;
  for (const auto& [word, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, word);
  return text;
}

std::string recommendation_text(const Answer& given, const DisplayUnit& unit) {
  return ident::sentence(shown_answer(given, unit).recommendation);
}

std::string answer_text(const Answer& given, const DisplayUnit& unit) {
  const Answer answer = shown_answer(given, unit);
  for (const Model& model : answer.models) {
    if (model.name == answer.recommendation.model) return what_it_is(model);
  }
  return {};
}

std::string short_report(const Answer& given, const DisplayUnit& unit, Reasons reasons) {
  if (given.models.empty() && given.paper.empty()) return {};
  const Answer answer = shown_answer(given, unit);
  std::string text;
  const ident::Recommendation& recommendation = answer.recommendation;
  const auto chosen = std::find_if(answer.models.begin(), answer.models.end(),
                                   [&](const Model& model) { return model.name == recommendation.model; });
  if (chosen != answer.models.end()) {
    text += what_it_is(*chosen) + why_it_is_recommended(*chosen, answer.models, recommendation, reasons);
  } else {
    text += line("recommended", "none");
    bool others_err_alike = false;
    if (!recommendation.reason.empty()) {
      // What lies in the record comes with what to do.
      const auto of_record = std::find_if(answer.models.begin(), answer.models.end(), [&](const Model& model) {
        return model.verdict && !model.verdict->reasons.empty() &&
               model.verdict->reasons.front() == recommendation.reason + ".";
      });
      const bool is_of_record = of_record != answer.models.end();
      // A drift keeps every structure from following, and leads their advice astray.
      others_err_alike = is_of_record && ident::wanders(*of_record, *of_record->verdict);
      text += line("because", is_of_record ? recommendation.reason + "." : brief(recommendation.reason, reasons));
    }
    if (!recommendation.accepted_instead.empty()) text += line("not rejected", recommendation.accepted_instead);
    if (!others_err_alike) text += reasons_by_model(answer.models, recommendation.reason);
  }
  const std::string& output_unit = (answer.models.empty() ? answer.paper : answer.models).front().output_unit;
  std::vector<std::vector<std::string>> rows;
  const std::vector<Model> models =
      ident::in_table_order(answer.models, recommendation, [](const Model& model) -> const Model& { return model; });
  for (const Model& model : models) {
    rows.push_back(row_for(model, model.name));
    const std::string why = chosen == answer.models.end() ? std::string() : why_outdone(model, *chosen);
    if (!why.empty()) rows.back().back() += " " + why;
  }
  for (const Model& model : answer.paper) rows.push_back(row_for(model, model.name + " (paper)"));
  const bool on_unseen = has_unseen((answer.models.empty() ? answer.paper : answer.models).front());
  std::string words;
  for (const std::string_view word : ident::kWordsBesideGrades) {
    if (std::none_of(rows.begin(), rows.end(), [&](const auto& row) { return row.back().starts_with(word); })) continue;
    const char* place = word == ident::kOutdone ? "" : "; in a run its file lies in models/rejected";
    words += wrapped(fmt::format("{}: {}{}.", word, ident::meaning_of(word), place), 0) + "\n";
  }
  return text + "\n" +
         text_table({{"model", Align::left},
                     {"fit %", Align::right},
                     {"R2 %", Align::right},
                     {fmt::format("largest {}", output_unit), Align::right},
                     {"band Hz", Align::right},
                     {"verdict", Align::left}},
                    rows) +
         fmt::format("fit, R2, largest error: on {}. {}Terms: eha(1)\n",
                     on_unseen ? "unseen data" : "the samples that estimated the model",
                     reasons == Reasons::all ? "" : "-v: every figure. ") +
         words;
}

}  // namespace eha::cli
