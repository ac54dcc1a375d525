// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/wrong_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/temporary_folder.hpp"

namespace eha::cli {
namespace {

using ::testing::HasSubstr;

class WrongFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("rig.toml", "backend = \"sim\"\n[limits]\nsafe_V = 0.0\n[sim]\nbore_mm = 40.0\n");
    folder_.write("experiment.toml", "name = \"one\"\nduration_s = 5.0\n[excitation]\nkind = \"multisine\"\n");
    folder_.write("axis.toml", "name = \"axis\"\n[feedback]\nkp = 1.0\n[promise]\ntwins = 50\n");
    folder_.write("model.json", "{\n  \"schema\": \"eha-model/1\"\n}\n");
    folder_.write("record.csv", "time_s,voltage_V,displacement_in\n0,0,1\n");
    folder_.write("broken.toml", "duration_s =\n");
  }

  [[nodiscard]] std::string said(const std::string& file, const std::string& takes) const {
    return wrong_file({{(folder_.path() / file).string(), takes}});
  }

  test::TemporaryFolder folder_;
};

TEST_F(WrongFile, IsNamedWithWhatItIsWhatWasExpectedAndWhatTakesIt) {
  const std::string said_of_rig = said("rig.toml", "EXPERIMENT");
  EXPECT_THAT(said_of_rig, HasSubstr("rig.toml: is a rig file (backend, [limits]), expected an experiment file"));
  EXPECT_THAT(said_of_rig, HasSubstr("[excitation], duration_s"));
  EXPECT_THAT(said_of_rig, HasSubstr("`eha check`"));
  EXPECT_THAT(said("experiment.toml", "RIG"), HasSubstr("is an experiment file"));
  EXPECT_THAT(said("axis.toml", "EXPERIMENT"), HasSubstr("`eha track`"));
  EXPECT_THAT(said("model.json", "CONTROLLER|RUN"),
              HasSubstr("expected a controller file ([feedback], [promise]) or a run"));
  EXPECT_THAT(said("record.csv", "MODEL"), HasSubstr("is a record"));
  EXPECT_THAT(said("experiment.toml", "SOURCE ..."), HasSubstr("expected a record"));
}

TEST_F(WrongFile, IsNoneOfTheRightKindOrOfNoKnownOne) {
  for (const auto& [file, takes] : {std::pair{"rig.toml", "RIG"},
                                    {"experiment.toml", "RIG|EXPERIMENT|CONTROLLER"},
                                    {"axis.toml", "MODEL|CONTROLLER|RUN"},
                                    {"model.json", "RUN|MODEL..."},
                                    {"record.csv", "RUN|FILE"},
                                    {"broken.toml", "EXPERIMENT"},
                                    {"missing.toml", "EXPERIMENT"},
                                    {"rig.toml", "LENGTH"}}) {
    EXPECT_EQ(said(file, takes), "") << file;
  }
}

}  // namespace
}  // namespace eha::cli
