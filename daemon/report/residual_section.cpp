// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "daemon/report/advice.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/section.hpp"
#include "ident/validation/lags_note.hpp"

namespace eha::report {
namespace {

/// Whether the verdict has more to say than that the model is good.
bool has_note(const ident::Verdict& verdict) {
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(),
                     [](const ident::Criterion& c) { return has_failed(c); });
}

Remark remark_on_residual(const Subject& subject, const ident::Model& model) {
  const ident::ValidationReport& validation = *model.validation;
  Remark remark;
  remark.seen = fmt::format(
      "Residual of {} with itself: {} of {} lags outside the 99 % bound. With the input, at lags 0 "
      "and more: {} of {}.",
      model.name, outside99(validation.acf, 1), validation.acf.lags.empty() ? 0 : validation.acf.lags.size() - 1,
      outside99(validation.ccf, 0), validation.ccf.lags.size() / 2 + 1);
  if (validation.tests) {
    remark.seen += fmt::format(
        " Joint tests: p = {:.2g} for the input, p = {:.2g} for what an autoregression of these "
        "rows alone, of order {}, leaves of the residual.",
        validation.tests->input.p, validation.tests->whiteness.p, validation.tests->ar_order);
  }
  if (model.verdict) {
    if (const std::string note = ident::lags_note(model, *model.verdict); !note.empty()) remark.seen += " " + note;
  }
  remark.good =
      "The input's correlation stays within its bounds (p above 0.01): the model misses nothing that the input causes. "
      "A residual that is correlated with itself alone is coloured noise or drift and no fault of the model; the "
      "intervals allow for it.";
  const bool passes = model.verdict && !has_note(*model.verdict);
  const std::string known = passes ? "" : against_error(model);
  remark.to_do = known.empty() ? nothing_to_do(subject) : known;
  return remark;
}

}  // namespace

Section residual_section(const Subject& subject) {
  Section section{.title = "Residual"};
  if (subject.models.empty()) return section;
  const ident::Model& model = subject.models.front().model;
  if (!model.validation || model.validation->acf.lags.empty() || model.validation->ccf.lags.empty()) return section;
  Item item{.heading = "Correlation of the residual of " + model.name + " with itself and with the input"};
  item.figure = {.title = item.heading,
                 .panels = {correlation_panel(model.validation->acf, "with itself"),
                            correlation_panel(model.validation->ccf, "with the input")}};
  item.remark = remark_on_residual(subject, model);
  section.items.push_back(std::move(item));
  return section;
}

}  // namespace eha::report
