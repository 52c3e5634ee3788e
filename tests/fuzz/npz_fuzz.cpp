// SPDX-License-Identifier: BSD-3-Clause
// An archive of NumPy arrays.
#include "s2nnds/data/readers.h"
#include "tests/fuzz/one_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string path = s2nnds::fuzz::file_of(data, size, ".npz");
  s2nnds::fuzz::expect_one_line([&] { s2nnds::make_demonstrations(s2nnds::read_npy({path})); });
  return 0;
}
