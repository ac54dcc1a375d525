// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/plot/figure.hpp"
#include "daemon/report/subject.hpp"

namespace eha::report {

/// Remark beside a plot: one sentence each, as text.
struct Remark {
  std::string seen;   ///< meaning in this record
  std::string good;   ///< appearance of a good one
  std::string to_do;  ///< action to take
};

/// One plot with its remark, or HTML alone.
struct Item {
  std::string heading;
  std::optional<plot::Figure> figure = {};
  Remark remark = {};
  std::string html = {};  ///< below the plot
  bool folded = false;    ///< closed until its heading is clicked; printed open
};

/// A part of a report. Without items it is left out.
struct Section {
  std::string title;
  std::vector<Item> items = {};
  bool folded = false;  ///< as of an item
};

// Sections in the order of the page. Each is empty if the subject has no data for it.
[[nodiscard]] Section time_section(const Subject& subject);
[[nodiscard]] Section models_section(const Subject& subject);
[[nodiscard]] Section frequency_section(const Subject& subject);
[[nodiscard]] Section step_section(const Subject& subject);
[[nodiscard]] Section stability_section(const Subject& subject);
[[nodiscard]] Section residual_section(const Subject& subject);
[[nodiscard]] Section valve_section(const Subject& subject);
[[nodiscard]] Section parameter_section(const Subject& subject);
[[nodiscard]] Section other_models_section(const Subject& subject);
[[nodiscard]] Section paper_section(const Subject& subject);
[[nodiscard]] Section timing_section(const Subject& subject);
[[nodiscard]] Section manifest_section(const Subject& subject);

/// Returns the first part of the page, as HTML: the model to use, or the reason why there is none.
[[nodiscard]] std::string verdict(const Subject& subject);

}  // namespace eha::report
