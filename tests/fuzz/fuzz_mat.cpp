// SPDX-License-Identifier: GPL-3.0-or-later
// The reader of MAT-files either refuses with DataError or returns columns of numbers.
#include "tests/fuzz/fuzz_arrays.hpp"

// libmatio asks for as much memory as a file claims. eha-reader has a limit, beyond which it gets none; so here. What
// the library then leaks ends with that process.
extern "C" const char* __asan_default_options() {  // NOLINT(bugprone-reserved-identifier): AddressSanitizer's name
  return "allocator_may_return_null=1:max_allocation_size_mb=256:detect_leaks=0";
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  eha::fuzz::check_arrays(&eha::importer::read_mat, data, size);
  return 0;
}
