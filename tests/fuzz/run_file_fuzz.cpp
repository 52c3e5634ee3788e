// SPDX-License-Identifier: BSD-3-Clause
// A run file whose items are not what they should be, or some of whose bytes are damaged, and what `info` says.
#include <cstdint>
#include <fstream>
#include <iterator>

#include "s2nnds/runs/run_record.h"
#include "s2nnds/runs/statement.h"
#include "s2nnds/runs/summary.h"
#include "tests/fuzz/hdf5_edits.h"
#include "tests/fuzz/one_line.h"
#include "tests/runs/unusual_record.h"

namespace {

using s2nnds::fuzz::file_of;

std::string file_at(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string whole_file() {
  const std::string path = file_of(nullptr, 0, ".h5");
  s2nnds::save_run(path, s2nnds::unusual_record());
  s2nnds::load_run(path);
  return file_at(path);
}

std::string written(const std::string& bytes) {
  return file_of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), ".h5");
}

// Two bytes where, one what it becomes; never in the last line, the digest.
std::string damaged(std::string bytes, const std::uint8_t* data, std::size_t size) {
  const std::size_t end = bytes.size() - 100;
  for (std::size_t i = 0; i + 2 < size; i += 3) {
    bytes[(data[i] * std::size_t{256} + data[i + 1]) % end] = static_cast<char>(data[i + 2]);
  }
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string whole = whole_file();
  if (size < 3) return 0;
  const bool bytes_damaged = data[0] % 8 == 0;
  const std::string path = written(bytes_damaged ? damaged(whole, data + 1, size - 1) : whole);
  if (!bytes_damaged) s2nnds::fuzz::edit_hdf5(path, data + 1, size - 1);
  s2nnds::fuzz::expect_one_line([&] {
    const s2nnds::RunRecord run = s2nnds::load_run(path);
    s2nnds::summary_json(run, path);
    s2nnds::guarantee_statement(run);
  });
  return 0;
}
