// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "s2nnds/core/check.h"
#include "s2nnds/data/orientation.h"
#include "s2nnds/runs/statement.h"
#include "tests/runs/temporary_directory.h"
#include "tests/runs/unusual_record.h"

namespace s2nnds {
namespace {

// unusual_record() with orientations.
RunRecord turning_record() {
  RunRecord r = unusual_record();
  r.data.frame.goal_orientation = quaternion_of({0.3, -1.2, 0.4});
  r.data.frame.quaternion_order = "wxyz";
  for (Demonstration& d : r.data.demonstrations)
    d.orientation = orientations(r.data.frame.goal_orientation, Points::Constant(d.samples(), 3, 0.1));
  OrientationLaw law;
  law.psi.head = Head::zero_at_origin;
  law.psi.layers = {{Points::Constant(4, 2, 0.3), Vector::Constant(4, 0.2), Activation::tanh},
                    {Points::Constant(3, 4, -0.1), {}, Activation::identity}};
  law.rate = 1.75;
  law.initial_error = 0.6;
  r.orientation = law;
  r.rollouts[0].orientation = orientations(r.data.frame.goal_orientation, Points::Constant(3, 3, 0.2));
  r.evaluation.orientation_mean_train = 1.5;
  r.evaluation.orientation_largest_test = 2.5;
  r.certificate.orientation = {
      .proved = true, .bound = 1.0, .initial_error = 0.6, .rate = 1.75, .boxes = 99, .reason = "why"};
  return r;
}

TEST(OrientationRecord, EverythingComesBack) {
  const TemporaryDirectory directory;
  const RunRecord a = turning_record();
  save_run(directory.file("run.h5"), a);
  const RunRecord b = load_run(directory.file("run.h5"));
  EXPECT_EQ(a.data.frame.goal_orientation, b.data.frame.goal_orientation);
  EXPECT_EQ(b.data.frame.quaternion_order, "wxyz");
  for (std::size_t k = 0; k < a.data.demonstrations.size(); ++k)
    EXPECT_EQ(a.data.demonstrations[k].orientation, b.data.demonstrations[k].orientation);
  ASSERT_TRUE(b.orientation.has_value());
  EXPECT_EQ(a.orientation->hash(), b.orientation->hash());
  EXPECT_EQ(b.orientation->rate, 1.75);
  EXPECT_EQ(b.orientation->initial_error, 0.6);
  EXPECT_EQ(a.rollouts[0].orientation, b.rollouts[0].orientation);
  EXPECT_EQ(b.rollouts[1].orientation.size(), 0);
  EXPECT_EQ(b.evaluation.orientation_mean_train, 1.5);
  EXPECT_EQ(b.evaluation.orientation_largest_test, 2.5);
  EXPECT_EQ(to_toml(a.certificate.orientation), to_toml(b.certificate.orientation));
}

TEST(OrientationRecord, MisfitsAreRefused) {
  RunRecord r = turning_record();
  EXPECT_NO_THROW(check_record(r));
  r.data.demonstrations[1].orientation.resize(0, 0);
  EXPECT_THROW(check_record(r), Error);
  r = turning_record();
  r.orientation->psi.layers.pop_back();
  EXPECT_THROW(check_record(r), Error);
  r = turning_record();
  r.data.frame.goal_orientation *= 1.1;
  EXPECT_THROW(check_record(r), Error);
  r = turning_record();
  r.data.frame.quaternion_order = "wzyx";
  EXPECT_THROW(check_record(r), Error);
}

// What is said of a bound is never less than it, and of covered starts never more than they are.
TEST(OrientationRecord, WordsAreRoundedToWhatIsTrue) {
  RunRecord r = turning_record();
  r.certificate.guarantee = Guarantee::invariant;
  r.certificate.orientation.bound = 1.0;          // 57.2957...
  r.certificate.orientation.initial_error = 0.5;  // 28.6478...
  const std::string text = guarantee_statement(r);
  for (const char* words : {"at most 28.64 degrees", "|psi(p)| < 57.3 degrees", "from |e| <= 122.7)",
                            "exp(-1.75 t)", "Excluded are starts with a larger |e|"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in: " << text;
  EXPECT_EQ(text.find("tool"), std::string::npos);
  r.certificate.orientation.tool = "a capsule";
  EXPECT_NE(guarantee_statement(r).find("Nothing is guaranteed of the tool, a capsule."), std::string::npos);
  r.certificate.orientation.tool_clear = true;
  EXPECT_NE(guarantee_statement(r).find("The tool, a capsule in the frame that turns, touches nothing"),
            std::string::npos);
  r.certificate.guarantee = Guarantee::proved;
  EXPECT_NE(guarantee_statement(r).find("Nothing is guaranteed of the orientation"), std::string::npos);
  r.data.frame.goal_orientation = {};
  EXPECT_EQ(guarantee_statement(r).find("orientation"), std::string::npos);
}

}  // namespace
}  // namespace s2nnds
