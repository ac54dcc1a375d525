// SPDX-License-Identifier: GPL-3.0-or-later
// The box of a run without models: what was found, the figures, what to do.
#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "core/capitalised.hpp"
#include "core/time_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/next_text.hpp"
#include "daemon/report/verdict_box.hpp"

namespace eha::report {
namespace {

using nlohmann::ordered_json;

/// "The run tripped at 3.5 s"
std::string tripped_text(const Subject& subject, const char* what) {
  return fmt::format("The {} tripped{}", what,
                     subject.trip_s() ? fmt::format(" at {} s", time_text(*subject.trip_s())) : "");
}

/// How the run ended. @param is_known  its cause, which is said beside it
std::string end_of(const Subject& subject, bool is_known) {
  const ordered_json& description = subject.part("report", "description");
  if (!description.is_string() || description.get_ref<const std::string&>().empty()) return {};
  const std::string end = description.get<std::string>();
  return paragraph(is_known ? record::without_remedy(end) : end);
}

/// Ticks that came late, where any did: rows without a reading, and a reason to look at the machine first.
std::string late_ticks(const Subject& subject) {
  const auto count = [&](const char* key) {
    const ordered_json& value = subject.part("report", "counters", key);
    return value.is_number() ? value.get<std::int64_t>() : 0;
  };
  const std::int64_t late = count("late");
  const std::int64_t skipped = count("skipped");
  if (late + skipped == 0) return {};
  return paragraph(fmt::format(
      "{} of its {} ticks began late, and {} more never ran (rows without a reading): `eha doctor` and `eha latency "
      "--load` say what holds the loop up.",
      late, count("ticks"), skipped));
}

/// "The run was stopped at 30.2 s"
std::string heading_without_trip(const Subject& subject) {
  const ordered_json& outcome = subject.part("outcome");
  if (outcome != "interrupted") {
    return fmt::format("No model: the run ended as \"{}\"",
                       outcome.is_string() ? outcome.get<std::string>() : std::string("unknown"));
  }
  const bool has_rows = subject.record && subject.record->output.size() > 0;
  return fmt::format("No model: the run was stopped{}",
                     has_rows ? fmt::format(" at {} s", time_text(subject.record->step_s *
                                                                  static_cast<double>(subject.record->output.size())))
                              : "");
}

std::string box_of_trial(const Subject& subject) {
  const std::string plot = fmt::format("`eha plot {}` shows it until then.", folder_word(subject));
  if (!has_tripped(subject)) {
    return box("none", "The trial was stopped: nothing is judged",
               end_of(subject, false) + paragraph("Next: `eha track` plays it again; " + plot));
  }
  std::string html;
  if (subject.leak) html += paragraph(leak_finding(*subject.leak, subject.unit));
  if (!subject.trial_stood.empty()) html += paragraph(capitalised(subject.trial_stood) + ".");
  if (!subject.trial_changes.empty()) {
    html += paragraph("Until then the moving rod shows:") + list(subject.trial_changes);
  }
  html += end_of(subject, !subject.trial_stood.empty() || (subject.leak && !subject.trial_changes.empty()));
  html += paragraph(fmt::format("Next: {}; {}", first_after_trial(subject), plot));
  return box("none", tripped_text(subject, "trial") + ": the promise is not kept", html);
}

}  // namespace

std::string without_models(const Subject& subject) {
  if (subject.part("experiment", "track").is_string() && subject.part("outcome") != "completed") {
    return box_of_trial(subject);
  }
  const ordered_json& outcome = subject.part("outcome");
  const ordered_json& error = subject.part("identification", "error");
  std::string html;
  if (subject.cause) html += paragraph(capitalised(identify::sentence_of(*subject.cause, subject.unit)) + ".");
  if (error.is_string()) html += paragraph("The identification failed: " + error.get<std::string>());
  html += end_of(subject, subject.cause.has_value()) + late_ticks(subject);
  if (outcome == "completed") {
    if (!error.is_string()) {
      html += paragraph(fmt::format(
          "`eha fit {0}` fits models; of a run that measured the valve `eha characterise {0}` shows the sheet.",
          folder_word(subject)));
    } else if (subject.is_constant()) {
      html += paragraph("Next: `eha read` shows whether the reading follows the rod; once it does, record again.");
    }
    return box("none", "No model in this run", html);
  }
  const std::string again =
      outcome == "interrupted" ? "record again, to the end" : against_end(subject) + "; then record again";
  html += paragraph(
      !subject.record || subject.record->output.size() == 0
          ? "The run ended before its first row: there is nothing to fit or to draw. Correct what ended it and record "
            "again."
      : fit_of_part(subject).empty()
          ? fmt::format("Next: {}. The part before, shown below, is too short to fit.", again)
          : fmt::format("Next: {}. Only completed runs are fitted automatically; `{}` fits the part before, which is "
                        "shown below.",
                        again, fit_of_part(subject)));
  return box("none", has_tripped(subject) ? tripped_text(subject, "run") + ": no model" : heading_without_trip(subject),
             html);
}

}  // namespace eha::report
