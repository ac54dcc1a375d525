// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are no record: the right exit code, one message with the next step, nothing written.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/system/foreign_files.hpp"
#include "tests/system/program.hpp"
#include "tests/system/refusal.hpp"

namespace eha::test {
namespace {

/// `eha fit` and `eha import` must refuse a file with this content.
void expect_refused_file(const std::string& name, const std::string& content,
                         const std::vector<std::string>& fragments) {
  const TemporaryFolder folder;
  folder.write(name, content);
  expect_refused(folder, {"fit", name, "-o", "models"}, ExitCode::bad_data, fragments);
  expect_refused(folder, {"import", name, "-o", "record.csv"}, ExitCode::bad_data, fragments);
}

std::string rows(const std::string& header, const std::string& row) {
  std::string text = header;
  for (int k = 0; k < 50; ++k) text += fmt::format(fmt::runtime(row), 0.01 * k, k % 7, 0.1 * k);
  return text;
}

TEST(BadFile, IsEmpty) { expect_refused_file("r.csv", "", {"r.csv", "empty", "expected"}); }

TEST(BadFile, IsAWorkbook) {
  expect_refused_file("r.xlsx", std::string("PK\x03\x04\x14\0\x06\0", 8), {"r.xlsx", "save as CSV"});
}

TEST(BadFile, IsBinary) {
  std::string bytes;
  for (int i = 0; i < 4096; ++i) bytes += static_cast<char>((i * 7919 + 13) % 251);
  expect_refused_file("r.dat", bytes, {"r.dat", "binary"});
}

TEST(BadFile, HasMixedSeparators) {
  const std::string text = rows("t;u;y\n", "{:.2f};{};{:.1f}\n") + "0.50,1,5.0\n" + rows("", "{:.2f};{};{:.1f}\n");
  expect_refused_file("r.csv", text, {"r.csv:52", "expected 3 columns", "got 1"});
}

TEST(BadFile, HasDuplicateHeaders) {
  expect_refused_file("r.csv", rows("time_s,value,value\n", "{:.2f},{},{:.1f}\n"),
                      {"two columns are named \"value\"", "--input 2 --output 3`"});
}

TEST(BadFile, HasThousandsSeparators) {
  std::string text = rows("t;u;y\n", "{:.2f};{};{:.1f}\n");
  expect_refused_file("r.csv", text + "0.50;1;1 234.5\n", {"r.csv:52", "1 234.5", "thousands separator"});
}

TEST(BadFile, HasWordsForMissingValues) {
  for (const char* word : {"NaN", "NA", "#N/A", "null", ""}) {
    const std::string text = rows("t;u;y\n", "{:.2f};{};{:.1f}\n") + fmt::format("0.50;1;{}\n", word);
    expect_refused_file("r.csv", text, {"r.csv:52", "number", "--resample`"});
  }
}

TEST(BadFile, HasDatesForTimes) {
  std::string text = "Date;u;y\n";
  for (int k = 0; k < 50; ++k) text += fmt::format("01.03.2024 10:00:{:02};{};{}\n", k / 10, k % 7, k);
  expect_refused_file("r.csv", text, {"dates or times of day", "--period 0.1`"});
}

TEST(BadFile, IsATruncatedMatFileOrHdf5File) {
  const TemporaryFolder made;
  static_cast<void>(write_foreign_files(measured(1000), made.path()));
  for (const char* name : {"struct5.mat", "struct73.mat", "matrix.mat", "datasets.h5"}) {
    const std::string whole = content_of(made.path() / name);
    expect_refused_file(name, whole.substr(0, whole.size() / 3), {name});
  }
}

TEST(BadFile, IsAMatFileOfCells) {
  const TemporaryFolder folder;
  std::size_t size[2] = {1, 3};
  matvar_t* cells = Mat_VarCreate("runs", MAT_C_CELL, MAT_T_CELL, 2, size, nullptr, 0);
  mat_t* file = Mat_CreateVer((folder.path() / "cells.mat").c_str(), nullptr, MAT_FT_MAT5);
  ASSERT_NE(file, nullptr);
  ASSERT_EQ(Mat_VarWrite(file, cells, MAT_COMPRESSION_NONE), 0);
  Mat_VarFree(cells);
  Mat_Close(file);
  expect_refused(folder, {"fit", "cells.mat"}, ExitCode::bad_data, {"cells.mat", "runs is a cell array", "cell2mat"});
}

TEST(BadFile, IsAnHdf5FileOfTwoRunsOrWithoutNumbers) {
  const TemporaryFolder folder;
  const Measured r = measured(200);
  write_hdf5(folder.path() / "two.h5",
             {{"a/t", r.time_s},
              {"a/u", r.input_V},
              {"a/y", r.output_in},
              {"b/t", r.time_s},
              {"b/u", r.input_V},
              {"b/y", r.output_in}},
             "");
  expect_refused(folder, {"fit", "two.h5"}, ExitCode::bad_data,
                 {"which column is the time", "`eha fit two.h5 --time 1`"});
  write_hdf5(folder.path() / "none.h5", {}, "");
  expect_refused(folder, {"fit", "none.h5"}, ExitCode::bad_data, {"without arrays of numbers"});
}

TEST(BadFile, NamesAColumnThatIsNotThere) {
  const TemporaryFolder folder;
  folder.write("r.csv", sound_record(1000));
  expect_refused(folder, {"fit", "r.csv", "--input", "force"}, ExitCode::usage,
                 {"--input force", "no such column", "2 \"voltage_V\""});
  expect_refused(folder, {"import", "r.csv", "--output", "7"}, ExitCode::usage, {"--output 7", "no such column"});
}

TEST(BadFile, IsNeverWrittenOverWhereItIsRead) {
  const TemporaryFolder folder;
  folder.write("r.csv", sound_record(1000));
  folder.write("m.json", "{}");
  std::filesystem::create_symlink("r.csv", folder.path() / "other.csv");
  expect_refused(folder, {"import", "r.csv", "-o", "r.csv"}, ExitCode::usage, {"the file to be read"});
  expect_refused(folder, {"simulate", "m.json", "r.csv", "-o", "./r.csv"}, ExitCode::usage, {"the file to be read"});
  expect_refused(folder, {"export", "r.csv", "--format", "csv", "-o", "other.csv"}, ExitCode::usage,
                 {"the file to be read"});
  expect_refused(folder, {"report", "m.json", "-o", "m.json"}, ExitCode::usage, {"the file to be read"});
}

TEST(BadFile, IsARunWhereAFileOrAModelBelongs) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "run");
  folder.write("run/run.json", "{}");
  folder.write("u.csv", "time_s,voltage_V\n0,0\n1,1\n");
  expect_refused(folder, {"import", "run", "-o", "r.csv"}, ExitCode::usage, {"a run", "`eha fit run`"});
  expect_refused(folder, {"simulate", "run", "u.csv"}, ExitCode::usage,
                 {"run: a run", "run/models", "eha runs show run"});
  expect_refused(folder, {"validate", "run", "u.csv"}, ExitCode::usage, {"run: a run", "run/models"});
}

TEST(BadFile, IsARunThatIsBeingWrittenOrAModel) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "run");
  folder.write("run/run.json", R"({"schema": "eha-run/1", "outcome": "in_progress"})");
  expect_refused(folder, {"fit", "run"}, ExitCode::bad_data, {"still going", "eha runs recover"});
  folder.write("m.json", "{\n  \"schema\": \"eha-model/1\"}\n");
  expect_refused(folder, {"fit", "m.json"}, ExitCode::bad_data, {"is a model file", "expected a record"});
}

TEST(BadFile, OfTwoGigabytesIsRefusedAtOnce) {
  const TemporaryFolder folder;
  folder.write("r.dat", "");
  std::filesystem::resize_file(folder.path() / "r.dat", std::uintmax_t{2} << 30U);
  const Ended ended = run_eha({"fit", "r.dat"}, folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::bad_data));
  EXPECT_NE(ended.err.find("binary"), std::string::npos) << ended.err;
}

}  // namespace
}  // namespace eha::test
