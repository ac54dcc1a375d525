// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/capitalised.hpp"
#include "daemon/eha/compared_parts.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/report/better_model.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/verdict.hpp"

// The answer on models that are held against one record.

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string plant_of(const identify::ScoredModel& scored) {
  if (!scored.refit || !scored.cannot_tell.empty()) return "unknown";
  return scored.of_another_plant ? "another" : "this";
}

/// "Both models are of this record's plant".
std::string plants_text(const std::vector<identify::ScoredModel>& scored) {
  const auto all = static_cast<std::ptrdiff_t>(scored.size());
  const auto count = [&](std::string_view plant) {
    return std::count_if(scored.begin(), scored.end(), [&](const auto& one) { return plant_of(one) == plant; });
  };
  if (const auto others = count("another"); others > 0) {
    return all == 1 ? std::string("The model is of another plant than this record")
                    : fmt::format("{} of {} models {} of another plant than this record", others, all,
                                  others == 1 ? "is" : "are");
  }
  if (count("unknown") > 0) return "Not shown whether every model is of this record's plant";
  return all == 1   ? std::string("The model is of this record's plant")
         : all == 2 ? std::string("Both models are of this record's plant")
                    : fmt::format("All {} models are of this record's plant", all);
}

}  // namespace

identify::ScoredModel converted(identify::ScoredModel scored, const DisplayUnit& unit, const std::string& output_unit) {
  const double factor = unit.factor(output_unit);
  if (scored.validation.jump) scored.validation.jump->change *= factor;
  for (ident::Score* score :
       {&scored.validation.score,
        scored.validation.offset_reestimated ? &*scored.validation.offset_reestimated : nullptr}) {
    if (score == nullptr) continue;
    score->error_min *= factor;
    score->error_max *= factor;
  }
  scored.rms_error *= factor;
  scored.output.measured *= factor;
  scored.output.simulated *= factor;
  scored.refit_rms_error *= factor;
  if (scored.change) scored.change = in_output_unit(*scored.change, factor);
  return scored;
}

Compared described(const std::vector<identify::ScoredModel>& scored, const std::vector<ident::Model>& models,
                   const std::vector<std::string>& files, const identify::Source& source) {
  Compared out;
  std::vector<std::vector<std::string>> rows;
  Json entries = Json::array();
  std::string sentences;
  const std::vector<std::string> titles = report::titles_of(files);
  std::vector<std::string> rejected;
  std::vector<std::string> jumps;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const identify::ScoredModel& one = scored[i];
    const ident::Score best = one.validation.offset_reestimated.value_or(one.validation.score);
    out.models.emplace_back(titles[i], &models[i]);
    out.subjects.push_back({.label = titles[i],
                            .model = models[i],
                            .time_s = one.output.time_s,
                            .measured = one.output.measured,
                            .simulated = one.output.simulated});
    out.subjects.back().input_range = input_range(source.record);
    const std::string grade = grade_of(models[i]);
    if (grade == kRejected) rejected.push_back(titles[i]);
    out.findings.sentences.push_back(
        fmt::format("{}: {}R2 {} %, rms error {:.3g} {}; of {} plant", titles[i],
                    grade == kNoGrade ? "" : fmt::format("{} by the fit that made it; ", grade),
                    ident::percent_text(best.r2_percent), one.rms_error, models[i].output_unit,
                    plant_of(one) == "unknown" ? "an unknown" : plant_of(one)));
    if (one.of_another_plant) {
      out.findings.sentences.back() +=
          fmt::format(": its error is {:.1f} times that of its structure fitted to the record",
                      one.rms_error / one.refit_rms_error);
      add_changes(out.findings.sentences, titles[i], *one.change, models[i], Shows::change);
    }
    if (!one.cannot_tell.empty()) {
      out.findings.sentences.push_back(
          fmt::format("{}: cannot tell whether it is of this plant: {}", titles[i], one.cannot_tell));
    }
    rows.push_back({files[i], ident::percent_text(one.validation.score.r2_percent),
                    ident::percent_text(best.r2_percent), ident::percent_text(best.fit_percent),
                    fmt::format("{:.3g}", one.rms_error),
                    fmt::format("{:.3g}", std::max(std::abs(best.error_min), std::abs(best.error_max))),
                    one.refit ? fmt::format("{:.3g}", one.refit_rms_error) : "-", plant_of(one), grade});
    Json entry{{"file", files[i]},
               {"r2_percent", one.validation.score.r2_percent},
               {"r2_reestimated_percent", best.r2_percent},
               {"fit_percent", best.fit_percent},
               {"rms_error", one.rms_error},
               {"plant", plant_of(one)},
               {"grade", grade == kNoGrade ? Json(nullptr) : Json(grade)}};
    if (one.refit) entry["refit_rms_error"] = one.refit_rms_error;
    if (const auto& jump = one.validation.jump) {
      entry["error_jump"] = {{"time_s", jump->time_s}, {"change", jump->change}};
      jumps.push_back(fmt::format("with {} the {}", titles[i], ident::jump_text(*jump, models[i].output_unit)));
    }
    if (one.change) entry["change"] = change_json(*one.change, models[i]);
    entries.push_back(std::move(entry));
    if (!one.cannot_tell.empty()) {
      entries.back()["cannot_tell"] = one.cannot_tell;
      sentences += fmt::format("{}: cannot tell whether it is of this plant: {}\n", files[i], one.cannot_tell);
    }
    if (!one.of_another_plant) continue;
    sentences += fmt::format(
        "{}: a model of another plant, although it scores R2 {} %: its error is {:.1f} times that of its structure "
        "fitted to {}\n",
        files[i], ident::percent_text(best.r2_percent), one.rms_error / one.refit_rms_error, source.name);
    sentences += change_lines(*one.change, models[i]);
  }
  out.findings.title = fmt::format("Models on {}", report::titles_of({source.name}).front());
  std::vector<const ident::PlantChange*> changes;
  for (const identify::ScoredModel& one : scored) {
    if (one.of_another_plant && one.change) changes.push_back(&*one.change);
  }
  const auto of_another =
      std::count_if(scored.begin(), scored.end(), [](const auto& one) { return one.of_another_plant; });
  const auto unknown =
      std::count_if(scored.begin(), scored.end(), [](const auto& one) { return plant_of(one) == "unknown"; });
  out.findings.heading = plants_text(scored);
  if (scored.size() > 1) {
    std::vector<report::RankedModel> ranked;
    for (std::size_t i = 0; i < models.size(); ++i) {
      ranked.push_back({.label = titles[i],
                        .rms_error = scored[i].rms_error,
                        .parameters = report::estimated_parameters(models[i]),
                        .but = grade_of(models[i]) == kRejected ? std::string(kRejected)
                               : scored[i].of_another_plant     ? "of another plant"
                               : scored[i].is_doubtful          ? "not shown to be of this plant"
                                                                : ""});
    }
    out.findings.heading += "; " + report::better_model(std::move(ranked), models.front().output_unit);
  } else if (!rejected.empty()) {
    out.findings.heading += ", but it is rejected";
  }
  if (!jumps.empty()) {
    const std::string told =
        fmt::format("{}: {}; `eha validate` names the cut", fmt::join(jumps, ", "), ident::kMakesAJump);
    out.findings.heading += "; but " + told;
    out.findings.sentences.push_back(capitalised(told) + ".");
  }
  out.findings.is_alike = of_another == 0 && unknown == 0 && rejected.empty() && jumps.empty();
  out.findings.is_one_plant = of_another == 0 && unknown == 0;
  out.findings.sentences.emplace_back(
      "Scored on the whole record with the offset estimated again; the figures of a fit are of the part that did not "
      "estimate the model, so that they differ a little.");
  out.findings.is_one_record = true;
  if (of_another > 0) {
    out.findings.to_do =
        "Use no model of another plant for this record: fit one to it, or look for what changed since the "
        "model's own record. " +
        report::causes_of(changes);
  } else if (std::all_of(scored.begin(), scored.end(), [](const auto& one) { return plant_of(one) == "this"; }) &&
             !rejected.empty()) {
    out.findings.to_do = fmt::format(
        "Do not use {}, however small the error is here: `eha report` with the models' files says why, and recommends "
        "one.",
        fmt::join(rejected, ", "));
  }
  out.text = fmt::format("{}\non {}: {} samples\n", out.findings.heading, source.name,
                         scored.front().validation.score.samples);
  out.text += text_table({{"model"},
                          {"R2 %", Align::right},
                          {"re. R2 %", Align::right},
                          {"re. fit %", Align::right},
                          {"rms error", Align::right},
                          {"largest", Align::right},
                          {"refit rms", Align::right},
                          {"plant"},
                          {"verdict"}},
                         rows);
  out.text += fmt::format(
      "re.: offset re-estimated; errors [{}]; refit: the same structure fitted to this record; verdict: by the fit "
      "that made the model\n",
      models.front().output_unit);
  out.text += sentences;
  add_to_do(out, changes, 0, "Use no such model for this record: fit one to it.");
  out.document = {{"schema", "eha-comparison/1"}, {"source", source.name}, {"models", std::move(entries)}};
  return out;
}

}  // namespace eha::cli
