// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/runs/run_record.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <functional>
#include <regex>

#include "s2nnds/core/hdf5.h"
#include "s2nnds/runs/summary.h"
#include "s2nnds/runs/version.h"
#include "tests/runs/temporary_directory.h"
#include "tests/runs/unusual_record.h"

namespace s2nnds {
namespace {

void expect_equal(const NetworkWeights& a, const NetworkWeights& b) {
  EXPECT_EQ(a.head, b.head);
  EXPECT_EQ(a.quadratic, b.quadratic);
  ASSERT_EQ(a.layers.size(), b.layers.size());
  for (std::size_t k = 0; k < a.layers.size(); ++k) {
    EXPECT_EQ(a.layers[k].weight, b.layers[k].weight);
    EXPECT_EQ(a.layers[k].bias, b.layers[k].bias);
    EXPECT_EQ(a.layers[k].activation, b.layers[k].activation);
  }
}

void expect_equal(const RunData& a, const RunData& b) {
  EXPECT_EQ(a.frame.unit, b.frame.unit);
  EXPECT_EQ(a.frame.name, b.frame.name);
  EXPECT_EQ(a.frame.goal, b.frame.goal);
  EXPECT_EQ(a.frame.goals, b.frame.goals);
  EXPECT_EQ(a.dimension, b.dimension);
  EXPECT_EQ(a.frame.normalization, b.frame.normalization);
  EXPECT_EQ(a.frame.position_scale, b.frame.position_scale);
  EXPECT_EQ(a.frame.velocity_scale, b.frame.velocity_scale);
  EXPECT_EQ(a.split.train, b.split.train);
  EXPECT_EQ(a.split.test, b.split.test);
  EXPECT_EQ(a.split.validation, b.split.validation);
  ASSERT_EQ(a.demonstrations.size(), b.demonstrations.size());
  for (std::size_t k = 0; k < a.demonstrations.size(); ++k) {
    EXPECT_EQ(a.demonstrations[k].time, b.demonstrations[k].time);
    EXPECT_EQ(a.demonstrations[k].position, b.demonstrations[k].position);
    EXPECT_EQ(a.demonstrations[k].velocity, b.demonstrations[k].velocity);
  }
}

void expect_equal(const Grid& a, const Grid& b) {
  EXPECT_EQ(a.axes, b.axes);
  EXPECT_EQ(a.unsafe, b.unsafe);
  EXPECT_EQ(a.initial, b.initial);
  EXPECT_EQ(a.V, b.V);
  EXPECT_EQ(a.B, b.B);
  EXPECT_EQ(a.velocity, b.velocity);
}

TEST(RunRecord, EverythingComesBack) {
  const TemporaryDirectory directory;
  const RunRecord a = unusual_record();
  save_run(directory.file("run.h5"), a);
  const RunRecord b = load_run(directory.file("run.h5"));
  EXPECT_EQ(a.program_version, b.program_version);
  EXPECT_EQ(a.library_versions, b.library_versions);
  EXPECT_EQ(a.created, b.created);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.seed, b.seed);
  EXPECT_EQ(a.config.text, b.config.text);
  EXPECT_EQ(a.config.resolved, b.config.resolved);
  EXPECT_EQ(a.config.values, b.config.values);
  expect_equal(a.data, b.data);
  EXPECT_EQ(a.problem.frame, b.problem.frame);
  EXPECT_EQ(a.problem.unsafe, b.problem.unsafe);
  EXPECT_EQ(a.problem.initial, b.problem.initial);
  EXPECT_EQ(a.problem.containment, b.problem.containment);
  EXPECT_EQ(a.problem.level_band, b.problem.level_band);
  EXPECT_EQ(a.problem.workspace.lower, b.problem.workspace.lower);
  EXPECT_EQ(a.problem.workspace.upper, b.problem.workspace.upper);
  EXPECT_EQ(a.problem.files, b.problem.files);
  EXPECT_EQ(a.history, b.history);
  expect_equal(a.networks.f, b.networks.f);
  expect_equal(a.networks.V, b.networks.V);
  expect_equal(a.networks.B, b.networks.B);
  EXPECT_EQ(weight_hash(b.networks), b.certificate.weight_hash);
  EXPECT_EQ(flatten(a.certificate), flatten(b.certificate));
  EXPECT_EQ(flatten(a.evaluation), flatten(b.evaluation));
  EXPECT_EQ(flatten(a.timing), flatten(b.timing));
  ASSERT_EQ(a.rollouts.size(), b.rollouts.size());
  for (std::size_t k = 0; k < a.rollouts.size(); ++k) {
    EXPECT_EQ(a.rollouts[k].start_kind, b.rollouts[k].start_kind);
    EXPECT_EQ(a.rollouts[k].stop, b.rollouts[k].stop);
    EXPECT_EQ(a.rollouts[k].time, b.rollouts[k].time);
    EXPECT_EQ(a.rollouts[k].position, b.rollouts[k].position);
  }
  ASSERT_TRUE(b.grid.has_value());
  expect_equal(*a.grid, *b.grid);
  ASSERT_TRUE(b.checkpoint.has_value());
  EXPECT_EQ(a.checkpoint->round, b.checkpoint->round);
  EXPECT_EQ(a.checkpoint->finished, b.checkpoint->finished);
  EXPECT_EQ(a.checkpoint->points, b.checkpoint->points);
  EXPECT_EQ(a.checkpoint->numbers, b.checkpoint->numbers);
}

TEST(RunRecord, SavingWhatWasLoadedGivesTheSameBytes) {
  const TemporaryDirectory directory;
  save_run(directory.file("a.h5"), unusual_record());
  save_run(directory.file("b.h5"), load_run(directory.file("a.h5")));
  EXPECT_EQ(bytes_of(directory.file("a.h5")), bytes_of(directory.file("b.h5")));
}

TEST(RunRecord, GridAndCheckpointMayBeAbsent) {
  const TemporaryDirectory directory;
  RunRecord record = unusual_record();
  record.grid.reset();
  record.checkpoint.reset();
  record.history.clear();
  record.rollouts.clear();
  record.certificate = {};
  save_run(directory.file("run.h5"), record);
  const RunRecord loaded = load_run(directory.file("run.h5"));
  EXPECT_FALSE(loaded.grid.has_value());
  EXPECT_FALSE(loaded.checkpoint.has_value());
  EXPECT_TRUE(loaded.history.empty());
  EXPECT_TRUE(loaded.rollouts.empty());
  EXPECT_TRUE(loaded.certificate.conditions.empty());
}

TEST(RunRecord, ThreeDimensionalGridsKeepTheirShape) {
  const TemporaryDirectory directory;
  Counter c;
  RunRecord record = unusual_record();
  record.data.dimension = 3;
  record.data.demonstrations.clear();
  record.data.frame.goal = Vector::Zero(3);
  record.data.frame.goals.resize(0, 3);
  record.data.split = {};
  record.rollouts.clear();
  record.certificate.conditions.clear();
  record.problem.workspace = Box{.lower = -Vector::Ones(3), .upper = Vector::Ones(3)};
  record.networks.f.layers = {{.weight = c.points(3, 3), .bias = {}, .activation = Activation::tanh}};
  record.networks.V.layers = {{.weight = c.points(2, 3), .bias = {}, .activation = Activation::tanh}};
  record.networks.B.layers = {{.weight = c.points(1, 3), .bias = {}, .activation = Activation::tanh}};
  record.grid = Grid{.axes = {c.vector(2), c.vector(3), c.vector(4)},
                     .unsafe = c.vector(24),
                     .initial = c.vector(24),
                     .V = c.vector(24),
                     .B = c.vector(24),
                     .velocity = c.points(24, 3)};
  save_run(directory.file("run.h5"), record);
  expect_equal(*load_run(directory.file("run.h5")).grid, *record.grid);
  EXPECT_EQ(Hdf5Reader(directory.file("run.h5")).read_array("/grid/velocity").shape,
            (std::vector<Eigen::Index>{2, 3, 4, 3}));
}

// A resumed run must see the numbers that training saw, to the last bit.
TEST(RunRecord, NormalizedDemonstrationsComeBackBitForBit) {
  const TemporaryDirectory directory;
  const RunRecord a = unusual_record();
  save_run(directory.file("run.h5"), a);
  const std::vector<Demonstration> before = a.data.normalized();
  const std::vector<Demonstration> after = load_run(directory.file("run.h5")).data.normalized();
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(before[k].time, after[k].time);
    EXPECT_EQ(before[k].position, after[k].position);
    EXPECT_EQ(before[k].velocity, after[k].velocity);
  }
}

TEST(RunRecord, MisfitsAreNamed) {
  const auto error = [](const std::function<void(RunRecord&)>& change) {
    RunRecord record = unusual_record();
    change(record);
    return error_of([&] { check_record(record); });
  };
  EXPECT_EQ(error([](RunRecord&) {}), "no error");
  EXPECT_EQ(error([](RunRecord& r) { r.networks.B.layers[1].weight.resize(5, 4); }),
            "/networks/B: network: layer 1 takes 4 inputs, expected the 5 outputs of the layer before");
  EXPECT_EQ(error([](RunRecord& r) { r.networks.f.layers[0].weight(1, 1) = std::nan(""); }),
            "/networks/f: network: layer 0 holds a weight that is not a finite number");
  EXPECT_EQ(error([](RunRecord& r) { std::swap(r.networks.f, r.networks.B); }),
            "/networks/f: found 2 inputs and 1 outputs, expected 2 and 2");
  EXPECT_EQ(error([](RunRecord& r) { r.data.split.test = {3}; }),
            "/data/test: found demonstration 3, expected 0 to 2");
  EXPECT_EQ(error([](RunRecord& r) { r.data.frame.velocity_scale = std::nan(""); }),
            "/data: found position_scale 42.5 and velocity_scale nan, expected numbers > 0");
  EXPECT_EQ(error([](RunRecord& r) { r.data.frame.goals.resize(2, 2); }),
            "/data: found goals [2, 2], expected [3, 2]");
  EXPECT_EQ(error([](RunRecord& r) { r.data.demonstrations[1].velocity.resize(3, 2); }),
            "/data/demonstrations/1: found position [4, 2] and velocity [3, 2], expected [4, 2]");
  EXPECT_EQ(error([](RunRecord& r) { r.problem.workspace.upper.resize(3); }),
            "/problem: found workspace_lower [2] and workspace_upper [3], expected [2]");
  EXPECT_EQ(error([](RunRecord& r) { r.history[1].second.resize(4); }),
            "/history/loss: found 4 rounds, expected 5 as in round");
  EXPECT_EQ(error([](RunRecord& r) { r.history[1].first = "loss/f"; }),
            "/history: found the name \"loss/f\", expected one without a slash");
  EXPECT_EQ(error([](RunRecord& r) { r.rollouts[1].time.resize(1); }),
            "/rollouts/1: found position [2, 2], expected [1, 2]");
  EXPECT_EQ(error([](RunRecord& r) { r.grid->V.resize(5); }), "/grid/V: found 5 values, expected 6");
  EXPECT_EQ(error([](RunRecord& r) { r.certificate.conditions[1].witness = {0.5}; }),
            "/certificate/conditions/1: found a witness of 1 coordinates, expected 2");
  EXPECT_EQ(error([](RunRecord& r) { r.checkpoint->points[0].first = ""; }),
            "/checkpoint/points: found the name \"\", expected one without a slash");
}

TEST(RunRecord, AMisfitIsNotSavedAndTheOldFileStays) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("run.h5");
  save_run(path, unusual_record());
  const std::string old = bytes_of(path);
  RunRecord record = unusual_record();
  record.networks.V.layers[0].weight(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error_of([&] { save_run(path, record); }),
            path + ": /networks/V: network: layer 0 holds a weight that is not a finite number");
  EXPECT_EQ(bytes_of(path), old);
  EXPECT_EQ(directory.entries(), 1u);
}

// What an ill-willed or ill-fated file may hold, made with the tool that such files come from.
void edit(const std::string& path, const std::string& python) {
  const std::string command = "/usr/bin/python3 -c \"import h5py; f = h5py.File('" + path + "', 'r+'); " +
                              python + "; f.close()\" 2>/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

bool has_h5py() { return std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") == 0; }

TEST(RunRecord, DamagedItemsAreNamed) {
  if (!has_h5py()) GTEST_SKIP() << "needs /usr/bin/python3 with h5py";
  const TemporaryDirectory directory;
  const std::string path = directory.file("run.h5");
  const auto error_after = [&](const std::string& python) {
    save_run(path, unusual_record());
    edit(path, python);
    return error_of([&] { load_run(path); });
  };
  EXPECT_EQ(error_after("f.attrs.modify('schema_version', 1)"),
            path + ": found a run file of schema 1, expected schema 5");
  EXPECT_EQ(error_after("del f.attrs['schema_version']"),
            path + ": expected a run file, found HDF5 without a schema_version");
  EXPECT_EQ(
      error_after("del f['networks/B/weight_1']; f['networks/B/weight_1'] = [[1.0, 2.0]] * 5"),
      path + ": /networks/B: network: layer 1 takes 2 inputs, expected the 5 outputs of the layer before");
  EXPECT_EQ(error_after("f['networks/f/weight_0'][0, 1] = float('nan')"),
            path + ": /networks/f: network: layer 0 holds a weight that is not a finite number");
  EXPECT_EQ(error_after("del f['networks/V/weight_0']"),
            path + ": expected a dataset /networks/V/weight_0, found none");
  EXPECT_EQ(error_after("f['networks/V'].attrs['activation_0'] = 'relu'"),
            path +
                ": /networks/V: activation: found \"relu\", expected one of identity, tanh, elu, softplus, "
                "silu, sine");
  EXPECT_EQ(error_after("f['networks/V'].attrs['activation_0'] = 'a\\nb'").find("found \"a?b\""),
            path.size() + std::string(": /networks/V: activation: ").size());
  EXPECT_EQ(error_after("del f['certificate'].attrs['weight_hash']"),
            path + ": expected an attribute weight_hash of /certificate, found none");
  EXPECT_EQ(error_after("f['data'].attrs.modify('dimension', 0)"),
            path + ": /data: found dimension 0, expected at least 1");
  EXPECT_EQ(error_after("del f['grid/B']; f['grid/B'] = [1.0, 2.0]"),
            path + ": /grid/B: found the shape [2], expected [3, 2]");
  EXPECT_EQ(error_after("del f['data/train']; f['data/train'] = [0.5]"),
            path + ": /data/train: expected integers of 1 dimension, found numbers of shape [1]");
}

TEST(RunRecord, TextsThatAreNotUtf8AreShown) {
  RunRecord record = unusual_record();
  record.problem.unsafe = "\xFFx";
  EXPECT_NE(summary_json(record, "run.h5").find("\xEF\xBF\xBDx"), std::string::npos);
}

TEST(RunRecord, TruncatedFilesAreErrors) {
  const TemporaryDirectory directory;
  save_run(directory.file("run.h5"), unusual_record());
  const std::string whole = bytes_of(directory.file("run.h5"));
  const std::string path = directory.file("cut.h5");
  for (std::size_t part = 0; part < 16; ++part) {
    put_bytes(path, whole.substr(0, whole.size() * part / 16));
    EXPECT_TRUE(error_of([&] { load_run(path); }).starts_with(path + ": expected ")) << part;
  }
}

TEST(RunRecord, ForeignFilesAreErrors) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("other.h5");
  EXPECT_EQ(error_of([&] { load_run(path); }), path + ": cannot read it: No such file or directory");
  {
    Hdf5Writer file(path);
    file.write("/demonstrations/0/time", Vector(Vector::Ones(3)));
    file.commit();
  }
  EXPECT_EQ(error_of([&] { load_run(path); }),
            path + ": expected a run file, found HDF5 without a schema_version");
  const std::string unwritten =
      error_of([&] { save_run(directory.file("missing/run.h5"), unusual_record()); });
  EXPECT_TRUE(unwritten.starts_with(directory.file("missing/run.h5") + ": cannot write")) << unwritten;
  EXPECT_TRUE(unwritten.ends_with("No such file or directory")) << unwritten;
}

TEST(RunRecord, AFullDiskLeavesTheOldRun) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("run.h5");
  save_run(path, unusual_record());
  const std::string old = bytes_of(path);
  const pid_t child = fork();
  if (child == 0) {  // the limit is for good, so a process of its own
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {.rlim_cur = 10000, .rlim_max = 10000};
    setrlimit(RLIMIT_FSIZE, &limit);
    const std::string message = error_of([&] { save_run(path, unusual_record()); });
    _exit(message.starts_with(path + ": cannot write ") ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(bytes_of(path), old);
  EXPECT_EQ(directory.entries(), 1u);
}

// A process killed in the middle of saving, again and again, leaves a file that loads.
TEST(RunRecord, AKilledSaveLeavesAWholeRun) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("run.h5");
  save_run(path, unusual_record());
  for (int i = 0; i < 15; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      for (;;) save_run(path, unusual_record());
    }
    usleep(2000 * static_cast<useconds_t>(i) + 500);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    EXPECT_EQ(load_run(path).name, "Sine — test");
  }
}

TEST(RunRecord, OtherProgramsReadTheFile) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("run.h5");
  save_run(path, unusual_record());
  if (std::system("command -v h5dump >/dev/null") == 0) {
    EXPECT_EQ(std::system(("h5dump " + path + " >/dev/null").c_str()), 0);
  }
  if (!has_h5py()) GTEST_SKIP() << "needs /usr/bin/python3 with h5py";
  const std::string script = directory.file("read.py");
  put_bytes(script, R"(
import h5py, sys
with h5py.File(sys.argv[1]) as f:
    assert f.attrs['schema_version'] == 5
    assert f.attrs['created'] == '2024-05-31T12:00:00Z'
    assert f['config/text'][()].decode() == '# a comment\nseed = 1\n'
    assert f['config/values'].attrs['zeta.b'] == '3'
    assert f['networks/f/weight_0'].shape == (4, 2)
    assert abs(f['networks/f/weight_0'][0, 1] - f['networks/f/weight_0'][0, 0] - 0.1) < 1e-12
    assert 'bias_1' not in f['networks/f'] and f['networks/f'].attrs['activation_0'] == 'tanh'
    assert f['grid/velocity'].shape == (3, 2, 2)
    assert list(f['data/train']) == [2] and list(f['data/validation']) == [0]
    assert f['certificate/conditions/1'].attrs['verdict'] == 'refuted'
    assert list(f['certificate/conditions/1'].attrs['witness']) == [0.5, -0.5]
    assert f['evaluation'].attrs['safe_area_ratio'] != f['evaluation'].attrs['safe_area_ratio']
    assert f['rollouts/1'].attrs['stop'] == 'reached_goal'
    assert f['checkpoint'].attrs['round'] == 7 and f['checkpoint/points/initial'].shape == (0, 2)
)");
  EXPECT_EQ(std::system(("/usr/bin/python3 " + script + " " + path).c_str()), 0);
}

TEST(RunRecord, VersionsAndTimeHaveTheirForm) {
  EXPECT_TRUE(std::regex_match(program_version(), std::regex(R"(\d+\.\d+\.\d+)"))) << program_version();
  EXPECT_TRUE(std::regex_search(library_versions(), std::regex(R"(HDF5 \d+\.\d+\.\d+, Eigen \d)")))
      << library_versions();
  EXPECT_TRUE(std::regex_match(time_stamp(), std::regex(R"(20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ)")))
      << time_stamp();
}

}  // namespace
}  // namespace s2nnds
