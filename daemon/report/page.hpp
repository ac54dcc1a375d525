// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/report/section.hpp"
#include "daemon/suggest/commands.hpp"

namespace eha::report {

/// A report as one HTML page: no other file, no script, nothing from the network. It prints on A4.
struct Page {
  std::string html;
  std::vector<std::string> missing = {};  ///< plots that could not be drawn, one sentence each
};

/// Renders a page of sections, each plot with its remark; leaves out a section without items. What is folded is closed
/// until a reader opens it. Its last line says when it was written, by which version.
/// @param title      text @param lead_html  first part, as HTML
/// @param rig  how its commands reach the rig; none: as they stand
/// Cost: some 0.2 s, nearly all of it gnuplot's. If gnuplot is missing or fails, the page has no plots.
[[nodiscard]] Page assembled(const std::string& title, const std::string& lead_html,
                             const std::vector<Section>& sections, const std::optional<suggest::RigAccess>& rig = {});

}  // namespace eha::report
