// SPDX-License-Identifier: GPL-3.0-or-later
// Names, units and reasons that a stranger wrote, through what is shown to people: pages, pictures, the text of
// gnuplot, the service's log and a terminal have the form that they have with harmless texts.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/os/files.hpp"
#include "core/terminal_text.hpp"
#include "daemon/ehad/log.hpp"
#include "daemon/plot/gnuplot.hpp"
#include "tests/unit/hostile_text.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using test::hostile;

/// Texts of each kind; EHA_CAMPAIGN_RUNS overrides.
int texts_wanted() {
  const char* asked = std::getenv("EHA_CAMPAIGN_RUNS");
  return asked != nullptr ? std::atoi(asked) : 10'000;
}

/// The elements of a page with the names of their attributes, in their order: what a browser makes of the text.
std::string markup_of(std::string_view html) {
  std::string markup;
  for (std::size_t at = html.find('<'); at != std::string_view::npos; at = html.find('<', at)) {
    char quote = '\0';
    for (; at < html.size(); ++at) {
      const char c = html[at];
      if (quote == '\0') markup += c;
      if (c == quote) {
        quote = '\0';
      } else if (quote == '\0' && (c == '"' || c == '\'')) {
        quote = c;
      } else if (quote == '\0' && c == '>') {
        break;
      }
    }
  }
  // gnuplot's attribute of a text with two blanks.
  constexpr std::string_view kSpace = " xml:space=\"";
  for (std::size_t at = markup.find(kSpace); at != std::string::npos; at = markup.find(kSpace, at)) {
    markup.erase(at, kSpace.size());
  }
  // What a text has between backticks is shown in a command's letters, and an option is not broken, whoever wrote it.
  for (const std::string_view code : {"<code>", "</code>", "<span class=\"></span>"}) {
    for (std::size_t at = markup.find(code); at != std::string::npos; at = markup.find(code, at)) {
      markup.erase(at, code.size());
    }
  }
  return markup;
}

Subject named(const std::string& name, const std::string& unit, const std::string& reason) {
  Subject subject = subject_of(name, ident::Grade::usable);
  ident::Model& model = subject.models.front().model;
  model.name = name;
  model.input_unit = unit;
  model.output_unit = unit;
  model.verdict->reasons = {reason};
  model.provenance["record"] = name;
  model.parameters.front().name = name;
  subject.models.front().file = name;
  subject.fit.input = {name, unit};
  subject.fit.output = {name, unit};
  subject.fit.models.front().model = name;
  subject.has_recommendation = true;
  subject.reason = reason;
  return subject;
}

TEST(HostileTextCampaign, AddsNoElementToAPage) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);  // without pictures, which take 0.2 s a page
  const std::string expected = markup_of(page_of(named("name", "unit", "reason")).html);
  EXPECT_GT(expected.size(), 1000U);
  std::mt19937_64 generator(31);
  const int pages = (texts_wanted() + 2) / 3;
  for (int i = 0; i < pages && !testing::Test::HasFailure(); ++i) {
    const std::string name = hostile(generator, 40);
    const std::string unit = hostile(generator, 20);
    const std::string reason = hostile(generator, 200);
    EXPECT_EQ(markup_of(page_of(named(name, unit, reason)).html), expected)
        << i << "\nname " << name << "\nunit " << unit << "\nreason " << reason;
  }
  setenv("PATH", path.c_str(), 1);
  fmt::print("{} pages with {} texts\n", pages, 3 * pages);
}

constexpr int kTextsOfAFigure = 5;

plot::Figure figure_of(const std::vector<std::string>& texts) {
  plot::Series series{.label = texts[0], .x = {0.0, 1.0, 2.0}, .y = {0.0, 0.5, 0.2}};
  return {.title = texts[1],
          .panels = {{.x_label = texts[2],
                      .y_label = texts[3],
                      .series = {series},
                      .captions = {{.x = 1.0, .y = 0.2, .text = texts[4]}}}}};
}

std::vector<std::string> hostile_texts(std::mt19937_64& generator) {
  std::vector<std::string> texts;
  for (int k = 0; k < kTextsOfAFigure; ++k) texts.push_back(hostile(generator, 40));
  return texts;
}

/// A script without what stands between single quotes, and without numbers, which depend on the lengths of texts.
std::string commands_of(const std::string& script) {
  std::string commands;
  bool in_text = false;
  for (const char c : script) {
    if (c == '\'') in_text = !in_text;
    if (!in_text && std::isdigit(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') commands += c;
  }
  // A long title has a second line: the same command again.
  std::string once;
  std::string before;
  std::istringstream lines(commands);
  for (std::string line; std::getline(lines, line); before = line) {
    if (line != before) once += line + "\n";
  }
  return once;
}

TEST(HostileTextCampaign, AddsNoCommandToGnuplot) {
  std::mt19937_64 generator(32);
  const std::vector<std::string> harmless(kTextsOfAFigure, "harmless");
  const int figures = texts_wanted() / kTextsOfAFigure;
  for (const plot::Surface surface : {plot::Surface::page, plot::Surface::file, plot::Surface::characters}) {
    const std::string expected = commands_of(plot::script_of(figure_of(harmless), surface));
    for (int i = 0; i < figures && !testing::Test::HasFailure(); ++i) {
      EXPECT_EQ(commands_of(plot::script_of(figure_of(hostile_texts(generator)), surface)), expected) << i;
    }
  }
  fmt::print("{} scripts with {} texts\n", 3 * figures, 3 * figures * kTextsOfAFigure);
}

TEST(HostileTextCampaign, AddsNoElementToAPicture) {
  constexpr int kFiguresOfACall = 50;
  std::mt19937_64 generator(33);
  const std::vector<std::string> harmless(kTextsOfAFigure, "harmless");
  std::vector<plot::Figure> figures(kFiguresOfACall, figure_of(harmless));
  const auto markups = [&] {
    std::vector<std::string> all;
    for (const plot::InlineFigure& figure : plot::draw_inline(figures)) {
      EXPECT_EQ(figure.error, "");
      all.push_back(markup_of(figure.svg));
    }
    return all;
  };
  const std::vector<std::string> expected = markups();
  EXPECT_GT(expected.front().size(), 300U);
  int drawn = 0;
  for (; drawn < texts_wanted() / kTextsOfAFigure && !testing::Test::HasFailure(); drawn += kFiguresOfACall) {
    for (plot::Figure& figure : figures) figure = figure_of(hostile_texts(generator));
    const std::vector<std::string> found = markups();
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k], expected[k]) << drawn << " " << k;
  }
  fmt::print("{} pictures with {} texts\n", drawn, kTextsOfAFigure * drawn);
}

TEST(HostileTextCampaign, AddsNoLineToTheLog) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "log").string();
  const int texts = texts_wanted();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const int log = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (dup2(log, STDERR_FILENO) < 0) _exit(2);
    service::set_up_log();
    std::mt19937_64 generator(34);
    constexpr int kAtOnce = 50;  // the queue is bounded
    for (int i = 0; i < texts; ++i) {
      spdlog::info("{}", hostile(generator, 200));
      if (i % kAtOnce == 0 && !service::flush_log(std::chrono::seconds(10))) _exit(1);
    }
    _exit(service::flush_log(std::chrono::seconds(10)) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
  std::istringstream lines(os::read_file(file));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    ASSERT_TRUE(line.starts_with("ehad: info: ")) << line;
    ASSERT_EQ(terminal_text(line), line);
  }
  EXPECT_EQ(count, texts);
  fmt::print("{} messages in {} lines\n", texts, count);
}

TEST(HostileTextCampaign, ControlsNoTerminalAndEndsNoLine) {
  std::mt19937_64 generator(35);
  const int texts = texts_wanted();
  for (int i = 0; i < texts; ++i) {
    const std::string text = hostile(generator, 200);
    const std::string shown = terminal_text(text);
    ASSERT_EQ(std::count(shown.begin(), shown.end(), '\n'), std::count(text.begin(), text.end(), '\n')) << i;
    const std::string line = one_line(text);
    for (std::size_t at = 0; at < line.size(); ++at) {
      const auto byte = static_cast<unsigned char>(line[at]);
      ASSERT_TRUE(byte >= ' ' && byte != 0x7f) << i;
      // U+0080 to U+009F; U+200E, U+200F; U+2028 to U+202E; U+2066 to U+2069.
      const auto next = static_cast<unsigned char>(at + 1 < line.size() ? line[at + 1] : '\0');
      const auto third = static_cast<unsigned char>(at + 2 < line.size() ? line[at + 2] : '\0');
      ASSERT_FALSE(byte == 0xC2 && next >= 0x80 && next < 0xA0) << i;
      ASSERT_FALSE(byte == 0xE2 && next == 0x80 && (third == 0x8E || third == 0x8F)) << i;
      ASSERT_FALSE(byte == 0xE2 && next == 0x80 && third >= 0xA8 && third <= 0xAE) << i;
      ASSERT_FALSE(byte == 0xE2 && next == 0x81 && third >= 0xA6 && third <= 0xA9) << i;
    }
  }
  fmt::print("{} texts\n", texts);
}

}  // namespace
}  // namespace eha::report
