// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/console.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/terminal_text.hpp"
#include "daemon/eha/closed_pipe.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/wrapped_text.hpp"

namespace eha::cli {
namespace {

bool environment_has(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0';
}

template <typename Use>
void for_each_line(std::string_view text, Use&& use) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    use(text.substr(0, end));
    if (end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

constexpr std::chrono::seconds kBetweenMessages{30};

/// A word of a suggested command that the user replaces.
struct Placeholder {
  std::string_view word;
  std::string_view stands_for;
};

constexpr std::array kToReplace{Placeholder{"INPUT.csv", "a file with the model's input, in its unit"},
                                Placeholder{"RECORD.csv", "a record of the same plant that the model has not seen"},
                                Placeholder{"EXPERIMENT.toml", "an experiment file, see eha-experiment(5)"},
                                Placeholder{"PART...", "the folders (-o) of the other parts, on this machine"}};

void write_out(std::string_view text) {
  // A failure stays in the stream's error flag until flush() checks it.
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), stdout));
}

}  // namespace

Console::Console(const ConsoleOptions& options)
    : options_(options), bar_wanted_(!options.no_progress && !options.quiet && isatty(STDERR_FILENO) == 1) {
  const auto mode = environment_has("NO_COLOR") ? spdlog::color_mode::never : spdlog::color_mode::automatic;
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>(mode);
  auto logger = std::make_shared<spdlog::logger>("eha", std::move(sink));
  logger->set_pattern("eha: %^%l%$: %v");
  logger->set_level(options.quiet ? spdlog::level::err : options.verbose ? spdlog::level::debug : spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

const suggest::RigAccess& Console::rig() const {
  if (!rig_) rig_ = usual_access();
  return *rig_;
}

std::string Console::with_commands(std::string_view text) const {
  // A program that asks for another one, as ehad does, knows the rig and completes them itself.
  const bool is_for_program = options_.json && options_.quiet;
  if (is_for_program || text.find("`eha ") == std::string_view::npos) return std::string(text);
  return suggest::completed(text, rig());
}

void Console::error(std::string_view text) const {
  std::cout.flush();  // in one file with the errors no line is torn
  for_each_line(terminal_text(with_commands(text)), [](std::string_view line) { spdlog::error("{}", line); });
}

void Console::warning(std::string_view text) const {
  const bool is_named = subject_.empty() || text.find(subject_) != std::string_view::npos;
  const std::string whole = is_named ? std::string(text) : subject_ + ": " + std::string(text);
  std::cout.flush();
  for_each_line(terminal_text(with_commands(whole)), [](std::string_view line) { spdlog::warn("{}", line); });
}

void Console::info(std::string_view text) const {
  std::cout.flush();
  for_each_line(terminal_text(with_commands(text)), [](std::string_view line) { spdlog::info("{}", line); });
}

void Console::debug(std::string_view text) const {
  for_each_line(terminal_text(text), [](std::string_view line) { spdlog::debug("{}", line); });
}

void Console::print(std::string_view text) const {
  if (options_.json || hides_results_) return;
  write_out(terminal_text(wrapped_where_longer(text, with_commands(text))));
  if (text.empty() || text.back() != '\n') write_out("\n");
}

void Console::redraw(std::string_view text) {
  if (options_.json) return;
  const bool replaces = isatty(STDOUT_FILENO) == 1;
  // Cursor up, then erase from there to the end of the screen (ECMA-48 CUU, ED).
  if (replaces && drawn_lines_ > 0) write_out(fmt::format("\x1b[{}A\x1b[J", drawn_lines_));
  print(text);
  drawn_lines_ = replaces ? std::count(text.begin(), text.end(), '\n') + (text.ends_with('\n') ? 0 : 1) : 0;
  flush();
}

void Console::print_json(const nlohmann::ordered_json& document) const {
  if (kept_) {
    kept_->push_back(document);
    return;
  }
  if (options_.json) {
    // A terminal obeys control characters beyond ASCII; a program gets the text as it is.
    const bool ascii = isatty(STDOUT_FILENO) != 0;
    write_out(document.dump(2, ' ', ascii, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  }
}

void Console::print_content(std::string_view text) const {
  write_out(isatty(STDOUT_FILENO) != 0 ? terminal_text(text) : std::string(text));
}

nlohmann::ordered_json Console::taken_documents() {
  nlohmann::ordered_json documents = kept_.value_or(nlohmann::ordered_json::array());
  kept_.reset();
  return documents;
}

void Console::next_step(std::string_view command) const {
  if (options_.json || options_.quiet || kept_) return;
  const bool takes_units =
      !options_.units.empty() && command.starts_with("eha ") && command.find("--units") == std::string_view::npos;
  std::string shown = terminal_text(command);
  std::replace(shown.begin(), shown.end(), '\n', '?');  // of a name: text after it would look like another command
  write_out(fmt::format("Next: {}{}\n", shown, takes_units ? " --units " + options_.units : ""));
  std::istringstream words(shown);
  for (std::string word; words >> word;) {
    const auto found =
        std::find_if(kToReplace.begin(), kToReplace.end(), [&](const auto& p) { return p.word == word; });
    if (found != kToReplace.end()) write_out(fmt::format("      {}: {}\n", found->word, found->stands_for));
  }
}

void Console::show_run(std::string_view line) {
  if (bar_wanted_) {
    draw_bar(line);
  } else {
    say_now_and_then(line);
  }
}

void Console::draw_bar(std::string_view line) {
  winsize size{};
  const bool is_known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  const std::size_t width = is_known ? size.ws_col - 1U : 79U;
  // Carriage return, then erase to the end of the line (ECMA-48 EL). A line that wraps would stay.
  std::cerr << "\r" << terminal_text(line.substr(0, width)) << "\x1b[K" << std::flush;
  bar_drawn_ = true;
}

void Console::say_now_and_then(std::string_view line) {
  if (options_.no_progress || isatty(STDERR_FILENO) == 1) return;
  const auto now = std::chrono::steady_clock::now();
  if (!said_) said_ = now;
  if (now - *said_ < kBetweenMessages) return;
  said_ = now;
  info(line);
}

void Console::progress(double share, std::string_view text) {
  if (!bar_wanted_) {
    if (!text.ends_with('\n')) say_now_and_then(fmt::format("{}, {:.0f} % done", text, 100.0 * std::min(share, 1.0)));
    return;
  }
  if (text.ends_with('\n')) {
    std::cerr << "\r\x1b[K" << terminal_text(text) << std::flush;
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (!bar_drawn_ || share < bar_share_) bar_begun_ = now;
  bar_share_ = share;
  const double taken_s = std::chrono::duration<double>(now - bar_begun_).count();
  // An earlier estimate would fluctuate.
  const bool is_known = taken_s > 2.0 && share > 0.05 && share < 1.0;
  const std::string left = is_known ? fmt::format(", {:.0f} s left,", taken_s * (1.0 - share) / share) : "";
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(std::lround(kWidth * std::clamp(share, 0.0, 1.0)));
  const std::string bar =
      std::string(static_cast<std::size_t>(filled), '#') + std::string(static_cast<std::size_t>(kWidth - filled), '.');
  draw_bar(fmt::format("[{}] {:3.0f} %{} {}", bar, 100.0 * std::clamp(share, 0.0, 1.0), left, text));
}

std::function<void(double, const std::string&)> Console::progress_callback() {
  return [this](double share, const std::string& text) { progress(share, text); };
}

void Console::end_progress() {
  if (bar_drawn_) std::cerr << "\r\x1b[K" << std::flush;
  bar_drawn_ = false;
  said_.reset();
}

bool Console::confirm(std::string_view question) const {
  if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1) {
    throw UsageError(fmt::format("{} There is no terminal to ask on: add --yes to confirm", question));
  }
  std::string answer;
  do {
    std::cerr << terminal_text(question) << " Type yes to go on: " << std::flush;
    std::getline(std::cin, answer);
    if (answer == "y") std::cerr << "The whole word, please.\n";
  } while (answer == "y");
  return answer == "yes";
}

void Console::flush() const {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    // A write that failed before this flush has set the error flag, but its reason is lost: writing one more byte fails
    // for the same reason.
    if (errno == 0 && ::write(STDOUT_FILENO, "\n", 1) == 1) errno = EIO;
    const int reason = errno;
    if (reason == EPIPE) throw ClosedPipe("nobody reads standard output");
    throw IoError(fmt::format("cannot write to standard output: {}", error_text(reason)));
  }
}

}  // namespace eha::cli
