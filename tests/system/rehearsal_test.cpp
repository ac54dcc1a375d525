// SPDX-License-Identifier: GPL-3.0-or-later
// What an experiment will do to the rod is said before it is played, and what it did after a trip.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using Json = nlohmann::json;

constexpr const char* kDrifts =
    "schema = 1\nname = \"drifts\"\nduration_s = 60.0\n[excitation]\nkind = \"sine\"\noffset_V = 0.8\n"
    "tones = [{ frequency_Hz = 0.2, amplitude_V = 2.0 }]\n[record]\ndiscard_s = 0.0\n[[model]]\nname = \"io\"\n"
    "structure = \"io\"\n";

TEST(Rehearsal, RefusesATripThatIsForetoldAndExplainsOneThatWasAccepted) {
  const std::string rig = source_file("config/rigs/sim.toml");
  const TemporaryFolder folder;
  folder.write("drifts.toml", kDrifts);
  const Ended good =
      run_eha({"check", source_file("config/experiments/paper.toml"), "--rig", rig, "--json"}, folder.path());
  ASSERT_EQ(good.code, 0) << good.err;
  EXPECT_LT(Json::parse(good.out).at("rehearsal").at("chance_of_trip").get<double>(), 0.05);
  EXPECT_EQ(good.err.find("warning"), std::string::npos) << good.err;
  const Ended bad = run_eha({"check", "drifts.toml", "--rig", rig}, folder.path());
  EXPECT_EQ(bad.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(bad.err.find("100 % of the rehearsed rods reach a limit"), std::string::npos) << bad.err;
  EXPECT_NE(bad.err.find("until it is stopped before a limit the rod moves within "), std::string::npos) << bad.err;
  const std::size_t offset = bad.err.find("set offset_V = ");
  ASSERT_NE(offset, std::string::npos) << bad.err;
  std::string better = kDrifts;
  better.replace(better.find("0.8"), 3, std::to_string(std::stod(bad.err.substr(offset + 15))));
  folder.write("better.toml", better);
  EXPECT_EQ(run_eha({"check", "better.toml", "--rig", rig}, folder.path()).code, 0) << better;
  const Ended risked = run_eha({"check", "drifts.toml", "--rig", rig, "--accept-travel-risk"}, folder.path());
  EXPECT_EQ(risked.code, 0) << risked.err;
  EXPECT_EQ(risked.out.find("Next: eha run"), std::string::npos) << "not under such a warning: " << risked.out;
  const Ended refused = run_eha({"run", "drifts.toml", "--local", "--fast", "--rig", rig}, folder.path());
  EXPECT_EQ(refused.code, static_cast<int>(ExitCode::configuration)) << refused.err;
  EXPECT_NE(refused.err.find("--accept-travel-risk"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "runs")) << "nothing is played";
  const Ended tripped =
      run_eha({"run", "drifts.toml", "--local", "--fast", "--rig", rig, "--accept-travel-risk"}, folder.path());
  EXPECT_EQ(tripped.code, static_cast<int>(ExitCode::safety_trip)) << tripped.err;
  EXPECT_NE(tripped.err.find("the rod drifted at +"), std::string::npos) << tripped.err;
  EXPECT_NE(tripped.err.find("offset_V = -0."), std::string::npos) << tripped.err;
}

TEST(Rehearsal, ThatWasNotPossibleLeavesOneRemedyForATripOnTerminalAndPage) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::size_t following = rig.find("[following]");
  rig.erase(following, rig.find("# How ticks are kept.") - following);
  folder.write("unmeasured.toml", rig);
  folder.write("drifts.toml", kDrifts);
  const Ended tripped = run_eha({"run", "drifts.toml", "--local", "--fast", "--rig", "unmeasured.toml"}, folder.path());
  ASSERT_EQ(tripped.code, static_cast<int>(ExitCode::safety_trip)) << tripped.err;
  ASSERT_NE(tripped.err.find("travel_limit"), std::string::npos) << tripped.err;
  const std::string cause = "he rig file has no [following], so that nothing showed beforehand where the rod goes: ";
  const std::string likely = "start nearer to mid-travel";
  std::string page;
  for (const auto& run : std::filesystem::directory_iterator(folder.path() / "runs")) {
    if (std::filesystem::exists(run.path() / "report.html")) page = content_of(run.path() / "report.html");
  }
  for (const std::string& text : {tripped.err, page}) {
    EXPECT_NE(text.find(cause), std::string::npos) << text.substr(0, 5000);
    EXPECT_EQ(text.find(likely), std::string::npos) << text.substr(0, 5000);
  }
}

TEST(Rehearsal, ThatPromisedOtherwiseShowsAnotherRig) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::size_t leak = rig.find("leakage_cm3_per_s_per_bar");
  ASSERT_NE(leak, std::string::npos);
  rig.replace(leak, rig.find('\n', leak) - leak, "leakage_cm3_per_s_per_bar = 0.3");
  folder.write("leaky.toml", rig);
  const Ended tripped = run_eha(
      {"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig", "leaky.toml"}, folder.path());
  EXPECT_EQ(tripped.code, static_cast<int>(ExitCode::safety_trip)) << tripped.err;
  EXPECT_NE(tripped.err.find("likely the valve is another one now, the rig leaks"), std::string::npos) << tripped.err;
  EXPECT_EQ(tripped.err.find("lower the amplitudes, or add"), std::string::npos) << tripped.err;
}

TEST(Rehearsal, NamesNoRemedyThatIsThereAndHowNearTheStartIsToTheLimit) {
  const TemporaryFolder folder;
  std::string text = kDrifts;
  text.replace(text.find("0.8"), 3, "0.0");
  text.replace(text.find("amplitude_V = 2.0"), 17, "amplitude_V = 4.0");
  text.insert(text.find("[excitation]"), "[start]\ndisplacement_mm = 141\n[hold]\n");
  folder.write("near.toml", text);
  const Ended near = run_eha({"check", "near.toml", "--rig", source_file("config/rigs/sim.toml")}, folder.path());
  EXPECT_EQ(near.code, static_cast<int>(ExitCode::configuration)) << near.err;
  EXPECT_NE(near.err.find("[start] is 5.05 mm from the limit of 146 mm: lower the amplitudes, or move [start]"),
            std::string::npos)
      << near.err;
  EXPECT_EQ(near.err.find("add [hold]"), std::string::npos) << near.err;
}

TEST(Rehearsal, NamesTheMoveToMidTravelWhereThatIsAllThatIsMissing) {
  const TemporaryFolder folder;
  const Ended far = run_eha({"check", source_file("config/experiments/paper.toml"), "--rig",
                             source_file("config/rigs/sim.toml"), "--at", "5in"},
                            folder.path());
  EXPECT_EQ(far.code, static_cast<int>(ExitCode::configuration));
  EXPECT_NE(
      far.err.find("the rod stands at 5.000 in, and from mid-travel the experiment stays clear of them: `eha goto "
                   "2.95in` first"),
      std::string::npos)
      << far.err;
}

TEST(Rehearsal, NamesNoMoveThatALocalSimulatedRodForgets) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::string start = "initial_displacement_in = 2.95";
  folder.write("rig.toml", rig.replace(rig.find(start), start.size(), "initial_displacement_in = 5.0"));
  const std::string paper = source_file("config/experiments/paper.toml");
  const Ended run = run_eha({"run", paper, "--local", "--fast", "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(run.code, static_cast<int>(ExitCode::configuration));
  EXPECT_EQ(run.err.find("eha goto"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("put [start] with displacement_in = 2.95 into it"), std::string::npos) << run.err;
  folder.write("paper.toml", content_of(paper) + "\n[start]\ndisplacement_in = 2.95\n");
  const Ended checked = run_eha({"check", "paper.toml", "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.err;
  const Ended signed_place = run_eha({"goto", "+60mm", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(signed_place.code, static_cast<int>(ExitCode::usage));
  EXPECT_NE(signed_place.err.find("goto takes a place; write 60mm, or"), std::string::npos) << signed_place.err;
  const Ended placed = run_eha({"goto", "60mm", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(placed.code, 0) << placed.err;
  EXPECT_NE(placed.err.find("begins each time where rig.toml says"), std::string::npos) << placed.err;
  EXPECT_NE(placed.out.find("Next: eha plot runs/"), std::string::npos) << placed.out;
}

TEST(Rehearsal, SaysWhatToDoWithTheDriftOfTheShippedPair) {
  const TemporaryFolder folder;
  const Ended checked =
      run_eha({"check", source_file("config/experiments/paper.toml"), "--rig", source_file("config/rigs/sim.toml")},
              folder.path());
  ASSERT_EQ(checked.code, 0) << checked.err;
  EXPECT_NE(checked.out.find("leave no room for the offset_V"), std::string::npos) << checked.out;
  EXPECT_NE(checked.out.find("may be played as it is"), std::string::npos) << "Next: is eha run: " << checked.out;
  EXPECT_NE(checked.out.find("Next: eha run "), std::string::npos) << checked.out;
}

TEST(Rehearsal, SaysOfVoltsWithinTheDeadBandThatTheRodDriftsWhereItDoes) {
  const TemporaryFolder folder;
  const auto warning = [&](double offset_V) {
    folder.write("e.toml", fmt::format("schema = 1\nname = \"e\"\nduration_s = 60.0\n[excitation]\nkind = \"sine\"\n"
                                       "offset_V = {:.2f}\ntones = [{{ frequency_Hz = 0.2, amplitude_V = 0.2 }}]\n",
                                       offset_V));
    const Ended checked = run_eha({"check", "e.toml", "--rig", source_file("config/rigs/sim.toml")}, folder.path());
    EXPECT_EQ(checked.code, 0) << checked.err;
    return checked.err;
  };
  const std::string drifting = warning(-0.12);
  EXPECT_NE(drifting.find("to one side and otherwise hardly moves"), std::string::npos) << drifting;
  EXPECT_EQ(drifting.find("will hardly move"), std::string::npos) << drifting;
}

TEST(Rehearsal, IsRefusedFromBeyondATravelLimitWithTheWayBack) {
  const TemporaryFolder folder;
  std::string rig = "units = \"mm\"\n" + content_of(source_file("config/rigs/sim.toml"));
  const std::string start = "initial_displacement_in = 2.95";
  rig.replace(rig.find(start), start.size(), "initial_displacement_in = 0.05");
  folder.write("rig.toml", rig);
  const std::string paper = source_file("config/experiments/paper.toml");
  const std::string way =
      "2.540 mm beyond the lower travel limit of 3.810 mm, from where no experiment is played: "
      "set where it begins each time, initial_displacement_in (or _mm) of [sim] in rig.toml";
  for (const std::vector<std::string>& words : {std::vector<std::string>{"check", paper, "--rig", "rig.toml"},
                                                {"run", paper, "--local", "--fast", "--rig", "rig.toml"}}) {
    const Ended ended = run_eha(words, folder.path());
    EXPECT_EQ(ended.code, static_cast<int>(ExitCode::configuration)) << ended.err;
    EXPECT_NE(ended.err.find(way), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("lower the amplitudes"), std::string::npos) << ended.err;
  }
  const Ended inside = run_eha({"check", paper, "--rig", "rig.toml", "--at", "75mm"}, folder.path());
  EXPECT_EQ(inside.code, 0) << inside.err;
}

TEST(Rehearsal, OnTheFileOfAMachineThatNoServiceDrivesLeadsToNoService) {
  const TemporaryFolder folder;
  folder.write("other.toml", content_of(source_file("config/rigs/pci1716.toml")));
  std::string small = kDrifts;
  small.replace(small.find("0.8"), 3, "0.0");
  small.replace(small.find("amplitude_V = 2.0"), 17, "amplitude_V = 0.5");
  folder.write("small.toml", small);
  const Ended checked = run_eha({"check", "small.toml", "--rig", "other.toml"}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_NE(checked.out.find("--local --rig other.toml\n"), std::string::npos) << checked.out;
  EXPECT_EQ(checked.out.find("--fast"), std::string::npos) << checked.out;
}

TEST(Rehearsal, NamesTheCheckedFileInEachCommandItSuggests) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::string null = "\nnull_V = ";
  rig.replace(rig.find(null), null.size(), "\nnull_V = 0.6 # ");
  folder.write("drift.toml", rig);
  const Ended checked =
      run_eha({"check", source_file("config/experiments/paper.toml"), "--rig", "drift.toml"}, folder.path());
  const std::string said = checked.out + checked.err;
  EXPECT_NE(said.find("eha characterise -o rig-new.toml --local --fast --rig drift.toml`"), std::string::npos) << said;
  EXPECT_EQ(said.find("--local --fast`"), std::string::npos) << said;
}

TEST(Rehearsal, IsSaidToBeMissingWhereTheRigFileDoesNotHaveTheValve) {
  const TemporaryFolder folder;
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  const std::size_t following = rig.find("\n[following]");
  rig.erase(following, rig.find("\n[", following + 1) - following);
  folder.write("rig.toml", rig);
  const std::string missing = "not rehearsed, because rig.toml has no [following]";
  const std::string paper = source_file("config/experiments/paper.toml");
  const Ended checked = run_eha({"check", paper, "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_NE(checked.err.find(missing), std::string::npos) << checked.err;
  const std::string measure = "eha characterise -o rig-new.toml --local --fast --rig rig.toml";
  EXPECT_NE(checked.err.find("play `" + measure + "` first"), std::string::npos) << checked.err;
  EXPECT_NE(checked.out.find("Next: " + measure + "\n"), std::string::npos)
      << "the run is no step before it: " << checked.out;
  const Ended rig_itself = run_eha({"check", "rig.toml"}, folder.path());
  EXPECT_NE(rig_itself.err.find("experiments are not rehearsed"), std::string::npos) << rig_itself.err;
  EXPECT_NE(rig_itself.out.find("Next: " + measure + "\n"), std::string::npos) << rig_itself.out;
  // A rig without its valve is written on request, and nothing moves.
  const Ended bare = run_eha({"characterise", "--without-following", "-o", "bare.toml", "--local", "--rig",
                              source_file("config/rigs/sim.toml")},
                             folder.path());
  EXPECT_EQ(bare.code, 0) << bare.err;
  EXPECT_NE(bare.out.find("--rig bare.toml\n"), std::string::npos) << bare.out;
  EXPECT_NE(run_eha({"check", "bare.toml"}, folder.path()).err.find("no [following]"), std::string::npos);
  const Ended told = run_eha({"check", paper, "--rig", "rig.toml", "--json"}, folder.path());
  EXPECT_TRUE(Json::parse(told.out).at("rehearsal").is_null()) << told.out;
  folder.write("short.toml",
               "schema = 1\nname = \"short\"\nduration_s = 10.0\n[excitation]\nkind = \"sine\"\n"
               "tones = [{ frequency_Hz = 0.5, amplitude_V = 1.0 }]\n[[model]]\nname = \"il\"\n"
               "structure = \"integrator_lag\"\ninput_map = \"valve\"\n");
  const Ended played = run_eha({"run", "short.toml", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
  EXPECT_NE(played.err.find(missing), std::string::npos) << played.err;
  // What plays no table of its own is not rehearsed at all.
  const Ended placed = run_eha({"goto", "3in", "--local", "--fast", "--rig", "rig.toml"}, folder.path());
  EXPECT_EQ(placed.err.find("not rehearsed"), std::string::npos) << placed.err;
  const Ended with = run_eha({"check", paper, "--rig", source_file("config/rigs/sim.toml")}, folder.path());
  EXPECT_EQ(with.err.find("not rehearsed"), std::string::npos) << with.err;
}

}  // namespace
}  // namespace eha::test
