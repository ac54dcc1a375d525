// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "daemon/eha/command_line.hpp"
#include "daemon/eha/command_list.hpp"

namespace eha::cli {
namespace {

constexpr const char* kFooter = R"(
Prints the completion script of a shell. The Debian package installs both.

Examples:
  source <(eha completion bash)
  eha completion zsh > ~/.zfunc/_eha)";

using Words = std::vector<std::string>;

/// Returns the values that an option accepts.
struct Value {
  Words choices;
  bool file = false;
  bool folder = false;
};

Value value_of(const CLI::Option& option) {
  constexpr std::array<std::string_view, 7> kFiles{"EXPERIMENT", "RIG", "MODEL", "INPUT", "FILE", "SOURCE", "RUN"};
  Value value;
  const std::string type = option.get_type_name();
  for (std::size_t begin = 0; begin <= type.size();) {
    const std::size_t end = std::min(type.find('|', begin), type.size());
    const std::string word = type.substr(begin, end - begin);
    if (!word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") == std::string::npos) {
      value.choices.push_back(word);
    }
    value.file = value.file || std::find(kFiles.begin(), kFiles.end(), word) != kFiles.end();
    value.folder = value.folder || word == "DIR";
    begin = end + 1;
  }
  return value;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

Words names_of(const CLI::Option& option) {
  Words names;
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  return names;
}

/// A command and its CLI::App; the program itself has an empty path.
struct Node {
  std::string path;    ///< "runs list"
  std::string parent;  ///< "runs"
  std::string name;    ///< "list"
  const CLI::App* app;
};

void collect(const CLI::App& app, const std::string& path, std::vector<Node>& nodes) {
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string own = path.empty() ? sub->get_name() : path + " " + sub->get_name();
    nodes.push_back({own, path, sub->get_name(), sub});
    collect(*sub, own, nodes);
  }
}

std::vector<Node> nodes_of(const CLI::App& app) {
  std::vector<Node> nodes{{"", "", "", &app}};
  collect(app, "", nodes);
  return nodes;
}

Words subcommand_names(const CLI::App& app) {
  Words names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

std::vector<const CLI::Option*> options_of(const CLI::App& app, bool positional) {
  return app.get_options([positional](const CLI::Option* option) { return option->get_positional() == positional; });
}

std::string bash_value(const Value& value) {
  if (value.file) return "mapfile -t COMPREPLY < <(compgen -f -- \"$current\"); compopt -o filenames";
  if (value.folder) return "mapfile -t COMPREPLY < <(compgen -d -- \"$current\"); compopt -o filenames";
  if (value.choices.empty()) return "COMPREPLY=()";
  return fmt::format("mapfile -t COMPREPLY < <(compgen -W '{}' -- \"$current\")", fmt::join(value.choices, " "));
}

std::string bash_script(const CLI::App& app) {
  const std::vector<Node> nodes = nodes_of(app);
  Words common;
  for (const CLI::Option* option : options_of(app, false)) {
    for (const std::string& name : names_of(*option)) common.push_back(name);
  }
  std::string steps;
  std::string values;
  std::string rest;
  for (const Node& node : nodes) {
    if (!node.path.empty()) steps += fmt::format("{}'{}:{}'", steps.empty() ? "" : " | ", node.parent, node.name);
    Words words = node.path.empty() ? Words{} : common;
    for (const CLI::Option* option : options_of(*node.app, false)) {
      const Words names = names_of(*option);
      for (const std::string& name : names) {
        if (std::find(words.begin(), words.end(), name) == words.end()) words.push_back(name);
      }
      if (!takes_value(*option)) continue;
      Words patterns;
      for (const std::string& name : names) patterns.push_back(fmt::format("'{}:{}'", node.path, name));
      values += fmt::format("    {}) {}; return ;;\n", fmt::join(patterns, " | "), bash_value(value_of(*option)));
    }
    Words arguments = subcommand_names(*node.app);
    Value positional;
    for (const CLI::Option* option : options_of(*node.app, true)) {
      const Value value = value_of(*option);
      positional.file = positional.file || value.file;
      positional.folder = positional.folder || value.folder;
      arguments.insert(arguments.end(), value.choices.begin(), value.choices.end());
    }
    positional.choices = arguments;
    rest += fmt::format("    '{}:-') mapfile -t COMPREPLY < <(compgen -W '{}' -- \"$current\") ;;\n", node.path,
                        fmt::join(words, " "));
    rest += fmt::format("    '{}:') {} ;;\n", node.path, bash_value(positional));
  }
  return fmt::format(R"(# bash completion for eha, made by: eha completion bash
_eha() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} command='' i
  for ((i = 1; i < COMP_CWORD; i++)); do
    case "$command:${{COMP_WORDS[i]}}" in
      {}) command="${{command:+$command }}${{COMP_WORDS[i]}}" ;;
    esac
  done
  case "$command:$previous" in
{}  esac
  local kind=''
  if [[ $current == -* ]]; then kind=-; fi
  case "$command:$kind" in
{}  esac
}}
complete -F _eha eha
)",
                     steps, values, rest);
}

/// Escapes text for a single-quoted specification of zsh's _arguments, where [ ] : and \ have a meaning.
std::string zsh_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result;
}

std::string zsh_value(const Value& value) {
  if (value.file) return "_files";
  if (value.folder) return "_files -/";
  if (value.choices.empty()) return " ";
  return fmt::format("({})", fmt::join(value.choices, " "));
}

Words zsh_options(const CLI::App& app) {
  Words specifications;
  for (const CLI::Option* option : options_of(app, false)) {
    const std::string value =
        takes_value(*option) ? fmt::format(":{}:{}", zsh_text(option->get_type_name()), zsh_value(value_of(*option)))
                             : "";
    for (const std::string& name : names_of(*option)) {
      specifications.push_back(fmt::format("'*{}[{}]{}'", name, zsh_text(option->get_description()), value));
    }
  }
  return specifications;
}

/// The function for one command. It calls those of its subcommands, which the script defines too.
std::string zsh_function(const Node& node, const Words& common) {
  std::string function = node.path.empty() ? "_eha" : "_eha_" + node.path;
  std::replace(function.begin(), function.end(), ' ', '_');
  Words specifications = zsh_options(*node.app);
  for (const std::string& specification : common) {
    if (std::find(specifications.begin(), specifications.end(), specification) == specifications.end()) {
      specifications.push_back(specification);
    }
  }
  const std::vector<const CLI::App*> subs = node.app->get_subcommands([](const CLI::App*) { return true; });
  if (subs.empty()) {
    for (const CLI::Option* option : options_of(*node.app, true)) {
      const bool many = option->get_items_expected_max() > 1;
      specifications.push_back(
          fmt::format("'{}:{}:{}'", many ? "*" : "", zsh_text(option->get_type_name()), zsh_value(value_of(*option))));
    }
    return fmt::format("{}() {{\n  _arguments \\\n    {}\n}}\n", function, fmt::join(specifications, " \\\n    "));
  }
  std::string commands;
  std::string cases;
  for (const CLI::App* sub : subs) {
    commands += fmt::format("    '{}:{}'\n", sub->get_name(), zsh_text(sub->get_description()));
    cases += fmt::format("        {0}) {1}_{0} ;;\n", sub->get_name(), function);
  }
  return fmt::format(R"({}() {{
  local curcontext=$curcontext state line
  local -a commands=(
{}  )
  _arguments -C \
    {} \
    '1:command:->command' '*::argument:->argument'
  case $state in
    command) _describe command commands ;;
    argument)
      case $words[1] in
{}      esac ;;
  esac
}}
)",
                     function, commands, fmt::join(specifications, " \\\n    "), cases);
}

std::string zsh_script(const CLI::App& app) {
  const Words common = zsh_options(app);
  std::string script = "#compdef eha\n# zsh completion for eha, made by: eha completion zsh\n";
  for (const Node& node : nodes_of(app)) script += zsh_function(node, common);
  // In a file on $fpath this completes at once; in a sourced script it registers the function.
  return script + "if [ \"$funcstack[1]\" = _eha ]; then _eha \"$@\"; else compdef _eha eha; fi\n";
}

}  // namespace

void add_completion(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("completion", "Print the completion script of a shell");
  sub->footer(kFooter);
  const auto shell = std::make_shared<std::string>();
  sub->add_option("shell", *shell, "bash or zsh")
      ->required()
      ->type_name("bash|zsh")
      ->check(CLI::IsMember({"bash", "zsh"}).description(""));
  sub->callback([&app, &line, shell] { line.text = completion_script(app, *shell); });
}

std::string completion_script(const CLI::App& app, const std::string& shell) {
  return shell == "bash" ? bash_script(app) : zsh_script(app);
}

}  // namespace eha::cli
