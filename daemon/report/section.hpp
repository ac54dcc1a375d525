// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/plot/figure.hpp"
#include "daemon/report/subject.hpp"

namespace eha::report {

/// The note beside a plot: one sentence each, as text.
struct Remark {
  std::string seen;   ///< in this record
  std::string good;   ///< how a good one looks
  std::string to_do;  ///< now
};

/// One plot with its remark, or HTML alone.
struct Item {
  std::string heading;
  std::optional<plot::Figure> figure = {};
  Remark remark = {};
  std::string html = {};  ///< below the plot
};

/// A part of a report. Without items it is left out.
struct Section {
  std::string title;
  std::vector<Item> items = {};
};

// The sections in the order of the page. Each is empty where the subject has nothing for it.
[[nodiscard]] Section time_section(const Subject& subject);
[[nodiscard]] Section models_section(const Subject& subject);
[[nodiscard]] Section frequency_section(const Subject& subject);
[[nodiscard]] Section step_section(const Subject& subject);
[[nodiscard]] Section stability_section(const Subject& subject);
[[nodiscard]] Section residual_section(const Subject& subject);
[[nodiscard]] Section valve_section(const Subject& subject);
[[nodiscard]] Section parameter_section(const Subject& subject);
[[nodiscard]] Section paper_section(const Subject& subject);
[[nodiscard]] Section timing_section(const Subject& subject);
[[nodiscard]] Section manifest_section(const Subject& subject);

/// The first thing on the page, as HTML: what to use, or why nothing.
[[nodiscard]] std::string verdict(const Subject& subject);

}  // namespace eha::report
