// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/report/section.hpp"

namespace eha::report {

/// A report as one HTML page: no other file, no script, nothing from the network. It prints on A4.
struct Page {
  std::string html;
  std::vector<std::string> missing = {};  ///< plots that could not be drawn, one sentence each
};

/// A page of sections, each plot beside its remark; a section without items is left out.
/// @param title      text @param lead_html  what stands first, as HTML
/// Cost: some 0.2 s, nearly all of it gnuplot's. A missing or failing gnuplot leaves the page without the plots.
[[nodiscard]] Page assembled(const std::string& title, const std::string& lead_html,
                             const std::vector<Section>& sections);

}  // namespace eha::report
