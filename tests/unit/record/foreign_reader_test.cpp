// SPDX-License-Identifier: GPL-3.0-or-later
// raw.h5 read by other programs.
#include <cstdlib>
#include <cstring>

#include "core/os/files.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/unit/record/record_fixture.hpp"

namespace eha::record {
namespace {

class ForeignReader : public RecordTest {};

template <typename Value>
std::vector<Value> values_of(const std::string& bytes) {
  std::vector<Value> values(bytes.size() / sizeof(Value));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Value));
  return values;
}

TEST_F(ForeignReader, OctaveLoadsTheRawFileBitForBit) {
  if (std::system("command -v octave-cli >/dev/null 2>&1") != 0) GTEST_SKIP() << "octave-cli is not installed";
  const play::FinishedRun finished = run();
  const std::string script =
      "s = load('" + (finished.folder / kRawFile).string() + "'); f = fopen('" + (folder_ / "displacement").string() +
      "', 'wb'); fwrite(f, s.displacement_in, 'double'); fclose(f); f = fopen('" + (folder_ / "code").string() +
      "', 'wb'); fwrite(f, s.feedback_code, 'uint32'); fclose(f); "
      "assert(abs(s.time_s(s.state == 4)(1)) == 0); assert(numel(s.header) > 100);";
  ASSERT_EQ(std::system(("octave-cli --no-init-file --eval \"" + script + "\"").c_str()), 0);
  const std::vector<double> displacement_in = values_of<double>(os::read_file(folder_ / "displacement"));
  const std::vector<std::uint32_t> codes = values_of<std::uint32_t>(os::read_file(folder_ / "code"));
  const std::vector<acquisition::TickRecord> ticks = read_ticks(finished.folder);
  ASSERT_EQ(displacement_in.size(), ticks.size());
  ASSERT_EQ(codes.size(), ticks.size());
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    ASSERT_EQ(displacement_in[k], ticks[k].displacement_in) << "row " << k;
    ASSERT_EQ(codes[k], ticks[k].feedback_code) << "row " << k;
  }
}

}  // namespace
}  // namespace eha::record
