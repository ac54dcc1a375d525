// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/compared_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "ident/statistics/distributions.hpp"
#include "ident/statistics/robust.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::batch {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kFewestForTrends = 10;

/// Computes the distances from which on an estimate is an outlier.
void set_half_widths(std::vector<Parameter>& parameters) {
  std::size_t comparisons = 0;
  for (const Parameter& parameter : parameters) comparisons += parameter.estimates.size();
  for (Parameter& parameter : parameters) {
    const std::size_t count = parameter.estimates.size();
    if (count < kFewestForOutliers) continue;
    std::vector<double> distances;
    for (const Estimate& one : parameter.estimates) distances.push_back(one.value - parameter.median);
    const double spread = ident::robust_std(std::move(distances));
    const double share = kOutlierLevel / (2.0 * static_cast<double>(comparisons));
    const double t = ident::student_exceeded(share, static_cast<double>(count - 1));
    for (Estimate& one : parameter.estimates) one.half_width = t * std::max(one.std, spread);
  }
}

/// What a row's model says of one compared number.
struct Estimated {
  std::string name;
  std::string unit;
  Estimate estimate;  ///< without the row
};

/// @param p  a parameter of the model with value and standard error   @param at_rest  its figure at rest in its place
Estimated estimated(const Json& model, const Json& p, bool at_rest) {
  const std::string name = p.at("name");
  if (at_rest && model.at(kAtRest).contains(name)) {
    const Json& figure = model.at(kAtRest).at(name);
    const double value = figure.at("value");
    const double std = figure.at("std");
    const double half_width = ident::kInterval95 * std;
    return {figure.at("name"),
            figure.at("unit"),
            {.value = value, .std = std, .lower95 = value - half_width, .upper95 = value + half_width}};
  }
  const double value = p.at("value");
  const auto end_of = [&](const char* key) { return p.at(key).is_number() ? p.at(key).get<double>() : value; };
  return {name,
          model.value("parameter_units", Json::object()).value(name, std::string()),
          {.value = value, .std = p.at("std"), .lower95 = end_of("lower95"), .upper95 = end_of("upper95")}};
}

}  // namespace

const Json* model_of(const Json& fit, const std::string& name) {
  if (!fit.is_object()) return nullptr;
  for (const Json& model : fit.at("models")) {
    if (model.at("name") == name) return &model;
  }
  return nullptr;
}

bool is_accepted(const Json& model) {
  const auto verdict = model.find("verdict");
  return verdict == model.end() || verdict->value("accepted", true);
}

std::vector<std::size_t> rows_in_other_units(const std::vector<Row>& rows, const std::string& model) {
  std::optional<Json> units;
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Json* found = model_of(rows[i].fit, model);
    if (found == nullptr || !is_accepted(*found)) continue;
    const Json own = found->value("units", Json());
    if (!units) units = own;
    if (own != *units) others.push_back(i);
  }
  return others;
}

std::vector<Parameter> parameters_of(const std::vector<Row>& rows, const std::string& model) {
  std::vector<Parameter> parameters;
  const std::vector<std::size_t> others = rows_in_other_units(rows, model);
  std::vector<std::pair<std::size_t, const Json*>> compared;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Json* found = model_of(rows[i].fit, model);
    const bool is_left_out =
        found == nullptr || !is_accepted(*found) || std::find(others.begin(), others.end(), i) != others.end();
    if (!is_left_out) compared.emplace_back(i, found);
  }
  const bool at_rest =
      std::all_of(compared.begin(), compared.end(), [](const auto& one) { return one.second->contains(kAtRest); });
  for (const auto& [row, found] : compared) {
    for (const Json& p : found->at("parameters")) {
      const std::string name = p.at("name");
      if (p.at("fixed") == true || name == "initial_output" || !p.at("value").is_number() || !p.at("std").is_number()) {
        continue;
      }
      const Estimated one = estimated(*found, p, at_rest);
      auto place =
          std::find_if(parameters.begin(), parameters.end(), [&](const auto& known) { return known.name == one.name; });
      if (place == parameters.end()) {
        place = parameters.insert(place, {.name = one.name, .unit = one.unit, .estimates = {}});
      }
      place->estimates.push_back(one.estimate);
      place->estimates.back().row = row;
    }
  }
  for (Parameter& parameter : parameters) {
    std::vector<double> values;
    for (const Estimate& one : parameter.estimates) values.push_back(one.value);
    parameter.median = ident::median_of(std::move(values));
  }
  set_half_widths(parameters);
  return parameters;
}

std::vector<Resolution> mark_outliers(std::vector<Row>& rows, const std::string& model) {
  std::vector<Resolution> resolutions;
  for (const Parameter& parameter : parameters_of(rows, model)) {
    if (parameter.estimates.size() < kFewestForOutliers) continue;
    Resolution resolution{.parameter = parameter.name, .median = parameter.median, .unit = parameter.unit};
    double furthest = -1.0;
    for (const Estimate& one : parameter.estimates) {
      const double half_width = one.half_width;
      const double distance = std::abs(one.value - parameter.median);
      if (resolution.change <= 0.0 || half_width < resolution.change) {
        resolution.change = half_width;
        resolution.change_row = one.row;
      }
      if (half_width > 0.0 && distance > furthest) {
        furthest = distance;
        resolution.furthest_row = one.row;
        resolution.furthest = one.value;
        resolution.furthest_change = half_width;
      }
      if (distance > half_width) {
        rows[one.row].outliers.push_back({parameter.name, one.value, parameter.median, half_width, parameter.unit});
      }
    }
    if (furthest >= 0.0) resolutions.push_back(resolution);
  }
  return resolutions;
}

std::vector<Trend> trends_of(const std::vector<Parameter>& parameters) {
  std::vector<Trend> trends;
  const double share = kOutlierLevel / (2.0 * static_cast<double>(std::max<std::size_t>(1, parameters.size())));
  const double threshold = ident::normal_exceeded(share);
  for (const Parameter& parameter : parameters) {
    const std::vector<Estimate>& seen = parameter.estimates;
    if (seen.size() < kFewestForTrends) continue;
    std::vector<double> slopes;
    double balance = 0.0;  // pairs that rise less pairs that fall
    for (std::size_t i = 0; i < seen.size(); ++i) {
      for (std::size_t k = i + 1; k < seen.size(); ++k) {
        const double rise = seen[k].value - seen[i].value;
        balance += rise > 0.0 ? 1.0 : rise < 0.0 ? -1.0 : 0.0;
        slopes.push_back(rise / static_cast<double>(seen[k].row - seen[i].row));
      }
    }
    const auto n = static_cast<double>(seen.size());
    const double std = std::sqrt(n * (n - 1.0) * (2.0 * n + 5.0) / 18.0);
    if (std::abs(balance) - 1.0 <= threshold * std) continue;
    trends.push_back({parameter.name,
                      ident::median_of(std::move(slopes)) * static_cast<double>(seen.back().row - seen.front().row),
                      parameter.unit});
  }
  return trends;
}

}  // namespace eha::batch
