// SPDX-License-Identifier: GPL-3.0-or-later
// The tick loop and cyclictest (rt-tests) in turns on one machine, idle and under load: wake-up latency of both, their
// ratios, and the duration of a tick on the simulated rig. On shared machines two runs of cyclictest differ by a factor
// of two, so several alternating runs are made and no figure is judged.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/doctor/latency.hpp"
#include "daemon/doctor/load_threads.hpp"

extern char** environ;

namespace {

using eha::acquisition::Histogram;
using eha::acquisition::RunReport;

constexpr int kHistogramLength_us = 100000;

/// p50, p99, p99.9 and maximum [us].
using Figures = std::array<double, 4>;
constexpr std::array<const char*, 4> kFigureNames{"p50", "p99", "p99.9", "max"};
constexpr std::array<double, 3> kShares{0.5, 0.99, 0.999};

Figures figures_of(const Histogram& histogram) {
  Figures figures{};
  for (std::size_t i = 0; i < kShares.size(); ++i) figures[i] = histogram.percentile_us(kShares[i]);
  figures[3] = static_cast<double>(histogram.maximum_ns()) * 1e-3;
  return figures;
}

/// Of cyclictest's JSON: {"thread": {"0": {"histogram": {"15": 1, ...}, "cycles": ..., "max": ...}}}. Like Histogram, a
/// percentile is the upper edge of its bucket.
Figures figures_of_cyclictest(const nlohmann::json& document) {
  const nlohmann::json& thread = document.at("thread").at("0");
  std::map<int, double> counts;
  for (const auto& [latency_us, count] : thread.at("histogram").items()) counts[std::stoi(latency_us)] = count;
  const auto cycles = thread.at("cycles").get<double>();
  Figures figures{};
  figures[3] = thread.at("max").get<double>();
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    figures[i] = figures[3];
    double seen = 0.0;
    for (const auto& [latency_us, count] : counts) {
      seen += count;
      if (seen < std::ceil(kShares[i] * cycles)) continue;
      figures[i] = latency_us + 1;
      break;
    }
  }
  return figures;
}

/// Runs a program to its end, its standard output thrown away. @returns its exit code
int run_program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start cyclictest; install rt-tests");
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status)) throw std::runtime_error("cyclictest was killed");
  return WEXITSTATUS(status);
}

/// cyclictest as the loop runs: SCHED_FIFO 80, memory locked, absolute wake-ups on CLOCK_MONOTONIC every millisecond.
Figures run_cyclictest(int seconds, bool fifo) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("cyclictest-{}.json", getpid());
  std::vector<std::string> words{"cyclictest",
                                 "--quiet",
                                 "--threads=1",
                                 "--interval=1000",
                                 fmt::format("--loops={}", seconds * 1000),
                                 fmt::format("--histogram={}", kHistogramLength_us),
                                 fmt::format("--json={}", file.string())};
  if (fifo) {
    words.insert(words.end(), {"--mlockall", "--priority=80"});
  } else {
    words.emplace_back("--policy=other");
  }
  const int code = run_program(words);
  std::ifstream stream(file);
  const nlohmann::json document = nlohmann::json::parse(stream, nullptr, false);
  std::filesystem::remove(file);
  if (code != 0 || document.is_discarded()) throw std::runtime_error(fmt::format("cyclictest ended with {}", code));
  return figures_of_cyclictest(document);
}

RunReport run_loop(int seconds) {
  const eha::acquisition::StopRequest stop;
  return eha::doctor::measure_latency(seconds, {}, stop, {});
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::string row(const Figures& figures, const char* format) {
  std::string text;
  for (const double figure : figures) text += fmt::format(fmt::runtime(format), figure);
  return text;
}

void print_line(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

/// Alternating runs under one kind of load, and the medians over them.
void compare(const char* load_name, int runs, int seconds) {
  std::array<std::vector<double>, 4> ratios;
  Figures execution{};
  for (int run = 1; run <= runs; ++run) {
    const RunReport report = run_loop(seconds);
    const Figures loop = figures_of(report.latency);
    const Figures cyclictest = run_cyclictest(seconds, report.realtime.fifo);
    Figures ratio{};
    for (std::size_t i = 0; i < ratio.size(); ++i) {
      ratio[i] = loop[i] / std::max(cyclictest[i], 1.0);
      ratios[i].push_back(ratio[i]);
    }
    const Figures took = figures_of(report.execution);
    for (std::size_t i = 0; i < execution.size(); ++i) execution[i] = std::max(execution[i], took[i]);
    print_line(fmt::format("{:<5} {:>3}  loop       {} us   {} late, {} skipped", load_name, run, row(loop, "{:9.0f}"),
                           report.counters.late, report.counters.skipped));
    print_line(fmt::format("{:<5} {:>3}  cyclictest {} us", load_name, run, row(cyclictest, "{:9.0f}")));
    print_line(fmt::format("{:<5} {:>3}  ratio      {}", load_name, run, row(ratio, "{:9.2f}")));
  }
  Figures middle{};
  for (std::size_t i = 0; i < middle.size(); ++i) middle[i] = median(ratios[i]);
  print_line(fmt::format("{:<5} all  ratio      {}      (median)", load_name, row(middle, "{:9.2f}")));
  print_line(fmt::format("{:<5} all  tick takes {} us   (worst run)", load_name, row(execution, "{:9.0f}")));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The tick loop beside cyclictest: wake-up latency, idle and under load");
  int runs = 5;
  int seconds = 10;
  app.add_option("--runs", runs, "Alternating runs of each (default 5)")->check(CLI::Range(1, 1000));
  app.add_option("--seconds", seconds, "Length of each run (default 10)")->check(CLI::Range(1, 86400));
  CLI11_PARSE(app, argc, argv);
  try {
    const RunReport probe = run_loop(1);
    for (const std::string& sentence : probe.realtime.refused) print_line("note: " + sentence);
    if (!probe.realtime.fifo) print_line("note: both run on ordinary scheduling");
    std::string titles;
    for (const char* name : kFigureNames) titles += fmt::format("{:>9}", name);
    print_line(fmt::format("load  run  what       {}", titles));
    compare("idle", runs, seconds);
    const eha::doctor::LoadThreads load;
    compare("load", runs, seconds);
  } catch (const std::exception& error) {
    fmt::print(stderr, "loop_vs_cyclictest: error: {}\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
