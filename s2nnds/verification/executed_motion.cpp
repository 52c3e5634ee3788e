// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/executed_motion.h"

#include <cmath>
#include <limits>

#include "s2nnds/core/check.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/verification/convergence_ball.h"
#include "s2nnds/verification/level_set_examiner.h"
#include "s2nnds/verification/rounding.h"
#include "s2nnds/verification/standard_floating_point.h"
#include "s2nnds/verification/supremum.h"

namespace s2nnds {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Boxes this small, relative to the workspace, are given up; hopeless ones if they are so many times as wide.
constexpr double level_resolution = 1e-4, hopeless_boxes = 40.0;
constexpr std::int64_t most_boxes = 500000;
constexpr double most_seconds = 60.0;

// |value - middle| <= radius, for each of some numbers.
struct TileIntervals {
  explicit TileIntervals(Eigen::Index count) : middle(count), radius(count) {}

  TileRow size(Eigen::Index i) const { return (middle[i].abs() + radius[i]) * slack; }
  TileRow norm() const {  // above the 2-norm
    TileRow sum;
    for (Eigen::Index i = 0; i < std::ssize(middle); ++i) sum += size(i).square();
    return sum.sqrt() * slack + underflow;
  }

  std::vector<TileRow> middle, radius;
};

// sum_k a_k b_k over the given entries, with its rounding.
class ProductSum {
 public:
  void add(const TileRow& a, const TileRow& a_radius, const TileRow& b, const TileRow& b_radius) {
    const TileRow product = a * b;
    middle += product;
    radius += a.abs() * b_radius + a_radius * (b.abs() + b_radius) + 1e-13 * product.abs() + underflow;
  }
  void store(TileIntervals& to, Eigen::Index i) const {
    to.middle[i] = middle;
    to.radius[i] = radius * slack;
  }
  TileRow size() const { return (middle.abs() + radius) * slack; }

 private:
  TileRow middle, radius;
};

// Each box of the tile with all that is within `distance` of it.
BoxTile grown(const BoxTile& tile, double distance) {
  BoxTile larger = tile;
  for (TileRow& half : larger.half) half = (half + distance) * slack;
  return larger;
}

// Functions first, first + stride, ... of `to` from the models.
void store(const BoxTile& tile, const TileModels& models, TileIntervals& to, Eigen::Index first,
           Eigen::Index stride) {
  for (Eigen::Index i = 0; i < std::ssize(models.remainder); ++i) {
    to.middle[first + i * stride] = models.value(i);
    to.radius[first + i * stride] = (models.spread(i, tile) + models.deviation(i, tile)) * slack + underflow;
  }
}

// f and its Jacobian on tiles; for one thread.
class FieldEnclosure {
 public:
  explicit FieldEnclosure(const TaylorFunction& field)
      : field_(field),
        workspace_(field.workspace()),
        models_(field.output_dimension(), field.input_dimension()),
        partials_(static_cast<std::size_t>(field.input_dimension()), models_),
        value(field.output_dimension()),
        jacobian(field.output_dimension() * field.input_dimension()) {}

  void evaluate_value(const BoxTile& tile) {
    field_.models(tile, *workspace_, models_);
    store(tile, models_, value, 0, 1);
  }
  // Of both.
  void evaluate_jacobian(const BoxTile& tile) {
    field_.jacobian_models(tile, *workspace_, models_, partials_);
    store(tile, models_, value, 0, 1);
    for (Eigen::Index axis = 0; axis < tile.dimension(); ++axis)
      store(tile, partials_[static_cast<std::size_t>(axis)], jacobian, axis, tile.dimension());
  }

 private:
  const TaylorFunction& field_;
  std::unique_ptr<TaylorFunction::Workspace> workspace_;
  TileModels models_;
  std::vector<TileModels> partials_;  // one for each axis

 public:
  TileIntervals value,  // [n]
      jacobian;         // [n, n]
};

// What follows from the model for the whole of {B <= 0}.
struct ExecutionBounds {
  ExecutionModel model;
  double field = 0.0;         // above |f| + field_error at every reading
  double most_command = 0.0;  // above |speed f| there
  double most_rate = 0.0;     // above |xdot|
  // From the present place, above the distance of every reading that had a part in the motion since the
  // oldest reading that still counts.
  double reach = 0.0;
  double lag_error = 0.0;  // above |v - speed f(x)| / speed, where lag > 0

  // (|w| + |error of the command|) / speed where |u| / speed is at most `size`.
  double noise(double size) const {
    return (model.velocity_error / model.least_speed + model.velocity_error_relative * size +
            model.field_error) *
           slack;
  }
};

ExecutionBounds bounds_of(const ProofFunctions& functions, const SafetyProblem& problem,
                          const ExecutionModel& model) {
  ExecutionBounds bounds{.model = model};
  // Over {B <= 0}.
  const auto largest = [&](auto size) {
    return supremum(functions, problem.workspace, BarrierSet::inside, [&functions, size]() -> TileSize {
      return [field = std::make_shared<FieldEnclosure>(*functions.f), size](const BoxTile& tile) {
        return size(*field, tile);
      };
    });
  };
  const double speed = largest([&](FieldEnclosure& field, const BoxTile& tile) {
    field.evaluate_value(grown(tile, model.position_error));
    return field.value.norm();
  });
  bounds.field = (speed + model.field_error) * slack;
  bounds.most_command = model.most_speed * bounds.field * slack;
  bounds.most_rate =
      (bounds.most_command * (1.0 + model.velocity_error_relative) + model.velocity_error) * slack;
  bounds.reach = (model.position_error + 2.0 * model.window() * bounds.most_rate) * slack;
  if (!(model.lag > 0.0)) return bounds;
  // lag edot = (u - speed f(x)) - e - lag speed J_f(x) xdot for e = v - speed f(x).
  const double steepest = largest([&](FieldEnclosure& field, const BoxTile& tile) {
    field.evaluate_jacobian(grown(tile, bounds.reach));
    return field.jacobian.norm();
  });
  bounds.lag_error = (steepest * (model.position_error + (model.window() + model.lag) * bounds.most_rate) +
                      model.field_error) *
                     slack;
  return bounds;
}

// delta = xdot / speed - f(x) of the model, at places in {B <= 0}.
class ExecutionPerturbation final : public Perturbation {
 public:
  // `arbitrary`: any velocity up to most_command may have been commanded before, not only speed f.
  ExecutionPerturbation(const ProofFunctions& functions, const ExecutionBounds& bounds, bool arbitrary)
      : bounds_(bounds), arbitrary_(arbitrary), field_(*functions.f) {}

  TileRow work(ScalarEnclosure& function, const BoxTile& tile) override {
    const ExecutionModel& model = bounds_.model;
    TileIntervals gradient(tile.dimension());
    store(tile, function.gradient(tile), gradient, 0, 1);
    const TileRow norm = gradient.norm();
    if (model.lag > 0.0) {
      return norm * ((bounds_.lag_error + bounds_.noise(bounds_.field)) * slack) * slack;
    }
    const BoxTile around = grown(tile, bounds_.reach);
    const TileRow command = command_size(around);
    const TileRow noise = model.velocity_error / model.least_speed + model.velocity_error_relative * command +
                          model.field_error;
    TileRow sum = norm * noise;
    if (model.displaces()) sum += displacement_work(gradient, command, around);
    return sum * slack * slack + underflow;
  }

 private:
  // Above |u| / speed; 0 where it does not matter.
  TileRow command_size(const BoxTile& around) {
    if (bounds_.model.displaces()) field_.evaluate_jacobian(around);
    if (arbitrary_) return TileRow(TileRow::Constant(bounds_.field));
    if (!bounds_.model.displaces()) {
      if (!(bounds_.model.velocity_error_relative > 0.0)) return {};
      field_.evaluate_value(around);
    }
    return field_.value.norm() + bounds_.model.field_error;
  }
  // f(y) - f(x) = J (error of the reading - what was moved since), with p = J' grad:
  // |p| position_error + window (most_speed |p . f| + |p| |w|), |w| on the way.
  TileRow displacement_work(const TileIntervals& gradient, const TileRow& command, const BoxTile& around) {
    const ExecutionModel& model = bounds_.model;
    const TileIntervals pulled = pull_back(gradient);
    if (arbitrary_)
      return pulled.norm() * ((model.position_error + model.window() * bounds_.most_rate) * slack);
    const TileRow rate_noise =
        model.velocity_error +
        model.most_speed * (model.velocity_error_relative * command + model.field_error);
    ProductSum along;
    for (Eigen::Index j = 0; j < around.dimension(); ++j)
      along.add(pulled.middle[j], pulled.radius[j], field_.value.middle[j], field_.value.radius[j]);
    const TileRow moved = model.most_speed * along.size() + pulled.norm() * rate_noise;
    return pulled.norm() * model.position_error + model.window() * moved * slack;
  }
  // grad' J.
  TileIntervals pull_back(const TileIntervals& gradient) const {
    const auto n = static_cast<Eigen::Index>(gradient.middle.size());
    TileIntervals pulled(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      ProductSum sum;
      for (Eigen::Index i = 0; i < n; ++i) {
        sum.add(gradient.middle[i], gradient.radius[i], field_.jacobian.middle[i * n + j],
                field_.jacobian.radius[i * n + j]);
      }
      sum.store(pulled, j);
    }
    return pulled;
  }

  const ExecutionBounds& bounds_;
  bool arbitrary_;
  FieldEnclosure field_;
};

void check_model(const ExecutionModel& model) {
  const auto is_size = [](double x) { return x >= 0.0 && x < infinity; };
  check(is_size(model.period) && is_size(model.delay) && is_size(model.lag) &&
            is_size(model.position_error) && is_size(model.velocity_error) &&
            is_size(model.velocity_error_relative),
        "execution: found a time or an error that is negative or not finite, expected finite ones >= 0");
  check(model.least_speed > 0.0 && model.least_speed <= model.most_speed && model.most_speed < infinity,
        "execution: found the speed factors {} to {}, expected 0 < least <= most", model.least_speed,
        model.most_speed);
}

// Why the bounds do not hold; "" if they do.
std::string beyond_range(const ProofFunctions& functions, const Box& workspace,
                         const ExecutionBounds& bounds) {
  const double size = std::max(workspace.lower.cwiseAbs().maxCoeff(), workspace.upper.cwiseAbs().maxCoeff());
  if (!(bounds.reach <= 10.0 * size) || !(bounds.lag_error < infinity)) {
    return fmt::format(
        "readings may be {:.3g} normalised units away from where the robot is, farther than the workspace is "
        "wide",
        bounds.reach);
  }
  for (const auto& function : {functions.f, functions.V, functions.B}) {
    if (!(function->growth(size + bounds.reach) <= largest_growth))
      return "weights are beyond those for which underflow is covered";
  }
  return "";
}

// Boxes that fail come back; one that does is enough to end.
BranchLimits level_set_limits(std::int64_t kept_boxes = 0) {
  BranchLimits limits;
  limits.max_boxes = most_boxes;
  limits.max_abandoned = std::max<std::int64_t>(kept_boxes, 1);
  limits.kept_boxes = kept_boxes;
  limits.max_seconds = most_seconds;
  return limits;
}

BranchResult examine_level_set(const ProofFunctions& functions, const SafetyProblem& problem,
                               const PerturbationFactory& perturbation, std::int64_t kept_boxes = 0) {
  const Box& workspace = problem.workspace;
  const double resolution = level_resolution * (workspace.upper - workspace.lower).maxCoeff();
  return branch_and_bound(
      workspace.lower.transpose(), workspace.upper.transpose(),
      [&] {
        return std::make_unique<LevelSetExaminer>(functions, resolution, perturbation(), 1.0,
                                                  hopeless_boxes * resolution);
      },
      level_set_limits(kept_boxes));
}

PerturbationFactory perturbations(const ProofFunctions& functions, const ExecutionBounds& bounds,
                                  bool arbitrary) {
  return [&functions, &bounds, arbitrary] {
    return std::make_unique<ExecutionPerturbation>(functions, bounds, arbitrary);
  };
}

enum class BarrierQuantity { value, gradient };

// Above how far B or its gradient changes from a place where B = 0 to any within the distance.
double largest_change(const ProofFunctions& functions, const Box& workspace, double distance,
                      BarrierQuantity quantity) {
  if (!(distance > 0.0)) return 0.0;
  return supremum(functions, workspace, BarrierSet::level_set, [&]() -> TileSize {
    return [=, barrier = std::make_shared<ScalarEnclosure>(*functions.B, nullptr)](const BoxTile& tile) {
      const BoxTile around = grown(tile, distance);
      if (quantity == BarrierQuantity::value) return barrier->value(around).variation(around, distance);
      TileRow sum;
      for (Eigen::Index d = 0; d < tile.dimension(); ++d)
        sum += barrier->partial_derivative(around, d).variation(around, distance).square();
      return TileRow(sum.sqrt() * slack);
    };
  });
}

// Whether all speed factors from `least` to `most` are certified; most_command is raised to that of `most`.
bool certifies(const ProofFunctions& functions, const SafetyProblem& problem, ExecutionModel model,
               double least, double most, double& most_command) {
  model.least_speed = least;
  model.most_speed = most;
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  if (!beyond_range(functions, problem.workspace, bounds).empty()) return false;
  if (!examine_level_set(functions, problem, perturbations(functions, bounds, false)).proved) return false;
  most_command = std::max(most_command, bounds.most_command);
  return true;
}

}  // namespace

ExecutedMotion prove_executed(const ProofFunctions& functions, const SafetyProblem& problem,
                              const ExecutionModel& model) {
  check_model(model);
  const StandardFloatingPoint mode;
  const Stopwatch watch;
  ExecutedMotion result{.convergence_radius = infinity};
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  result.most_command = bounds.most_command;
  result.reason = beyond_range(functions, problem.workspace, bounds);
  if (result.reason.empty()) {
    const PerturbationFactory perturbation = perturbations(functions, bounds, false);
    const BranchResult level_set = examine_level_set(functions, problem, perturbation);
    result.invariant = level_set.proved;
    result.boxes = level_set.boxes;
    if (result.invariant) {
      BranchLimits limits = level_set_limits();
      limits.max_seconds -= watch.seconds();
      const ConvergenceBall ball = convergence_ball(functions, problem, perturbation, limits);
      result.convergence_radius = ball.radius;
      result.boxes += ball.boxes;
    }
  }
  result.seconds = watch.seconds();
  return result;
}

BranchResult prove_executed_invariance(const ProofFunctions& functions, const SafetyProblem& problem,
                                       const ExecutionModel& model, std::int64_t kept_boxes) {
  check_model(model);
  const StandardFloatingPoint mode;
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  if (!beyond_range(functions, problem.workspace, bounds).empty()) {
    BranchResult open;
    open.stopped = true;
    open.open_boxes = 1;
    open.open_lower = problem.workspace.lower.transpose();
    open.open_upper = problem.workspace.upper.transpose();
    return open;
  }
  return examine_level_set(functions, problem, perturbations(functions, bounds, false), kept_boxes);
}

SpeedRange certified_speeds(const ProofFunctions& functions, const SafetyProblem& problem,
                            const ExecutionModel& model) {
  check_model(model);
  const StandardFloatingPoint mode;
  SpeedRange range;
  double ignored = 0.0;
  const auto holds = [&](double least, double most, double& command) {
    return certifies(functions, problem, model, least, most, command);
  };
  if (!holds(model.least_speed, model.most_speed, range.most_command)) return range;
  range.least = model.least_speed;
  range.most = model.most_speed;
  constexpr double first_step = 1.5, last_step = 1.02, farthest = 1e3;
  if (!(model.window() + model.lag > 0.0)) {  // all else shrinks as the speed grows
    range.most = infinity;
    range.most_command = 0.0;
  } else {
    for (double step = first_step; step > last_step && range.most < farthest;) {
      const double next = range.most * step;
      if (holds(range.most, next, range.most_command))
        range.most = next;
      else
        step = std::sqrt(step);
    }
  }
  if (!(model.velocity_error > 0.0)) {  // all else shrinks with the speed
    range.least = 0.0;
  } else {
    for (double step = first_step; step > last_step && range.least > 1.0 / farthest;) {
      const double next = range.least / step;
      if (holds(next, range.least, ignored))
        range.least = next;
      else
        step = std::sqrt(step);
    }
  }
  return range;
}

Shield prove_shield(const ProofFunctions& functions, const SafetyProblem& problem,
                    const ExecutionModel& model) {
  check_model(model);
  const StandardFloatingPoint mode;
  Shield shield;
  const ExecutionBounds bounds = bounds_of(functions, problem, model);
  if (model.lag > 0.0 || !beyond_range(functions, problem.workspace, bounds).empty()) return shield;
  if (!examine_level_set(functions, problem, perturbations(functions, bounds, true)).proved) return shield;
  const double distance = (model.position_error + model.window() * bounds.most_rate) * slack;
  shield.band = largest_change(functions, problem.workspace, distance, BarrierQuantity::value);
  shield.cone = largest_change(functions, problem.workspace, distance, BarrierQuantity::gradient);
  shield.certified = shield.band < infinity && shield.cone < infinity;
  shield.most_command = bounds.most_command;
  return shield;
}

}  // namespace s2nnds
