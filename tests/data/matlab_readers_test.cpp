// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <matio.h>

#include <Eigen/Geometry>
#include <fstream>
#include <iterator>
#include <memory>

#include "s2nnds/data/readers.h"
#include "tests/data/temporary_folder.h"

namespace s2nnds {
namespace {

const std::string kShared = S2NNDS_SHARED_DATA;

#define SKIP_WITHOUT(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no file " << (path)

DemonstrationSet lasa(const std::string& path) { return make_demonstrations(read_lasa(path)); }
DemonstrationSet ds_opt(const std::string& path) { return make_demonstrations(read_ds_opt(path)); }

// A MATLAB matrix [rows, columns] from its transpose (one column of MATLAB's a row of ours).
matvar_t* matrix(const char* name, Points transposed) {
  std::size_t size[2] = {static_cast<std::size_t>(transposed.cols()),
                         static_cast<std::size_t>(transposed.rows())};
  return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, transposed.data(), 0);
}

matvar_t* cells(const char* name, std::vector<matvar_t*> elements) {
  std::size_t size[2] = {1, elements.size()};
  return Mat_VarCreate(name, MAT_C_CELL, MAT_T_CELL, 2, size, elements.data(), 0);
}

matvar_t* structure(std::vector<std::pair<const char*, Points>> fields) {
  std::vector<const char*> names;
  for (const auto& [name, value] : fields) names.push_back(name);
  std::size_t size[2] = {1, 1};
  matvar_t* const result =
      Mat_VarCreateStruct(nullptr, 2, size, names.data(), static_cast<unsigned>(names.size()));
  for (const auto& [name, value] : fields)
    Mat_VarSetStructFieldByName(result, name, 0, matrix(nullptr, value));
  return result;
}

class MatlabReaders : public testing::Test {
 protected:
  // Writes the variables, which it frees, to a new file.
  std::string write(const std::vector<matvar_t*>& variables, mat_ft version = MAT_FT_MAT5,
                    matio_compression compression = MAT_COMPRESSION_ZLIB) const {
    const std::string path = folder_.path("made.mat");
    mat_t* const file = Mat_CreateVer(path.c_str(), nullptr, version);
    for (matvar_t* variable : variables) {
      Mat_VarWrite(file, variable, compression);
      Mat_VarFree(variable);
    }
    Mat_Close(file);
    return path;
  }

  TemporaryFolder folder_;
  const Points time_{{0}, {0.5}, {1.5}};
  const Points position_{{1, 2}, {3, 4}, {5, 6}};
  const Points velocity_{{7, 8}, {9, 10}, {11, 12}};
};

TEST_F(MatlabReaders, LasaRoundTrip) {
  const Points other = 2 * position_;
  const std::string path = write(
      {matrix("dt", Points{{0.5}}),
       cells("demos", {structure({{"pos", position_}, {"t", time_}, {"vel", velocity_}}),
                       structure({{"vel", velocity_}, {"extra", time_}, {"t", time_}, {"pos", other}})})});
  const DemonstrationSet set = lasa(path);
  EXPECT_EQ(set.name, "made");
  EXPECT_EQ(set.unit, "mm");
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_EQ(set.demonstrations[0].time, time_.col(0));
  EXPECT_EQ(set.demonstrations[0].position, position_);
  EXPECT_EQ(set.demonstrations[0].velocity, velocity_);
  EXPECT_EQ(set.demonstrations[1].position, other);
}

TEST_F(MatlabReaders, Version73ReadsAlike) {
  const std::string path =
      write({cells("demos", {structure({{"pos", position_}, {"t", time_}, {"vel", velocity_}}),
                             structure({{"pos", 2 * position_}, {"t", time_}, {"vel", velocity_}})})},
            MAT_FT_MAT73);
  const DemonstrationSet set = lasa(path);
  ASSERT_EQ(set.demonstrations.size(), 2U);
  EXPECT_EQ(set.demonstrations[0].velocity, velocity_);
  EXPECT_EQ(set.demonstrations[1].position, 2 * position_);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  expect_error([&] { lasa(path); }, "made.mat: expected a whole HDF5 file");
}

TEST_F(MatlabReaders, LasaDefectsAreNamed) {
  const auto expect_rejected = [&](const std::vector<matvar_t*>& variables, const std::string& part) {
    const std::string path = write(variables);
    expect_error([&] { lasa(path); }, part);
  };
  expect_rejected({matrix("a", time_), matrix("b", time_)},
                  "made.mat: found the variable(s) 'a', 'b'; expected a LASA");
  expect_rejected({matrix("demos", time_)}, "found 'demos' that is not a cell array");
  expect_rejected({cells("demos", {matrix(nullptr, time_)})}, "demonstration 0: ");
  expect_rejected({cells("demos", {structure({{"pos", position_}, {"t", time_}})})},
                  "demonstration 0: vel: found no real matrix of doubles; expected a LASA file");
  expect_rejected(
      {cells("demos", {structure({{"pos", position_}, {"t", Points{{0}, {1}}}, {"vel", velocity_}})})},
      "demonstration 0: found 2 times for 3 positions");
  expect_rejected(
      {cells("demos", {structure({{"pos", position_}, {"t", Points{{0}, {1}, {1}}}, {"vel", velocity_}})})},
      "demonstration 0: sample 2: found time 1 after 1");
}

// Quaternions with a sign that flips, either way round, and rotation matrices row by row.
TEST_F(MatlabReaders, OrientationsOfNamedMatrices) {
  const Eigen::Index m = 21;
  Points time(m, 1), position(m, 3), quaternion(m, 4), rotation(m, 9);
  std::vector<Eigen::Quaterniond> shown;
  for (Eigen::Index i = 0; i < m; ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(m - 1);
    const Eigen::Quaterniond q(
        Eigen::AngleAxisd(1.0 - s, Eigen::Vector3d(0.6, 0.64, 0.48).normalized()).toRotationMatrix());
    shown.push_back(q);
    time(i, 0) = 0.1 * static_cast<double>(i);
    position.row(i) << 1 - s, s * s, 0.5 * s;
    quaternion.row(i) << q.w(), q.x(), q.y(), q.z();
    if (i % 2 == 1) quaternion.row(i) *= -1.0;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> r = q.toRotationMatrix();
    rotation.row(i) = Eigen::Map<const Eigen::RowVectorXd>(r.data(), 9);
  }
  DataOptions options;
  options.source = "mat";
  options.files = {"made.mat"};
  options.state = "pose";
  options.quaternion_order = "wxyz";
  options.cleaning.rest = 0;
  const auto expect_shown = [&](const std::vector<matvar_t*>& variables) {
    write(variables);
    const DemonstrationSet set = read_demonstrations(options, folder_.path(""));
    EXPECT_TRUE(set.has_orientations);
    const Points& q = set.demonstrations.at(0).orientation;
    ASSERT_EQ(q.rows(), m);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Quaterniond read(q(i, 0), q(i, 1), q(i, 2), q(i, 3));
      EXPECT_NEAR(read.angularDistance(shown[static_cast<std::size_t>(i)]), 0.0, 1e-7);
    }
  };
  const auto part = [](const char* name, const Points& values) { return matrix(name, values); };
  expect_shown({part("time", time), part("position", position), part("quaternion", quaternion)});
  expect_shown(
      {part("time", time), part("position", position), matrix("quaternion", Points(quaternion.transpose()))});
  options.columns.rotation = {"R"};
  expect_shown({part("time", time), part("position", position), part("R", rotation)});
  write({part("time", time), part("position", position)});
  expect_error([&] { read_demonstrations(options, folder_.path("")); }, "found no orientations");
  write({part("time", time), part("position", position), part("R", position)});
  expect_error([&] { read_demonstrations(options, folder_.path("")); },
               "found orientations of 3 numbers; expected 4 of a quaternion or 9 of a rotation matrix");
  options.state = "position";
  EXPECT_EQ(read_demonstrations(options, folder_.path("")).demonstrations[0].orientation.size(), 0);
}

TEST_F(MatlabReaders, DsOptWithAndWithoutVelocitiesAndTimeStep) {
  Points both(3, 4);
  both << position_, velocity_;
  const DemonstrationSet recorded = ds_opt(write({cells("data", {matrix(nullptr, both)})}));
  EXPECT_EQ(recorded.unit, "m");
  EXPECT_EQ(recorded.demonstrations[0].position, position_);
  EXPECT_EQ(recorded.demonstrations[0].velocity, velocity_);
  EXPECT_TRUE(recorded.demonstrations[0].time.isApprox(Vector({{0, 0.01, 0.02}})));

  const Points positions_3d{{0, 0, 0}, {1, 2, 3}, {2, 4, 6}};
  const DemonstrationSet bare =
      ds_opt(write({cells("data", {matrix(nullptr, positions_3d)}), matrix("dt", Points{{0.25}})}));
  EXPECT_EQ(bare.dimension(), 3);
  EXPECT_TRUE(bare.demonstrations[0].velocity.isApprox(Points{{4, 8, 12}, {4, 8, 12}, {4, 8, 12}}));
  EXPECT_EQ(ds_opt(write({cells("data", {matrix(nullptr, position_)})})).dimension(), 2);
}

TEST_F(MatlabReaders, DsOptDefectsAreNamed) {
  const std::string other = write({cells("demos", {matrix(nullptr, time_)})});
  expect_error([&] { ds_opt(other); }, "found the variable(s) 'demos'; expected a ds-opt file");
  const std::string odd = write({matrix("two\nlines\001", time_)});
  expect_error([&] { ds_opt(odd); }, "found the variable(s) 'two?lines?'; expected a ds-opt file");
  const std::string backwards =
      write({cells("data", {matrix(nullptr, position_)}), matrix("dt", Points{{-1}})});
  expect_error([&] { ds_opt(backwards); },
               "dt: found 1 value(s), the first -1; expected one time step > 0 s");
}

TEST_F(MatlabReaders, FilesThatAreNoMatlabFiles) {
  const std::vector<DemonstrationSet (*)(const std::string&)> readers = {lasa, ds_opt};
  for (const auto read : readers) {
    expect_error([&] { read(folder_.path("none.mat")); }, "none.mat: found no such file");
    expect_error([&] { read(folder_.path("")); }, "found a directory");
    expect_error([&] { read(folder_.write("empty.mat", "")); }, "empty.mat: found no MATLAB");
    expect_error([&] { read(folder_.write("text.mat", "time,x,y\n0,1,2\n1,2,3\n" + std::string(400, 'x'))); },
                 "text.mat: found no MATLAB");
    expect_error([&] { read(write({matrix("d", time_)}, MAT_FT_MAT4)); },
                 "made.mat: found no MATLAB 5 to 7.3 file");
  }
}

// Wherever the file breaks off, reading it either fails or gives what the whole file gives.
TEST_F(MatlabReaders, ATruncatedFileNeverGivesOtherNumbers) {
  const Points pos = Points::Random(40, 2);
  const Points t = Vector::LinSpaced(40, 0, 1);
  const std::string path = write({cells("demos", {structure({{"pos", pos}, {"t", t}, {"vel", pos}}),
                                                  structure({{"pos", pos}, {"t", t}, {"vel", pos}})})});
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Points expected = stack_positions(lasa(path).demonstrations);
  int rejected = 0;
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    try {
      EXPECT_EQ(stack_positions(lasa(folder_.write("cut.mat", whole.substr(0, size))).demonstrations),
                expected)
          << size;
    } catch (const Error&) {
      ++rejected;
    }
  }
  EXPECT_GT(rejected, static_cast<int>(whole.size() / 7) - 5);
  expect_error([&] { lasa(folder_.write("cut.mat", whole.substr(0, whole.size() / 2))); },
               "cut.mat: found damaged or truncated data");
}

// libmatio would take the memory that a damaged size asks for.
TEST_F(MatlabReaders, DamagedSizesAreRefusedAtOnce) {
  const std::string path = write({matrix("dt", Points{{0.25}}), cells("data", {matrix(nullptr, position_)})},
                                 MAT_FT_MAT5, MAT_COMPRESSION_NONE);
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  // Byte `at` is the highest of 4: of a variable's length, or of its first side.
  const auto damaged = [&](std::size_t at) {
    std::string bytes = whole;
    bytes.at(at) = '\x24';
    return folder_.write("damaged.mat", bytes);
  };
  const std::size_t dt = 128;
  const std::size_t data = dt + 8 + static_cast<unsigned char>(whole.at(dt + 4));
  const auto expect_refused = [&](std::size_t at, const std::string& what) {
    expect_error([&] { ds_opt(damaged(at)); },
                 "damaged.mat: found damaged or truncated data (" + what + "); expected a ds-opt file");
  };
  expect_refused(dt + 7, "a length that goes beyond the end");
  expect_refused(data + 7, "a length that goes beyond the end");
  expect_refused(dt + 35, "more numbers than bytes");
  expect_refused(data + 35, "more cells or fields than bytes");
}

// Damage to compressed bytes, wherever it is, is refused or changes nothing.
TEST_F(MatlabReaders, ADamagedCompressedFileNeverGivesOtherNumbers) {
  const std::string path = write({cells("data", {matrix(nullptr, position_), matrix(nullptr, velocity_)})});
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Points expected = stack_positions(ds_opt(path).demonstrations);
  for (std::size_t at = 124; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x11);
    try {
      EXPECT_EQ(stack_positions(ds_opt(folder_.write("damaged.mat", bytes)).demonstrations), expected) << at;
    } catch (const Error&) {
    }
  }
}

TEST_F(MatlabReaders, CellsWithinCellsAreLimited) {
  matvar_t* nested = matrix(nullptr, position_);
  for (int i = 0; i < 30; ++i) nested = cells(nullptr, {nested});
  const std::string path = write({cells("data", {nested})});
  expect_error([&] { ds_opt(path); }, "found damaged or truncated data (too many cells within cells)");
}

TEST(LasaData, KnownFigures) {
  const std::string path = kShared + "/lasa/Sine.mat";
  SKIP_WITHOUT(path);
  const DemonstrationSet set = lasa(path);
  EXPECT_EQ(set.name, "Sine");
  EXPECT_EQ(set.unit, "mm");
  ASSERT_EQ(set.demonstrations.size(), 7U);
  const Demonstration& d = set.demonstrations[0];
  EXPECT_EQ(d.samples(), 1000);
  EXPECT_NEAR(d.position(0, 0), -45.07042254, 1e-8);
  EXPECT_NEAR(d.position(0, 1), -0.93896714, 1e-8);
  EXPECT_EQ(d.position.row(999).norm(), 0);
  EXPECT_NEAR(d.time[1], 0.00519821185, 1e-10);
  EXPECT_NEAR(d.time[999], 5.19301364, 1e-8);
  EXPECT_NEAR(d.velocity.cwiseAbs().maxCoeff(), 24.669276964787716, 1e-12);
}

// But for the first and last instants, where the recorded velocities were smoothed and ended at zero.
TEST(LasaData, DifferentiatedVelocitiesAreNearTheRecordedOnes) {
  for (const char* motion : {"Sine", "Sshape", "CShape", "Worm", "Angle", "GShape", "PShape", "NShape"}) {
    const std::string path = kShared + "/lasa/" + motion + ".mat";
    SKIP_WITHOUT(path);
    for (const Demonstration& d : lasa(path).demonstrations) {
      const Points error = (differentiate(d.time, d.position) - d.velocity).middleRows(20, 960);
      EXPECT_LT(error.norm(), 0.01 * d.velocity.norm()) << motion;
      EXPECT_EQ(d.velocity.row(999).norm(), 0);
    }
  }
}

TEST(DsOptData, KnownFigures) {
  const std::string box = kShared + "/ds_opt/3D-pick-box.mat";
  SKIP_WITHOUT(box);
  const DemonstrationSet set = ds_opt(box);
  ASSERT_EQ(set.demonstrations.size(), 4U);
  EXPECT_EQ(set.unit, "m");
  EXPECT_EQ(set.dimension(), 3);
  EXPECT_EQ(set.demonstrations[0].samples(), 663);
  EXPECT_NEAR(set.demonstrations[0].time[1], 0.01079178, 1e-8);
  EXPECT_NEAR(set.demonstrations[0].position(662, 2), 0.63040947, 1e-8);
  EXPECT_EQ(set.demonstrations[0].velocity.row(662).norm(), 0);

  const DemonstrationSet bottom = ds_opt(kShared + "/ds_opt/3D_Cshape_bottom.mat");
  ASSERT_EQ(bottom.demonstrations.size(), 15U);
  EXPECT_EQ(bottom.demonstrations[14].samples(), 401);
  EXPECT_NEAR(bottom.demonstrations[14].position(400, 1), 0.0851855, 1e-7);
  EXPECT_DOUBLE_EQ(bottom.demonstrations[14].time[400], 4);  // no dt in the file: 0.01 s
}

}  // namespace
}  // namespace s2nnds
