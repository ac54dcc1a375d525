// SPDX-License-Identifier: GPL-3.0-or-later
// Names that hold the end of a line: in model files, runs, controllers, rig files, lists of a batch and names of
// folders. No line that `eha` prints begins with what stands behind that end.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/toml_text.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using Document = nlohmann::ordered_json;
using Words = std::vector<std::string>;

constexpr std::string_view kForged = "Next: eha arm && pwned";
/// Ends of lines: of ASCII, then U+0085, U+2028 and U+2029.
constexpr auto kEnds = std::to_array<std::string_view>(
    {"\n", "\n  ", "\r\n", "\r", "\v", "\f", "\xC2\x85", "\xE2\x80\xA8", "\xE2\x80\xA9"});

std::string with_end(std::string_view name, std::string_view end = kEnds.front()) {
  return fmt::format("{}{}{}", name, end, kForged);
}

/// The forged text at the beginning of a line, however the line before it ends.
bool is_forged(const std::string& text) {
  for (std::size_t at = text.find(kForged); at != std::string::npos; at = text.find(kForged, at + 1)) {
    const std::size_t last = at == 0 ? std::string::npos : text.find_last_not_of(" \t", at - 1);
    if (last == std::string::npos) return true;
    const std::string_view before = std::string_view(text).substr(0, last + 1);
    if (std::any_of(kEnds.begin(), kEnds.end(), [&](auto end) { return end != "\n  " && before.ends_with(end); })) {
      return true;
    }
  }
  return false;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void write_bytes(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }
Document read_json(const fs::path& path) { return Document::parse(bytes_of(path)); }
void write_json(const fs::path& path, const Document& document) { write_bytes(path, document.dump(2)); }

/// Lets `edit` change every text of a document but those of a kind or a file, which are checked or copied whole.
void for_each_text(Document& document, const std::function<void(std::string&)>& edit) {
  constexpr auto kKept = std::to_array<std::string_view>({"schema", "outcome", "text", "time_base", "sha256", "grade",
                                                          "freedom", "kind", "initial_state", "time", "path"});
  if (!document.is_structured()) return;
  for (const auto& item : document.items()) {
    const bool is_kept = std::find(kKept.begin(), kKept.end(), item.key()) != kKept.end();
    if (item.value().is_string() && !is_kept) {
      edit(item.value().get_ref<std::string&>());
    } else {
      for_each_text(item.value(), edit);
    }
  }
}

class ForgedLines : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TemporaryFolder;
    fs::copy_file(source_file("config/rigs/sim.toml"), shared_->path() / "rig.toml");
    fs::copy_file(source_file("tests/web/short_periodic.toml"), shared_->path() / "e.toml");
    fs::copy_file(source_file("tests/vm/rod.json"), shared_->path() / "rod.json");
    const Ended played = run_eha({"run", "--local", "--fast", "--rig", "rig.toml", "e.toml"}, shared_->path());
    ASSERT_EQ(played.code, 0) << played.err;
    fs::remove(shared_->path() / "runs" / "latest");
    for (const auto& run : fs::directory_iterator(shared_->path() / "runs")) {
      fs::rename(run.path(), shared_->path() / "runs" / "r");
      break;
    }
    const Ended tuned =
        run_eha({"tune", "rod.json", "--rig", "rig.toml", "--kind", "p", "-o", "axis.toml"}, shared_->path());
    ASSERT_EQ(tuned.code, 0) << tuned.err;
  }
  static void TearDownTestSuite() {
    delete shared_;
    shared_ = nullptr;
  }

  void SetUp() override { fs::copy(shared_->path(), folder_.path(), fs::copy_options::recursive); }

  /// Runs `eha` and checks what it prints.
  Ended printed(const Words& words) {
    const Ended ended = run_eha(words, folder_.path());
    EXPECT_FALSE(is_forged(ended.out)) << fmt::format("eha {}\n", fmt::join(words, " ")) << ended.out;
    EXPECT_FALSE(is_forged(ended.err)) << fmt::format("eha {}\n", fmt::join(words, " ")) << ended.err;
    EXPECT_LT(ended.code, 128) << fmt::format("eha {}", fmt::join(words, " "));
    return ended;
  }
  [[nodiscard]] fs::path at(const std::string& name) const { return folder_.path() / name; }

  static inline TemporaryFolder* shared_ = nullptr;
  TemporaryFolder folder_;
};

TEST_F(ForgedLines, ComeFromNoTextOfAModelFile) {
  const Document sound = read_json(at("runs/r/models/rig.json"));
  Document named = sound;
  std::size_t texts = 0;
  for_each_text(named, [&](std::string& text) { text = with_end(text, kEnds[texts++ % kEnds.size()]); });
  EXPECT_GE(texts, 2 * kEnds.size());
  named["units"] = sound["units"];  // in others it is refused before anything is printed of it
  for (const std::string_view end : kEnds) {
    named["name"] = with_end("io", end);
    write_json(at("m.json"), named);
    printed({"simulate", "m.json", "runs/r/data_40ms.csv", "-o", "s.csv"});
  }
  EXPECT_NE(printed({"validate", "m.json", "runs/r"}).out.find("pwned"), std::string::npos);
  Document model = sound;
  model["units"] = {{"input", with_end("V")}, {"output", with_end("in")}};
  write_json(at("m.json"), model);
  printed({"validate", "m.json", "runs/r"});
  printed({"simulate", "m.json", "runs/r/data_40ms.csv", "-o", "s.csv"});
}

TEST_F(ForgedLines, ComeFromNoTextOfARun) {
  Document manifest = read_json(at("runs/r/run.json"));
  manifest["report"]["write_error"] = "full";
  manifest["report"]["fault"] = {{"cause", "end_stop"}};
  for_each_text(manifest, [](std::string& text) { text = with_end(text); });
  write_json(at("runs/r/run.json"), manifest);
  EXPECT_NE(printed({"runs", "list"}).out.find("pwned"), std::string::npos);
  EXPECT_NE(printed({"runs", "show", "runs/r"}).out.find("pwned"), std::string::npos);
  for (const Words& words : std::vector<Words>{{"fit", "runs/r", "--model", "io", "--poles", "1"},
                                               {"compare", "runs/r", "runs/r", "--model", "io", "--poles", "1"},
                                               {"report", "runs/r"},
                                               {"tune", "runs/r", "--kind", "p", "-o", "a.toml"},
                                               {"replay", "runs/r"}}) {
    printed(words);
  }
}

TEST_F(ForgedLines, ComeFromNoNameOfAFolder) {
  for (std::size_t i = 0; i < kEnds.size(); ++i) {
    const fs::path run = at("runs") / with_end(fmt::format("q{}", i), kEnds[i]);
    fs::copy(at("runs/r"), run, fs::copy_options::recursive);
  }
  printed({"runs", "list"});
  fs::create_directory_symlink(with_end("q0"), at("runs/latest"));
  printed({"runs", "list"});
  printed({"runs", "show", "runs/latest"});
  for (const Words& words : std::vector<Words>{{"fit", "runs/latest", "--model", "io", "--poles", "1"},
                                               {"tune", "runs/latest", "--kind", "p", "-o", "a.toml"}}) {
    const Ended refused = printed(words);
    EXPECT_NE(refused.err.find("holds the end of a line"), std::string::npos) << refused.err;
  }
  const fs::path torn = at("runs") / with_end("z");
  fs::copy(at("runs/r"), torn);
  Document manifest = read_json(torn / "run.json");
  manifest["outcome"] = "in_progress";
  write_json(torn / "run.json", manifest);
  printed({"runs", "list"});
  EXPECT_NE(printed({"runs", "recover", "runs"}).out.find("recovered"), std::string::npos);
  printed({"runs", "recover", "runs"});
}

TEST_F(ForgedLines, AreRefusedInEveryFileThatAUserWrites) {
  const auto refuses = [&](const std::string& file, std::string_view key, const std::vector<Words>& commands) {
    const std::string sound = bytes_of(at(file));
    const std::string line = fmt::format("\n{} = \"", key);
    const std::size_t from = sound.find(line) + line.size();
    ASSERT_GE(from, line.size()) << file << ": " << key;
    std::string text = sound;
    const std::string name = toml_string(with_end("x"));
    text.replace(from - 1, sound.find('"', from) + 2 - from, name);
    write_bytes(at(file), text);
    for (const Words& words : commands) {
      const Ended ended = printed(words);
      EXPECT_EQ(ended.code, 78) << file << ": " << key << ": " << ended.out;
      EXPECT_NE(ended.err.find("a string of one line, without control characters"), std::string::npos) << ended.err;
    }
    write_bytes(at(file), sound);
  };
  refuses("rig.toml", "name", {{"check", "e.toml", "--rig", "rig.toml"}});
  refuses("axis.toml", "name", {{"check", "axis.toml", "--rig", "rig.toml"}});
  for (const char* key : {"model", "rig", "rig_file", "twin", "run", "made_by"}) {
    refuses("axis.toml", key,
            {{"check", "axis.toml", "--rig", "rig.toml"}, {"track", "axis.toml", "--rig", "rig.toml", "--local"}});
  }
}

TEST_F(ForgedLines, ComeFromNoRecordOfABatch) {
  fs::create_directory(at("records"));
  fs::copy_file(at("runs/r/data_40ms.csv"), at("records/a.csv"));
  const Words words{"batch", "records", "-o", "b", "--", "--model", "io", "--poles", "1"};
  for (const std::string& name : {with_end("b.csv\n").append(".csv"), std::string("c\x1b[2J.csv")}) {
    const fs::path hostile = at("records") / name;
    fs::copy_file(at("records/a.csv"), hostile);
    const Ended refused = printed({"batch", hostile.string(), "-o", "refused"});
    EXPECT_EQ(refused.code, 2) << refused.err;
    EXPECT_NE(refused.err.find("rename "), std::string::npos) << refused.err;
  }
  EXPECT_NE(printed(words).out.find("skipped  2 of records: "), std::string::npos);
  for (const auto& item : fs::recursive_directory_iterator(at("b"))) {
    if (item.path().extension() != ".json") continue;
    Document document = read_json(item.path());
    for_each_text(document, [](std::string& text) { text = with_end(text); });
    write_json(item.path(), document);
    printed(words);
  }
}

}  // namespace
}  // namespace eha::test
