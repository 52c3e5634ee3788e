// SPDX-License-Identifier: BSD-3-Clause
#include "s2nnds/data/cleaning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "s2nnds/core/check.h"
#include "s2nnds/data/local_polynomial.h"
#include "s2nnds/data/quantile.h"

namespace s2nnds {
namespace {

using Samples = std::vector<Eigen::Index>;
constexpr double kUsual = 0.9;  // share of the steps that are no longer than the usual one

double usual_step(const Recording& r) {
  std::vector<double> steps;
  for (Eigen::Index i = 1; i < r.samples(); ++i) steps.push_back(r.time[i] - r.time[i - 1]);
  return quantile(std::move(steps), kUsual);
}

double extent_of(const Recording& r) {
  return (r.position.colwise().maxCoeff() - r.position.colwise().minCoeff()).norm();
}

double duration_of(const Recording& r) { return r.time[r.samples() - 1] - r.time[0]; }

std::string counted(Eigen::Index count, std::string_view one, std::string_view more) {
  return fmt::format("{} {}", count, count == 1 ? one : more);
}

// One recording on its way through the steps.
class Cleaning {
 public:
  Cleaning(const Recording& recording, const CleaningOptions& options, std::string unit)
      : r_(recording), options_(options), unit_(std::move(unit)) {}

  void check_shapes() const {
    check(r_.time.size() == r_.samples() && r_.samples() >= 2,
          "{}: found {} times for {} positions; expected one each, at least 2", r_.where, r_.time.size(),
          r_.samples());
    check(r_.velocity.size() == 0 ||
              (r_.velocity.rows() == r_.samples() && r_.velocity.cols() == r_.position.cols()),
          "{}: found velocities [{}, {}]; expected [{}, {}] as the positions", r_.where, r_.velocity.rows(),
          r_.velocity.cols(), r_.samples(), r_.position.cols());
  }

  void drop_missing() {
    if (!options_.missing) {
      if (!r_.time.allFinite() || !r_.position.allFinite() || !r_.velocity.allFinite() ||
          !r_.orientation.allFinite())
        check_recording(r_);
      return;
    }
    Samples whole;
    for (Eigen::Index i = 0; i < r_.samples(); ++i) {
      if (std::isfinite(r_.time[i]) && r_.position.row(i).allFinite() &&
          (r_.velocity.size() == 0 || r_.velocity.row(i).allFinite()) &&
          (r_.orientation.size() == 0 || r_.orientation.row(i).allFinite()))
        whole.push_back(i);
    }
    const auto gone = r_.samples() - static_cast<Eigen::Index>(whole.size());
    check(static_cast<double>(gone) <= options_.most_missing * static_cast<double>(r_.samples()),
          "{}: found {} of {} samples with missing, NaN or infinite numbers; expected at most {:g} % "
          "(data.cleaning.most_missing)",
          r_.where, gone, r_.samples(), 100 * options_.most_missing);
    keep(whole, [](Eigen::Index dropped) {
      return counted(dropped, "sample with missing, NaN or infinite numbers dropped",
                     "samples with missing, NaN or infinite numbers dropped");
    });
  }

  // Exchanged stamps lie few places from where they belong; a clock that was set back, or a second
  // demonstration, is not for us to guess.
  void order_times() {
    if (!options_.repeated_times) return;
    constexpr Eigen::Index kFarthest = 5;
    Samples order(static_cast<std::size_t>(r_.samples()));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](Eigen::Index a, Eigen::Index b) { return r_.time[a] < r_.time[b]; });
    Samples back;  // samples before the one above them
    bool far = false;
    for (Eigen::Index i = 1; i < r_.samples(); ++i) {
      if (r_.time[i] < r_.time[i - 1]) back.push_back(i);
      far = far || std::abs(order[static_cast<std::size_t>(i)] - i) > kFarthest;
    }
    if (back.empty()) return;
    const auto moved = static_cast<Eigen::Index>(back.size());
    check(!far && (moved <= 1 || 10 * moved <= r_.samples()),
          "{}: found time {:.9g} s after {:.9g} s ({} in all that go back); expected one demonstration with "
          "times in order (more than one in a file: data.columns.index, or blank lines between them)",
          r_.place(back.front()), r_.time[back.front()] + r_.time_offset,
          r_.time[back.front() - 1] + r_.time_offset, moved);
    r_ = r_.at(order);
    say(counted(moved, "time stamp out of order sorted", "time stamps out of order sorted"));
  }

  void merge_repeated() {
    if (!options_.repeated_times) return;
    merge([](double step) { return step <= 0; }, "repeated time stamp merged", "repeated time stamps merged");
  }

  void merge_bursts() {
    if (!(options_.burst > 0)) return;
    const double closest = options_.burst * usual_step(r_);
    merge([&](double step) { return step > 0 && step < closest; }, "time stamp in a burst merged",
          "time stamps in bursts merged");
  }

  void check_times() const { check_recording(r_); }

  void drop_outliers() {
    if (!(options_.outlier > 0) || r_.samples() < 8) return;
    constexpr Eigen::Index kLongest = 3;
    const Vector speed = speeds();
    std::vector<double> moving(speed.data(), speed.data() + speed.size());
    std::erase(moving, 0.0);
    const double overall = quantile(std::move(moving), 0.5);
    Samples kept;
    Eigen::Index i = outliers_at(0, 1, speed, overall);
    kept.push_back(i++);
    while (i < r_.samples()) {
      const Eigen::Index run = outliers_at(i, kLongest, speed, overall);
      i += run;
      if (i < r_.samples()) kept.push_back(i++);
    }
    keep(kept, [](Eigen::Index gone) { return counted(gone, "outlier dropped", "outliers dropped"); });
  }

  void find_gaps() {
    if (!(options_.gap > 0) || r_.samples() < 3) return;
    const double longest = options_.gap * usual_step(r_);
    double in_gaps = 0, path = 0, largest = 0;
    Eigen::Index gaps = 0, place = 0;
    for (Eigen::Index i = 1; i < r_.samples(); ++i) {
      const double step = r_.time[i] - r_.time[i - 1];
      const double moved = (r_.position.row(i) - r_.position.row(i - 1)).norm();
      path += moved;
      if (step <= longest) continue;
      ++gaps;
      in_gaps += moved;
      if (step > largest) place = i;
      largest = std::max(largest, step);
    }
    if (gaps == 0) return;
    const double share = path > 0 ? in_gaps / path : 0;
    check(share <= options_.most_in_gaps,
          "{}: found {} with {:.3g} % of the path in them, the longest of {:.4g} s; expected at most {:g} % "
          "(data.cleaning.most_in_gaps)",
          r_.place(place), counted(gaps, "gap", "gaps"), 100 * share, largest, 100 * options_.most_in_gaps);
    say(fmt::format("{} of up to {:.3g} s, {:.2g} % of the path", counted(gaps, "gap", "gaps"), largest,
                    100 * share));
  }

  void measure_noise() {
    if (options_.window > 0) smooth_ = smooth_derivative(r_.time, r_.position, options_.window);
  }

  // Rest is where a recording has not moved out of what noise explains, less the time in which the motion that
  // follows was under way already: see rest_at().
  void cut_rest() {
    if (!(options_.rest > 0)) return;
    const double extent = extent_of(r_);
    check(extent > 0, "{}: found a recording that does not move; expected a motion", r_.where);
    const double radius =
        std::max(options_.rest * extent, 4 * smooth_.noise * std::sqrt(double(r_.position.cols())));
    const Eigen::Index last = r_.samples() - 1;
    const double least = std::min(0.5, duration_of(r_) / 20);
    const double at_start = rest_at(radius, 1), at_end = rest_at(radius, -1);
    Eigen::Index begin = 0, end = last;
    if (at_start >= least) {
      while (begin < last && r_.time[begin + 1] <= r_.time[0] + at_start) ++begin;
      say(fmt::format("{:.2g} s of rest at the start cut", at_start));
    }
    if (at_end >= least) {
      while (end > 0 && r_.time[end - 1] >= r_.time[last] - at_end) --end;
      say(fmt::format("{:.2g} s of rest at the end cut", at_end));
    }
    check(begin < end && time_beyond(radius, 1) < r_.time[last],
          "{}: found a recording that does not leave its noise of {:.3g} {}; expected a motion", r_.where,
          smooth_.noise, unit_);
    if (begin == 0 && end == last) return;
    Samples kept(static_cast<std::size_t>(end - begin + 1));
    std::iota(kept.begin(), kept.end(), begin);
    r_ = r_.at(kept);
    measure_noise();
  }

  Demonstration finish(std::int64_t stride) {
    check_recording(r_);
    if (smooth_.velocity.size() > 0) {
      const double extent = extent_of(r_);
      say(fmt::format("noise {:.2g} {}{}({:.2g} % of the extent)", smooth_.noise, unit_,
                      unit_.empty() ? "" : " ", extent > 0 ? 100 * smooth_.noise / extent : 0));
      if (r_.velocity.size() == 0) r_.velocity = smooth_.velocity;
    }
    if (options_.resample != "none") resample();
    return make_demonstration(r_, stride);
  }

  std::vector<std::string> steps() const { return steps_; }
  double noise() const {
    return smooth_.velocity.size() > 0 ? smooth_.noise : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  void say(std::string text) { steps_.push_back(std::move(text)); }

  template <typename Words>
  void keep(const Samples& kept, const Words& words) {
    const auto left = static_cast<Eigen::Index>(kept.size());
    check(left >= 2, "{}: found {} sample(s) that can be used; expected at least 2", r_.where, left);
    if (left == r_.samples()) return;
    say(words(r_.samples() - left));
    r_ = r_.at(kept);
    measured_again();
  }
  void measured_again() { smooth_ = {}; }

  // Samples whose time after the first of their group is close go into their mean.
  template <typename Close>
  void merge(const Close& close, std::string_view one, std::string_view more) {
    Samples firsts = {0};
    for (Eigen::Index i = 1; i < r_.samples(); ++i)
      if (!close(r_.time[i] - r_.time[firsts.back()])) firsts.push_back(i);
    const auto groups = static_cast<Eigen::Index>(firsts.size());
    const Eigen::Index gone = r_.samples() - groups;
    if (gone == 0) return;
    Recording merged = r_.at(firsts);
    for (Eigen::Index g = 0; g < groups; ++g) {
      const Eigen::Index first = firsts[static_cast<std::size_t>(g)];
      const Eigen::Index end = g + 1 < groups ? firsts[static_cast<std::size_t>(g) + 1] : r_.samples();
      merged.time[g] += (r_.time.segment(first, end - first).array() - r_.time[first]).mean();
      merged.position.row(g) = r_.position.middleRows(first, end - first).colwise().mean();
      if (r_.velocity.size() > 0)
        merged.velocity.row(g) = r_.velocity.middleRows(first, end - first).colwise().mean();
      if (r_.orientation.size() > 0)  // neighbours, and without jumps of sign: their mean is not 0
        merged.orientation.row(g) =
            r_.orientation.middleRows(first, end - first).colwise().mean().normalized();
    }
    r_ = std::move(merged);
    say(counted(gone, one, more));
  }

  Vector speeds() const {
    Vector speed(r_.samples() - 1);
    for (Eigen::Index i = 0; i < speed.size(); ++i)
      speed[i] = (r_.position.row(i + 1) - r_.position.row(i)).norm() / (r_.time[i + 1] - r_.time[i]);
    return speed;
  }

  // How many samples from i on are outliers, 0 to `longest`: a step there and a step back, both far faster
  // than usual, that leave the motion where it would be without them.
  // Of the first and the last sample, the one step is enough.
  Eigen::Index outliers_at(Eigen::Index i, Eigen::Index longest, const Vector& speed, double overall) const {
    constexpr Eigen::Index kAround = 12;
    const Eigen::Index low = std::max<Eigen::Index>(0, i - kAround);
    const Eigen::Index high = std::min<Eigen::Index>(speed.size(), i + kAround);
    const bool may_be = speed[std::max<Eigen::Index>(0, i - 1)] > options_.outlier * overall;
    if (!may_be) return 0;
    const double around = quantile({speed.data() + low, speed.data() + high}, 0.5);
    const double fast = options_.outlier * std::max(around, overall);
    if (i == 0) return speed[0] > fast ? 1 : 0;
    if (!(speed[i - 1] > fast)) return 0;
    if (i == speed.size()) return 1;
    for (Eigen::Index run = 1; run <= longest && i + run < r_.samples(); ++run) {
      const Eigen::Index next = i + run;
      const double across =
          (r_.position.row(next) - r_.position.row(i - 1)).norm() / (r_.time[next] - r_.time[i - 1]);
      if (speed[next - 1] > fast && across <= 0.5 * fast) return run;
    }
    return 0;
  }

  // The time at which the recording first leaves the ball of `radius` around its end's position, the mean of half a
  // window of options; `step`, 1 or -1, leads into it from that end.
  double time_beyond(double radius, Eigen::Index step) const {
    const Eigen::Index outer = step > 0 ? 0 : r_.samples() - 1, inner = r_.samples() - 1 - outer;
    Eigen::RowVectorXd rest = r_.position.row(outer);
    double count = 1;
    for (Eigen::Index i = outer + step;
         i != inner && std::abs(r_.time[i] - r_.time[outer]) <= 0.5 * options_.window; i += step) {
      rest += r_.position.row(i);
      ++count;
    }
    rest /= count;
    double before = 0;
    for (Eigen::Index i = outer;; i += step) {
      const double distance = (r_.position.row(i) - rest).norm();
      if (distance > radius) {
        if (i == outer) return r_.time[outer];
        const double share = std::clamp((radius - before) / (distance - before), 0.0, 1.0);
        return r_.time[i - step] + share * (r_.time[i] - r_.time[i - step]);
      }
      if (i == inner) return r_.time[inner];
      before = distance;
    }
  }

  // Seconds of rest at that end. A motion that leaves rest with a finite jerk goes as t^3 (as t^2 with a jump of the
  // force, as t with one of the speed): it needs at least as long to go from `radius` to eight times as far as it
  // took to go `radius`. What is before is rest.
  double rest_at(double radius, Eigen::Index step) const {
    const double start = r_.time[step > 0 ? 0 : r_.samples() - 1];
    const double gone = time_beyond(radius, step), farther = time_beyond(8 * radius, step);
    return std::abs(gone - start) - std::abs(farther - gone);
  }

  // Positions and velocities between samples: the cubic that has both at both ends.
  void resample() {
    const auto count = static_cast<Eigen::Index>(options_.samples);
    const Eigen::Index last = r_.samples() - 1;
    if (r_.velocity.size() == 0) r_.velocity = make_demonstration(r_, 1).velocity;
    Vector along = r_.time;  // what the new samples are evenly spread over
    if (options_.resample == "arc_length") {
      along[0] = 0;
      for (Eigen::Index i = 1; i <= last; ++i)
        along[i] = along[i - 1] + (r_.position.row(i) - r_.position.row(i - 1)).norm();
      check(along[last] > 0, "{}: found a recording that does not move; expected a motion", r_.where);
    }
    Recording even{r_.where,
                   r_.time_column,
                   r_.time_offset,
                   Vector(count),
                   Points(count, r_.position.cols()),
                   Points(count, r_.position.cols()),
                   {},
                   Points(r_.orientation.size() > 0 ? count : 0, r_.orientation.cols())};
    Eigen::Index piece = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      const double place =
          along[0] + (along[last] - along[0]) * static_cast<double>(k) / static_cast<double>(count - 1);
      while (piece + 1 < last && along[piece + 1] <= place) ++piece;
      const double width = along[piece + 1] - along[piece];
      const double u = width > 0 ? std::clamp((place - along[piece]) / width, 0.0, 1.0) : 0.0;
      interpolate(piece, u, even, k);
    }
    say(fmt::format("resampled to {} by {}", count, options_.resample == "time" ? "time" : "arc length"));
    r_ = std::move(even);
  }

  void interpolate(Eigen::Index i, double u, Recording& even, Eigen::Index k) const {
    const double h = r_.time[i + 1] - r_.time[i];
    const auto p = r_.position.row(i), q = r_.position.row(i + 1);
    const auto v = r_.velocity.row(i), w = r_.velocity.row(i + 1);
    const double a = u * u * (3 - 2 * u), b = u * (1 - u) * (1 - u), c = u * u * (u - 1);
    even.time[k] = r_.time[i] + u * h;
    even.position.row(k) = (1 - a) * p + a * q + h * (b * v + c * w);
    even.velocity.row(k) = (1 - u) * v + u * w;
    if (r_.orientation.size() > 0) {
      even.orientation.row(k) =
          ((1 - u) * r_.orientation.row(i) + u * r_.orientation.row(i + 1)).normalized();
    }
  }

  Recording r_;
  const CleaningOptions& options_;
  std::string unit_;
  SmoothDerivative smooth_;
  std::vector<std::string> steps_;
};

}  // namespace

void CleaningOptions::visit(FieldVisitor& v) {
  v.field("steps", steps, {"auto", "on", "off"});
  v.field("missing", missing);
  v.field("most_missing", most_missing, between(0, 1));
  v.field("repeated_times", repeated_times);
  v.field("burst", burst, {.low = 0, .high = 1, .open_high = true});
  v.field("outlier", outlier, at_least(0));
  v.field("gap", gap, at_least(0));
  v.field("most_in_gaps", most_in_gaps, between(0, 1));
  v.field("rest", rest, {.low = 0, .high = 1, .open_high = true});
  v.field("window", window, at_least(0));
  v.field("resample", resample, {"none", "time", "arc_length"});
  v.field("samples", samples, at_least(2));
}

CleanDemonstration clean(const Recording& recording, const CleaningOptions& options, std::int64_t stride,
                         const std::string& unit) {
  Cleaning cleaning(recording, options, unit);
  cleaning.check_shapes();
  cleaning.drop_missing();
  cleaning.order_times();
  cleaning.merge_repeated();
  cleaning.merge_bursts();
  cleaning.check_times();
  cleaning.drop_outliers();
  cleaning.find_gaps();
  cleaning.measure_noise();
  cleaning.cut_rest();
  CleanDemonstration result;
  result.demonstration = cleaning.finish(stride);
  result.steps = cleaning.steps();
  result.noise = cleaning.noise();
  return result;
}

}  // namespace s2nnds
