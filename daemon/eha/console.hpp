// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace eha::cli {

/// What the options common to all commands ask for.
struct ConsoleOptions {
  bool json = false;         ///< results as one JSON document
  bool quiet = false;        ///< errors only
  bool verbose = false;      ///< debugging messages too
  bool no_progress = false;  ///< no progress bar even on a terminal
};

/// The terminal: results to standard output, messages and the progress bar to standard error. Colours and the bar only
/// where standard error is a terminal; NO_COLOR in the environment turns colours off (no-color.org).
/// Thread-safe but for progress(), which belongs to one thread.
class Console {
 public:
  explicit Console(const ConsoleOptions& options);

  [[nodiscard]] bool json() const noexcept { return options_.json; }

  /// Each line of `text` becomes a message of its own: "eha: error: ...".
  void error(std::string_view text) const;
  void warning(std::string_view text) const;
  void info(std::string_view text) const;
  void debug(std::string_view text) const;

  /// Results as text for people; nothing with --json. Ends what it prints with a newline.
  void print(std::string_view text) const;

  /// The one document of --json; nothing without.
  void print_json(const nlohmann::ordered_json& document) const;

  /// Standard output whatever the options: for content, such as CSV.
  void print_content(std::string_view text) const;

  /// The command to go on with, the last line of a success; nothing with --json or --quiet.
  void next_step(std::string_view command) const;

  /// Draws the bar anew. @param share  0..1   @param text  what is going on
  void progress(double share, std::string_view text);
  /// Takes the bar away; harmless without one.
  void end_progress();

  /// Asks on the terminal and returns whether the answer is "yes".
  /// @throws UsageError  standard input is no terminal: names --yes
  [[nodiscard]] bool confirm(std::string_view question) const;

  /// @throws IoError  something written to standard output did not get there (a full disk, a closed pipe)
  void flush() const;

 private:
  ConsoleOptions options_;
  bool bar_wanted_ = false;
  bool bar_drawn_ = false;
};

}  // namespace eha::cli
