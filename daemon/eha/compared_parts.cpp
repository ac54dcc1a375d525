// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/compared_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "ident/model/difference_text.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {

using ident::ParameterChange;

std::string table_of(const report::ComparedSubject& first, const report::ComparedSubject& subject, Shows shows) {
  const ident::Model& model = subject.model;
  std::vector<std::vector<std::string>> rows;
  for (const ParameterChange& p : subject.change->parameters) {
    const ident::DifferenceText text = ident::difference_text(p.after - p.before, p.half_width);
    rows.push_back({p.name, ident::value_text(p.name, p.before, first.model, text.resolution),
                    ident::value_text(p.name, p.after, model, text.resolution), text.difference, text.half_width,
                    ident::unit_of(p, model), report::change_word(subject, p.changed)});
  }
  if (const identify::LeftOver& e = subject.left_over; e.before > 0.0) {
    rows.push_back({"left over, rms", fmt::format("{:.3g}", e.before), fmt::format("{:.3g}", e.after),
                    fmt::format("{:.3g}", e.after - e.before), fmt::format("x {:g}", identify::kOtherLeftOver),
                    model.output_unit, report::left_over_word(subject)});
    if (subject.first_model_error > 0.0) {
      rows.push_back({"of the first model", fmt::format("{:.3g}", e.before),
                      fmt::format("{:.3g}", subject.first_model_error),
                      fmt::format("{:.3g}", subject.first_model_error - e.before),
                      fmt::format("x {:g}", ident::kGreatestErrorOverRefit), model.output_unit,
                      report::first_model_word(subject)});
    }
  }
  return text_table({{"parameter"},
                     {"before", Align::right},
                     {"after", Align::right},
                     {"difference", Align::right},
                     {"joint +-", Align::right},
                     {"unit"},
                     {shows == Shows::change ? "changed" : "differs"}},
                    rows);
}

void add_changes(std::vector<std::string>& sentences, const std::string& name, const ident::PlantChange& change,
                 const ident::Model& model, Shows shows) {
  for (const ParameterChange& p : change.parameters) {
    if (p.changed) sentences.push_back(name + ": " + change_sentence(p, model, shows));
  }
  if (const std::string unit = ident::unit_instead(change); !unit.empty()) sentences.push_back(name + ": " + unit);
}

std::optional<std::pair<double, double>> input_range(const ident::Record& record) {
  if (record.input.size() == 0) return std::nullopt;
  return std::pair(record.input.minCoeff(), record.input.maxCoeff());
}

void add_to_do(Compared& out, const std::vector<const ident::PlantChange*>& changes, std::size_t source,
               std::string_view then, report::MapCause found,
               const std::function<std::string(const std::string&)>& complete) {
  std::string advice = report::advice_on(changes, found, then);
  if (advice.empty()) return;
  if (complete) advice = complete(advice);
  out.text += "To do: " + wrapped(advice, 7) + "\n";
  out.changed_source = source;
  out.changes_valve =
      std::any_of(changes.begin(), changes.end(), [](const auto* change) { return report::changes_valve(*change); });
}

std::string grade_of(const ident::Model& model) {
  return std::string(model.verdict ? ident::verdict_word(*model.verdict) : kNoGrade);
}

}  // namespace eha::cli
