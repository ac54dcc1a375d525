// SPDX-License-Identifier: GPL-3.0-or-later

#include "daemon/eha/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/unit_names.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/version.hpp"

namespace eha::cli {
namespace {

constexpr const char* kHelpFooter = R"(
Results go to standard output, messages to standard error.

Exit codes:
  0 ok                  10 bad data              74 input/output error
  1 a bug in eha        11 safety trip           77 permission denied
  2 wrong usage         12 deadline missed       78 wrong configuration
  3 model rejected      69 device or service    130 interrupted
  4 not converged          unavailable

Examples:
  eha run config/experiments/paper.toml --local --fast
  eha fit record.csv --model io --model fo -o models
  eha import bench.mat -o record.csv
  eha simulate models/fo.json input.csv -o output.csv

Every command takes the options above; `eha COMMAND --help` describes its own. Manual pages: eha(1),
eha-experiment(5), eha-rig(5), eha-record(5).)";

/// The command line, quoted for a shell.
std::string for_a_shell(int argc, const char* const* argv) {
  std::string line = "eha";
  for (int i = 1; i < argc; ++i) line += " " + shell_quoted(argv[i]);
  return line;
}

void add_common_options(CLI::App& app, ConsoleOptions& console) {
  app.footer(kHelpFooter);
  app.require_subcommand(1);
  app.fallthrough();
  app.set_help_flag("-h,--help", "Print this help and leave");
  app.set_version_flag("--version", "", "Print the versions of eha and its libraries and leave");
  app.add_flag("--json", console.json, "Results on standard output as one JSON document");
  app.add_flag("-q,--quiet", console.quiet, "Errors only");
  app.add_flag("-v,--verbose", console.verbose, "More messages, and every figure of a result");
  std::vector<std::string> units;
  for (const LengthUnit& unit : kLengthUnits) units.emplace_back(unit.name);
  app.add_option("--units", console.units, "Unit of lengths for people (default: the rig file's, else the record's)")
      ->type_name(fmt::format("{}", fmt::join(units, "|")))
      ->transform(
          CLI::IsMember(units, [](const std::string& unit) { return unit_as_written_here(unit); }).description(""));
  app.add_flag("--no-progress", console.no_progress, "No progress bar on a terminal (NO_COLOR: no colours)");
}

/// "eha validate MODEL SOURCE [OPTIONS]"
std::string form_of(const CLI::App& sub, const std::string& command) {
  std::string form = command;
  for (const CLI::Option* option : sub.get_options()) {
    if (!option->get_positional()) continue;
    const std::string type = option->get_type_name();
    // The type of a choice is the list of its words.
    const std::string name = type.empty() || type.find('|') != std::string::npos ? option->get_name(true) : type;
    const std::string shown = option->get_expected_max() > 1 ? name + "..." : name;
    form += option->get_required() ? " " + shown : " [" + shown + "]";
  }
  if (!sub.get_subcommands([](const CLI::App*) { return true; }).empty()) form += " COMMAND";
  return form + " [OPTIONS]";
}

/// Whether a command has arguments that are no options.
bool takes_words(const CLI::App& sub) {
  const std::vector<const CLI::Option*> options = sub.get_options();
  return std::any_of(options.begin(), options.end(), [](const CLI::Option* o) { return o->get_positional(); });
}

/// The first example of a command's help; empty without one.
std::string first_example(const CLI::App& sub, const std::string& command) {
  const std::string help = sub.get_footer();
  const std::string begin = "\n  " + command + " ";
  const std::size_t at = help.find(begin, std::min(help.find("Example"), help.size()));
  if (at == std::string::npos) return {};
  const std::size_t end = std::min(help.find('\n', at + 1), help.size());
  std::string example = help.substr(at + 3, end - at - 3);
  // What stands behind two blanks explains it.
  return example.substr(0, std::min(example.find("  "), example.size()));
}

/// ` (did you mean "--decimate"?)` of the first word that a command does not know; empty where none of its options and
/// commands is similar.
std::string meant(const CLI::App& app, const CLI::App& sub) {
  std::vector<std::string> options;
  for (const CLI::App* of : {&sub, &app}) {
    for (const CLI::Option* option : of->get_options()) {
      for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    }
  }
  std::vector<std::string> commands;
  for (const CLI::App* below : sub.get_subcommands([](const CLI::App*) { return true; })) {
    commands.push_back(below->get_name());
  }
  for (const std::string& word : app.remaining(true)) {
    const bool is_option = word.rfind("--", 0) == 0;
    const std::vector<std::string>& names = is_option ? options : commands;
    const std::string written = is_option ? word.substr(0, word.find('=')) : word;
    if ((written == "--out" || written == "--output") && sub.get_option_no_throw("-o") != nullptr) {
      return " (did you mean \"-o\"?)";
    }
    const auto nearest = similar(written, {names.begin(), names.end()});
    if (nearest) return fmt::format(" (did you mean \"{}\"?)", *nearest);
  }
  return {};
}

/// Writes the message of a wrong command line: what is wrong, what was expected, an example, and the help to read.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  std::string command = "eha";
  const CLI::App* sub = &app;
  while (!sub->get_subcommands().empty()) {
    sub = sub->get_subcommands().back();
    command += " " + sub->get_name();
  }
  const bool unknown = app.get_subcommands().empty() && app.remaining_size() > 0;
  std::string what = unknown ? "unknown command or option \"" + app.remaining().front() + "\"" : error.what();
  const bool has_extras = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError);
  // CLI11 writes them from last to first.
  if (has_extras && !unknown) what = fmt::format("not expected: {}", fmt::join(app.remaining(true), " "));
  if (unknown || has_extras) what += meant(app, *sub);
  if (has_extras && !unknown && !takes_words(*sub)) {
    for (const std::string& word : app.remaining(true)) {
      if (const std::string takers = takers_of(word); !takers.empty()) what += "; " + takers;
    }
  }
  if (sub != &app) {
    what += fmt::format("; expected `{}`", form_of(*sub, command));
    if (const std::string example = first_example(*sub, command); !example.empty()) {
      what += fmt::format(", for example `{}`", example);
    }
  }
  if (unknown) what += "; expected `eha COMMAND [OPTIONS]`, for example `eha fit record.csv -o models`";
  return what + "; see `" + command + " --help`";
}

/// Returns the words of the arguments and options that may name files to read.
std::vector<NamedFile> named_files(const CLI::App& app) {
  std::vector<NamedFile> files;
  for (const CLI::App* sub : app.get_subcommands()) {
    for (const CLI::Option* option : sub->get_options()) {
      const std::string takes = option->get_type_name();
      if (takes == "FILE" && !option->get_positional()) continue;  // written
      for (const std::string& word : option->results()) files.push_back({word, takes});
    }
    const std::vector<NamedFile> below = named_files(*sub);
    files.insert(files.end(), below.begin(), below.end());
  }
  return files;
}

bool is_option_written(const CLI::Option* option) { return option->check_sname("o") && option->count() > 0; }

/// The same file, by whatever name.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(a, ignored) && std::filesystem::equivalent(a, b, ignored);
}

/// A command that writes over what it reads loses a record that was measured, or a model.
void refuse_to_overwrite_what_is_read(const CLI::App& app) {
  for (const CLI::App* sub : app.get_subcommands()) {
    for (const CLI::Option* written : sub->get_options(is_option_written)) {
      for (const CLI::Option* read : sub->get_options([&](const CLI::Option* o) { return o != written; })) {
        for (const std::string& word : read->results()) {
          if (!is_same_file(written->as<std::string>(), word)) continue;
          throw UsageError(
              fmt::format("-o {}: that is the file to be read; name another one", written->as<std::string>()));
        }
      }
    }
    refuse_to_overwrite_what_is_read(*sub);
  }
}

/// A name with line breaks could imitate messages of the program.
void refuse_ends_of_lines(int argc, const char* const* argv) {
  constexpr std::size_t kShown = 60;
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]).find_first_of("\n\r") == std::string_view::npos) continue;
    throw UsageError(fmt::format("{}: holds the end of a line; rename the file", shortened(argv[i], kShown)));
  }
}

}  // namespace

ParsedLine parse_command_line(int argc, const char* const* argv) {
  refuse_ends_of_lines(argc, argv);
  if (argc >= 2 && std::string_view(argv[1]) == "help") {  // as of other programs: `eha help fit`
    std::vector<const char*> words{argv[0]};
    words.insert(words.end(), argv + 2, argv + argc);
    words.push_back("--help");
    return parse_command_line(static_cast<int>(words.size()), words.data());
  }
  ParsedLine line;
  line.as_given = for_a_shell(argc, argv);
  // The arguments after -- of a batch are those of `eha fit`.
  const auto dashes = std::find(argv, argv + argc, std::string_view("--"));
  const bool is_batch = std::find(argv, dashes, std::string_view("batch")) != dashes;
  if (is_batch && dashes != argv + argc) line.after_dashes.assign(dashes + 1, argv + argc);
  CLI::App app("eha - from an electro-hydraulic actuator rig to validated models", "eha");
  add_common_options(app, line.console);
  for (const auto add : kCommands) add(app, line);
  try {
    app.parse(is_batch ? static_cast<int>(dashes - argv) : argc, argv);
    line.named_files = named_files(app);
    refuse_to_overwrite_what_is_read(app);
  } catch (const CLI::CallForHelp&) {
    line.text = app.help();
  } catch (const CLI::CallForVersion&) {
    line.text = version_text();
  } catch (const CLI::ParseError& error) {
    throw UsageError(usage_message(app, error));
  }
  return line;
}

}  // namespace eha::cli
