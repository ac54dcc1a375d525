// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_options.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::cli {
namespace {

using ident::ParameterRequest;
using ident::StructureOptions;

/// Message of the usage error that these options end in.
std::string fault_of(const ModelOptions& options) {
  try {
    static_cast<void>(structures_for(options, {}));
    static_cast<void>(ladder_for(options));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no fault";
}

TEST(ModelOptions, NameNoStructureWhereNothingIsAskedSoThatTheLadderIsClimbed) {
  EXPECT_TRUE(structures_for({}, {}).empty());
  const ident::LadderOptions ladder = ladder_for({});
  EXPECT_EQ(ladder.input_map, nullptr);
  EXPECT_FALSE(ladder.delay);
  EXPECT_TRUE(ladder.parameters.empty());
}

TEST(ModelOptions, ClimbTheLadderWhateverAnExperimentNames) {
  ModelOptions options;
  options.families = {"fo"};
  const std::vector<StructureOptions> configured = structures_for(options, {});
  ASSERT_EQ(configured.size(), 1U);
  EXPECT_EQ(structures_for({}, configured).size(), 1U);
  options.families = {std::string(kLadder)};
  EXPECT_TRUE(structures_for(options, configured).empty());
  options.families.emplace_back("io");
  EXPECT_EQ(fault_of(options), "--model ladder fits every structure of the ladder: leave out the other structures");
}

TEST(ModelOptions, ShapeTheWholeLadderWhereNoModelIsNamed) {
  ModelOptions options;
  options.poles = 3;
  options.zeros = 1;
  options.delay = "0.02";
  options.input_map = "valve";
  options.initial_state = ident::InitialState::none;
  options.fixed = {"n2=2"};
  const ident::LadderOptions ladder = ladder_for(options);
  EXPECT_EQ(ladder.io.poles, 3);
  EXPECT_EQ(ladder.io.zeros, 1);
  ASSERT_TRUE(ladder.delay && ladder.input_map);
  EXPECT_EQ(ladder.delay->value, 0.02);
  EXPECT_EQ(ladder.delay->freedom, ident::Freedom::held);
  EXPECT_EQ(ladder.input_map->name, "valve");
  EXPECT_EQ(ladder.initial_state, ident::InitialState::none);
  ASSERT_EQ(ladder.parameters.size(), 1U);
  EXPECT_EQ(ladder.parameters[0].name, "n2");
  options.zeros = 4;
  EXPECT_THROW(static_cast<void>(ladder_for(options)), UsageError);
}

TEST(ModelOptions, TakeTheExperimentsModelsUnlessOthersAreNamed) {
  StructureOptions third_order;
  third_order.name = "third";
  third_order.structure = ident::structures::io({3, 0});
  EXPECT_EQ(structures_for({}, {third_order}).front().structure.degrees->poles, 3);

  ModelOptions options;
  options.families = {"lag", "io"};
  const auto structures = structures_for(options, {third_order});
  ASSERT_EQ(structures.size(), 2U);
  EXPECT_EQ(structures[0].name, "lag");
  EXPECT_EQ(structures[1].name, "third");
  EXPECT_EQ(structures[1].structure.degrees->poles, 3);
}

TEST(ModelOptions, PutModelsBehindAMapAndNameThemSo) {
  ModelOptions options;
  options.families = {"io", "fo"};
  options.poles = 3;
  options.input_map = "valve";
  const auto structures = structures_for(options, {});
  ASSERT_EQ(structures.size(), 2U);
  EXPECT_EQ(structures[0].name, "io_valve");
  EXPECT_TRUE(structures[0].structure.input_map.valve);
  EXPECT_EQ(structures[0].structure.degrees->poles, 3);
  EXPECT_EQ(structures[1].name, "fo_valve");

  StructureOptions configured = structures[0];
  EXPECT_EQ(structures_for(options, {configured}).front().name, "io_valve");
  options = {};
  options.poles = 2;
  const auto kept = structures_for(options, {configured});
  EXPECT_TRUE(kept.front().structure.input_map.valve) << "other degrees keep the map";
  options = {};
  options.input_map = "none";
  EXPECT_EQ(structures_for(options, {configured}).front().name, "io");
  EXPECT_FALSE(structures_for(options, {configured}).front().structure.input_map.valve);
}

TEST(ModelOptions, TakeTheNamesThatTheTablesPrint) {
  ModelOptions named;
  named.families = {"io1_valve", "io_valve", "io"};
  const std::vector<StructureOptions> structures = structures_for(named, {});
  ASSERT_EQ(structures.size(), 3U);
  EXPECT_EQ(structures[0].name, "io1_valve");
  EXPECT_EQ(structures[0].structure.family, "io1");
  EXPECT_EQ(ident::input_map_kind_of(structures[0].structure).name, "valve");
  EXPECT_EQ(structures[1].name, "io_valve");
  EXPECT_EQ(structures[2].name, "io");
  EXPECT_EQ(ident::input_map_kind_of(structures[2].structure).name, "none");
  const std::vector<std::string> names = model_names();
  EXPECT_EQ(std::count(names.begin(), names.end(), "friction"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "friction_valve"), 0) << "a grey box has no map before it";
  named.families = {"io_valve", "io_valve"};
  EXPECT_NE(fault_of(named).find("given twice"), std::string::npos) << fault_of(named);
}

TEST(ModelOptions, GiveDegreesOnlyToModelsThatHaveThem) {
  ModelOptions options;
  options.families = {"io", "fo"};
  options.poles = 3;
  options.zeros = 1;
  const auto structures = structures_for(options, {});
  EXPECT_EQ(structures[0].structure.degrees->poles, 3);
  EXPECT_EQ(structures[0].structure.degrees->zeros, 1);
  EXPECT_FALSE(structures[1].structure.degrees);

  options.families = {"fo"};
  EXPECT_EQ(fault_of(options).substr(0, 30), "--poles and --zeros are for th");
  options.families = {"io"};
  options.zeros = 4;
  EXPECT_EQ(fault_of(options), "--zeros: expected at most 3, the number of poles, got 4");
}

TEST(ModelOptions, AddTheStructureOfAFile) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "s.toml").string();
  std::ofstream(file) << "name = \"two\"\ndenominator = [{ order = 1.2, free = true }, { order = 0 }]\n";
  ModelOptions options;
  options.structure_files = {file};
  options.delay = "0.1";
  ASSERT_EQ(structures_for(options, {}).size(), 1U);
  EXPECT_EQ(structures_for(options, {})[0].name, "two");
  EXPECT_EQ(structures_for(options, {})[0].structure.delay.value, 0.1);
  options.families = {"io"};
  EXPECT_EQ(structures_for(options, {}).size(), 2U);
  options.structure_files = {file, file};
  EXPECT_EQ(fault_of(options), "--structure " + file +
                                   ": another model is named two, and each would be written to two.json; give it "
                                   "another `name`");
  options.structure_files = {(folder.path() / "none.toml").string()};
  EXPECT_THROW(static_cast<void>(structures_for(options, {})), ConfigError);
}

TEST(ModelOptions, FreeOrHoldTheDelay) {
  ModelOptions options;
  options.families = {"io"};
  options.delay = "free";
  EXPECT_EQ(structures_for(options, {})[0].structure.delay.freedom, ident::Freedom::free);
  options.delay = "0.16";
  EXPECT_EQ(structures_for(options, {})[0].structure.delay.freedom, ident::Freedom::held);
  EXPECT_DOUBLE_EQ(structures_for(options, {})[0].structure.delay.value, 0.16);
  options.delay = "-1";
  EXPECT_EQ(fault_of(options), "--delay: expected free or seconds >= 0, got -1");
  options.delay = "soon";
  EXPECT_EQ(fault_of(options), "--delay soon: expected a finite number, got \"soon\"");
}

TEST(ModelOptions, CollectWhatIsAskedOfOneParameter) {
  ModelOptions options;
  options.families = {"io", "fo"};
  options.fixed = {"n1=0.9"};
  options.free = {"b0"};
  options.starts = {"n2=1.7"};
  options.bounds = {"n2=1.5:2"};
  const std::vector<ParameterRequest> parameters = structures_for(options, {})[1].parameters;
  ASSERT_EQ(parameters.size(), 3U);
  EXPECT_EQ(parameters[0].name, "n1");
  EXPECT_EQ(parameters[0].fixed, true);
  EXPECT_EQ(parameters[0].start, 0.9);
  EXPECT_EQ(parameters[1].name, "b0");
  EXPECT_EQ(parameters[1].fixed, false);
  EXPECT_EQ(parameters[2].name, "n2");
  EXPECT_FALSE(parameters[2].fixed.has_value());
  EXPECT_EQ(parameters[2].start, 1.7);
  EXPECT_EQ(parameters[2].lower, 1.5);
  EXPECT_EQ(parameters[2].upper, 2.0);
}

TEST(ModelOptions, OverrideWhatTheExperimentAsksOfAParameter) {
  StructureOptions configured;
  configured.parameters = {{.name = "a0", .fixed = true, .start = 1.0, .lower = {}, .upper = {}}};
  ModelOptions options;
  options.free = {"a0"};
  const auto structures = structures_for(options, {configured});
  ASSERT_EQ(structures[0].parameters.size(), 1U);
  EXPECT_EQ(structures[0].parameters[0].fixed, false);
  EXPECT_EQ(structures[0].parameters[0].start, 1.0);
}

TEST(ModelOptions, RefuseMalformedRequests) {
  EXPECT_EQ(fault_of({.fixed = {"n1"}}), "--fix n1: expected NAME=VALUE");
  EXPECT_EQ(fault_of({.fixed = {"=3"}}), "--fix =3: expected NAME=VALUE");
  EXPECT_EQ(fault_of({.fixed = {"n1=big"}}), "--fix n1=big: expected a finite number, got \"big\"");
  EXPECT_EQ(fault_of({.fixed = {"n1=nan"}}), "--fix n1=nan: expected a finite number, got \"nan\"");
  EXPECT_EQ(fault_of({.starts = {"n1=1x"}}), "--start n1=1x: expected a finite number, got \"1x\"");
  EXPECT_EQ(fault_of({.bounds = {"n1=1"}}), "--bound n1=1: expected NAME=LOW:HIGH");
  EXPECT_EQ(fault_of({.bounds = {"n1=2:1"}}), "--bound n1=2:1: the lower bound must be below the upper one");
  EXPECT_EQ(fault_of({.families = {"io", "io"}}).substr(0, 27), "--model io is given twice, ");
}

TEST(RecordOptions, OverrideOnlyWhatIsSet) {
  ident::FitOptions options;
  options.decimation = 40;
  options.discard_s = 10.0;
  options.split = 0.5;
  const ident::FitOptions changed = with(options, {.decimation = {}, .discard_s = 2.0, .split = 1.0}, 1);
  EXPECT_EQ(changed.decimation, 40);
  EXPECT_DOUBLE_EQ(changed.discard_s, 2.0);
  EXPECT_DOUBLE_EQ(changed.split, 1.0);
}

}  // namespace
}  // namespace eha::cli
