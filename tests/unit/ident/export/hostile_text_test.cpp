// SPDX-License-Identifier: GPL-3.0-or-later
// Names, units and reasons of a model file that a stranger wrote, through every export: they change comments only.
#include "tests/unit/hostile_text.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <sstream>
#include <string>
#include <string_view>

#include "core/code_text.hpp"
#include "core/os/files.hpp"
#include "ident/export/model_formats.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::ident {
namespace {

using test::hostile;

constexpr int kTexts = 10000;

ExportedModel sound() {
  Model model;
  model.name = "io";
  model.transfer_function = {{{0.13, 0}}, {{0.013, 2}, {1, 1}, {0.0028, 0}}, 0.01};
  model.input_map = ValveMap{-0.2, 0.15, 0.88};
  ExportedModel out = exported(model, {});
  out.input_unit = "V";
  out.output_unit = "in";
  out.verdict = "rejected";
  out.rejected_for = {"R2 is low"};
  out.origin = {"Fitted to the record bench.csv"};
  return out;
}

ExportedModel attacked(std::mt19937_64& generator) {
  ExportedModel model = sound();
  model.name = hostile(generator, 40);
  model.input_unit = hostile(generator, 20);
  model.output_unit = hostile(generator, 20);
  model.rejected_for = {hostile(generator, 200)};
  model.origin = {hostile(generator, 160)};
  return model;
}

/// The model's description as it stands in the text of a format, and what comes before and after it.
struct Parts {
  std::string before;
  std::string description;
  std::string after;
};

Parts parts(const std::string& text) {
  const std::size_t from = text.find("Model ");
  const std::size_t last = text.find("CRONE (without the delay)");
  const std::size_t to = last == std::string::npos ? last : text.find('\n', last);
  if (from == std::string::npos || to == std::string::npos) return {};
  return {text.substr(0, from), text.substr(from, to - from), text.substr(to)};
}

class HostileText : public testing::Test {
 protected:
  using Text = std::string (*)(const ExportedModel&, const std::string&);

  /// All descriptions as comments of the format, before the text of the sound model.
  std::string all_before_the_code(Text format, const std::string& opening, const std::string& closing) {
    std::mt19937_64 generator(24);
    EXPECT_FALSE(parts(format(sound(), "f")).description.empty());
    std::string text;
    for (int i = 0; i < kTexts; ++i) {
      const ExportedModel attack = attacked(generator);
      const Parts found = parts(format(attack, "f"));
      // Names of arguments end in a unit that is known; no other text of a unit may become code.
      ExportedModel same = sound();
      same.input_unit = with_unit("u", attack.input_unit) == "u" ? "?" : attack.input_unit;
      same.output_unit = with_unit("y", attack.output_unit) == "y" ? "?" : attack.output_unit;
      const Parts expected = parts(format(same, "f"));
      EXPECT_EQ(found.before, expected.before) << i;
      EXPECT_EQ(found.after, expected.after) << i;
      if (HasFailure()) return {};
      text += opening + found.description + closing;
    }
    return text + format(sound(), "f");
  }

  static bool succeeds(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

  std::string printed_by(const std::string& command) {
    const std::string at = "cd '" + folder_.path().string() + "' && ";
    const int status = std::system((at + command + " >log 2>&1").c_str());
    const std::string printed = os::read_file(folder_.path() / "log");
    EXPECT_EQ(status, 0) << command << "\n" << printed.substr(0, 2000);
    return printed;
  }

  void write(const std::string& name, const std::string& text) {
    os::write_file_atomically(folder_.path() / name, text);
  }

  test::TemporaryFolder folder_;
};

TEST_F(HostileText, AddsNoSymbolToC) {
  const std::string text = all_before_the_code(&c_text, "/*\n * ", "\n */\n");
  if (!succeeds("command -v gcc")) GTEST_SKIP() << "gcc is not installed";
  write("hostile.c", text);
  write("sound.c", c_text(sound(), "f"));
  for (const std::string standard : {"c99", "gnu17"}) {
    for (const std::string file : {"hostile", "sound"}) {
      EXPECT_EQ(printed_by("gcc -std=" + standard + " -Wall -Wextra -Wpedantic -Werror -c " + file + ".c"), "");
    }
    EXPECT_EQ(printed_by("nm hostile.o"), printed_by("nm sound.o"));
  }
}

TEST_F(HostileText, AddsNoStatementToPython) {
  const std::string text = all_before_the_code(&python_text, "\"\"\"", "\n\"\"\"\n");
  if (!succeeds("command -v python3")) GTEST_SKIP() << "python3 is not installed";
  write("hostile.py", text);
  write("sound.py", python_text(sound(), "f"));
  write("statements.py", R"(import ast, hashlib, sys
with open(sys.argv[1], 'rb') as file:
    tree = ast.parse(file.read())
text = lambda s: isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant) and isinstance(s.value.value, str)
for s in tree.body:
    if not text(s):
        print(type(s).__name__, hashlib.sha256(ast.dump(s).encode()).hexdigest())
)");
  const std::string expected = printed_by("python3 statements.py sound.py");
  EXPECT_NE(expected.find("FunctionDef"), std::string::npos);
  EXPECT_EQ(printed_by("python3 -W error statements.py hostile.py"), expected);
}

TEST_F(HostileText, AddsNoStatementToOctave) {
  const std::string state_space = all_before_the_code(&state_space_text, "% ", "\n");
  const std::string function = all_before_the_code(&octave_text, "% ", "\n");
  if (HasFailure()) return;
  std::istringstream lines(state_space.substr(0, state_space.size() - state_space_text(sound(), "f").size()) +
                           function.substr(0, function.size() - octave_text(sound(), "f").size()));
  for (std::string line; std::getline(lines, line);) {
    ASSERT_TRUE(line.starts_with("% ") && line.find_first_of("\r\f\v{}") == std::string::npos) << line;
  }
  if (!succeeds("command -v octave-cli")) GTEST_SKIP() << "the lines are comments; octave-cli is not installed";
  write("hostile.m", state_space);
  write("sound.m", state_space_text(sound(), "f"));
  const auto variables = [&](const std::string& file) {
    return printed_by("octave-cli --no-init-file --eval \"" + file + "; disp(who)\"");
  };
  EXPECT_EQ(variables("hostile"), variables("sound"));
}

TEST_F(HostileText, IsDataInJson) {
  std::mt19937_64 generator(24);
  for (int i = 0; i < kTexts; ++i) {
    for (const char c : json_text(attacked(generator), "f")) ASSERT_TRUE((c >= ' ' && c <= '~') || c == '\n') << i;
  }
}

TEST_F(HostileText, MayNameAFunctionByAWordThatTheCTextReplaces) {
  if (!succeeds("command -v gcc")) GTEST_SKIP() << "gcc is not installed";
  for (const char* function : {"eha_COUNT", "my_FUNCTION_", "NAME_", "DRIVING", "eha_HIGHEST_BUFFER"}) {
    write("named.c", c_text(sound(), function));
    EXPECT_EQ(printed_by("gcc -std=c99 -Wall -Wextra -Wpedantic -Werror -c named.c"), "");
    const std::string symbols = printed_by("nm named.o");
    EXPECT_NE(symbols.find(std::string(" T ") + function + "_step\n"), std::string::npos) << symbols;
  }
}

}  // namespace
}  // namespace eha::ident
