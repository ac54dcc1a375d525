// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/fitter.hpp"

#include <gtest/gtest.h>

#include <string>

#include "daemon/record/run_folder.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

class FitConclusionTest : public ::testing::Test {
 protected:
  void write_manifest(const std::string& identification) {
    folder_.write("run.json",
                  R"({"schema":"eha-run/1","outcome":"completed","identification":)" + identification + "}");
  }
  [[nodiscard]] Json identification() const {
    return to_json(record::read_manifest(folder_.path())).at("identification");
  }

  test::TemporaryFolder folder_;
};

TEST_F(FitConclusionTest, HasTheModelsOfARunThatWasFittedWhateverTheVerdict) {
  write_manifest(R"({"accepted":false,"models":[{"name":"io","accepted":false}]})");
  for (const ExitCode code : {ExitCode::ok, ExitCode::model_rejected, ExitCode::not_converged}) {
    const FitConclusion fit = conclude_fit(folder_.path(), {static_cast<int>(code), "said"});
    EXPECT_TRUE(fit.fitted);
    EXPECT_EQ(fit.code, code);
    EXPECT_EQ(fit.models.at(0).at("name"), "io");
    EXPECT_EQ(fit.note, "");
    EXPECT_FALSE(identification().contains("error"));
  }
}

TEST_F(FitConclusionTest, WritesTheReasonIntoTheManifestOfARunThatWasNotFitted) {
  write_manifest("null");
  const FitConclusion killed = conclude_fit(folder_.path(), {std::nullopt, "killed by signal 9"});
  EXPECT_FALSE(killed.fitted);
  EXPECT_EQ(killed.code, ExitCode::not_converged);
  EXPECT_EQ(killed.note, "killed by signal 9");
  EXPECT_EQ(identification().at("error"), "killed by signal 9");
  const FitConclusion failed = conclude_fit(folder_.path(), {static_cast<int>(ExitCode::bad_data), "bad data"});
  EXPECT_FALSE(failed.fitted);
  EXPECT_EQ(failed.code, ExitCode::bad_data);
  EXPECT_EQ(identification().at("error"), "bad data");
  // A console puts this before every error by itself.
  const FitConclusion said = conclude_fit(folder_.path(), {10, "eha: error: the record has a hole"});
  EXPECT_EQ(said.note, "the record has a hole");
  EXPECT_EQ(identification().at("error"), "the record has a hole");
}

TEST_F(FitConclusionTest, NamesAManifestThatCannotBeWritten) {
  const FitConclusion fit = conclude_fit(folder_.path(), {std::nullopt, "killed"});
  EXPECT_NE(fit.manifest_error.find("run.json"), std::string::npos) << fit.manifest_error;
  EXPECT_TRUE(fit.models.empty());
}

TEST(Fitter, IsIdleWhenItsWorkerCannotBeStarted) {
  Fitter fitter({"/no/such/helper", "/no/such/eha"});
  EXPECT_THROW(fitter.start(3, "/run", {}), IoError);
  EXPECT_EQ(fitter.entry(), std::nullopt);
  EXPECT_FALSE(fitter.poll());
}

}  // namespace
}  // namespace eha::service
