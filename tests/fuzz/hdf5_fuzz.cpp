// SPDX-License-Identifier: BSD-3-Clause
// Recordings as HDF5 whose items are not what they should be.
#include "s2nnds/core/hdf5.h"
#include "s2nnds/data/readers.h"
#include "tests/fuzz/hdf5_edits.h"
#include "tests/fuzz/one_line.h"

namespace {

void write_recordings(const std::string& path) {
  s2nnds::Hdf5Writer file(path);
  for (const char* const group : {"/demonstrations/0", "/demonstrations/10"}) {
    file.write(std::string(group) + "/time", s2nnds::Vector{{0.0, 1.0, 2.0}});
    file.write(std::string(group) + "/position", s2nnds::Points{{0.0, 1.0}, {2.0, 3.0}, {4.0, 5.0}});
    file.write(std::string(group) + "/velocity", s2nnds::Points{{1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}});
  }
  file.commit();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string path = s2nnds::fuzz::file_of(nullptr, 0, ".h5");
  write_recordings(path);
  s2nnds::fuzz::edit_hdf5(path, data, size);
  s2nnds::fuzz::expect_one_line([&] { s2nnds::make_demonstrations(s2nnds::read_hdf5(path)); });
  return 0;
}
