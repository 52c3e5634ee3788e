// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/sweeps/slurm.h"

#include <gtest/gtest.h>

#include <numeric>

#include "s2nnds/core/check.h"

namespace s2nnds {
namespace {

TEST(Slurm, OptionsAreThoseOfSbatch) {
  const SlurmOptions options = parse_slurm("partition=cpu,time=1-02:00:00,throttle=200,chunk=20,mem=2G");
  EXPECT_EQ(options.sbatch.at("partition"), "cpu");
  EXPECT_EQ(options.sbatch.at("time"), "1-02:00:00");
  EXPECT_EQ(options.throttle, 200);
  EXPECT_EQ(options.chunk, 20);
  EXPECT_EQ(options.sbatch.at("mem"), "2G");
  EXPECT_THROW(parse_slurm("partition"), Error);
  EXPECT_THROW(parse_slurm("throttle=0"), Error);
  EXPECT_THROW(parse_slurm("partition=a b"), Error);
}

TEST(Slurm, ArraysHoldTheTasksWithSomethingToDo) {
  EXPECT_EQ(array_text({0, 1, 2, 3, 4, 5, 6, 7}, 1), "0-7");
  EXPECT_EQ(array_text({1, 4, 5, 9}, 1), "1,4-5,9");
  EXPECT_EQ(array_text({3, 20, 21, 39, 45}, 10), "0,2-4");
  EXPECT_EQ(array_text({7}, 10), "0");
}

TEST(Slurm, ArraysStayBelowTheUsualLimit) {
  EXPECT_EQ(chunk_of({}, 8), 1);
  EXPECT_EQ(chunk_of({}, 1000), 1);
  EXPECT_EQ(chunk_of({}, 1001), 2);
  EXPECT_EQ(chunk_of({}, 100000), 100);
  EXPECT_EQ(chunk_of({.chunk = 7}, 100000), 7);
}

TEST(Slurm, ScriptsSayWhatWasAsked) {
  Sweep sweep;
  sweep.options.name = "it's";
  SlurmOptions options = parse_slurm("partition=cpu,time=02:00:00,throttle=5");
  const std::string script = batch_script(sweep, SweepFolder("/shared/a b"), options, "0-3,7", 20, 4,
                                          {"/bin/prog", "it's", "$first-$last"});
  for (const char* line : {"#!/bin/bash\n", "#SBATCH --partition=cpu\n", "#SBATCH --time=02:00:00\n",
                           "#SBATCH --array=0-3,7%5\n", "#SBATCH --cpus-per-task=4\n", "#SBATCH --requeue\n",
                           "#SBATCH --output='/shared/a b/slurm/%A_%a.log'\n",
                           "first=$((SLURM_ARRAY_TASK_ID * 20))\nlast=$((first + 19))\n",
                           "exec '/bin/prog' 'it'\\''s' \"$first-$last\"\n"}) {
    EXPECT_NE(script.find(line), std::string::npos) << line << script;
  }
  EXPECT_EQ(script.find("--mem"), std::string::npos);
}

}  // namespace
}  // namespace s2nnds
