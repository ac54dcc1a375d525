// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/metrics.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <sstream>
#include <string>

namespace eha::service {
namespace {

bool has_line(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

TEST(Metrics, AreLinesThatPrometheusTakes) {
  const std::string text = metrics_text({}, {});
  const std::regex sample(R"(ehad_[a-z_]+(\{[a-z]+="[a-z_]+"\})? -?[0-9][0-9.e+-]*)");
  const std::regex comment(R"(# (HELP ehad_[a-z_]+ .+|TYPE ehad_[a-z_]+ (counter|gauge)))");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(std::regex_match(line, line[0] == '#' ? comment : sample)) << line;
  }
}

TEST(Metrics, CountTheRunsThatAreOverAndTheOneThatIsOn) {
  Totals totals;
  acquisition::RunReport report;
  report.counters.ticks = 100;
  report.counters.late = 2;
  report.latency.add(5'000'000, 0);
  report.outcome = acquisition::Outcome::faulted;
  totals.add(report);
  MetricsFacts facts;
  facts.state = acquisition::State::running;
  facts.waiting = 3;
  facts.lease_remaining_s = 12.5;
  facts.snapshot.emplace();
  facts.snapshot->counters.ticks = 11;
  facts.snapshot->latency_max_ns = 4'000'000;
  const std::string text = metrics_text(totals, facts);
  EXPECT_TRUE(has_line(text, "ehad_ticks_total 111")) << text;
  EXPECT_TRUE(has_line(text, "ehad_late_ticks_total 2"));
  EXPECT_TRUE(has_line(text, "ehad_latency_max_seconds 0.005"));
  EXPECT_TRUE(has_line(text, "ehad_runs_total{outcome=\"faulted\"} 1"));
  EXPECT_TRUE(has_line(text, "ehad_runs_total{outcome=\"completed\"} 0"));
  EXPECT_TRUE(has_line(text, "ehad_state{state=\"running\"} 1"));
  EXPECT_TRUE(has_line(text, "ehad_state{state=\"idle\"} 0"));
  EXPECT_TRUE(has_line(text, "ehad_queue_length 3"));
  EXPECT_TRUE(has_line(text, "ehad_lease_remaining_seconds 12.5"));
}

}  // namespace
}  // namespace eha::service
