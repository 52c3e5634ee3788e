// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>

#include "s2nnds/runs/run_record.h"

namespace s2nnds {

// Numbers that differ everywhere, so that a mix-up shows.
class Counter {
 public:
  double next() { return 0.1 * ++count_; }
  Points points(Eigen::Index rows, Eigen::Index cols) {
    Points values(rows, cols);
    for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = next();
    return values;
  }
  Vector vector(Eigen::Index size) { return points(size, 1); }

 private:
  int count_ = 0;
};

// A record in which everything is there and nothing has its default.
inline RunRecord unusual_record() {
  Counter c;
  RunRecord r;
  r.program_version = "9.8.7";
  r.library_versions = "HDF5 1.2.3";
  r.created = "2024-05-31T12:00:00Z";
  r.name = "Sine — test";
  r.seed = 1234567890123;
  r.config = {.text = "# a comment\nseed = 1\n",
              .resolved = "seed = 1\n",
              .values = {{"zeta.b", "3"}, {"alpha", "x"}}};
  r.data.dimension = 2;
  r.data.frame = {.unit = "mm",
                  .name = "base_link",
                  .normalization = "max_norm",
                  .goal = c.vector(2),
                  .goals = c.points(3, 2),
                  .position_scale = 42.5,
                  .velocity_scale = 17.25};
  r.data.split = {.train = {2}, .test = {1}, .validation = {0}};
  for (int samples : {3, 4, 2}) {
    r.data.demonstrations.push_back(
        {.time = c.vector(samples), .position = c.points(samples, 2), .velocity = c.points(samples, 2)});
  }
  r.problem = {.frame = "data",
               .unsafe = "ball",
               .initial = "box",
               .containment = 0.97,
               .level_band = 0.01,
               .workspace = {},
               .files = {}};
  r.problem.files = {{"../maps/room 1.pgm", std::string("P5\0\xff\n", 5)}, {"/a/b.json", "{}"}};
  r.problem.workspace = {.lower = -c.vector(2), .upper = c.vector(2)};
  r.history = {
      {"round", c.vector(5)}, {"loss", c.vector(5)}, {"counterexamples_barrier_decrease", c.vector(5)}};
  r.networks.f.head = Head::zero_at_origin;
  r.networks.f.layers = {{.weight = c.points(4, 2), .bias = c.vector(4), .activation = Activation::tanh},
                         {.weight = c.points(2, 4), .bias = {}, .activation = Activation::identity}};
  r.networks.V.head = Head::squared_norm;
  r.networks.V.quadratic = 0.05;
  r.networks.V.layers = {{.weight = c.points(3, 2), .bias = {}, .activation = Activation::sine}};
  r.networks.B.layers = {{.weight = c.points(5, 2), .bias = c.vector(5), .activation = Activation::elu},
                         {.weight = c.points(5, 5), .bias = c.vector(5), .activation = Activation::silu},
                         {.weight = c.points(1, 5), .bias = c.vector(1), .activation = Activation::softplus}};
  r.certificate.guarantee = Guarantee::conformal;
  r.certificate.weight_hash = weight_hash(r.networks);
  r.certificate.attempts = 3;
  r.certificate.level_band = c.next();
  r.certificate.disturbance_margin = c.next();
  r.certificate.convergence_radius = c.next();
  r.certificate.side.goal_is_safe = true;
  r.certificate.statement = "What holds.\nAnd where.";
  r.certificate.conditions.resize(2);
  ConditionVerdict& verdict = r.certificate.conditions[1];
  verdict = {.condition = Condition::unsafe,
             .method = Method::proof,
             .verdict = Verdict::refuted,
             .samples = 11,
             .violations = 12,
             .seed = 13,
             .worst = c.next(),
             .epsilon = c.next(),
             .beta = c.next(),
             .attempt = 14,
             .order = 15,
             .quantile = -std::numeric_limits<double>::infinity(),
             .tightest_epsilon = c.next(),
             .boxes = 16,
             .open_boxes = 17,
             .open_volume = c.next(),
             .witness = {0.5, -0.5},
             .reason = "why not",
             .seconds = c.next()};
  r.evaluation = {.mse_train = c.next(),
                  .mse_test = c.next(),
                  .mse_validation = c.next(),
                  .sd_train = c.next(),
                  .sd_test = c.next(),
                  .dtw_train = c.next(),
                  .dtw_test = c.next(),
                  .dtw_independent_test = c.next(),
                  .safe_area = c.next(),
                  .true_safe_area = c.next(),
                  .safe_area_ratio = std::nan("")};
  r.timing.training = c.next();
  r.timing.proof = c.next();
  r.rollouts = {
      {.start_kind = "grid", .stop = "time_out", .time = c.vector(3), .position = c.points(3, 2)},
      {.start_kind = "test", .stop = "reached_goal", .time = c.vector(2), .position = c.points(2, 2)}};
  r.grid = Grid{.axes = {c.vector(3), c.vector(2)},
                .unsafe = c.vector(6),
                .initial = c.vector(6),
                .V = c.vector(6),
                .B = c.vector(6),
                .velocity = c.points(6, 2)};
  r.checkpoint = Checkpoint{.round = 7,
                            .finished = true,
                            .points = {{"workspace", c.points(4, 2)}, {"initial", Points(0, 2)}},
                            .numbers = {{"rate", c.next()}, {"best", c.next()}}};
  return r;
}

}  // namespace s2nnds
