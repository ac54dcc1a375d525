// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/capitalised.hpp"
#include "daemon/eha/compared_parts.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/identify/compared_records.hpp"
#include "daemon/report/better_model.hpp"
#include "daemon/report/change_causes.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict.hpp"

// The answer on models that are compared without a record.

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Whether two models, named without a record, are of one plant, and what differs.
std::string pair_text(const report::ComparedSubject& first, const report::ComparedSubject& subject,
                      bool is_one_record) {
  if (is_one_record) return "two models of one record, so of one plant";
  if (!subject.cannot_tell.empty()) return "Not shown whether the plant has changed: " + subject.cannot_tell;
  if (subject.change->parameters.empty())
    return "Not shown whether the plants differ: no parameter of both is estimated";
  if (first.model.name != subject.model.name) {
    return fmt::format("Not shown whether the plants differ: the structures do, {} and {}, and each has its own values",
                       first.model.name, subject.model.name);
  }
  return subject.change->changed ? report::outcome(first, subject)
                                 : "The same plant, as far as the models show: no parameter changed";
}

/// The models by their errors on the part of their one record that estimated none of them; none where these parts may
/// differ.
std::optional<std::vector<report::RankedModel>> ranked_on_unseen_data(const std::vector<ident::Model>& models,
                                                                      const std::vector<std::string>& titles) {
  const auto rows = [](const ident::Model& model) -> std::string {
    const bool is_known = model.validation && model.estimation && model.estimation->information;
    return is_known ? fmt::format("{} {}", model.estimation->information->record, model.validation->score.samples) : "";
  };
  std::vector<report::RankedModel> ranked;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const std::string known = rows(models[i]);
    if (known.empty() || known != rows(models.front())) return std::nullopt;
    ranked.push_back({.label = titles[i],
                      .rms_error = std::sqrt(models[i].validation->score.mse),
                      .parameters = report::estimated_parameters(models[i]),
                      .but = grade_of(models[i]) == kRejected ? std::string(kRejected) : ""});
  }
  return ranked;
}

/// "io_valve, usable, rms error 0.00213 in on the unseen data of its own record".
std::string fit_text(const ident::Model& model) {
  const std::string grade = grade_of(model);
  return model.name + (grade == kNoGrade ? "" : ", " + grade) +
         (model.validation ? fmt::format(", rms error {} on the unseen data of its own record",
                                         ident::error_text(std::sqrt(model.validation->score.mse), model.output_unit))
                           : "");
}

}  // namespace

Compared described(const std::vector<ident::Model>& models, const std::vector<std::string>& files) {
  Compared out;
  Json entries = Json::array();
  const double level = ident::kFalseAlarm / static_cast<double>(models.size() - 1);
  const std::vector<std::string> titles = report::titles_of(files);
  out.models.emplace_back(titles.front(), &models.front());
  out.subjects.push_back({.label = titles.front(), .model = models.front()});
  out.findings.title = "Comparison of models";
  out.findings.is_alike = true;
  std::vector<ident::PlantChange> changes;
  std::string found;
  for (std::size_t i = 1; i < models.size(); ++i) {
    const ident::PlantChange change = ident::without_other_units(
        ident::compare_parameters(models.front(), models[i], level), models.front(), models[i]);
    out.models.emplace_back(titles[i], &models[i]);
    out.subjects.push_back({.label = titles[i], .model = models[i], .change = change});
    out.findings.is_alike = out.findings.is_alike && !change.changed;
    const bool are_of_one_record = is_one_record(record_of(models.front()), record_of(models[i]));
    const bool tells_plants = !are_of_one_record && models.front().name == models[i].name;
    const Shows shows = tells_plants ? Shows::change : Shows::difference;
    const double shift =
        std::max(ident::noted_shift(models.front()).value_or(0.0), ident::noted_shift(models[i]).value_or(0.0));
    const bool is_bent = tells_plants && identify::explains_valve(shift, change);
    const std::string bent = fmt::format(
        "null and dead band of such fits may be up to {:.2g} {} off the valve's, as where oil leaks past the piston or "
        "friction bends the edges, which alone explains their change; compare the runs, or two valve sheets",
        shift, models[i].input_unit);
    if (is_bent && ident::is_of_dead_zone_alone(change)) out.subjects.back().cannot_tell = bent;
    const std::string says = pair_text(out.subjects.front(), out.subjects.back(), are_of_one_record);
    add_changes(out.findings.sentences, titles[i], change, models[i], shows);
    if (are_of_one_record) {
      out.findings.sentences.push_back(titles[i] +
                                       ": of the same record as the first, so it describes the same plant.");
    }
    if (i == 1) out.findings.heading = says;
    if (models.size() > 2) found += fmt::format("{} and {}: {}\n", titles.front(), titles[i], says);
    if (!change.parameters.empty() || !change.other_unit.empty()) found += change_lines(change, models[i], shows);
    if (!change.parameters.empty()) found += table_of(out.subjects.front(), out.subjects.back(), shows);
    if (is_bent) {
      found += capitalised(bent) + "\n";
      out.findings.sentences.push_back(capitalised(bent) + ".");
    }
    entries.push_back({{"file", files[i]}, {"change", change_json(change, models[i])}});
    if (is_bent) entries.back()["map_shift"] = shift;
    if (tells_plants && out.subjects.back().cannot_tell.empty()) changes.push_back(change);
  }
  out.findings.is_one_plant = std::all_of(models.begin() + 1, models.end(), [&](const ident::Model& model) {
    return is_one_record(record_of(models.front()), record_of(model));
  });
  if (out.findings.is_one_plant) {
    out.findings.heading = "Models of one record, so of one plant";
    if (const auto ranked = ranked_on_unseen_data(models, titles)) {
      out.findings.heading +=
          fmt::format("; on unseen data {}", report::better_model(*ranked, models.front().output_unit));
    }
  } else if (models.size() > 2) {
    out.findings.heading = out.findings.is_alike ? "No difference of a parameter found" : "The parameters differ";
  }
  out.text = out.findings.heading + "\n";
  for (std::size_t i = 0; i < files.size(); ++i) {
    out.text += fmt::format("{} {}: {}\n", i == 0 ? "before" : "after ", files[i], fit_text(models[i]));
  }
  out.text += found;
  std::vector<const ident::PlantChange*> changed;
  for (const ident::PlantChange& change : changes) changed.push_back(&change);
  if (const std::string advice = report::advice_on(changed, report::MapCause::unknown, report::kUntilKnown);
      !advice.empty()) {
    out.text += "To do: " + wrapped(advice, 7) + "\n";
  }
  out.text += "Which describes a record better: name the record, too (eha compare MODEL MODEL RECORD).\n";
  out.document = {{"schema", "eha-comparison/1"}, {"first", files.front()}, {"models", std::move(entries)}};
  return out;
}

}  // namespace eha::cli
