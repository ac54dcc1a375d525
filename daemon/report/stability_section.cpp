// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/display_unit.hpp"
#include "daemon/report/advice.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"
#include "ident/fractional/poles.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/criterion.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::report {
namespace {

constexpr double kSlow = 2.0;  // duration of a record that shows a pole, in time constants of the pole
constexpr double kSmallMargin_rad = 0.1;

/// Time constant of the slowest pole [s]; infinite for an integrator, 0 without a pole.
double slowest_s(const ident::Poles& poles) {
  if (poles.order_at_zero > 0.0) return std::numeric_limits<double>::infinity();
  double slowest = 0.0;
  for (const auto& value : poles.values) {
    if (std::abs(value) > 0.0) slowest = std::max(slowest, std::pow(std::abs(value), -1.0 / poles.base_order));
  }
  return slowest;
}

Remark remark_on(const Subject& subject, const ident::Model& model) {
  const ident::Poles poles = ident::with_rounded_at_zero(ident::poles(model.transfer_function));
  const ident::StabilityReport stability =
      model.stability ? *model.stability : ident::stability(model.transfer_function);
  const double limit_deg = 90.0 * poles.base_order;
  Remark remark;
  const std::string figures = ident::engineering_form(model, ident::half_width_sign(model, "±"));
  remark.seen =
      !figures.empty()
          ? fmt::format("{}: {} (T of a real pole, f0 and damping D of a pair; unstable is the right half).",
                        model.name, figures)
      : poles.is_commensurate
          ? fmt::format("{} has {} pole{} in the plane of w = s^{:.4g}; unstable is |arg w| below {:.4g} deg.",
                        model.name, poles.values.size(), poles.values.size() == 1 ? "" : "s", poles.base_order,
                        limit_deg)
          : fmt::format("{} has {} pole{} on the principal sheet of s; unstable is |arg s| below 90 deg.", model.name,
                        poles.values.size(), poles.values.size() == 1 ? "" : "s");
  remark.seen += fmt::format(" It is {}, with a margin of {:.3g} deg of s.", stability.stable ? "stable" : "not stable",
                             stability.margin_rad * kDegrees);
  if (!poles.is_complete) remark.seen += " Not every pole could be located; the margin counts them all.";
  remark.good = fmt::format(
      "No cross within the shaded sector, and a margin above {:.2g} deg. Each circle has its f0 beside it; the "
      "distances are logarithmic.",
      kSmallMargin_rad * kDegrees);
  const double slowest = slowest_s(poles);
  const double duration_s = subject.fit.time_s.empty() ? 0.0 : subject.fit.time_s.back() - subject.fit.time_s.front();
  if (poles.order_at_zero > 0.0 && stability.margin_rad > -1e-9) {
    const std::string integrates =
        is_length(model.output_unit)
            ? "The pole at 0 is the integration from valve opening to position, as an open hydraulic cylinder has it"
            : "The pole at 0 integrates: after a step of the input the output never comes to rest. Take the model only "
              "for a plant that does so";
    // A model may be rejected for something else.
    const bool is_allowed =
        model.verdict &&
        (model.verdict->accepted ||
         std::any_of(model.verdict->criteria.begin(), model.verdict->criteria.end(), [](const auto& c) {
           return c.kind == ident::CriterionKind::stability_margin && c.judged && c.passed;
         }));
    const bool is_damped = !(stability.margin_rad > 1e-9 && stability.margin_rad < kSmallMargin_rad);
    remark.to_do =
        is_allowed && !is_damped
            ? "A pole beside that at 0 is lightly damped: check its resonance against the measured response. " +
                  integrates + "."
        : is_allowed ? nothing_to_do(subject) + " " + integrates + ", and the limits of [acceptance] allow it."
                     : integrates + ". Accept it with require_stable = false in [acceptance].";
  } else if (!stability.stable) {
    remark.to_do =
        "Do not simulate with it over long times. An unstable model of a rig that is stable comes from drift or "
        "a bias that was not estimated" +
        (named_in_box(model).empty() ? ": record longer." : ": " + named_in_box(model));
  } else if (duration_s > 0.0 && slowest > kSlow * duration_s) {
    remark.to_do = fmt::format(
        "The slowest pole has a time constant of {:.3g} s, the record lasts {:.3g} s: it cannot tell "
        "this pole from an integrator. If that matters, record longer.",
        slowest, duration_s);
  } else {
    remark.to_do = stability.margin_rad < kSmallMargin_rad
                       ? "It is lightly damped: check the resonance against the measured response."
                       : nothing_to_do(subject);
  }
  return remark;
}

}  // namespace

Section stability_section(const Subject& subject) {
  Section section{.title = "Stability"};
  for (const ReportedModel* reported : subject.pictured()) {
    section.items.push_back({.heading = "Poles of " + reported->model.name + " and the stability sector",
                             .figure = pole_figure(reported->model),
                             .remark = remark_on(subject, reported->model)});
  }
  return section;
}

}  // namespace eha::report
