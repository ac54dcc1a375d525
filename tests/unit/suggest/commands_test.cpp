// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/suggest/commands.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace eha::suggest {
namespace {

RigAccess local_rig() { return {.is_local = true, .is_fast = true, .rig_file = "my rig.toml"}; }

TEST(Suggestions, NameTheRigOfALocalRunInEveryCommandThatReachesIt) {
  const RigAccess rig = local_rig();
  EXPECT_EQ(run(rig, {"a.toml", "b.toml"}), "eha run a.toml b.toml --local --fast --rig 'my rig.toml'");
  EXPECT_EQ(characterise(rig), "eha characterise -o rig-new.toml --local --fast --rig 'my rig.toml'");
  EXPECT_EQ(track(rig, "axis.toml"), "eha track axis.toml --local --fast --rig 'my rig.toml'");
  EXPECT_EQ(read(rig), "eha read --local --rig 'my rig.toml'") << "which knows no --fast";
  EXPECT_EQ(tune(rig, "runs/latest", "runs/sheet"), "eha tune runs/latest --rig 'my rig.toml' --sheet runs/sheet");
}

TEST(Suggestions, NameTheServiceOfARunOfTheService) {
  const RigAccess rig{.is_fast = true, .rig_file = "unused.toml", .socket = "/tmp/s"};
  EXPECT_EQ(run(rig, {"a.toml"}), "eha run a.toml --fast --socket /tmp/s");
  EXPECT_EQ(read(rig), "eha read --socket /tmp/s");
  EXPECT_EQ(characterise({}), "eha characterise -o rig-new.toml");
  const RigAccess disarmed{.is_disarmed = true, .socket = "/tmp/s"};
  EXPECT_EQ(characterise(disarmed), "eha arm --socket /tmp/s && eha characterise -o rig-new.toml --socket /tmp/s");
  EXPECT_EQ(read(disarmed), "eha read --socket /tmp/s") << "moves nothing";
  EXPECT_EQ(run({.is_local = true, .is_disarmed = true}, {"a.toml"}), "eha run a.toml --local");
  EXPECT_EQ(sheet_into_rig_file({.is_local = true, .rig_file = "my rig.toml"}, "runs/a"),
            "eha characterise runs/a -o rig-new.toml --local --rig 'my rig.toml'");
}

TEST(Suggestions, NameNoCommandForTheValveOfAForeignRecord) {
  RigAccess rig;
  rig.new_rig_file.clear();
  EXPECT_EQ(completed("shift them further: `eha characterise` measures them", rig),
            "shift them further: a record of a slow triangle of volts about the null that is wider than the dead band "
            "measures them");
  EXPECT_EQ(
      completed("They shift. `eha characterise` measures them", rig),
      "They shift. A record of a slow triangle of volts about the null that is wider than the dead band measures them");
}

TEST(Suggestions, CompleteWhatATextNamesInShort) {
  RigAccess rig = local_rig();
  const std::string text =
      "measure the valve with `eha characterise`, then `eha tune`; as `eha tune` does; `eha track`";
  EXPECT_EQ(completed(text, rig),
            "measure the valve with `eha characterise -o rig-new.toml --local --fast --rig 'my rig.toml'`, then `eha "
            "tune`; as `eha tune` does; `eha track`")
      << "without a model and a controller";
  rig.model = "models/io.json";
  rig.controller = "axis.toml";
  const std::string whole = completed(text, rig);
  EXPECT_NE(whole.find("then `eha tune models/io.json --rig rig-new.toml`; as `eha tune` does"), std::string::npos)
      << whole;
  EXPECT_NE(whole.find("`eha track axis.toml --local --fast --rig 'my rig.toml'`"), std::string::npos) << whole;
  EXPECT_EQ(completed(whole, rig), whole);
}

TEST(Suggestions, NameTheRecordOfAFitWithAnotherStructure) {
  const std::string text =
      "fit the structure with dry friction (`eha fit --model friction`), or `eha fit --model outflow`";
  RigAccess rig;
  EXPECT_EQ(completed(text, rig), text);
  rig.fit = "eha fit 'my bench.csv' --to 78";
  const std::string whole = completed(text, rig);
  EXPECT_EQ(whole,
            "fit the structure with dry friction (`eha fit 'my bench.csv' --to 78 --model friction`), or `eha fit 'my "
            "bench.csv' --to 78 --model outflow`");
  EXPECT_EQ(completed(whole, rig), whole);
  rig.fit = "eha fit --to 78 -- -r.csv";
  EXPECT_EQ(completed("`eha fit --model friction`", rig), "`eha fit --to 78 --model friction -- -r.csv`");
}

TEST(Suggestions, EscapeTheNamesOfAPage) {
  RigAccess rig = local_rig();
  rig.rig_file = "<b>&'\n.toml";
  const std::string html = completed_html("<code>eha read</code>", rig);
  EXPECT_EQ(html.find("<b>"), std::string::npos) << html;
  EXPECT_EQ(html.find('\n'), std::string::npos) << html;
  EXPECT_NE(html.find("&lt;b&gt;&amp;"), std::string::npos) << html;
}

TEST(Suggestions, KnowFromARunHowItWasPlayed) {
  nlohmann::ordered_json manifest{{"time_base", "virtual"}, {"rig", {{"file", "/rigs/a.toml"}}}};
  EXPECT_EQ(read(access_of_run(manifest)), "eha read --local --rig /rigs/a.toml");
  manifest["played_by"] = "ehad";
  EXPECT_EQ(read(access_of_run(manifest)), "eha read");
  EXPECT_EQ(run(access_of_run(manifest), {"a.toml"}), "eha run a.toml --fast");
  manifest["played_by"] = "eha";
  manifest["time_base"] = "monotonic";
  EXPECT_EQ(run(access_of_run(manifest), {"a.toml"}), "eha run a.toml --local --rig /rigs/a.toml");
}

TEST(Suggestions, NameNewFilesOnAPageAfterItsRunAsTheUsualOnesMayBeThere) {
  const nlohmann::ordered_json manifest{{"utc_start", "2026-11-27T17:12:22Z"}};
  EXPECT_EQ(characterise(access_of_run(manifest)), "eha characterise -o rig-20261127T171222Z.toml");
  EXPECT_EQ(tune(access_of_run(manifest), "runs/a"), "eha tune runs/a -o controller-20261127T171222Z.toml");
}

}  // namespace
}  // namespace eha::suggest
