// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <span>

#include "daemon/record/sha256.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"

namespace eha::report {
namespace {

using Json = nlohmann::ordered_json;
using Row = std::vector<std::string>;

/// A value as text: "amplitude_V 2; tones (0.05, 0.1)". Members without a value are left out.
std::string value_of(const Json& json) {
  if (json.is_null()) return "-";
  if (json.is_string()) return json.get<std::string>();
  if (json.is_boolean()) return json.get<bool>() ? "yes" : "no";
  if (json.is_number_float()) return fmt::format("{:.7g}", json.get<double>());
  if (!json.is_structured()) return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string text;
  for (const auto& [key, value] : json.items()) {
    if (value.is_null() || value == "") continue;
    const std::string inner = value_of(value);
    text += (text.empty()       ? ""
             : json.is_object() ? "; "
                                : ", ") +
            (json.is_object() ? key + " " : std::string()) + (value.is_structured() ? "(" + inner + ")" : inner);
  }
  return text.empty() ? "none" : text;
}

double number_of(const Json& json, double otherwise) { return json.is_number() ? json.get<double>() : otherwise; }

/// Counts by microsecond.
struct Buckets {
  std::vector<double> duration_us;
  std::vector<double> count;
};

std::optional<Buckets> buckets_of(const Json& histogram) {
  if (!histogram.is_object()) return std::nullopt;
  const Json& at = histogram.value("bucket_us", Json());
  const Json& counts = histogram.value("counts", Json());
  if (!at.is_array() || !counts.is_array() || at.size() != counts.size() || at.empty()) return std::nullopt;
  Buckets buckets;
  for (std::size_t i = 0; i < at.size(); ++i) {
    buckets.duration_us.push_back(number_of(at[i], 0.0));
    buckets.count.push_back(std::log10(std::max(1.0, number_of(counts[i], 1.0))));
  }
  return buckets;
}

plot::Figure latency_figure(const Buckets& wake_up, const std::optional<Buckets>& work) {
  const auto panel_of = [](const Buckets& buckets, const std::string& x_label) {
    plot::Panel panel{.x_label = x_label, .y_label = "log10 of ticks"};
    panel.series.push_back({.label = "", .x = buckets.duration_us, .y = {}, .mark = plot::Mark::impulses, .style = 1});
    // A single tick is still visible.
    for (const double count : buckets.count) panel.series[0].y.push_back(count + 0.1);
    panel.x_range = std::pair(-1.0, buckets.duration_us.back() + 2.0);
    panel.y_range = std::pair(0.0, 1.1 + *std::max_element(buckets.count.begin(), buckets.count.end()));
    return panel;
  };
  plot::Figure figure{.title = "Latency of the ticks", .panels = {panel_of(wake_up, "lateness of a tick [us]")}};
  if (work) figure.panels.push_back(panel_of(*work, "work of a tick [us]"));
  return figure;
}

std::string lateness_text(double us) {
  return us < 1000.0 ? fmt::format("{:.3g} us", us) : fmt::format("{:.3g} ms", 1e-3 * us);
}

Remark remark_on_timing(const Subject& subject) {
  const Json& counters = subject.part("report", "counters");
  const double late = number_of(subject.part("report", "counters", "late"), 0.0);
  const double skipped = number_of(subject.part("report", "counters", "skipped"), 0.0);
  Remark remark;
  remark.seen = fmt::format(
      "{} ticks; 99 % woke up within {}, the latest {} late. {} were late by more than half a period, {} more were "
      "skipped.",
      value_of(counters.value("ticks", Json())),
      lateness_text(number_of(subject.part("report", "latency", "p99_us"), 0.0)),
      lateness_text(number_of(subject.part("report", "latency", "max_us"), 0.0)), late, skipped);
  remark.good =
      "No tick late or skipped, 99.9 % within 50 us. The columns are logarithmic: each unit is ten times as many "
      "ticks, and the last one holds everything from 1023 us up.";
  remark.to_do = late + skipped > 0.0
                     ? "Run `eha doctor` and `eha latency --load`; the rows of skipped ticks are marked in "
                       "raw.h5 and count for nothing in fit and tests."
                     : "Nothing.";
  return remark;
}

std::string facts_table(const Subject& subject) {
  std::vector<Row> rows;
  const auto add = [&](const char* what, const std::string& value) { rows.push_back({what, value}); };
  add("run", subject.name);
  add("experiment", value_of(subject.part("experiment", "name")));
  add("rig", value_of(subject.part("rig", "name")));
  add("rig file", value_of(subject.part("rig", "file")));
  if (const Json& text = subject.part("rig", "text"); text.is_string()) {
    const std::string& content = text.get_ref<const std::string&>();
    add("rig file, SHA-256", record::sha256_of(std::as_bytes(std::span(content))));
  }
  add("outcome", value_of(subject.part("outcome")));
  add("started (UTC)", value_of(subject.part("utc_start")));
  add("ended (UTC)", value_of(subject.part("utc_end")));
  add("sample period [s]", value_of(subject.part("sample_period_s")));
  add("samples per repetition", value_of(subject.part("samples_per_repetition")));
  add("repetitions", value_of(subject.part("repetitions")));
  add("excitation", value_of(subject.part("experiment", "excitation")));
  add("record", value_of(subject.part("experiment", "record")));
  add("acceptance", value_of(subject.part("experiment", "acceptance")));
  add("device", value_of(subject.part("device")));
  add("clock", value_of(subject.part("time_base")));
  add("seeds", value_of(subject.part("seed")));
  add("counters", value_of(subject.part("report", "counters")));
  add("versions", value_of(subject.part("versions")));
  add("host", value_of(subject.part("host")));
  add("kernel", value_of(subject.part("kernel")));
  return table({{"what"}, {"value", Column::wide_text}}, rows);
}

std::string files_table(const Subject& subject) {
  std::vector<Row> rows;
  const Json& files = subject.part("files");
  if (!files.is_array()) return {};
  for (const Json& file : files) {
    if (!file.is_object()) continue;
    const std::string path = value_of(file.value("path", Json()));
    if (path == "report.html") continue;  // this page
    rows.push_back({path, value_of(file.value("bytes", Json())), value_of(file.value("sha256", Json()))});
  }
  return table({{"file"}, {"bytes", Column::number}, {"SHA-256", Column::wide_text}}, rows);
}

std::string provenance_table(const ident::Model& model) {
  std::vector<Row> rows;
  for (const auto& [key, value] : model.provenance) {
    if (key != "work") rows.push_back({key, value});  // what the search has computed, for its developers
  }
  return rows.empty() ? "" : table({{"what"}, {"value", Column::wide_text}}, rows);
}

}  // namespace

Section timing_section(const Subject& subject) {
  Section section{.title = "Timing"};
  const std::optional<Buckets> wake_up = buckets_of(subject.part("report", "latency"));
  if (!wake_up) return section;
  if (subject.part("time_base") == "virtual") {
    section.items.push_back(
        {.heading = "", .html = paragraph("The run used virtual time: its ticks have no latency.")});
    return section;
  }
  Item item{.heading = "Lateness and work of the ticks"};
  item.figure = latency_figure(*wake_up, buckets_of(subject.part("report", "execution")));
  item.remark = remark_on_timing(subject);
  section.items.push_back(std::move(item));
  return section;
}

Section manifest_section(const Subject& subject) {
  Section section{.title = "Provenance"};
  if (subject.manifest) {
    section.items.push_back({.heading = "Run", .html = facts_table(subject)});
    section.items.push_back({.heading = "Files", .html = files_table(subject)});
  }
  if (!subject.models.empty()) {
    const ident::Model& model = subject.models.front().model;
    if (std::string html = provenance_table(model); !html.empty()) {
      section.items.push_back({.heading = "Fit of " + model.name, .html = std::move(html)});
    }
  }
  return section;
}

}  // namespace eha::report
