// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/asked_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string_view>

#include "core/free_name.hpp"
#include "core/reading_options.hpp"
#include "core/shell_word.hpp"

namespace eha::importer {
namespace {

/// The end of the word of a command that begins at `at`; a part of it may be within quotation marks.
std::size_t word_end(const std::string& command, std::size_t at) {
  for (bool is_quoted = false; at < command.size() && (is_quoted || command[at] != ' '); ++at) {
    if (!is_quoted && command[at] == '\\') {
      ++at;
    } else if (command[at] == '\'') {
      is_quoted = !is_quoted;
    }
  }
  return std::min(at, command.size());
}

/// A word without its quotation marks.
std::string unquoted(std::string_view word) {
  std::string plain;
  for (std::size_t i = 0, is_quoted = 0; i < word.size(); ++i) {
    if (word[i] == '\'') {
      is_quoted = 1 - is_quoted;
    } else {
      if (is_quoted == 0 && word[i] == '\\' && i + 1 < word.size()) ++i;
      plain += word[i];
    }
  }
  return plain;
}

/// Erases "--name VALUE", "--name=VALUE", "--name" or "-nVALUE", the first time that it stands as a word of a shell's
/// command.
void erase_option(std::string& command, const std::string& name, bool has_value) {
  for (std::size_t at = 0; at < command.size();) {
    std::size_t end = word_end(command, at);
    const std::string_view word = std::string_view(command).substr(at, end - at);
    const bool is_short = !name.starts_with("--");
    const bool is_joined = word.starts_with(is_short ? name : name + "=") && word != name;
    if (word == name || is_joined) {
      if (has_value && !is_joined) end = word_end(command, std::min(end + 1, command.size()));
      command.erase(at > 0 ? at - 1 : 0, end - at + (at > 0 ? 1 : 0));
      return;
    }
    at = end + 1;
  }
}

/// Replaces each word that is `from`; false where there is none.
bool replace_word(std::string& command, const std::string& from, const std::string& by) {
  bool is_there = false;
  for (std::size_t at = 0; at < command.size();) {
    const std::size_t end = word_end(command, at);
    if (command.compare(at, end - at, from) == 0) {
      command.replace(at, end - at, by);
      at += by.size() + 1;
      is_there = true;
    } else {
      at = end + 1;
    }
  }
  return is_there;
}

/// "bench-record.csv", or one with a number where that is taken.
std::string copy_of(const std::filesystem::path& path, const std::string& taken = {}) {
  const std::string stem = path.stem().string() + "-record";
  std::string name = free_name(stem + ".csv");
  for (int number = 2; name == taken; ++number) name = free_name(fmt::format("{}-{}.csv", stem, number));
  return name;
}

}  // namespace

std::string command_with(const Options& options, const std::filesystem::path& path, const std::string& extra) {
  const std::string import = fmt::format("eha import {}", shell_word(path.string()));
  if (!options.then.empty()) {
    const std::string copy = copy_of(path);
    return fmt::format("{} {} -o {} && {}", import, extra, shell_word(copy), command_on(options, path, copy));
  }
  std::string command = options.command.empty() ? import : options.command;
  // What was given before for the same option no longer counts.
  std::istringstream stream(extra);
  const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i].starts_with("--")) {
      erase_option(command, words[i], i + 1 < words.size() && !words[i + 1].starts_with("--"));
    }
  }
  // After a `--` an option would be an argument.
  const std::size_t end = command.find(" -- ");
  return command.insert(std::min(end, command.size()), " " + extra);
}

std::string command_without(const Options& options, const std::vector<std::string>& names) {
  std::string command = options.command;
  for (const std::string& name : names) {
    for (std::size_t before = 0; before != command.size();) {  // it may be repeated
      before = command.size();
      erase_option(command, name, true);
    }
  }
  return command;
}

std::string command_without_flag(const Options& options, const std::string& name) {
  std::string command = options.command;
  erase_option(command, name, false);
  return command;
}

std::string command_that_made(const Options& options) {
  std::string command = command_without(options, {"-o", "--units"});
  for (const char* flag : {"--json", "--no-progress", "-q", "--quiet", "-v", "--verbose"}) {
    erase_option(command, flag, false);
  }
  return command;
}

std::string command_on(const Options& options, const std::filesystem::path& path, const std::string& made,
                       const std::vector<std::string>& wrong, const std::string& extra) {
  Options on_it = options;
  std::string& command = options.then.empty() ? on_it.command : on_it.then;
  if (options.then.empty()) command = command_without(options, wrong);
  if (!replace_word(command, shell_quoted(path.string()), shell_word(made))) command.clear();
  if (!extra.empty()) return command_with(on_it, made, extra);
  return command.empty() ? fmt::format("eha import {}", shell_word(made)) : command;
}

std::string words_of_reading(const std::string& command) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at < command.size();) {
    const std::size_t end = word_end(command, at);
    words.push_back(unquoted(std::string_view(command).substr(at, end - at)));
    at = end + 1;
  }
  std::string found;
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
    const ReadingOption* option = reading_option(words[i]);
    if (option == nullptr) continue;
    found += " " + shell_quoted(words[i]);
    if (option->has_value && option->name == words[i] && i + 1 < words.size()) found += " " + shell_quoted(words[++i]);
  }
  return found;
}

ReadAlike read_alike(const std::string& command, const std::filesystem::path& path, const std::string& taken) {
  const std::string words = words_of_reading(command);
  if (words.empty()) return {{}, path.string()};
  const std::string copy = copy_of(path, taken);
  return {fmt::format("eha import {}{} -o {} && ", shell_word(path.string()), words, shell_word(copy)), copy};
}

}  // namespace eha::importer
