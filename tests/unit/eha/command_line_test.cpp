// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/command_line.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/design_command.hpp"
#include "daemon/eha/fit_command.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/service_command.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::cli {
namespace {

using Words = std::vector<const char*>;

ParsedLine parse(Words words) {
  words.insert(words.begin(), "eha");
  return parse_command_line(static_cast<int>(words.size()), words.data());
}

/// The command of a line that must hold one of this kind.
template <typename Wanted>
Wanted command_of(const Words& words) {
  const ParsedLine line = parse(words);
  const auto* request = line.command.target<Request<Wanted>>();
  if (request == nullptr) throw std::logic_error("no command of this kind");
  return request->options;
}

std::string fault_of(const Words& words) {
  try {
    static_cast<void>(parse(words));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no fault";
}

TEST(CommandLine, ReadsRun) {
  const auto run = command_of<RunCommand>({"run", "e.toml", "--local", "--rig", "r.toml", "--fast", "--output", "d"});
  EXPECT_EQ(run.experiment_file, "e.toml");
  EXPECT_EQ(run.rig_file, "r.toml");
  EXPECT_TRUE(run.local);
  EXPECT_TRUE(run.fast);
  EXPECT_FALSE(run.yes);
  EXPECT_EQ(run.output, "d");
  EXPECT_EQ(command_of<RunCommand>({"run", "e.toml"}).output, "runs");
}

TEST(CommandLine, NamesTheOptionOrCommandThatIsMeant) {
  EXPECT_NE(fault_of({"fitt", "a.csv"}).find("\"fitt\" (did you mean \"fit\"?)"), std::string::npos);
  EXPECT_NE(fault_of({"fit", "a.csv", "--decimat", "4"}).find("(did you mean \"--decimate\"?)"), std::string::npos);
  EXPECT_NE(fault_of({"fit", "a.csv", "--decimat=4"}).find("(did you mean \"--decimate\"?)"), std::string::npos);
  EXPECT_NE(fault_of({"fit", "a.csv", "--jsn"}).find("(did you mean \"--json\"?)"), std::string::npos);
  EXPECT_NE(fault_of({"runs", "lst"}).find("(did you mean \"list\"?)"), std::string::npos);
  EXPECT_NE(fault_of({"fit", "a.csv", "--out", "x"}).find("not expected: --out x (did you mean \"-o\"?)"),
            std::string::npos)
      << fault_of({"fit", "a.csv", "--out", "x"});
  EXPECT_EQ(fault_of({"fit", "a.csv", "--xyzzyxyzzy"}).find("did you mean"), std::string::npos);
  EXPECT_EQ(fault_of({"fit", "a.csv", "b.csv"}).find("did you mean"), std::string::npos);
}

TEST(CommandLine, NamesWhatTakesAFileThatACommandDoesNotExpect) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "bench.csv").string();
  std::ofstream(file) << "time_s,u_V,y_mm\n";
  const std::string fault = fault_of({"read", file.c_str()});
  EXPECT_NE(fault.find("bench.csv is a record (columns of numbers): `eha fit`, `eha import`"), std::string::npos)
      << fault;
  EXPECT_EQ(fault_of({"fit", "a.csv", file.c_str()}).find("is a record"), std::string::npos);
}

TEST(CommandLine, RefusesANameThatWouldWriteLinesOfItsOwn) {
  EXPECT_NE(fault_of({"fit", "a\nNext: eha touch x.csv"}).find("holds the end of a line"), std::string::npos);
  EXPECT_EQ(fault_of({"fit", "a\tb.csv"}), "no fault");
}

TEST(CommandLine, AllowsWhatTheServiceDecidesOnlyWithLocal) {
  EXPECT_NE(fault_of({"run", "e.toml", "--rig", "r.toml"}).find("--local"), std::string::npos);
  EXPECT_NE(fault_of({"run", "e.toml", "--output", "d"}).find("--local"), std::string::npos);
  EXPECT_NE(fault_of({"run", "e.toml", "--allow-non-realtime"}).find("--local"), std::string::npos);
  EXPECT_NE(fault_of({"run", "e.toml", "--local", "--socket", "s"}).find("--local"), std::string::npos);
  EXPECT_TRUE(command_of<RunCommand>({"run", "e.toml", "--fast"}).fast);
}

TEST(CommandLine, ReadsTheCommandsOfTheService) {
  for (const char* method : {"status", "arm", "disarm", "stop", "metrics", "reload"}) {
    EXPECT_EQ(command_of<ServiceCommand>({method}).method, method);
    EXPECT_EQ(command_of<ServiceCommand>({method}).socket, "/run/ehad/ehad.sock");
  }
  EXPECT_TRUE(command_of<ServiceCommand>({"status", "--watch"}).watch);
  EXPECT_NE(fault_of({"read", "--rig", "r.toml"}).find("--local"), std::string::npos);
  EXPECT_EQ(command_of<ServiceCommand>({"stop", "--socket", "s"}).socket, "s");
  const auto cancel = command_of<ServiceCommand>({"runs", "cancel", "7"});
  EXPECT_EQ(cancel.method, "cancel");
  EXPECT_EQ(cancel.entries, (std::vector<std::int64_t>{7}));
  EXPECT_NE(fault_of({"runs", "cancel", "0"}).find("number"), std::string::npos);
}

TEST(DisplayUnits, ReadLengthsWithTheirUnit) {
  EXPECT_DOUBLE_EQ(inches_of("2.95in").value_or(0.0), 2.95);
  EXPECT_NEAR(inches_of("+25.4 mm").value_or(0.0), 1.0, 1e-12);
  EXPECT_NEAR(inches_of("-5mm").value_or(0.0), -5.0 / 25.4, 1e-12);
  for (const char* wrong : {"2.95", "in", "", "nanin", "infmm", "3 V", "1in2"}) EXPECT_FALSE(inches_of(wrong)) << wrong;
}

TEST(CommandLine, ReadsQueue) {
  EXPECT_EQ(command_of<ServiceCommand>({"queue"}).method, "queue");
  EXPECT_EQ(command_of<ServiceCommand>({"queue", "list", "--socket", "s"}).method, "queue");
  EXPECT_EQ(command_of<ServiceCommand>({"queue", "release"}).entries, std::vector<std::int64_t>());
  const auto release = command_of<ServiceCommand>({"queue", "release", "7", "--socket", "s"});
  EXPECT_EQ(release.method, "release");
  EXPECT_EQ(release.entries, (std::vector<std::int64_t>{7}));
  EXPECT_EQ(release.socket, "s");
  EXPECT_EQ(command_of<ServiceCommand>({"queue", "cancel", "7", "8"}).entries, (std::vector<std::int64_t>{7, 8}));
  EXPECT_EQ(command_of<ServiceCommand>({"queue", "hold"}).method, "hold");
  const auto up = command_of<ServiceCommand>({"queue", "move", "7", "up"});
  EXPECT_EQ(up.method, "move");
  EXPECT_EQ(up.by, -1);
  EXPECT_EQ(up.entries, (std::vector<std::int64_t>{7}));
  EXPECT_EQ(command_of<ServiceCommand>({"queue", "move", "7", "3"}).to, 3);
  EXPECT_NE(fault_of({"queue", "move", "7", "0"}).find("a position from 1"), std::string::npos);
}

TEST(CommandLine, ReadsSeveralExperiments) {
  const auto run = command_of<RunCommand>({"run", "a.toml", "b.toml", "--detach"});
  EXPECT_EQ(run.experiment_file, "a.toml");
  EXPECT_EQ(run.further_files, (std::vector<std::string>{"b.toml"}));
  EXPECT_TRUE(run.detach);
  EXPECT_NE(fault_of({"run", "a.toml", "--local", "--detach"}).find("--local"), std::string::npos);
  EXPECT_FALSE(fault_of({"run"}).empty());
}

TEST(CommandLine, ReadsFit) {
  const auto fit = command_of<FitCommand>({"fit",
                                           "--model",
                                           "io",
                                           "--model",
                                           "fo",
                                           "r.csv",
                                           "--poles",
                                           "3",
                                           "--zeros",
                                           "1",
                                           "--delay",
                                           "free",
                                           "--procedure",
                                           "paper",
                                           "--fix",
                                           "a=1",
                                           "--fix",
                                           "b=-2",
                                           "--decimate",
                                           "40",
                                           "--discard",
                                           "10",
                                           "--split",
                                           "1",
                                           "--seed",
                                           "7",
                                           "--initial-state",
                                           "none",
                                           "-o",
                                           "out",
                                           "--input-before",
                                           "-0.5"});
  EXPECT_EQ(fit.source, "r.csv");
  EXPECT_EQ(fit.models.families, (std::vector<std::string>{"io", "fo"}));
  EXPECT_EQ(fit.models.poles, 3);
  EXPECT_EQ(fit.models.zeros, 1);
  EXPECT_EQ(fit.models.delay, "free");
  EXPECT_EQ(fit.procedure, ident::Procedure::paper);
  EXPECT_EQ(fit.models.fixed, (std::vector<std::string>{"a=1", "b=-2"}));
  EXPECT_EQ(fit.record.decimation, 40);
  EXPECT_EQ(fit.record.discard_s, 10.0);
  EXPECT_EQ(fit.record.split, 1.0);
  EXPECT_EQ(fit.record.input_before, -0.5);
  EXPECT_EQ(fit.seed, 7U);
  EXPECT_EQ(fit.models.initial_state, ident::InitialState::none);
  EXPECT_EQ(fit.output, "out");
  EXPECT_FALSE(fit.cross_validate);
  EXPECT_TRUE(command_of<FitCommand>({"fit", "run", "--cross-validate"}).cross_validate);
}

TEST(CommandLine, KeepsTheFitAsGivenForTheNextOne) {
  const auto fit = command_of<FitCommand>({"fit", "my record.csv", "--poles", "3", "--fix", "a0=0"});
  EXPECT_EQ(fit.import.command, "eha fit 'my record.csv' --poles 3 --fix a0=0");
}

TEST(CommandLine, ReadsDesign) {
  EXPECT_EQ(command_of<DesignCommand>({"design", "e.toml", "-o", "u.csv"}).output, "u.csv");
  const auto design = command_of<DesignCommand>({"design", "--from", "m.json", "--improve", "n2", "--to", "0.05"});
  EXPECT_FALSE(design.experiment_file);
  EXPECT_EQ(design.model_file, "m.json");
  EXPECT_EQ(design.parameter, "n2");
  EXPECT_EQ(design.wanted_std, 0.05);
}

TEST(CommandLine, TakesCommonOptionsBeforeAndAfterTheCommand) {
  EXPECT_TRUE(parse({"--json", "check", "e.toml"}).console.json);
  EXPECT_TRUE(parse({"check", "e.toml", "--json"}).console.json);
  EXPECT_TRUE(parse({"runs", "list", "-q"}).console.quiet);
  EXPECT_TRUE(parse({"runs", "list", "--no-progress"}).console.no_progress);
}

TEST(CommandLine, ListsTheRunsWithRunsAlone) {
  EXPECT_EQ(fault_of({"runs"}), "no fault");
  EXPECT_TRUE(parse({"runs"}).command) << "it does something";
}

TEST(CommandLine, RefusesWhatItDoesNotKnow) {
  for (const auto& words : std::vector<Words>{
           {},
           {"frobnicate"},
           {"run"},
           {"check", "a", "b"},
           {"fit", "r.csv", "--model", "pid"},
           {"fit", "r.csv", "--poles", "0"},
           {"fit", "r.csv", "--poles", "11"},
           {"fit", "r.csv", "--poles", "2.5"},
           {"fit", "r.csv", "--split", "0"},
           {"fit", "r.csv", "--split", "1.1"},
           {"fit", "r.csv", "--split", "nan"},
           {"fit", "r.csv", "--discard", "-1"},
           {"fit", "r.csv", "--decimate", "0"},
           {"fit", "r.csv", "--seed", "-1"},
           {"fit", "r.csv", "--procedure", "Paper"},
           {"fit", "r.csv", "--seed", "1", "--seed", "2"},
           {"simulate", "m.json", "u.csv", "--method", "euler"},
           {"runs", "frobnicate"},
           {"check", "e.toml", "--unknown"},
       }) {
    EXPECT_NE(fault_of(words), "no fault") << (words.empty() ? "nothing" : words.back());
  }
}

TEST(CommandLine, SaysWhereHelpIs) {
  EXPECT_NE(fault_of({"fit", "r.csv", "--poles", "0"}).find("see `eha fit --help`"), std::string::npos);
}

TEST(CommandLine, SaysWhatWasExpectedWithAnExample) {
  const std::string fault = fault_of({"import", "r.csv", "--force"});
  EXPECT_NE(fault.find("--force"), std::string::npos) << fault;
  EXPECT_NE(fault.find("expected `eha import FILE [OPTIONS]`"), std::string::npos) << fault;
  EXPECT_NE(fault.find("for example `eha import bench.csv -o record.csv`"), std::string::npos) << fault;
  const std::string missing = fault_of({"validate", "m.json"});
  EXPECT_NE(missing.find("expected `eha validate MODEL SOURCE [OPTIONS]`"), std::string::npos) << missing;
  EXPECT_NE(fault_of({"runs", "frobnicate"}).find("expected `eha runs"), std::string::npos)
      << fault_of({"runs", "frobnicate"});
}

TEST(CommandLine, TakesHelpAsACommand) {
  EXPECT_EQ(parse({"help", "fit"}).text, parse({"fit", "--help"}).text);
  EXPECT_EQ(parse({"help"}).text, parse({"--help"}).text);
  EXPECT_NE(fault_of({"fti", "r.csv"}).find("(did you mean \"fit\"?)"), std::string::npos)
      << fault_of({"fti", "r.csv"});
}

TEST(CommandLine, ExplainsItself) {
  const std::string help = parse({"--help"}).text;
  for (const char* command : {"run", "fit", "simulate", "validate", "check", "design", "runs"}) {
    // In the list of commands: on a line of its own, in front of its sentence.
    EXPECT_NE(help.find("\n  " + std::string(command) + " "), std::string::npos) << command << " in\n" << help;
  }
  EXPECT_NE(help.find("\nExit codes:\n"), std::string::npos);
  EXPECT_NE(help.find("\nExamples:\n"), std::string::npos);
  for (const char* command : {"run", "fit", "simulate", "validate", "check", "design", "runs"}) {
    const std::string text = parse({command, "--help"}).text;
    const std::size_t examples = text.find("\nExamples:\n");
    ASSERT_NE(examples, std::string::npos) << command;
    EXPECT_NE(text.find("eha " + std::string(command) + " ", examples), std::string::npos) << text;
  }
}

TEST(CommandLine, NamesItsVersionAndBackends) {
  const std::string version = parse({"--version"}).text;
  EXPECT_EQ(version.rfind("eha ", 0), 0U) << version;
  EXPECT_NE(version.find("comedi backend: "), std::string::npos) << version;
  EXPECT_NE(version.find("NLopt"), std::string::npos) << version;
}

TEST(CommandLine, BoundsTheDurationOfLatency) {
  EXPECT_NE(fault_of({"latency", "--duration", "0"}).find("0.1 to 65535"), std::string::npos);
  EXPECT_NE(fault_of({"latency", "--duration", "nan"}).find("0.1 to 65535"), std::string::npos);
}

}  // namespace
}  // namespace eha::cli
