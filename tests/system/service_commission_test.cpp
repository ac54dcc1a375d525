// SPDX-License-Identifier: GPL-3.0-or-later
// A commissioning through the service, on the simulated rig.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/system/daemon.hpp"
#include "tests/system/drawn_rigs.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(ServiceCommission, StopsForTheRigFileAndGoesOnOnceItIsInstalled) {
  Daemon daemon;
  TemporaryFolder bench;
  {
    std::ofstream rig(daemon.rig_file());
    rig << unknown_rig();
  }
  daemon.start();
  const std::vector<std::string> words{
      "commission", daemon.rig_file().string(), "--socket", daemon.socket().string(), "--yes", "--fast", "--precision",
      "4"};
  const Ended first = run_eha(words, bench.path());
  EXPECT_EQ(first.code, 130) << first.err;
  EXPECT_THAT(first.err, HasSubstr("eha reload"));
  EXPECT_THAT(first.err, HasSubstr("to go on with this step: eha commission"));
  EXPECT_EQ(content_of(daemon.rig_file()), unknown_rig()) << "the service's file is its owner's";

  fs::copy_file(bench.path() / "commission" / "rig.toml", daemon.rig_file(), fs::copy_options::overwrite_existing);
  control::Client client(daemon.socket());
  client.call("disarm");
  client.call("reload");
  const Ended second = run_eha(words, bench.path());
  EXPECT_EQ(second.code, 0) << second.out << second.err;
  EXPECT_THAT(second.out, HasSubstr("the axis keeps the controller's promise"));
  EXPECT_THAT(second.out, Not(HasSubstr("$ eha characterise"))) << "the valve was measured before";
  EXPECT_TRUE(fs::exists(bench.path() / "commission" / "report.html"));
  std::string narrower = content_of(daemon.rig_file());
  const std::string limit = "\ntravel_max_in = 5.75 ";
  narrower.replace(narrower.find(limit), limit.size(), "\ntravel_max_in = 5.5 ");
  std::ofstream(daemon.rig_file()) << narrower;
  client.call("disarm");
  client.call("reload");
  client.call("arm");
  const Ended refused = run_eha({"track", "commission/axis.toml", "--socket", daemon.socket(), "--fast"}, bench.path());
  EXPECT_THAT(refused.err, HasSubstr("make it anew: `eha tune "));
  EXPECT_THAT(refused.err, HasSubstr(" --rig " + daemon.rig_file().string() + "`")) << "the limits in force";
  bool ended_early = false;
  for (const auto& run : manifests_of(daemon.runs()))
    ended_early = ended_early || run.at("outcome") == "precise_enough";
  EXPECT_TRUE(ended_early) << "the service ends a record once it is precise enough";
}

}  // namespace
}  // namespace eha::test
