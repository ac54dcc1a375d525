// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/exported_origin.hpp"

#include <fmt/format.h>

#include <system_error>

#include "config/bound_text.hpp"
#include "core/code_text.hpp"
#include "core/json_text.hpp"
#include "core/os/written_at.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/report/html.hpp"

namespace eha::cli {

std::string file_line(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return "File " + file.filename().string();  // a pipe is read
  const std::string written = os::written_at({file});
  // The hash first: what is too long for a line is cut at its end.
  return fmt::format("SHA-256 {} of {}{}", record::sha256_of_file(file), file.filename().string(),
                     written.empty() ? std::string() : ", written " + written + " UTC");
}

std::string source_line(const std::string& source) {
  if (!record::is_run_folder(source)) {
    const std::string folder = std::filesystem::path(source).parent_path().string();
    return file_line(source) + (folder.empty() ? std::string() : ", in " + folder);
  }
  const nlohmann::ordered_json& run = record::read_manifest(source).other;
  return fmt::format("Run {}, begun {} on {}", source,
                     report::utc_text(text_at(run, "/utc_start", "at an unknown time")),
                     text_at(run, "/rig/name", "an unknown rig"));
}

std::vector<std::string> origin_lines(const std::filesystem::path& file, const config::ControllerConfig& controller,
                                      const DisplayUnit& unit) {
  constexpr std::size_t kLongest = 200;
  const config::ControllerProvenance& from = controller.provenance;
  const config::ControllerPromise& p = controller.promise;
  const double factor = unit.factor("in");
  const std::string in = unit.of("in");
  std::vector<std::string> lines{
      file_line(file),
      fmt::format("Rig {}, its file {}, SHA-256 {}", from.rig, std::filesystem::path(from.rig_file).filename().string(),
                  from.rig_sha256),
      fmt::format("Model {} of run {}, SHA-256 {}", std::filesystem::path(from.model).filename().string(),
                  std::filesystem::path(from.run).filename().string(), from.model_sha256),
      fmt::format(
          "Promised: following error at most {} {} RMS and {} {} at worst, at rest {} {}; phase margin at least "
          "{} deg.",
          config::upper_bound_text(factor * p.following_rms_in.upper), in,
          config::upper_bound_text(factor * p.following_worst_in.upper), in,
          config::upper_bound_text(factor * p.rest_error_in.upper), in,
          config::bound_text(p.phase_margin_deg.lower, false)),
      "Made by " + from.made_by};
  for (std::string& line : lines) line = code_text(line, kLongest);
  return lines;
}

}  // namespace eha::cli
