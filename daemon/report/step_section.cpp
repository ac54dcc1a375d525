// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/section.hpp"

namespace eha::report {

Section step_section(const Subject& subject) {
  Section section{.title = "Step response"};
  std::vector<const ident::Model*> shown;
  for (const ReportedModel* reported : subject.pictured()) shown.push_back(&reported->model);
  if (shown.empty()) return section;
  Item item{.heading = "Output and speed after " + step_text(*shown.front())};
  try {
    item.figure = step_figure(shown, item.heading);
    item.remark.seen = step_sentence(*shown.front());
  } catch (const ConfigError&) {
    return section;  // no step: more zeros than poles
  }
  if (item.figure->panels.front().shades.empty()) {
    item.remark.good = shown.size() > 1 ? "Both models agree."
                                        : "As the plant answers a step: at rest in the end, or moving on at one speed.";
    item.remark.to_do = "Nothing.";
  } else {
    item.remark.good = shown.size() > 1
                           ? "Both models agree outside the hatched part, which is faster than the usable band."
                           : "The lag takes longer than the hatched part, which is faster than the usable band.";
    item.remark.to_do =
        "For a controller that reacts within the hatched part, excite higher frequencies (`eha design`) and fit again.";
  }
  section.items.push_back(std::move(item));
  return section;
}

}  // namespace eha::report
