// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/table_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/parameter_change.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::batch {
namespace {

using Json = nlohmann::ordered_json;

/// "0001-sim, 0003-b and 4 more".
std::string names_of(const Table& table, const std::vector<std::size_t>& rows) {
  constexpr std::size_t kMostListed = 8;
  std::string names;
  for (std::size_t i = 0; i < std::min(rows.size(), kMostListed); ++i) {
    names += (i == 0 ? "" : ", ") + table.rows[rows[i]].label;
  }
  return rows.size() <= kMostListed ? names : names + fmt::format(" and {} more", rows.size() - kMostListed);
}

}  // namespace

std::string other_units_text(const Table& table) {
  return names_of(table, rows_in_other_units(table.rows, table.common_model));
}

std::string grade_note(const Table& table) {
  const auto has = [&](std::string_view grade) {
    return std::any_of(table.rows.begin(), table.rows.end(), [&](const Row& row) { return grade_of(row) == grade; });
  };
  if (!has("good") || !has("usable")) return {};
  return "A verdict is about what the tests can see beside the noise of its record: the model of a noisy record may be "
         "good where that of a clean one, with a smaller error, is usable.";
}

std::string warning_text(const Table& table, const WarningKind& kind) {
  return fmt::format("{} of {} {} ({}): {}", kind.rows.size(), table.rows.size(),
                     table.rows.size() == 1 ? "record" : "records", names_of(table, kind.rows), kind.text);
}

std::string outlier_text(const Outlier& outlier) {
  const auto with_unit = [&](const char* format, double value) {
    return fmt::format(fmt::runtime(format), value) + ident::after_number(outlier.unit);
  };
  return fmt::format("{} is {}, more than {} from the median of all, {}", outlier.parameter,
                     with_unit("{:.4g}", outlier.value), with_unit("{:.2g}", outlier.half_width),
                     with_unit("{:.4g}", outlier.median));
}

std::string instead_text(const Row& row, const std::string& common_model) {
  std::vector<std::string> changed;
  for (const Outlier& one : row.outliers) changed.push_back(one.parameter);
  bool has_map = false;
  for (const Json& model : row.fit.value("models", Json::array())) {
    has_map = has_map || (model.at("name") == common_model && model.contains("input_map"));
  }
  const auto is_of_map = [](const std::string& name) {
    return name == "null" || name == "dead_band" || name == "negative_gain_ratio";
  };
  std::vector<std::string> causes;
  std::vector<std::string> followers;
  for (const std::string& name : changed) (is_of_map(name) ? causes : followers).push_back(name);
  if (has_map && !causes.empty() && !followers.empty()) return ident::either_follows(causes, followers);
  return ident::map_instead(changed, has_map);
}

RowFigures figures_of(const Json& fit, const std::string& recommended) {
  RowFigures figures;
  if (!fit.is_object()) return figures;
  for (const Json& found : fit.value("models", Json::array())) {
    if (found.at("name") != recommended) continue;
    try {
      const ident::Model model = ident::model_from_text(found.dump(), recommended);
      // Where nothing was left unseen, the figures are those of the samples that estimated.
      if (!model.validation && !model.estimation) break;
      const ident::Score& score = model.validation ? model.validation->score : model.estimation->score;
      figures.fit_percent = ident::percent_text(score.fit_percent, 1);
      // The greatest error of the samples that estimated is not kept.
      const double greatest = std::max(std::abs(score.error_min), std::abs(score.error_max));
      figures.error = model.validation ? fmt::format("{:.3g} {}", greatest, model.output_unit)
                                       : fmt::format("{:.3g} {} (rms)", std::sqrt(score.mse), model.output_unit);
      figures.form = ident::engineering_form(model);
    } catch (const Error&) {  // of another version
    }
    break;
  }
  return figures;
}

std::string why_none(const Row& row) {
  if (!row.judged || row.recommended != "none") return {};
  const auto found = row.fit.find("recommendation");
  if (found == row.fit.end() || !found->is_object()) return {};
  const auto reason = found->find("reason");
  return reason != found->end() && reason->is_string() ? reason->get<std::string>() : std::string();
}

std::string what_limits(const Row& row) {
  if (!row.judged) return {};
  for (const nlohmann::ordered_json& model : row.fit.at("models")) {
    if (model.value("name", "") != row.recommended || !model.contains("verdict")) continue;
    const auto& verdict = model.at("verdict");
    if (verdict.value("grade", "") != "usable" || !verdict.contains("reasons") || verdict.at("reasons").empty())
      return {};
    const auto reason = verdict.at("reasons").front().get<std::string>();
    // What could not be judged is nothing that was found.
    return reason.starts_with("Not judged") ? std::string() : ident::statement_of(reason);
  }
  return {};
}

std::string spread_text(const Table& table, const Resolution& one) {
  const std::string unit = ident::after_number(one.unit);
  const std::string& furthest = table.rows[one.furthest_row].label;
  const std::string in_furthest = one.furthest_row == one.change_row
                                      ? ""
                                      : fmt::format(", and of {:.2g}{} in {}", one.furthest_change, unit, furthest);
  return fmt::format(
      "{}: median {:.4g}{}, furthest from it {:.4g} ({}); a change of {:.2g}{} or more would have been seen in {}, the "
      "most precise record{}",
      one.parameter, one.median, unit, one.furthest, furthest, one.change, unit, table.rows[one.change_row].label,
      in_furthest);
}

std::string change_text(const Trend& trend) {
  return fmt::format("{} by {:.3g}{}", trend.change > 0.0 ? "rises" : "falls", std::abs(trend.change),
                     ident::after_number(trend.unit));
}

}  // namespace eha::batch
