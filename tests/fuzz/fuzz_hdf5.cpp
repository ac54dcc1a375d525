// SPDX-License-Identifier: GPL-3.0-or-later
// The reader of HDF5 files either refuses with DataError or returns columns of numbers.
#include "tests/fuzz/fuzz_arrays.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  eha::fuzz::check_arrays(&eha::importer::read_hdf5, data, size);
  return 0;
}
