// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/verification/branch_and_bound.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "s2nnds/core/check.h"
#include "s2nnds/core/parallel.h"
#include "s2nnds/core/stopwatch.h"
#include "s2nnds/verification/standard_floating_point.h"
#include "s2nnds/verification/taylor_kernels.h"

namespace s2nnds {
namespace {

// Boxes in a batch: of a small level few, so that it has some for every thread; of a large one many, since tiles that are
// filled from what is left of a batch are not full. A function of the level alone, so that results are.
Eigen::Index batch_size(Eigen::Index count) {
  constexpr Eigen::Index least = tile_boxes, most = 128, share = 8;
  return std::clamp(count / share / least * least, least, most);
}

// Up to so many boxes, which fill a tile for each of two threads, take as long as fewer: small levels are filled up to it by
// more cuts, as far as doubling goes.
constexpr double kFullLevel = 2.0 * tile_boxes;

constexpr std::int64_t kLeastToExpect = 4000;  // boxes examined before it is told how many are needed
constexpr double kTreeBytes = 10.0;            // a box examined, of a tree and of what is needed to write it

struct Level {
  explicit Level(Points low, Points high)
      : lower(std::move(low)),
        upper(std::move(high)),
        status(static_cast<std::size_t>(lower.rows()), BoxStatus::undecided),
        witness(Points::Zero(lower.rows(), lower.cols())),
        violation(Vector::Zero(lower.rows())),
        carried(Vector::Constant(lower.rows(), std::numeric_limits<double>::infinity())),
        cuts(static_cast<std::size_t>(lower.rows()), 1) {}

  Points lower, upper;
  std::vector<BoxStatus> status;
  Points witness;
  Vector violation, carried;
  std::vector<std::int32_t> cuts;
};

// Boxes that stay open, and the witnesses among them.
class OpenBoxes {
 public:
  // Adds rows of the level, in this order.
  void add(const Level& level, const std::vector<Eigen::Index>& rows) {
    if (rows.empty()) return;
    const std::size_t block = blocks_.size();
    blocks_.push_back({level.lower(rows, Eigen::all), level.upper(rows, Eigen::all)});
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Eigen::Index row = rows[i], at = static_cast<Eigen::Index>(i);
      volume_ += (level.upper.row(row) - level.lower.row(row)).prod();
      if (level.status[static_cast<std::size_t>(row)] == BoxStatus::refuted)
        refuted_.push_back({{block, at}, level.witness.row(row), level.violation(row)});
      else
        others_.push_back({block, at});
    }
  }
  std::int64_t count() const { return refuted() + others(); }
  std::int64_t refuted() const { return std::ssize(refuted_); }
  std::int64_t others() const { return std::ssize(others_); }

  void report(std::int64_t kept, BranchResult& result) {
    const Eigen::Index n = result.open_lower.cols();
    result.open_boxes = count();
    result.open_volume = volume_;
    // Refuted ones first, the worst leading; of too many others an even selection.
    std::stable_sort(refuted_.begin(), refuted_.end(),
                     [](const Refuted& a, const Refuted& b) { return a.violation > b.violation; });
    const std::int64_t all = std::min(kept, count());
    const std::int64_t certain = std::min(all, refuted()), rest = all - certain;
    result.open_lower.resize(all, n);
    result.open_upper.resize(all, n);
    result.witnesses.resize(certain, n);
    for (std::int64_t i = 0; i < all; ++i) {
      const Place place = i < certain ? refuted_[static_cast<std::size_t>(i)].place
                                      : others_[static_cast<std::size_t>((i - certain) * others() / rest)];
      result.open_lower.row(i) = blocks_[place.block].lower.row(place.row);
      result.open_upper.row(i) = blocks_[place.block].upper.row(place.row);
      if (i < certain) result.witnesses.row(i) = refuted_[static_cast<std::size_t>(i)].witness;
    }
    if (certain > 0) result.worst = refuted_.front().violation;
  }

 private:
  struct Block {
    Points lower, upper;  // [k, n] of one level
  };
  struct Place {
    std::size_t block;
    Eigen::Index row;
  };
  struct Refuted {
    Place place;
    Eigen::RowVectorXd witness;
    double violation;
  };
  std::vector<Block> blocks_;
  std::vector<Refuted> refuted_;
  std::vector<Place> others_;
  double volume_ = 0.0;
};

// Examines all boxes of the level; what the time limit leaves out stays undecided. Returns how many were
// examined.
std::int64_t examine(Level& level, std::vector<std::unique_ptr<BoxExaminer>>& examiners,
                     double seconds_left) {
  const Stopwatch watch;
  const Eigen::Index count = level.lower.rows(), size = batch_size(count),
                     batches = (count + size - 1) / size;
  std::atomic<std::int64_t> examined = 0;
  std::atomic<bool> stop = false;
  parallel_for(batches, [&](Eigen::Index b, int worker) {
    if (stop) return;
    const StandardFloatingPoint mode;
    const Eigen::Index first = b * size;
    BoxBatch batch = {level.lower,  level.upper,   first,           std::min(size, count - first),
                      level.status, level.witness, level.violation, level.carried,
                      level.cuts};
    examiners.at(static_cast<std::size_t>(worker))->examine(batch);
    examined += batch.count;
    if (watch.seconds() > seconds_left) stop = true;
  });
  return examined;
}

// Halves the box in these rows, and its halves, `cuts` times; the parts take the rows first, ..., first +
// 2^cuts - 1.
void bisect(Points& lower, Points& upper, Eigen::Index first, std::int32_t cuts) {
  if (cuts == 0) return;
  Eigen::Index axis = 0;
  (upper.row(first) - lower.row(first)).maxCoeff(&axis);
  const double middle = 0.5 * lower(first, axis) + 0.5 * upper(first, axis);
  const Eigen::Index second = first + (Eigen::Index(1) << (cuts - 1));
  lower.row(second) = lower.row(first);
  upper.row(second) = upper.row(first);
  upper(first, axis) = middle;
  lower(second, axis) = middle;
  bisect(lower, upper, first, cuts - 1);
  bisect(lower, upper, second, cuts - 1);
}

// What becomes of the boxes of a level without open ones.
std::vector<std::int8_t> as_recorded(const Level& level) {
  std::vector<std::int8_t> boxes;
  for (std::size_t row = 0; row < level.status.size(); ++row) {
    boxes.push_back(level.status[row] == BoxStatus::undecided  ? static_cast<std::int8_t>(level.cuts[row])
                    : level.status[row] == BoxStatus::excluded ? BisectionTree::excluded
                                                               : BisectionTree::shown);
  }
  return boxes;
}

// How many parts the undecided boxes are to be cut into; a double, which cannot overflow.
double parts_of(const Level& level, const std::vector<Eigen::Index>& rows) {
  double count = 0.0;
  for (Eigen::Index row : rows) count += std::exp2(level.cuts[static_cast<std::size_t>(row)]);
  return count;
}

// Bytes at most while a level of so many parts stands beside this one, should all of it stay open and be refuted.
double bytes_of(const Level& level, double parts, const OpenBoxes& open) {
  // Numbers of 8 bytes; lists grow by doubling, so that three times as much stands there at times.
  const auto n = static_cast<double>(level.lower.cols());
  const double examined = 3.0 * n + 7.0;             // corners, witness, the rest and places in two lists
  const double left_open = 2.0 * n + n + 3.0 * 6.0;  // corners, witness and places
  return sizeof(double) * ((static_cast<double>(level.lower.rows()) + parts) * examined +
                           (static_cast<double>(open.count()) + parts) * left_open);
}

// Cuts these boxes so often, but not more at once than is worth it, and a small level's more often. Returns how many boxes
// they seem to end in.
double limit_cuts(Level& level, const std::vector<Eigen::Index>& rows) {
  const double expected = parts_of(level, rows);
  for (Eigen::Index row : rows) {
    std::int32_t& cuts = level.cuts[static_cast<std::size_t>(row)];
    cuts = std::min(cuts, most_cuts);
  }
  if (rows.empty()) return expected;
  for (double parts = parts_of(level, rows); 2.0 * parts <= kFullLevel; parts *= 2.0) {
    for (Eigen::Index row : rows) ++level.cuts[static_cast<std::size_t>(row)];
  }
  return expected;
}

// The parts of the undecided boxes.
Level next_level(const Level& level, const std::vector<Eigen::Index>& rows) {
  const auto count = static_cast<Eigen::Index>(parts_of(level, rows));
  Points lower(count, level.lower.cols()), upper(count, level.lower.cols());
  Vector carried(count);
  Eigen::Index first = 0;
  for (Eigen::Index row : rows) {
    const std::int32_t cuts = level.cuts[static_cast<std::size_t>(row)];
    lower.row(first) = level.lower.row(row);
    upper.row(first) = level.upper.row(row);
    bisect(lower, upper, first, cuts);
    carried.segment(first, Eigen::Index(1) << cuts).setConstant(level.carried(row));
    first += Eigen::Index(1) << cuts;
  }
  Level next(std::move(lower), std::move(upper));
  next.carried = std::move(carried);
  return next;
}

}  // namespace

BranchResult branch_and_bound(Points lower, Points upper,
                              const std::function<std::unique_ptr<BoxExaminer>()>& examiner,
                              const BranchLimits& limits,
                              const std::function<void(const BranchProgress&)>& progress) {
  check(
      lower.rows() == upper.rows() && lower.cols() == upper.cols() && lower.allFinite() && upper.allFinite(),
      "branch and bound: expected finite boxes with as many lower as upper corners");
  const Stopwatch watch;
  std::vector<std::unique_ptr<BoxExaminer>> examiners;
  for (int t = 0; t < thread_count(); ++t) examiners.push_back(examiner());

  BranchResult result;
  result.open_lower.resize(0, lower.cols());
  result.open_upper.resize(0, lower.cols());
  OpenBoxes open;
  std::int64_t before_refuted = 0;  // boxes examined until the first refuted one
  Level level(std::move(lower), std::move(upper));
  for (std::int64_t depth = 0; level.lower.rows() > 0; ++depth) {
    const double left = limits.max_seconds - watch.seconds();
    const bool stop = depth > limits.max_depth || result.boxes + level.lower.rows() > limits.max_boxes ||
                      open.refuted() >= limits.max_refuted ||
                      result.boxes - before_refuted > limits.max_after_refuted ||
                      open.others() >= limits.max_abandoned || !(left > 0.0);
    result.stopped = result.stopped || stop;
    if (!stop) result.boxes += examine(level, examiners, left);
    std::vector<Eigen::Index> undecided, left_open;
    for (Eigen::Index row = 0; row < level.lower.rows(); ++row) {
      const BoxStatus status = level.status[static_cast<std::size_t>(row)];
      if (status == BoxStatus::undecided && !stop) {
        check(level.cuts[static_cast<std::size_t>(row)] >= 1, "branch and bound: expected at least one cut");
        undecided.push_back(row);
      }
      if (status == BoxStatus::refuted || status == BoxStatus::abandoned ||
          (status == BoxStatus::undecided && stop)) {
        left_open.push_back(row);
      }
    }
    open.add(level, left_open);
    const double tree = limits.keep_tree ? kTreeBytes * static_cast<double>(result.boxes) : 0.0;
    const double expected = static_cast<double>(result.boxes) + limit_cuts(level, undecided);
    const bool hopeless =
        result.boxes >= kLeastToExpect && expected > limits.max_expected && !undecided.empty();
    if (hopeless || bytes_of(level, parts_of(level, undecided), open) + tree > limits.max_bytes) {
      result.stopped = true;
      if (hopeless) result.expected = expected;
      open.add(level, undecided);
      undecided.clear();
    }
    if (open.refuted() == 0) before_refuted = result.boxes;
    if (progress) {
      progress({result.boxes, static_cast<std::int64_t>(undecided.size()), open.refuted(), depth,
                watch.seconds()});
    }
    if (limits.keep_tree) result.tree.add_level(as_recorded(level));
    level = next_level(level, undecided);
  }
  open.report(limits.kept_boxes, result);
  result.proved = result.open_boxes == 0;
  if (!result.proved) result.tree = {};
  result.seconds = watch.seconds();
  return result;
}

}  // namespace s2nnds
