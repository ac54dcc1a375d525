// SPDX-License-Identifier: GPL-3.0-or-later
// `eha completion`, tested with the shells themselves.
#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>

#include "tests/system/program.hpp"

namespace eha::test {
namespace {

/// Bash's completions of the last word; its builtin compopt works in an interactive shell only.
std::set<std::string> offered(const std::string& words) {
  std::istringstream lines(
      output_of_shell("cd '" + source_file("config").string() +
                      "' && bash -c 'compopt() { :; }; source <(" EHA_PROGRAM " completion bash); COMP_WORDS=(" +
                      words + "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _eha; printf \"%s\\n\" \"${COMPREPLY[@]}\"'"));
  std::set<std::string> all;
  for (std::string line; std::getline(lines, line);) all.insert(line);
  return all;
}

using Set = std::set<std::string>;

TEST(Completion, OffersTheCommandsThatBeginSo) { EXPECT_EQ(offered("eha ru"), (Set{"run", "runs"})); }

TEST(Completion, OffersTheOptionsOfTheCommandAndTheCommonOnes) {
  EXPECT_EQ(offered("eha fit --s"), (Set{"--seed", "--split", "--start", "--structure", "--sweep", "--sweep-orders"}));
  EXPECT_EQ(offered("eha --quiet fit --q"), Set{"--quiet"});
  EXPECT_EQ(offered("eha --l"), Set{""});
}

TEST(Completion, OffersTheChoicesOfAnOptionAndOfAnArgument) {
  EXPECT_EQ(offered("eha fit x.csv --initial-state a"), Set{"auto"});
  EXPECT_EQ(offered("eha fit x.csv --model i"), (Set{"integrator_lag", "io", "io1", "io3"}));
  EXPECT_EQ(offered("eha completion z"), Set{"zsh"});
}

TEST(Completion, OffersTheCommandsUnderACommand) { EXPECT_EQ(offered("eha runs re"), (Set{"recover", "remove"})); }

TEST(Completion, OffersFilesWhereAFileIsExpected) {
  EXPECT_EQ(offered("eha run experiments/p"), Set{"experiments/paper.toml"});
  EXPECT_EQ(offered("eha check --rig rigs/sim."), Set{"rigs/sim.toml"});
}

TEST(Completion, IsAScriptThatZshTakes) {
  if (output_of_shell("command -v zsh").empty()) GTEST_SKIP() << "zsh is not installed";
  EXPECT_EQ(output_of_shell("zsh -f -c 'autoload -Uz compinit && compinit -u -D; source <(" EHA_PROGRAM
                            " completion zsh) && echo ${_comps[eha]} ${+functions[_eha_runs_list]}' 2>&1"),
            "_eha 1\n");
}

}  // namespace
}  // namespace eha::test
