// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/core/hdf5.h"

#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <limits>
#include <thread>

#include "s2nnds/core/file_digest.h"
#include "s2nnds/core/random.h"
#include "tests/runs/temporary_directory.h"

namespace s2nnds {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Points some_points() {
  Points points(3, 2);
  points << 0.1, -kInfinity, 1e-320, -0.0, 1.0 / 3.0, std::numeric_limits<double>::max();
  return points;
}

void write_everything(Hdf5Writer& file) {
  file.write("/deep/down/points", some_points());
  file.write("/deep/vector", Vector(some_points().col(0)));
  file.write("/deep/array", Array{.shape = {2, 1, 3}, .values = {1, 2, 3, 4, 5, kNan}});
  file.write("/integers", std::vector<std::int64_t>{std::numeric_limits<std::int64_t>::min(), 0, 7});
  file.write("/text", std::string("Größe \"quoted\"\nsecond line"));
  file.write("/number", -2.5);
  file.write("/integer", std::numeric_limits<std::int64_t>::max());
  file.make_group("/empty");
  file.write("/none/points", Points(0, 3));
  file.write("/none/wide", Points(4, 0));
  file.write("/none/vector", Vector());
  file.write("/none/integers", std::vector<std::int64_t>{});
  file.write("/none/text", std::string());
  file.write_attribute("/", "zeta", std::string("first"));
  file.write_attribute("/", "alpha", std::int64_t{2});
  file.write_attribute("/made/here", "number", kInfinity);
  file.write_attribute("/made/here", "numbers", std::vector<double>{0.5, kNan});
  file.write_attribute("/made/here", "integers", std::vector<std::int64_t>{1, 2});
  file.write_attribute("/made/here", "texts", std::vector<std::string>{"a", "", "ö"});
  file.write_attribute("/made/here", "no numbers", std::vector<double>{});
  file.write_attribute("/made/here", "no texts", std::vector<std::string>{});
  file.write_attribute("/text", "long", std::string(100000, 'x'));
}

void write_file(const std::string& path) {
  Hdf5Writer file(path);
  write_everything(file);
  file.commit();
}

TEST(Hdf5File, EverythingComesBack) {
  const TemporaryDirectory directory;
  write_file(directory.file("a.h5"));
  const Hdf5Reader file(directory.file("a.h5"));
  EXPECT_EQ(file.read<Points>("/deep/down/points"), some_points());
  EXPECT_TRUE(std::signbit(file.read<Points>("deep/down/points")(1, 1)));
  EXPECT_EQ(file.read<Vector>("/deep/vector"), Vector(some_points().col(0)));
  const Array array = file.read<Array>("/deep/array");
  EXPECT_EQ(array.shape, (std::vector<Eigen::Index>{2, 1, 3}));
  EXPECT_EQ(array.values[4], 5.0);
  EXPECT_TRUE(std::isnan(array.values[5]));
  EXPECT_EQ(file.read<std::vector<std::int64_t>>("/integers"),
            (std::vector<std::int64_t>{std::numeric_limits<std::int64_t>::min(), 0, 7}));
  EXPECT_EQ(file.read<std::string>("/text"), "Größe \"quoted\"\nsecond line");
  EXPECT_EQ(file.read<double>("/number"), -2.5);
  EXPECT_EQ(file.read<std::int64_t>("/integer"), std::numeric_limits<std::int64_t>::max());

  EXPECT_EQ(file.attribute<std::string>("/", "zeta"), "first");
  EXPECT_EQ(file.attribute<std::int64_t>("/", "alpha"), 2);
  EXPECT_EQ(file.attribute<double>("/made/here", "number"), kInfinity);
  EXPECT_EQ(file.attribute<std::vector<double>>("/made/here", "numbers")[0], 0.5);
  EXPECT_TRUE(std::isnan(file.attribute<std::vector<double>>("/made/here", "numbers")[1]));
  EXPECT_EQ(file.attribute<std::vector<std::int64_t>>("/made/here", "integers"),
            (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(file.attribute<std::vector<std::string>>("/made/here", "texts"),
            (std::vector<std::string>{"a", "", "ö"}));
  EXPECT_EQ(file.attribute<std::string>("/text", "long"), std::string(100000, 'x'));
}

TEST(Hdf5File, EmptyArraysComeBack) {
  const TemporaryDirectory directory;
  write_file(directory.file("a.h5"));
  const Hdf5Reader file(directory.file("a.h5"));
  EXPECT_EQ(file.read<Points>("/none/points").rows(), 0);
  EXPECT_EQ(file.read<Points>("/none/points").cols(), 3);
  EXPECT_EQ(file.read<Points>("/none/wide").rows(), 4);
  EXPECT_EQ(file.read<Points>("/none/wide").cols(), 0);
  EXPECT_EQ(file.read<Vector>("/none/vector").size(), 0);
  EXPECT_TRUE(file.read<std::vector<std::int64_t>>("/none/integers").empty());
  EXPECT_EQ(file.read<std::string>("/none/text"), "");
  EXPECT_TRUE(file.attribute<std::vector<double>>("/made/here", "no numbers").empty());
  EXPECT_TRUE(file.attribute<std::vector<std::string>>("/made/here", "no texts").empty());
  EXPECT_TRUE(file.children("/empty").empty());
}

TEST(Hdf5File, KeepsTheOrderOfWriting) {
  const TemporaryDirectory directory;
  std::vector<std::string> names;
  {
    Hdf5Writer file(directory.file("a.h5"));
    for (int i = 30; i > 0; --i) {
      names.push_back(std::to_string(i * 7 % 31));
      file.write("/group/" + names.back(), static_cast<double>(i));
      file.write_attribute("/group", names.back(), static_cast<double>(i));
    }
    file.commit();
  }
  const Hdf5Reader file(directory.file("a.h5"));
  EXPECT_EQ(file.children("/group"), names);
  EXPECT_EQ(file.attributes("/group"), names);
}

TEST(Hdf5File, TellsWhatIsThere) {
  const TemporaryDirectory directory;
  write_file(directory.file("a.h5"));
  const Hdf5Reader file(directory.file("a.h5"));
  EXPECT_TRUE(file.exists("/deep/down/points"));
  EXPECT_TRUE(file.exists("/"));
  EXPECT_FALSE(file.exists("/deep/up/points"));
  EXPECT_FALSE(file.exists("/text/inside"));
  EXPECT_TRUE(file.has_attribute("/", "zeta"));
  EXPECT_FALSE(file.has_attribute("/", "beta"));
  EXPECT_FALSE(file.has_attribute("/nothing", "beta"));
  EXPECT_EQ(file.children("/deep"), (std::vector<std::string>{"down", "vector", "array"}));
}

TEST(Hdf5File, EqualContentsAreEqualBytes) {
  const TemporaryDirectory directory;
  write_file(directory.file("a.h5"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // a time stamp would show by now
  write_file(directory.file("b.h5"));
  EXPECT_EQ(bytes_of(directory.file("a.h5")), bytes_of(directory.file("b.h5")));
}

TEST(Hdf5File, WrongItemsAreNamed) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  write_file(path);
  const Hdf5Reader file(path);
  EXPECT_EQ(error_of([&] { file.read<Vector>("/deep/nothing"); }),
            path + ": expected a dataset /deep/nothing, found none");
  EXPECT_EQ(error_of([&] { file.read<Vector>("/deep"); }), path + ": expected a dataset /deep, found none");
  EXPECT_EQ(error_of([&] { file.read<Vector>("/deep/down/points"); }),
            path + ": /deep/down/points: expected numbers of 1 dimension, found numbers of shape [3, 2]");
  EXPECT_EQ(error_of([&] { file.read<double>("/integer"); }),
            path + ": /integer: expected numbers of one value, found integers of one value");
  EXPECT_EQ(error_of([&] { file.read<std::string>("/number"); }),
            path + ": /number: expected text of one value, found numbers of one value");
  EXPECT_EQ(error_of([&] { file.attribute<std::string>("/", "beta"); }),
            path + ": expected an attribute beta of /, found none");
  EXPECT_EQ(error_of([&] { file.attribute<double>("/", "zeta"); }),
            path + ": attribute zeta of /: expected numbers of one value, found text of one value");
  EXPECT_EQ(error_of([&] { file.children("/text"); }), path + ": expected a group /text, found none");
  EXPECT_EQ(error_of([&] { file.attributes("/nothing"); }), path + ": expected an item /nothing, found none");
}

TEST(Hdf5File, WhatCannotBeWrittenIsNamed) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  Hdf5Writer file(path);
  file.write("/twice", 1.0);
  EXPECT_TRUE(error_of([&] { file.write("/twice", 2.0); }).starts_with(path + ": /twice: cannot write it: "));
  EXPECT_TRUE(
      error_of([&] { file.write("/twice/inside", 2.0); }).starts_with(path + ": /twice/inside: cannot"));
  EXPECT_EQ(error_of([&] {
              file.write("/bad", Array{.shape = {2, 2}, .values = {1, 2, 3}});
            }),
            path + ": /bad: cannot write it: found 3 values, expected 4 of its shape [2, 2]");
  EXPECT_EQ(error_of([&] { file.write("/zero", std::string("a\0b", 3)); }),
            path + ": /zero: cannot write a text that holds a zero byte");
  file.commit();
  EXPECT_EQ(error_of([&] { file.write("/late", 1.0); }),
            path + ": /late: cannot write it: the file has been committed");
  EXPECT_EQ(error_of([&] { file.commit(); }), path + ": cannot write: the file has been committed");
}

TEST(Hdf5File, UnreadableFilesAreErrors) {
  const TemporaryDirectory directory;
  EXPECT_EQ(error_of([&] { Hdf5Reader file(directory.file("none.h5")); }),
            directory.file("none.h5") + ": cannot read it: No such file or directory");
  EXPECT_EQ(error_of([&] { Hdf5Reader file(directory.file("")); }),
            directory.file("") + ": expected an HDF5 file, found a directory");
  put_bytes(directory.file("text.h5"), "time,x,y\n");
  EXPECT_TRUE(error_of([&] {
                Hdf5Reader file(directory.file("text.h5"));
              }).starts_with(directory.file("text.h5") + ": expected a whole HDF5 file, found 9 bytes: "));
}

TEST(Hdf5File, TruncatedFilesAreErrors) {
  const TemporaryDirectory directory;
  write_file(directory.file("a.h5"));
  const std::string whole = bytes_of(directory.file("a.h5"));
  const std::string path = directory.file("cut.h5");
  for (std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{8}, std::size_t{95},
                             std::size_t{512}, whole.size() / 2, whole.size() - 1}) {
    put_bytes(path, whole.substr(0, length));
    EXPECT_TRUE(error_of([&] { Hdf5Reader file(path); }).starts_with(path + ": expected ")) << length;
  }
}

// A shape that promises more than the file holds must not take all memory.
TEST(Hdf5File, ADamagedShapeIsAnError) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  write_file(path);
  std::string bytes = without_digest(bytes_of(path), path);         // else nothing looks at the shape
  const std::string shape("\3\0\0\0\0\0\0\0\2\0\0\0\0\0\0\0", 16);  // [3, 2]
  const std::size_t at = bytes.find(shape);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 5] = 1;
  put_bytes(path, bytes);
  const Hdf5Reader file(path);
  // HDF5 1.14 refuses such an item by itself.
  const std::string error = error_of([&] { file.read<Points>("/deep/down/points"); });
  EXPECT_TRUE(error.starts_with(path + ": /deep/down/points: found shape [1099511627779, 2], more than") ||
              error.starts_with(path + ": expected a dataset /deep/down/points, found none"))
      << error;
}

// HDF5 itself may crash on damaged bytes, so it must not get to see them.
TEST(Hdf5File, ADamagedByteAnywhereIsAnError) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  write_file(path);
  const std::string whole = bytes_of(path);
  for (std::size_t at = 0; at + 80 < whole.size(); at += 97) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 4);
    put_bytes(path, bytes);
    EXPECT_EQ(
        error_of([&] { Hdf5Reader file(path); }),
        fmt::format("{}: expected a whole file, found {} bytes that are damaged: their SHA-256 is not the "
                    "one at their end",
                    path, whole.size()))
        << at;
  }
}

// Whatever a damaged file makes of itself: it is read or refused with an Error, and nothing is printed,
// neither then nor when the process ends.
TEST(Hdf5File, DamagedFilesOfOthersAreRefusedInSilence) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  write_file(path);
  const std::string whole = without_digest(bytes_of(path), path);  // as files of others
  hdf5_version();                                                  // as the program does first of all
  const auto child = [&] {
    RandomStream random(1, "damage");
    for (int k = 0; k < 100; ++k) {
      std::string bytes = whole;
      for (int i = 0; i < 8; ++i) {
        const auto at = static_cast<std::size_t>(random.uniform() * 6000.0);
        bytes[at] = static_cast<char>(random.uniform() * 256.0);
      }
      put_bytes(path, bytes);
      try {
        const Hdf5Reader file(path);
        for (const char* group : {"/", "/deep", "/none", "/made/here"}) {
          file.children(group);
          file.attributes(group);
        }
        file.read<Points>("/deep/down/points");
        file.read<Array>("/deep/array");
        file.read<std::string>("/text");
        file.attribute<std::vector<std::string>>("/made/here", "texts");
      } catch (const Error&) {
      }
    }
    std::exit(0);  // as a program ends: HDF5 closes itself then
  };
  EXPECT_EXIT(child(), testing::ExitedWithCode(0), "^$");
}

TEST(Hdf5File, WithoutCommitTheOldFileStays) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  put_bytes(path, "old");
  {
    Hdf5Writer file(path);
    write_everything(file);
  }
  EXPECT_EQ(bytes_of(path), "old");
  EXPECT_EQ(directory.entries(), 1u);
}

TEST(Hdf5File, CommitReplacesTheOldFileUnderAReader) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  write_file(path);
  const Hdf5Reader old(path);
  {
    Hdf5Writer file(path);
    file.write("/number", 3.5);
    file.commit();
  }
  EXPECT_EQ(Hdf5Reader(path).read<double>("/number"), 3.5);
  EXPECT_EQ(old.read<double>("/number"), -2.5);
  EXPECT_EQ(directory.entries(), 1u);
}

TEST(Hdf5File, UnwritablePathsAreErrors) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("missing/a.h5");
  EXPECT_TRUE(error_of([&] { write_file(path); }).starts_with(path + ": cannot write "));
  EXPECT_TRUE(error_of([&] { write_file(path); }).ends_with(" bytes: No such file or directory"));
  std::filesystem::create_directory(directory.file("folder.h5"));
  std::filesystem::create_directory(directory.file("folder.h5/inside"));
  EXPECT_TRUE(error_of([&] { write_file(directory.file("folder.h5")); }).ends_with(" bytes: Is a directory"));
  EXPECT_EQ(directory.entries(), 1u);
}

// A limit on the size of files fails writes as a full disk does, without root.
TEST(Hdf5File, AFullDiskLeavesTheOldFile) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("a.h5");
  write_file(path);
  const std::string old = bytes_of(path);
  const pid_t child = fork();
  if (child == 0) {  // the limit is for good, so a process of its own
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {.rlim_cur = 50000, .rlim_max = 50000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const std::string message = error_of([&] { write_file(path); });
    _exit(message.starts_with(path + ": cannot write ") && message.ends_with(": File too large") ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(bytes_of(path), old);
  EXPECT_EQ(directory.entries(), 1u);
}

#if defined(__linux__)
TEST(Hdf5File, AFullFileSystemLeavesTheOldFile) {
  const TemporaryDirectory directory;
  std::filesystem::create_directory(directory.file("small"));
  const std::string mount_point = directory.file("small");
  if (mount("none", mount_point.c_str(), "tmpfs", 0, "size=64k") != 0) {
    GTEST_SKIP() << "mounting a small file system needs root";
  }
  const std::string path = mount_point + "/a.h5";
  put_bytes(path, "old");
  EXPECT_TRUE(error_of([&] { write_file(path); }).ends_with(": No space left on device"));
  EXPECT_EQ(bytes_of(path), "old");
  EXPECT_EQ(
      std::distance(std::filesystem::directory_iterator(mount_point), std::filesystem::directory_iterator()),
      1);
  umount(mount_point.c_str());
}
#endif

TEST(Hdf5File, FilesInSeveralThreadsStayApart) {
  const TemporaryDirectory directory;
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) {
    threads.emplace_back([&directory, k] {
      const std::string path = directory.file(std::to_string(k) + ".h5");
      for (int i = 0; i < 20; ++i) {
        Hdf5Writer file(path);
        file.write("/number", k + 0.5);
        file.commit();
        EXPECT_EQ(Hdf5Reader(path).read<double>("/number"), k + 0.5);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace s2nnds
