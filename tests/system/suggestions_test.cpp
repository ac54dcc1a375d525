// SPDX-License-Identifier: GPL-3.0-or-later
// Every command that `eha` suggests to the user of a simulated rig in this process, on the terminal and on its pages:
// it can be pasted, reaches that rig, and names files that are there.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/command_line.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr const char* kRig = "my rig.toml";  // a word that needs quotes

std::string unescaped(std::string html) {
  using Entity = std::pair<const char*, const char*>;
  for (const auto& [entity, character] :
       {Entity{"&#39;", "'"}, Entity{"&quot;", "\""}, Entity{"&lt;", "<"}, Entity{"&gt;", ">"}, Entity{"&amp;", "&"}}) {
    html = std::regex_replace(html, std::regex(entity), character);
  }
  return html;
}

void add_matches(const std::string& text, const char* pattern, std::set<std::string>& commands) {
  const std::regex wanted(pattern);
  for (auto at = std::sregex_iterator(text.begin(), text.end(), wanted); at != std::sregex_iterator(); ++at) {
    commands.insert((*at)[1].str());
  }
}

/// Commands of a terminal: behind "Next: " or another colon at the end of a line, and between backquotes.
std::set<std::string> commands_of(const std::string& text) {
  std::set<std::string> commands;
  add_matches(text, "Next: ([^\n]+)", commands);
  add_matches(text, "`(eha [^`\n]+)`", commands);
  add_matches(text, ": (eha [a-z]+ [^`\n(]+[^`\n( ])(?: \\(or|\n)", commands);
  return commands;
}

/// The command lines of `eha` in a command, as a shell splits it.
std::vector<Words> lines_of(const std::string& command, const fs::path& at) {
  const std::string script =
      fmt::format("cd '{}' && eha() {{ printf '%s\\n' \"$@\" '-- end'; }}; xdg-open() {{ :; }}; sudo() {{ :; }}; {}",
                  at.string(), command);
  std::istringstream words(
      output_of_shell("bash -c " + fmt::format("'{}'", std::regex_replace(script, std::regex("'"), "'\\''"))));
  std::vector<Words> lines(1);
  for (std::string word; std::getline(words, word);) {
    if (word == "-- end") {
      lines.emplace_back();
    } else {
      lines.back().push_back(word);
    }
  }
  lines.pop_back();
  return lines;
}

bool is_one_of(const std::string& word, const std::vector<std::string>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// What is wrong with a suggested command; empty: nothing.
/// @param knows_rig  the command is about a rig that was named
std::string fault_of(const std::string& command, const fs::path& at, bool knows_rig = true) {
  const std::vector<Words> lines = lines_of(command, at);
  if (lines.empty() && command.find("eha ") == 0) return "the shell does not run it";
  for (const Words& line : lines) {
    const bool reaches_rig = is_one_of(line.front(), {"run", "characterise", "track", "read", "goto"});
    // The name of a command alone is no suggestion, unless it would go to a service that is not there.
    if (line.size() == 1 && !reaches_rig) continue;
    std::vector<const char*> words{"eha"};
    for (const std::string& word : line) words.push_back(word.c_str());
    std::vector<cli::NamedFile> files;
    try {
      files = cli::parse_command_line(static_cast<int>(words.size()), words.data()).named_files;
    } catch (const Error& error) {
      return error.what();
    }
    const bool is_of_a_run = line.size() > 1 && fs::is_directory(at / line[1]);
    if (reaches_rig && !is_of_a_run && !is_one_of("--local", line)) return "it does not reach the local rig";
    if (reaches_rig && knows_rig && !is_of_a_run && !is_one_of("--rig", line)) return "it names no rig";
    for (const cli::NamedFile& file : files) {
      const bool is_read = std::regex_search(file.takes, std::regex("RIG|EXPERIMENT|MODEL|RUN|CONTROLLER"));
      if (is_read && file.path.find('*') == std::string::npos && !fs::exists(at / file.path)) {
        return fmt::format("{} is not there", file.path);
      }
    }
  }
  return {};
}

/// Plays the way from a rig to a controller, and judges what each step and its pages suggest.
class Suggestions : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    folder_.write(kRig, content_of(source_file(fmt::format("config/rigs/{}.toml", GetParam()))));
  }

  std::string play(const Words& words, bool knows_rig = true) {
    const Ended ended = run_eha(words, folder_.path());
    const std::string text = ended.out + ended.err;
    for (const std::string& command : commands_of(text)) {
      ++seen_;
      EXPECT_EQ(fault_of(command, folder_.path(), knows_rig), "")
          << command << "\n  suggested by eha " << fmt::format("{}", fmt::join(words, " "));
    }
    return text;
  }

  void judge_pages() {
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      if (entry.path().extension() != ".html") continue;
      const std::string html = content_of(entry.path());
      std::set<std::string> commands;
      add_matches(html, "<code>(eha [^<]+)</code>", commands);
      for (const std::string& command : commands) {
        ++seen_;
        EXPECT_EQ(fault_of(unescaped(command), folder_.path()), "") << unescaped(command) << "\n  on " << entry.path();
      }
      EXPECT_EQ(html.find("RIG.toml"), std::string::npos) << entry.path();
    }
  }

  [[nodiscard]] std::string run_named(const std::string& part) const {
    for (const auto& entry : fs::directory_iterator(folder_.path() / "runs")) {
      const std::string name = entry.path().filename().string();
      if (!entry.is_symlink() && name.find(part) != std::string::npos) return "runs/" + name;
    }
    return "runs/none";
  }

  TemporaryFolder folder_;
  std::size_t seen_ = 0;
};

TEST_P(Suggestions, CanBePastedAndReachTheRigOfTheirRun) {
  const Words rig{"--local", "--fast", "--rig", kRig};
  const auto on_rig = [&](Words words) {
    words.insert(words.end(), rig.begin(), rig.end());
    return words;
  };
  const std::string paper = source_file("config/experiments/paper.toml");
  play(on_rig({"characterise"}));
  play(on_rig({"run", paper}));
  play(on_rig({"characterise", "-o", "rig-new.toml"}));
  play({"characterise", run_named("-characterise")});
  play({"check", "rig-new.toml"});
  play({"fit", "runs/latest"});
  play({"tune", "runs/latest", "--rig", kRig, "-o", "plain.toml"});
  play({"tune", "runs/latest", "--rig", kRig, "--sheet", run_named("-characterise"), "-o", "axis.toml"});
  play({"check", "axis.toml"});
  play(on_rig({"track", "axis.toml"}));
  play({"track", run_named("-track-axis")});
  play({"report", run_named("-track-axis")});
  play({"plot", "axis.toml", "-o", "step.svg"});
  play({"export", "axis.toml", "--format", "st", "-o", "axis.st"});
  play({"compare", run_named("-paper"), run_named("-characterise"), "-o", "changes.html"});
  play({"runs", "list"});
  play({"runs", "show", run_named("-paper")});
  play({"track", "axis.toml"});
  play({"run", paper}, false);
  play({"characterise"}, false);
  judge_pages();
  EXPECT_GT(seen_, 20U);
}

INSTANTIATE_TEST_SUITE_P(Rigs, Suggestions, testing::Values("sim", "sim-leaky"));

}  // namespace
}  // namespace eha::test
