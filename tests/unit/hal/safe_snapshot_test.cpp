// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/safe_snapshot.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "core/error.hpp"
#include "hal/snapshot_file.hpp"

namespace eha::hal {
namespace {

SafeSnapshot example() {
  SafeSnapshot s;
  s.device = "/dev/comedi0";
  s.board = "pci1716";
  s.subdevice = 1;
  s.channel = 1;
  s.range = 3;
  s.reference = 2;
  s.safe_code = 32768;
  s.safe_V = 0.1 + 0.2;
  s.enable = SafeSnapshot::Line{.subdevice = 3, .channel = 31, .off_level = 1, .is_bidirectional = true};
  return s;
}

/// A folder of the test's own that goes with it.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("eha-snapshot-" + std::to_string(getpid()))) {
    std::filesystem::create_directory(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void expect_equal(const SafeSnapshot& a, const SafeSnapshot& b) {
  EXPECT_EQ(a.device, b.device);
  EXPECT_EQ(a.board, b.board);
  EXPECT_EQ(a.subdevice, b.subdevice);
  EXPECT_EQ(a.channel, b.channel);
  EXPECT_EQ(a.range, b.range);
  EXPECT_EQ(a.reference, b.reference);
  EXPECT_EQ(a.safe_code, b.safe_code);
  EXPECT_EQ(a.safe_V, b.safe_V);
  ASSERT_EQ(a.enable.has_value(), b.enable.has_value());
  if (a.enable) {
    EXPECT_EQ(a.enable->subdevice, b.enable->subdevice);
    EXPECT_EQ(a.enable->channel, b.enable->channel);
    EXPECT_EQ(a.enable->off_level, b.enable->off_level);
    EXPECT_EQ(a.enable->is_bidirectional, b.enable->is_bidirectional);
  }
}

TEST(SafeSnapshot, ComesBackFromItsFileUnchanged) {
  const Folder folder;
  const auto path = folder.path() / "safe.json";
  write_safe_snapshot(to_text(example()), path);
  expect_equal(safe_snapshot_from_text(read_safe_snapshot(path), "safe.json"), example());
  SafeSnapshot without_enable = example();
  without_enable.enable.reset();
  write_safe_snapshot(to_text(without_enable), path);
  expect_equal(safe_snapshot_from_text(read_safe_snapshot(path), "safe.json"), without_enable);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "no temporary file is left";
}

TEST(SafeSnapshot, KeepsTheOldFileWhenTheNewOneCannotBeWritten) {
  const Folder folder;
  const auto path = folder.path() / "safe.json";
  write_safe_snapshot(to_text(example()), path);
  std::filesystem::create_directory(folder.path() / ("safe.json." + std::to_string(getpid()) + ".tmp"));
  EXPECT_THROW(write_safe_snapshot(to_text(SafeSnapshot()), path), IoError);
  expect_equal(safe_snapshot_from_text(read_safe_snapshot(path), "safe.json"), example());
}

TEST(SafeSnapshot, RefusesATextThatIsNoSnapshot) {
  const std::string good = to_text(example());
  const std::pair<std::string, std::string> changes[] = {{"\"eha-safe/1\"", "\"eha-model/1\""},
                                                         {"\"safe_code\": 32768", "\"safe_code\": -1"},
                                                         {"\"safe_code\": 32768", "\"safe_code\": 1.5"},
                                                         {"\"safe_code\": 32768", "\"safe_code\": 4294967296"},
                                                         {"\"off_level\": 1", "\"off_level\": 2"},
                                                         {"\"channel\": 31", "\"channel\": 32"},
                                                         {"\"board\"", "\"bored\""}};
  for (const auto& [from, to] : changes) {
    std::string text = good;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
      (void)safe_snapshot_from_text(text, "safe.json");
      ADD_FAILURE() << "accepted " << to;
    } catch (const ConfigError& error) {
      EXPECT_EQ(std::string(error.what()).rfind("safe.json: ", 0), 0U) << error.what();
    }
  }
  for (const std::string& text : {std::string(), std::string("null"), std::string("[1]"),
                                  good.substr(0, good.size() / 2), std::string(200, '\0')}) {
    EXPECT_THROW((void)safe_snapshot_from_text(text, "safe.json"), ConfigError);
  }
}

TEST(SafeSnapshot, SaysThatAFileCannotBeRead) {
  const Folder folder;
  EXPECT_THROW((void)read_safe_snapshot(folder.path() / "missing.json"), IoError);
  EXPECT_THROW((void)read_safe_snapshot(folder.path()), IoError);
  const auto big = folder.path() / "big.json";
  std::ofstream(big) << std::string(70000, ' ');
  EXPECT_THROW((void)read_safe_snapshot(big), ConfigError);
}

TEST(SafeSnapshot, MakesNothingSafeWhereThereIsNoCard) {
  SafeSnapshot snapshot = example();
  snapshot.device = "/dev/no-such-card";
  EXPECT_THROW(SafeCard(snapshot).make_safe(std::chrono::milliseconds(0)), DeviceError);
  snapshot.device = "/dev/null";
  EXPECT_THROW(SafeCard(snapshot).make_safe(std::chrono::milliseconds(0)), DeviceError);
}

}  // namespace
}  // namespace eha::hal
