// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#if __has_include(<hdf5.h>)
#include <hdf5.h>
#else
#include <hdf5/serial/hdf5.h>  // Debian's place
#endif

#include "s2nnds/core/hdf5.h"
#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

DemonstrationSet hdf5(const std::string& path) { return make_demonstrations(read_hdf5(path)); }

class Hdf5Demonstrations : public testing::Test {
 protected:
  Hdf5Demonstrations() : path_(folder_.path("made.h5")) {
    file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  }
  ~Hdf5Demonstrations() override { close(); }

  void close() {
    if (file_ >= 0) H5Fclose(file_);
    file_ = -1;
  }

  // Creates the groups on the way.
  void put(const std::string& name, const Points& values, int rank = 2, hid_t type = H5T_NATIVE_DOUBLE) {
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    const hsize_t size[2] = {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())};
    const hid_t space = H5Screate_simple(rank, size, nullptr);
    const hid_t set = H5Dcreate2(file_, name.c_str(), type, space, links, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(set);
    H5Sclose(space);
    H5Pclose(links);
  }
  void put_demonstration(const std::string& number, const Points& position) {
    put("/demonstrations/" + number + "/time", time_, 1);
    put("/demonstrations/" + number + "/position", position);
  }
  void expect_rejected(const std::string& part) {
    close();
    expect_error([&] { hdf5(path_); }, part);
  }

  TemporaryFolder folder_;
  std::string path_;
  hid_t file_ = -1;
  const Points time_{{0}, {0.5}, {1.5}};
  const Points position_{{1, 2, 3}, {3, 4, 5}, {7, 8, 9}};
  const Points velocity_{{7, 8, 1}, {9, 10, 2}, {11, 12, 3}};
};

TEST_F(Hdf5Demonstrations, RoundTripInOrderOfNumber) {
  put_demonstration("10", 10 * position_);
  put_demonstration("2", 2 * position_);
  put("/demonstrations/2/velocity", velocity_);
  close();
  const DemonstrationSet set = hdf5(path_);
  EXPECT_EQ(set.name, "made");
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_EQ(set.demonstrations[0].time, time_.col(0));
  EXPECT_EQ(set.demonstrations[0].position, 2 * position_);
  EXPECT_EQ(set.demonstrations[0].velocity, velocity_);
  EXPECT_EQ(set.demonstrations[1].position, 10 * position_);
  EXPECT_TRUE(set.demonstrations[1].velocity.isApprox(Points::Constant(3, 3, 40)));  // differentiated
}

TEST_F(Hdf5Demonstrations, TakesOtherNumberTypesAndTimeAsAColumn) {
  put("/demonstrations/0/time", Points{{0}, {1}}, 2, H5T_STD_I32BE);
  put("/demonstrations/0/position", Points{{0.5, 1}, {1.5, 3}}, 2, H5T_NATIVE_FLOAT);
  close();
  EXPECT_EQ(hdf5(path_).demonstrations[0].velocity.row(0), Eigen::RowVector2d(1, 2));
}

// As h5py writes it with compression="gzip": more numbers than the file has bytes for.
TEST_F(Hdf5Demonstrations, ReadsCompressedData) {
  const Eigen::Index count = 50'000;
  put("/demonstrations/0/time", Points(Vector::LinSpaced(count, 0.0, 1.0)), 1, H5T_NATIVE_FLOAT);
  Points position = Points::Zero(count, 3);
  position.topRows(1000).setConstant(0.5);
  const hsize_t size[2] = {static_cast<hsize_t>(count), 3};
  const hsize_t chunk[2] = {1000, 3};
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(creation, 2, chunk);
  H5Pset_deflate(creation, 6);
  const hid_t space = H5Screate_simple(2, size, nullptr);
  const hid_t set = H5Dcreate2(file_, "/demonstrations/0/position", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                               creation, H5P_DEFAULT);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, position.data());
  H5Dclose(set);
  H5Sclose(space);
  H5Pclose(creation);
  close();
  EXPECT_LT(std::filesystem::file_size(path_), static_cast<std::size_t>(position.size()) * sizeof(double));
  EXPECT_EQ(hdf5(path_).demonstrations[0].position, position);
}

TEST_F(Hdf5Demonstrations, ReadsDataSetsByTheirPaths) {
  put("/log/run_2/stamp", time_, 1);
  put("/log/run_2/arm/x", position_.col(0), 1);
  put("/log/run_2/arm/yz", position_.rightCols(2));
  put("/log/run_2/arm/v", velocity_);
  close();
  TableOptions options;
  options.columns.time = "stamp";
  options.columns.position = {"arm/x", "arm/yz"};
  options.columns.velocity = {"arm/v"};
  options.columns.index = "/log";
  const Recording r = read_hdf5(path_, options).recordings.at(0);
  EXPECT_EQ(r.time, time_.col(0));
  EXPECT_EQ(r.time_column, "stamp");
  EXPECT_EQ(r.position, position_);
  EXPECT_EQ(r.velocity, velocity_);
  options.columns.position = {"arm/q"};
  expect_error([&] { read_hdf5(path_, options); }, "expected a dataset /log/run_2/arm/q, found none");
  options.columns.index = "/logs";
  expect_error([&] { read_hdf5(path_, options); }, "expected a group /logs, found none");
}

TEST_F(Hdf5Demonstrations, ReadsRobomimicsLayout) {
  put("/data/demo_10/obs/robot0_eef_pos", 10 * position_);
  put("/data/demo_2/obs/robot0_eef_pos", position_);
  close();
  expect_error([&] { read_hdf5(path_); }, "expected data.rate (samples per second)");
  TableOptions options;
  options.rate = 4;
  const RecordingSet set = read_hdf5(path_, options);
  EXPECT_EQ(set.recordings.at(0).position, position_);
  EXPECT_EQ(set.recordings.at(1).time, Vector({{0, 0.25, 0.5}}));
  EXPECT_EQ(set.time_unit, 1);
  EXPECT_EQ(set.report.at(0), "2 demonstrations in /data: position obs/robot0_eef_pos, time by 4 samples/s");
  Hdf5Writer file(folder_.path("mimic.h5"));
  file.write("/data/demo_0/obs/robot0_eef_pos", position_);
  file.write_attribute("/data", "env_args",
                       std::string("{\"env_name\": \"Lift\", \"env_kwargs\": {\"control_freq\": 20}}"));
  file.commit();
  EXPECT_EQ(read_hdf5(folder_.path("mimic.h5")).recordings.at(0).time, Vector({{0, 0.05, 0.1}}));
}

TEST_F(Hdf5Demonstrations, NoDemonstrations) {
  expect_rejected("made.h5: expected a group /demonstrations, found none");
}

TEST_F(Hdf5Demonstrations, NoPosition) {
  put("/demonstrations/0/time", time_, 1);
  expect_rejected("made.h5: expected a dataset /demonstrations/0/position, found none");
}

TEST_F(Hdf5Demonstrations, ADatasetInsteadOfAGroup) {
  put("/demonstrations/0", time_);
  expect_rejected("made.h5: expected a dataset /demonstrations/0/time, found none");
}

TEST_F(Hdf5Demonstrations, WrongShapes) {
  put("/demonstrations/0/time", Points{{0}, {1}}, 1);
  put("/demonstrations/0/position", position_);
  expect_rejected("/demonstrations/0: found 2 times for 3 positions");
}

TEST_F(Hdf5Demonstrations, NotANumber) {
  put_demonstration("0", Points(position_ / 0.0 * 0.0));
  expect_rejected("/demonstrations/0: sample 0: found a position that is NaN, infinite or missing");
}

TEST_F(Hdf5Demonstrations, OneSample) {
  put("/demonstrations/0/time", Points{{0}}, 1);
  put("/demonstrations/0/position", Points{{1, 2}});
  expect_rejected("/demonstrations/0: found 1 sample(s)");
}

TEST_F(Hdf5Demonstrations, MissingTruncatedOrAnotherFormat) {
  put_demonstration("0", position_);
  close();
  expect_error([&] { hdf5(folder_.path("none.h5")); }, "none.h5: found no such file");
  expect_error([&] { hdf5(folder_.write("text.h5", "time,x,y\n")); }, "text.h5: expected a whole HDF5 file");
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  expect_error([&] { hdf5(path_); }, "made.h5: expected a whole HDF5 file");
}

}  // namespace
}  // namespace s2nnds
