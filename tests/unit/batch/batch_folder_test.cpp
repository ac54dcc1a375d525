// SPDX-License-Identifier: GPL-3.0-or-later
// The list of a batch becomes longer: results stay, under the IDs that a fresh batch over all records would give them.
#include "daemon/batch/batch_folder.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::batch {
namespace {

namespace fs = std::filesystem;

/// A list of records, numbered as records_of() does.
Batch batch_of(const std::vector<std::string>& sources) {
  Batch batch{rules_of({}), {}};
  for (const std::string& source : sources) {
    batch.records.push_back({.id = fmt::format("{:04}-{}", batch.records.size() + 1, fs::path(source).stem().string()),
                             .source = source,
                             .sha256 = "sum of " + source});
  }
  return batch;
}

class GrowingBatch : public ::testing::Test {
 protected:
  fs::path path() const { return folder_.path() / "out"; }

  /// Gives every open record a result that names it.
  void work(const std::vector<std::string>& sources) {
    BatchFolder folder(path(), batch_of(sources));
    folder.claim({});
    for (const Record& record : folder.open_records({})) {
      Result result;
      result.message = record.source;
      (void)folder.work_folder(record);
      folder.publish(record, result);
    }
  }

  /// Every record has the result that names it, but for those of `open`.
  void expect_results(const BatchFolder& folder, const std::vector<std::string>& open) const {
    for (const Record& record : folder.batch().records) {
      const bool is_open = std::find(open.begin(), open.end(), record.source) != open.end();
      const std::optional<Result> result = folder.result(record);
      ASSERT_EQ(result.has_value(), !is_open) << record.source;
      if (result) {
        EXPECT_EQ(result->message, record.source);
      }
    }
    EXPECT_EQ(folder.open_records({}).size(), open.size());
  }

  const std::vector<std::string> few_{"a/x", "a/z", "b/x"};
  const std::vector<std::string> all_{"a/new", "a/x", "a/y", "a/z", "b/w", "b/x"};
  const std::vector<std::string> open_{"a/new", "a/y", "b/w"};
  test::TemporaryFolder folder_;
};

TEST_F(GrowingBatch, KeepsItsResultsUnderTheirNewNumbers) {
  work(few_);
  const BatchFolder longer(path(), batch_of(all_));
  expect_results(longer, open_);
  expect_results(BatchFolder(path()), open_);
}

TEST_F(GrowingBatch, FollowsAnotherOrder) {
  work(few_);
  expect_results(BatchFolder(path(), batch_of({"b/x", "a/x", "a/z"})), {});
}

TEST_F(GrowingBatch, GoesOnWhereItWasKilled) {
  // The steps: the new list is there; results are put aside; the list has its place; results are put back.
  for (const int killed_after : {1, 2, 3, 4, 5, 6}) {
    fs::remove_all(path());
    work(few_);
    const fs::path kept = folder_.path() / "kept";
    fs::remove_all(kept);
    { const BatchFolder longer(kept, batch_of(all_)); }
    fs::rename(kept / "batch.json", path() / "batch.next.json");
    const fs::path aside = path() / "work" / "renumbered";
    const auto put = [&](const fs::path& from, const fs::path& to) { fs::rename(path() / from, path() / to); };
    if (killed_after > 1) {
      fs::create_directories(aside);
      put("records/0001-x", "work/renumbered/0002-x");
    }
    if (killed_after > 2) put("records/0002-z", "work/renumbered/0004-z");
    if (killed_after > 3) put("records/0003-x", "work/renumbered/0006-x");
    if (killed_after > 4) put("batch.next.json", "batch.json");
    if (killed_after > 5) put("work/renumbered/0002-x", "records/0002-x");
    if (killed_after % 2 == 0) {
      expect_results(BatchFolder(path()), open_);
    } else {
      expect_results(BatchFolder(path(), batch_of(all_)), open_);
    }
    EXPECT_FALSE(fs::exists(aside)) << killed_after;
    EXPECT_FALSE(fs::exists(path() / "batch.next.json")) << killed_after;
  }
}

TEST_F(GrowingBatch, OfAStrangerLeadsToNoOtherFolder) {
  work(few_);
  const auto with_id = [&](const std::string& id) {
    nlohmann::ordered_json list = nlohmann::ordered_json::parse(test::content_of(path() / "batch.json"));
    list["records"][0]["id"] = id;
    return list.dump();
  };
  const fs::path victim = folder_.path() / "victim";
  folder_.write("victim", "mine");
  folder_.write("payload", "theirs");
  for (const std::string& id : {std::string("../../payload"), victim.string(), std::string(".."), std::string()}) {
    folder_.write("out/batch.next.json", with_id(victim.string()));
    EXPECT_THROW(static_cast<void>(BatchFolder(path())), DataError) << id;
    fs::remove(path() / "batch.next.json");
    const std::string sound = test::content_of(path() / "batch.json");
    folder_.write("out/batch.json", with_id(id));
    EXPECT_THROW(static_cast<void>(BatchFolder(path())), DataError) << id;
    folder_.write("out/batch.json", sound);
  }
  for (const char* name : {"records", "work"}) {
    fs::rename(path() / name, folder_.path() / "elsewhere");
    fs::create_directory_symlink(folder_.path() / "elsewhere", path() / name);
    EXPECT_THROW(static_cast<void>(BatchFolder(path())), DataError) << name;
    EXPECT_THROW(static_cast<void>(BatchFolder(path(), batch_of(few_))), DataError) << name;
    fs::remove(path() / name);
    fs::rename(folder_.path() / "elsewhere", path() / name);
  }
  expect_results(BatchFolder(path()), {});
  EXPECT_EQ(test::content_of(victim), "mine");
}

TEST_F(GrowingBatch, IsRefusedFewerChangedOrOtherwiseJudgedRecords) {
  work(few_);
  const auto refusal = [&](const Batch& batch) {
    try {
      const BatchFolder folder(path(), batch);
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal(batch_of({"a/x", "a/z", "a/new"})).find("without b/x; records are added by naming all of them"),
            std::string::npos);
  Batch changed = batch_of(all_);
  changed.records[1].sha256 = "another";
  EXPECT_NE(refusal(changed).find("a/x has changed"), std::string::npos);
  Batch other_rules = batch_of(all_);
  other_rules.rules.version = "0";
  EXPECT_NE(refusal(other_rules).find("was begun by eha"), std::string::npos);
  expect_results(BatchFolder(path()), {});
}

TEST_F(GrowingBatch, StaysAsItIsWhileAnotherProcessWorksOnIt) {
  work(few_);
  const BatchFolder working(path(), batch_of(few_));
  EXPECT_THROW(BatchFolder(path(), batch_of(all_)), UsageError);
  const BatchFolder part(path(), batch_of(few_));
  expect_results(part, {});
}

}  // namespace
}  // namespace eha::batch
