// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/suggest/commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/html_text.hpp"
#include "core/json_text.hpp"
#include "core/shell_word.hpp"

namespace eha::suggest {
namespace {

using nlohmann::ordered_json;

/// A command that drives the rig. @param takes_output  -o is the parent of its run folder
std::string driven(const RigAccess& rig, std::string command, bool takes_output) {
  if (rig.is_local) command += " --local";
  if (rig.is_fast) command += " --fast";
  if (!rig.is_local) {
    return (rig.is_disarmed ? through(rig.socket, "eha arm") + " && " : "") + through(rig.socket, std::move(command));
  }
  if (!rig.rig_file.empty()) command += " --rig " + shell_word(rig.rig_file);
  if (takes_output && !rig.output.empty()) command += " --output " + shell_word(rig.output);
  if (rig.allows_non_realtime) command += " --allow-non-realtime";
  return command;
}

/// The commands that are named in short, and whole; an empty one is left as it is.
std::vector<std::pair<std::string, std::string>> whole_commands(const RigAccess& rig) {
  return {{"eha characterise", characterise(rig)},
          {"eha characterise --without-following -o rig-bare.toml", without_following(rig)},
          {"eha read", read(rig)},
          {"eha calibrate", calibrate(rig)},
          {"eha track", rig.controller.empty() ? std::string() : track(rig, rig.controller)}};
}

std::string replaced(std::string_view text, std::string_view what, std::string_view by) {
  std::string result;
  for (std::size_t at = text.find(what); at != std::string_view::npos; at = text.find(what)) {
    result.append(text.substr(0, at)).append(by);
    text.remove_prefix(at + what.size());
  }
  return result.append(text);
}

constexpr std::string_view kOnTheBench =
    "a record of a slow triangle of volts about the null that is wider than the dead band";

struct Quotes {
  std::string_view before;
  std::string_view after;
};

/// A fit of the record with an option more; after a `--` it would be an argument.
std::string fit_with(std::string fit, std::string_view option) {
  return fit.insert(std::min(fit.find(" -- "), fit.size()), option);
}

/// Completes `eha fit --model NAME` with the record.
std::string with_record(std::string_view text, const RigAccess& rig, std::string_view before, std::string_view after,
                        const std::function<std::string(const std::string&)>& shown) {
  constexpr std::string_view kShort = "eha fit --model ";
  const std::string begin = fmt::format("{}{}", before, kShort);
  std::string result;
  for (std::size_t at = text.find(begin); at != std::string_view::npos; at = text.find(begin)) {
    const std::size_t name = at + begin.size();
    const std::size_t end = text.find(after, name);
    if (end == std::string_view::npos) break;
    const std::string option = fmt::format(" --model {}", text.substr(name, end - name));
    result.append(text.substr(0, at + before.size())).append(shown(on_one_line(fit_with(rig.fit, option))));
    text.remove_prefix(end);
  }
  return result.append(text);
}

template <typename Shown>
std::string completed_between(std::string_view text, const RigAccess& rig, Quotes quotes, const Shown& shown) {
  const auto quoted = [&](const std::string& command) {
    return fmt::format("{}{}{}", quotes.before, command, quotes.after);
  };
  std::string result(text);
  if (text.find("eha ") == std::string_view::npos) return result;
  // No command measures a valve that this program does not drive.
  if (rig.new_rig_file.empty()) {
    const std::string measures = quoted("eha characterise");
    std::string as_sentence(kOnTheBench);
    as_sentence.front() = 'A';
    if (result.starts_with(measures)) result.replace(0, measures.size(), as_sentence);
    result = replaced(replaced(result, ". " + measures, ". " + as_sentence), measures, kOnTheBench);
  }
  for (const auto& [name, whole] : whole_commands(rig)) {
    if (!whole.empty()) result = replaced(result, quoted(name), quoted(shown(on_one_line(whole))));
  }
  if (!rig.fit.empty()) result = with_record(result, rig, quotes.before, quotes.after, shown);
  if (rig.model.empty()) return result;
  RigAccess tuned = rig;
  // A measurement before it in the text has written a new rig file.
  if (rig.is_local && text.find(quoted("eha characterise")) != std::string_view::npos)
    tuned.rig_file = rig.new_rig_file;
  const std::string whole = quoted(shown(on_one_line(tune(tuned, rig.model))));
  for (const char* before : {"then ", ": "}) {
    result = replaced(result, fmt::format("{}{}", before, quoted("eha tune")), fmt::format("{}{}", before, whole));
  }
  return result;
}

}  // namespace

RigAccess access_of_run(const ordered_json& manifest) {
  RigAccess rig;
  // A page may be read when the usual names are taken, and no file is overwritten.
  std::string began = text_at(manifest, "/utc_start");
  std::erase_if(began, [](char c) { return c == '-' || c == ':'; });
  if (!began.empty()) {
    rig.new_rig_file = fmt::format("rig-{}.toml", began);
    rig.bare_rig_file = fmt::format("rig-bare-{}.toml", began);
    rig.new_controller = fmt::format("controller-{}.toml", began);
  }
  rig.is_fast = text_at(manifest, "/time_base") == "virtual";
  const std::string player = text_at(manifest, "/played_by");
  rig.is_local = player.empty() ? rig.is_fast : player == "eha";
  if (rig.is_local) rig.rig_file = text_at(manifest, "/rig/file");
  rig.controller = text_at(manifest, "/experiment/controller_file");
  rig.model = text_at(manifest, "/experiment/controller_model");
  return rig;
}

RigAccess with_fit_of(RigAccess rig, const std::string& record) {
  rig.fit = "eha fit " + shell_word(record);
  return rig;
}

std::string through(const std::string& socket, std::string command) {
  if (!socket.empty()) command += " --socket " + shell_word(socket);
  return command;
}

std::string run(const RigAccess& rig, const std::vector<std::string>& experiments) {
  std::string command = "eha run";
  for (const std::string& experiment : experiments) command += " " + shell_word(experiment);
  return driven(rig, command + (rig.accepts_travel_risk ? " --accept-travel-risk" : ""), true);
}

std::string characterise(const RigAccess& rig) {
  return driven(rig, "eha characterise -o " + shell_word(rig.new_rig_file), false);
}

std::string without_following(const RigAccess& rig) {
  RigAccess reached = rig;
  reached.is_disarmed = false;
  reached.allows_non_realtime = false;
  return driven(reached, "eha characterise --without-following -o " + shell_word(rig.bare_rig_file), false);
}

std::string sheet_into_rig_file(const RigAccess& rig, const std::string& run) {
  std::string command = fmt::format("eha characterise {} -o {}", shell_word(run), shell_word(rig.new_rig_file));
  if (!rig.is_local) return through(rig.socket, std::move(command));
  if (!rig.rig_file.empty()) command += " --local --rig " + shell_word(rig.rig_file);
  return command;
}

namespace {

/// A command that reads the rig and moves nothing.
std::string reading(const RigAccess& rig, std::string command) {
  if (!rig.is_local) return through(rig.socket, std::move(command));
  return command + " --local" + (rig.rig_file.empty() ? std::string() : " --rig " + shell_word(rig.rig_file));
}

}  // namespace

std::string read(const RigAccess& rig) { return reading(rig, "eha read"); }

std::string calibrate(const RigAccess& rig) { return reading(rig, "eha calibrate"); }

std::string track(const RigAccess& rig, const std::string& controller) {
  return driven(rig, "eha track " + shell_word(controller), true);
}

std::string tune(const RigAccess& rig, const std::string& model, const std::string& sheet) {
  std::string command = "eha tune " + shell_word(model);
  if (!rig.rig_file.empty()) command += " --rig " + shell_word(rig.rig_file);
  if (!sheet.empty()) command += " --sheet " + shell_word(sheet);
  if (!rig.new_controller.empty()) command += " -o " + shell_word(rig.new_controller);
  return command;
}

std::string export_for_plc(const std::string& controller) {
  return fmt::format("eha export {} --format st -o {}", shell_word(controller),
                     shell_word(std::filesystem::path(controller).stem().string() + "_control.st"));
}

std::string completed(std::string_view text, const RigAccess& rig) {
  return completed_between(text, rig, {"`", "`"}, [](const std::string& command) { return command; });
}

std::string completed_html(std::string_view html, const RigAccess& rig) {
  return completed_between(html, rig, {"<code>", "</code>"}, escaped_html);
}

}  // namespace eha::suggest
