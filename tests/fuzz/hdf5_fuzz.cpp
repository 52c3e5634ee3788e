// SPDX-License-Identifier: BSD-3-Clause
// Recordings as HDF5 whose items are not what they should be.
#include <fstream>
#include <iterator>

#include "s2nnds/core/hdf5.h"
#include "s2nnds/data/readers.h"
#include "tests/fuzz/hdf5_edits.h"
#include "tests/fuzz/one_line.h"

namespace {

std::string whole_file() {
  const std::string path = s2nnds::fuzz::file_of(nullptr, 0, ".h5");
  s2nnds::Hdf5Writer file(path);
  for (const char* const group : {"/demonstrations/0", "/demonstrations/10"}) {
    file.write(std::string(group) + "/time", s2nnds::Vector{{0.0, 1.0, 2.0}});
    file.write(std::string(group) + "/position", s2nnds::Points{{0.0, 1.0}, {2.0, 3.0}, {4.0, 5.0}});
    file.write(std::string(group) + "/velocity", s2nnds::Points{{1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}});
  }
  file.commit();
  std::ifstream written(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(written), std::istreambuf_iterator<char>()};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string whole = whole_file();
  const std::string path =
      s2nnds::fuzz::file_of(reinterpret_cast<const std::uint8_t*>(whole.data()), whole.size(), ".h5");
  s2nnds::fuzz::edit_hdf5(path, data, size);
  s2nnds::fuzz::expect_one_line([&] { s2nnds::make_demonstrations(s2nnds::read_hdf5(path)); });
  return 0;
}
