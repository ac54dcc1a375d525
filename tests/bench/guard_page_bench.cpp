// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick costs more because of the guard: a beat, a look at the guard's mark, and its row in the shared page.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

#include "core/guard_page.hpp"
#include "core/os/shared_memory.hpp"
#include "daemon/acquisition/tick_record.hpp"

namespace {

using eha::GuardPage;

void tick(GuardPage& page, eha::acquisition::TickRecord& row) {
  page.beat();
  benchmark::DoNotOptimize(page.has_tripped());
  ++row.sequence;
  page.keep(&row);
}

/// The page in the cache, as in a loop without pauses.
void guard_page_of_a_tick(benchmark::State& state) {
  const eha::os::SharedMemory memory = eha::os::SharedMemory::create(sizeof(GuardPage));
  auto& page = *new (memory.data()) GuardPage;
  eha::acquisition::TickRecord row{};
  for (auto _ : state) tick(page, row);
}
BENCHMARK(guard_page_of_a_tick);

/// As after a millisecond that others used: the caches hold something else. Two readings of the clock are in it.
void guard_page_of_a_tick_from_memory(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const eha::os::SharedMemory memory = eha::os::SharedMemory::create(sizeof(GuardPage));
  auto& page = *new (memory.data()) GuardPage;
  eha::acquisition::TickRecord row{};
  std::vector<std::uint64_t> others(std::size_t{8} << 20, 1);
  for (auto _ : state) {
    for (std::uint64_t& other : others) other += 1;
    benchmark::ClobberMemory();
    const auto begun = Clock::now();
    tick(page, row);
    state.SetIterationTime(std::chrono::duration<double>(Clock::now() - begun).count());
  }
}
BENCHMARK(guard_page_of_a_tick_from_memory)->UseManualTime()->Iterations(200);

}  // namespace
