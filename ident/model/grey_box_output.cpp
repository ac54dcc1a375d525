// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/grey_box_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"

namespace eha::ident {

TransferFunction linear_form(const GreyBox& box, double delay_s) {
  const LinearForm form = box.kind->linearised(box.values);
  const double scale = form.denominator[1];
  return {{{form.gain / scale, 0.0}},
          {{form.denominator[2] / scale, 2.0}, {1.0, 1.0}, {form.denominator[0] / scale, 0.0}},
          delay_s};
}

Eigen::VectorXd grey_box_output(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& v, double step_s) {
  const GreyBox& box = model.grey_box.value();
  std::vector<double> state = model.initial_state;
  state.resize(box.kind->states, 0.0);
  const double rows_late = std::max(0.0, model.transfer_function.delay_s) / step_s;
  const auto late = static_cast<Eigen::Index>(std::min(std::floor(rows_late), static_cast<double>(v.size())));
  const double part_s = std::clamp(rows_late - static_cast<double>(late), 0.0, 1.0) * step_s;
  const auto at = [&](Eigen::Index row) { return row >= 0 ? v[row] : 0.0; };
  Eigen::VectorXd z(v.size());
  for (Eigen::Index k = 0; k < v.size(); ++k) {
    z[k] = state[0];
    if (part_s > 0.0) box.kind->advance(box.values.data(), state.data(), at(k - late - 1), part_s);
    if (part_s < step_s) box.kind->advance(box.values.data(), state.data(), at(k - late), step_s - part_s);
  }
  return z;
}

bool is_linear_form_of(const GreyBoxKind& kind, const Model& model) {
  const TransferFunction& g = model.transfer_function;
  if (model.grey_box || model.input_map || g.numerator.size() != 1 || !model.stability || !model.stability->stable) {
    return false;
  }
  std::array<double, 3> a = {};
  for (const Term& term : g.denominator) {
    const double order = std::round(term.order);
    if (std::abs(term.order - order) > 0.0 || order < 0.0 || order > 2.0) return false;
    a[static_cast<std::size_t>(order)] += term.coefficient;
  }
  if (std::abs(g.numerator.front().order) > 0.0) return false;
  const bool integrates = std::abs(a[0]) <= 0.0;
  if (!(a[2] > 0.0)) return false;
  if (kind.integrates || integrates) return kind.integrates && integrates;
  return a[1] * a[1] >= 4.0 * a[0] * a[2];
}

void require_linear(const Model& model, std::string_view why) {
  if (!model.grey_box) return;
  throw ConfigError(fmt::format("grey_box: {}, and a model of {} is none; take the model of a linear structure", why,
                                model.grey_box->kind->name));
}

}  // namespace eha::ident
