// SPDX-License-Identifier: GPL-3.0-or-later
// `eha plot` on files of other programs, and on folders that a stranger may have filled.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/batch_records.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

TEST(PlotCommand, DrawsARecordWithoutTimesByItsPeriod) {
  const TemporaryFolder folder;
  std::string rows = "voltage_V,displacement_mm\n";
  for (int k = 0; k < 200; ++k) {
    rows += std::to_string(std::sin(0.1 * k)) + "," + std::to_string(0.5 * std::sin(0.1 * k - 0.3)) + "\n";
  }
  folder.write("untimed.csv", rows);
  expect_refused(folder, {"plot", "untimed.csv"}, ExitCode::bad_data, {"`eha plot untimed.csv --period SECONDS`"});
  const Ended ended = run_eha({"plot", "untimed.csv", "--period", "0.02", "-o", "p.svg"}, folder.path());
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(content_of(folder.path() / "p.svg").find("displacement [mm]"), std::string::npos);
  const std::vector<std::string> as_before{"plot", "untimed.csv", "--period", "0.02", "--output", "q.svg"};
  EXPECT_EQ(run_eha(as_before, folder.path()).code, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "q.svg"));
}

TEST(PlotCommand, NamesWhatDrawsATableOfFigures) {
  const TemporaryFolder folder;
  folder.write("table.csv", "record,source,model,recommended,grade\n0001-bench,bench.csv,io,yes,good\n");
  expect_refused(folder, {"plot", "table.csv"}, ExitCode::bad_data,
                 {"table.csv: a table of `eha batch`, a row a model, without curves", "report.html"});
  folder.write("axis_table.csv", "part,figure,value,from,to,measured,noise adds to,unit,kept\naxis,controller,axis\n");
  expect_refused(folder, {"plot", "axis_table.csv"}, ExitCode::bad_data, {"a table of figures of an axis"});
}

TEST(PlotCommand, NamesTheComparisonForTwoSources) {
  const TemporaryFolder folder;
  expect_refused(folder, {"plot", "io.json", "fo.json"}, ExitCode::usage,
                 {"one picture is of one source, 2 are named", "`eha compare io.json fo.json -o compared.svg`"});
}

TEST(PlotCommand, FollowsNoLinkInTheFolderOfAFit) {
  const TemporaryFolder folder;
  folder.write("r.csv", first_order_record(1, 2.0, 300));
  ASSERT_EQ(run_eha({"fit", "r.csv", "--model", "io1", "-o", "m", "-q"}, folder.path()).code, 0);
  ASSERT_EQ(run_eha({"plot", "m/io1.json", "-o", "p.svg"}, folder.path()).code, 0);
  fs::rename(folder.path() / "m/fit.csv", folder.path() / "elsewhere.csv");
  fs::create_symlink("../elsewhere.csv", folder.path() / "m/fit.csv");
  for (const char* command : {"plot", "report"}) {
    expect_refused(folder, {command, "m/io1.json"}, ExitCode::bad_data, {"m/fit.csv: is a link"});
  }
}

TEST(PlotCommand, SaysTheGradeOfAModelAndDrawsTheRecommendedOneOfAFit) {
  const TemporaryFolder folder;
  folder.write("r.csv", first_order_record(1, 2.0, 300));
  ASSERT_EQ(run_eha({"fit", "r.csv", "--model", "io1", "--model", "lag", "-o", "m", "-q"}, folder.path()).code, 0);
  const Ended of_model = run_eha({"plot", "m/io1.json", "-o", "p.svg"}, folder.path());
  EXPECT_NE(of_model.out.find("io1: "), std::string::npos) << of_model.out;
  EXPECT_NE(content_of(folder.path() / "p.svg").find(">io1 ("), std::string::npos) << "the title has the grade";
  ASSERT_EQ(run_eha({"plot", "m/fit.csv", "-o", "f.svg"}, folder.path()).code, 0);
  const std::string drawn = content_of(folder.path() / "f.svg");
  EXPECT_NE(drawn.find(", recommended"), std::string::npos);
  EXPECT_NE(drawn.find("estimated before, validated after"), std::string::npos);
  // Without the files of its models: the table alone.
  fs::create_directory(folder.path() / "alone");
  fs::copy_file(folder.path() / "m/fit.csv", folder.path() / "alone/fit.csv");
  ASSERT_EQ(run_eha({"plot", "alone/fit.csv", "-o", "g.svg"}, folder.path()).code, 0);
  EXPECT_EQ(content_of(folder.path() / "g.svg").find("recommended"), std::string::npos);
}

TEST(PlotCommand, FollowsNoLinkOfAnotherUser) {
  const TemporaryFolder folder;
  folder.write("r.csv", first_order_record(1, 2.0, 300));
  fs::create_symlink("r.csv", folder.path() / "link.csv");
  EXPECT_EQ(run_eha({"plot", "link.csv", "-o", "p.svg"}, folder.path()).code, 0) << "a link of one's own";
  if (::geteuid() != 0) GTEST_SKIP() << "only root makes a link of another user";
  constexpr uid_t kStranger = 12345;
  ASSERT_EQ(::lchown((folder.path() / "link.csv").c_str(), kStranger, kStranger), 0);
  expect_refused(folder, {"plot", "link.csv"}, ExitCode::bad_data, {"link.csv: is a link of another user"});
}

}  // namespace
}  // namespace eha::test
