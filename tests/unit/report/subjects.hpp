// SPDX-License-Identifier: GPL-3.0-or-later
// Models and records for the tests of reports.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "daemon/report/report.hpp"
#include "ident/model/model.hpp"

namespace eha::report {

inline ident::Model model_named(const std::string& name, ident::Grade grade, double r2_percent) {
  ident::Model model;
  model.name = name;
  model.transfer_function = {{{0.13, 0.0}}, {{0.0132, 2.0}, {1.0, 1.0}, {0.0028, 0.0}}, 0.0};
  model.parameters = {{.name = "K", .value = 0.13, .std = 0.001, .lower95 = 0.128, .upper95 = 0.132},
                      {.name = "a0", .value = 0.0028, .std = 0.003, .lower95 = 0.0, .upper95 = 0.012}};
  model.estimation.emplace().score = {.r2_percent = 99.0, .samples = 50};
  ident::ValidationReport& validation = model.validation.emplace();
  validation.score = {
      .r2_percent = r2_percent, .mse = 1e-4, .fit_percent = 90.0, .error_min = -0.05, .error_max = 0.04, .samples = 50};
  validation.acf = {{0, 1, 2}, {1.0, 0.5, 0.1}, 0.2, 0.3};
  validation.ccf = {{-1, 0, 1}, {0.1, 0.5, 0.1}, 0.2, 0.3};
  model.verdict =
      ident::Verdict{.accepted = grade != ident::Grade::rejected,
                     .reasons = {"The error <exceeds> its \"limit\" & more."},
                     .grade = grade,
                     .criteria = {{ident::CriterionKind::r2, "validation", r2_percent, 90.0, r2_percent > 90.0}}};
  return model;
}

inline Subject subject_of(const std::string& name, ident::Grade grade) {
  Subject subject{.name = name};
  subject.models.push_back({model_named("io", grade, 99.0), "models/io.json"});
  subject.fit = {.input = {"voltage", "V"},
                 .output = {"displacement", "in"},
                 .time_s = {},
                 .applied = {},
                 .measured = {},
                 .models = {{"io", {}}}};
  for (int i = 0; i < 100; ++i) {
    subject.fit.time_s.push_back(0.04 * i);
    subject.fit.applied.push_back(std::sin(0.1 * i));
    subject.fit.measured.push_back(std::cos(0.1 * i));
    subject.fit.models[0].simulated.push_back(std::cos(0.1 * i) + 0.01);
  }
  return subject;
}

inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++found;
  return found;
}

}  // namespace eha::report
