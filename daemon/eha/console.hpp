// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/display_unit.hpp"
#include "daemon/suggest/commands.hpp"

namespace eha::cli {

/// The options common to all commands.
struct ConsoleOptions {
  bool json = false;         ///< results as one JSON document
  bool quiet = false;        ///< errors only
  bool verbose = false;      ///< debugging messages too
  bool no_progress = false;  ///< no progress bar even on a terminal
  std::string units = {};    ///< of displayed lengths; empty: the rig file's, or the record's
};

/// Prints results to standard output, messages and the progress bar to standard error. Colours and the bar appear only
/// on a terminal; NO_COLOR in the environment turns colours off (no-color.org). Thread-safe except progress(), which
/// belongs to one thread.
class Console {
 public:
  explicit Console(const ConsoleOptions& options);

  [[nodiscard]] bool json() const noexcept { return options_.json; }
  [[nodiscard]] bool verbose() const noexcept { return options_.verbose; }
  [[nodiscard]] bool quiet() const noexcept { return options_.quiet; }
  [[nodiscard]] const std::string& units() const noexcept { return options_.units; }  ///< --units; may be empty
  /// Takes the unit in which the user has typed a length, which comes before that of the rig file.
  void take_typed_unit(std::string name) { typed_unit_ = std::move(name); }
  /// Returns the unit of displayed lengths: --units, else the one typed, else that of the rig file.
  /// @param of_rig  of kLengthUnits, or empty
  [[nodiscard]] DisplayUnit unit(const std::string& of_rig = {}) const {
    return DisplayUnit(!options_.units.empty() ? options_.units : !typed_unit_.empty() ? typed_unit_ : of_rig);
  }

  /// Sets how the commands in messages and results reach the rig (suggest::completed()).
  void set_rig(suggest::RigAccess rig) { rig_ = std::move(rig); }
  /// How the rig is reached: as set, else usual_access().
  [[nodiscard]] const suggest::RigAccess& rig() const;

  /// Each line of `text` becomes a message of its own: "eha: error: ...".
  void error(std::string_view text) const;
  void warning(std::string_view text) const;
  void info(std::string_view text) const;
  void debug(std::string_view text) const;

  /// Prints results as text, with a newline at the end; nothing with --json.
  void print(std::string_view text) const;

  /// Prints results as text that the next call replaces on a terminal; elsewhere each is printed after the other.
  void redraw(std::string_view text);

  /// Prints the document of --json; prints nothing without that option.
  void print_json(const nlohmann::ordered_json& document) const;

  /// Prints content such as CSV to standard output, independently of the options; on a terminal as terminal_text().
  void print_content(std::string_view text) const;

  /// Prints the next useful command, as the last line of a success; prints nothing with --json or --quiet.
  void next_step(std::string_view command) const;

  /// Collects the documents of print_json() and prints no next step, for a command with several results and one
  /// document. taken_documents() ends the collection and returns it.
  void keep_documents() { kept_.emplace(nlohmann::ordered_json::array()); }
  [[nodiscard]] nlohmann::ordered_json taken_documents();

  /// While set, print() prints nothing: for a command whose results are summarised by another one.
  void hide_results(bool hidden) noexcept { hides_results_ = hidden; }

  /// What the warnings from now on are about, where a command is given several: each begins with it unless it names it
  /// anyway. Empty: nothing.
  void set_subject(std::string subject) { subject_ = std::move(subject); }

  /// Shows the progress of a run: on a terminal one line that the next call replaces, cut to its width; elsewhere a
  /// message every 30 s, the first after 30 s. end_progress() removes the line.
  void show_run(std::string_view line);

  /// Redraws the bar, with the time left as soon as it can be estimated; without a terminal prints messages like
  /// show_run().
  /// @param share  0..1   @param text  the current step
  void progress(double share, std::string_view text);
  /// Returns progress() as a function, for long work elsewhere. The console must outlive it.
  [[nodiscard]] std::function<void(double, const std::string&)> progress_callback();
  /// Removes the bar; does nothing without one.
  void end_progress();

  /// Asks on the terminal and returns whether the answer is "yes".
  /// @throws UsageError  standard input is no terminal: names --yes
  [[nodiscard]] bool confirm(std::string_view question) const;

  /// @throws IoError  standard output could not be written (a full disk, a closed pipe)
  void flush() const;

 private:
  /// Draws a line on the terminal that the next one replaces, cut to its width.
  void draw_bar(std::string_view line);
  /// Prints a message every 30 s where there is no terminal, the first after 30 s.
  void say_now_and_then(std::string_view line);

  /// Text with the commands that it names in short completed.
  [[nodiscard]] std::string with_commands(std::string_view text) const;

  ConsoleOptions options_;
  mutable std::optional<suggest::RigAccess> rig_ = {};  ///< none: not asked for yet
  std::string typed_unit_ = {};                         ///< of a length on the command line; empty: none
  std::string subject_ = {};                            ///< see set_subject()
  bool bar_wanted_ = false;
  bool hides_results_ = false;
  std::ptrdiff_t drawn_lines_ = 0;                      ///< replaced by redraw()
  mutable std::optional<nlohmann::ordered_json> kept_;  ///< collected documents; none: documents are printed at once
  std::optional<std::chrono::steady_clock::time_point> said_;  ///< time of say_now_and_then()'s last message
  bool bar_drawn_ = false;
  double bar_share_ = 0.0;                           ///< start of the work
  std::chrono::steady_clock::time_point bar_begun_;  ///< share of the work that the bar shows
};

}  // namespace eha::cli
