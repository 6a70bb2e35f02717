#include "raven2_trainer/training/motion_metrics.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/training/enclosing_sphere.h"
#include "raven2_trainer/training/smoothness.h"
#include "raven2_trainer/training/tremor.h"

namespace raven2_trainer::training {

namespace {

void addTo(Vec3* sum, const Vec3& v) {
  for (std::size_t i = 0; i < 3; ++i)
    (*sum)[i] += v[i] / static_cast<double>(kSampleTicks);
}

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double meanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values)
    sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/** Pearson's; nothing where either does not vary. */
std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double mean_a = meanOf(a), mean_b = meanOf(b);
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    aa += (a[k] - mean_a) * (a[k] - mean_a);
    bb += (b[k] - mean_b) * (b[k] - mean_b);
    ab += (a[k] - mean_a) * (b[k] - mean_b);
  }
  if (!(aa > 0.0 && bb > 0.0)) return std::nullopt;
  return ab / std::sqrt(aa * bb);
}

std::size_t countAbove(const std::vector<double>& values, double limit) {
  return static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [&](double v) { return v > limit; }));
}

/** Mean square distance from the mean. */
double scatter(const std::vector<Vec3>& places) {
  Vec3 mean{};
  for (const Vec3& place : places) {
    for (std::size_t i = 0; i < 3; ++i)
      mean[i] += place[i] / static_cast<double>(places.size());
  }
  double sum = 0.0;
  for (const Vec3& place : places)
    sum += std::pow(distance(place, mean), 2);
  return sum / static_cast<double>(places.size());
}

std::vector<double> joined(const std::vector<std::vector<double>>& pieces) {
  std::vector<double> all;
  for (const std::vector<double>& piece : pieces)
    all.insert(all.end(), piece.begin(), piece.end());
  return all;
}

/** Adds those of one piece: a stroke ends at a cut. */
void findStrokes(const std::vector<double>& speed, HandMotion* hand, std::vector<double>* arc_lengths) {
  const auto is_fast = [](double v) { return v > kStrokeSpeed; };
  for (auto begin = speed.begin(); begin != speed.end();) {
    begin = std::find_if(begin, speed.end(), is_fast);
    const auto end = std::find_if_not(begin, speed.end(), is_fast);
    if (static_cast<std::size_t>(end - begin) >= kStrokeLeast) {
      ++hand->strokes;
      const std::optional<double> arc = spectralArcLength({begin, end}, kSampleRate);
      if (arc) arc_lengths->push_back(*arc);
    }
    begin = end;
  }
}

void describeStrokes(const std::vector<std::vector<double>>& speeds, HandMotion* hand) {
  std::vector<double> arc_lengths;
  for (const std::vector<double>& speed : speeds)
    findStrokes(speed, hand, &arc_lengths);
  hand->stroke_sparc = median(arc_lengths);
}

}  // namespace

std::optional<double> overHands(const MotionMetrics& metrics, std::optional<double> HandMotion::*figure) noexcept {
  double sum = 0.0, weight = 0.0;
  for (const HandMotion& hand : metrics.hands) {
    if (!(hand.*figure)) continue;
    sum += *(hand.*figure) * hand.path;
    weight += hand.path;
  }
  if (!(weight > 0.0)) return std::nullopt;
  return sum / weight;
}

MotionAccumulator::MotionAccumulator(const MotionSettings& settings)
    : settings_(settings), contacts_(settings.bodies, settings.force_limit), haptic_(settings.force_limit) {}

bool MotionAccumulator::has(Tick tick) const noexcept {
  return first_ >= 0 && tick >= first_ && tick <= last_ && counted_[static_cast<std::size_t>(tick - first_)];
}

void MotionAccumulator::add(const TickRecord& record) {
  const Tick tick = record.model.tick;
  const bool follows = first_ >= 0 && tick == last_ + 1;
  if (first_ < 0) first_ = tick;
  last_ = tick;
  counted_.resize(static_cast<std::size_t>(tick - first_) + 1, false);
  counted_.back() = true;
  ++metrics_.ticks;
  const bool is_press = record.model.pedal != 0 && is_up_;
  is_up_ = record.model.pedal == 0;
  sample(record.model, follows && !is_press);
  followPedals(record.model);
  followView(record.model);
  followRobot(record);
}

Vec3 MotionAccumulator::tipInWorld(const ModelState& model, Arm arm) const {
  return toArray(at(settings_.X_WB, arm) * toEigen(at(model.arms, arm).p_BT));
}

/** With the pedal up the tools do not move: the model's return to its robot is no motion of the hand. */
void MotionAccumulator::followTips(const ModelState& model) {
  if (model.pedal == 0 && metrics_.ticks > 1) return;
  for (const Arm arm : kArms)
    at(tip_W_, arm) = tipInWorld(model, arm);
}

/** A gap in time begins a new sample, as a press does; what was gathered before it is too short for one. */
void MotionAccumulator::sample(const ModelState& model, bool follows) {
  followTips(model);
  if (!follows) in_sum_ = 0;
  if (in_sum_ == 0) {
    sum_ = {};
    sum_.follows = follows && !samples_.empty();
  }
  for (const Arm arm : kArms) {
    addTo(&at(sum_.tip_W, arm), at(tip_W_, arm));
    addTo(&at(sum_.master_I, arm), at(model.master_I, arm));
  }
  sum_.engaged = sum_.engaged && model.pedal == kSurgeonsPedal;
  if (++in_sum_ < kSampleTicks) return;
  samples_.push_back(sum_);
  in_sum_ = 0;
}

void MotionAccumulator::followPedals(const ModelState& model) {
  const bool is_down = model.pedal != 0;
  if (is_down && was_down_ && ups_ > 0) {
    ++metrics_.clutches;
    metrics_.clutch_time += toSeconds(ups_);
  }
  if (is_down) ups_ = 0;
  if (!is_down && was_down_) ++ups_;
  was_down_ = was_down_ || is_down;
  engaged_ticks_ += is_down ? 1 : 0;
  const bool is_camera = (model.pedals & bit(Pedal::kCamera)) != 0 || model.mode == Mode::kCameraMoving;
  if (is_camera && !camera_held_) ++metrics_.camera_moves;
  camera_ticks_ += is_camera ? 1 : 0;
  camera_held_ = is_camera;
}

bool MotionAccumulator::isVisible(const model::Camera& camera, const Vec3& tip_W) const {
  double u = 0.0, v = 0.0;
  if (!camera.project(toEigen(tip_W), &u, &v)) return false;
  // Pixel centres have integer coordinates: the picture's edge is half a pixel outside the first and last.
  return u >= -0.5 && u <= settings_.image_width - 0.5 && v >= -0.5 && v <= settings_.image_height - 0.5;
}

void MotionAccumulator::followView(const ModelState& model) {
  if (!settings_.camera) return;
  CameraConfig config = *settings_.camera;
  const bool is_known = distance(model.camera.eye_W, model.camera.target_W) > 0.0;
  if (is_known) {
    config.eye_W = model.camera.eye_W;
    config.target_W = model.camera.target_W;
    config.up_W = model.camera.up_W;
  }
  const model::Camera camera = model::makeCamera(config, settings_.image_width, settings_.image_height);
  bool hidden = false;
  for (const Arm arm : kArms) {
    const bool is_hidden = !isVisible(camera, tipInWorld(model, arm));
    at(tip_hidden_ticks_, arm) += is_hidden ? 1 : 0;
    hidden = hidden || is_hidden;
  }
  hidden_ticks_ += hidden ? 1 : 0;
}

void MotionAccumulator::followRobot(const TickRecord& record) {
  const bool comparable = record.model.linked != 0 && record.model.robot_fresh != 0 && record.robot.frame > 0;
  if (!comparable) return;
  double error = 0.0;
  for (const Arm arm : kArms)
    error = std::max(error, distance(at(record.model.arms, arm).p_BT, at(record.robot.arms, arm).p_BT));
  metrics_.tracking.add(error);
}

void MotionAccumulator::add(const HapticRecord& record) {
  if (!has(record.haptic.tick)) return;
  double newton = 0.0;
  for (const Vec3& force : record.haptic.force_I)
    newton = std::max(newton, distance(force, Vec3{}));
  haptic_.add(newton);
}

void MotionAccumulator::add(const ContactRecord& record) {
  if (has(record.tick)) contacts_.add(record);
}

/** By pieces without a gap in time. */
std::vector<std::vector<double>> MotionAccumulator::speeds(Arm arm) const {
  std::vector<std::vector<double>> all;
  for (const std::vector<Vec3>& piece : pieces(&Sample::tip_W, arm, false)) {
    all.emplace_back();
    for (std::size_t k = 1; k < piece.size(); ++k)
      all.back().push_back(distance(piece[k], piece[k - 1]) * kSampleRate);
  }
  return all;
}

/** Samples without a gap between them; @param[in] engaged only those with the surgeon's pedal down. */
std::vector<std::vector<Vec3>> MotionAccumulator::pieces(const PerArm<Vec3> Sample::*place,
                                                         Arm arm,
                                                         bool engaged) const {
  std::vector<std::vector<Vec3>> all;
  bool open = false;
  for (const Sample& s : samples_) {
    const bool counts = !engaged || s.engaged;
    if (counts && (!open || !s.follows)) all.emplace_back();
    if (counts) all.back().push_back(at(s.*place, arm));
    open = counts;
  }
  return all;
}

void MotionAccumulator::describeMaster(Arm arm, HandMotion* hand) const {
  if (!settings_.motion_scale) return;
  double radius = 0.0, square = 0.0;
  std::size_t count = 0;
  for (const std::vector<Vec3>& piece : pieces(&Sample::master_I, arm, true)) {
    radius = std::max(radius, enclosingSphere(piece).radius);
    square += scatter(piece) * static_cast<double>(piece.size());
    count += piece.size();
  }
  if (count == 0) return;
  hand->master_radius = radius / *settings_.motion_scale;
  hand->master_deviation = std::sqrt(square / static_cast<double>(count)) / *settings_.motion_scale;
}

void MotionAccumulator::describeTremor(Arm arm, HandMotion* hand) const {
  std::vector<double> powers;
  for (const std::vector<Vec3>& piece : pieces(&Sample::tip_W, arm, true)) {
    const std::vector<double> own = tremorPowers(piece, kSampleRate);
    powers.insert(powers.end(), own.begin(), own.end());
  }
  if (powers.empty()) return;
  std::nth_element(powers.begin(), powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 2), powers.end());
  hand->tremor = std::sqrt(powers[powers.size() / 2]);
}

HandMotion MotionAccumulator::handMotion(Arm arm) const {
  HandMotion hand;
  const std::vector<std::vector<double>> by_piece = speeds(arm);
  const std::vector<double> speed = joined(by_piece);
  for (const double v : speed) {
    hand.path += v / kSampleRate;
    hand.max_speed = std::max(hand.max_speed, v);
  }
  hand.mean_speed = meanOf(speed);
  hand.active_time = static_cast<double>(countAbove(speed, kActiveSpeed)) / kSampleRate;
  hand.sparc = spectralArcLength(speed, kSampleRate);
  hand.dlj = dimensionlessJerk(by_piece, kSampleRate);
  hand.ldlj = logDimensionlessJerk(by_piece, kSampleRate);
  double square = 0.0;
  std::size_t count = 0;
  for (const std::vector<Vec3>& piece : pieces(&Sample::tip_W, arm, false)) {
    const std::optional<double> jerk = meanJerk(piece, kSampleRate);
    if (!jerk) continue;
    square += *jerk * *jerk * static_cast<double>(piece.size() - 3);
    count += piece.size() - 3;
  }
  if (count > 0) hand.mean_jerk = std::sqrt(square / static_cast<double>(count));
  describeStrokes(by_piece, &hand);
  describeMaster(arm, &hand);
  describeTremor(arm, &hand);
  if (settings_.camera) hand.out_of_view = toSeconds(at(tip_hidden_ticks_, arm));
  return hand;
}

void MotionAccumulator::describeBoth(MotionMetrics* metrics) const {
  const std::vector<double> gold = joined(speeds(Arm::kGold)), green = joined(speeds(Arm::kGreen));
  std::size_t idle = 0;
  for (std::size_t k = 0; k < gold.size(); ++k)
    idle += std::max(gold[k], green[k]) < kActiveSpeed ? 1 : 0;
  if (!gold.empty()) metrics->idle = static_cast<double>(idle) / static_cast<double>(gold.size());
  const auto [shorter, longer] = std::minmax(metrics->hands[0].active_time, metrics->hands[1].active_time);
  if (longer > 0.0) metrics->bimanual = shorter / longer;
  metrics->speed_correlation = correlation(gold, green);
}

MotionMetrics MotionAccumulator::result() const {
  MotionMetrics metrics = metrics_;
  metrics.duration = duration();
  for (const Arm arm : kArms)
    at(metrics.hands, arm) = handMotion(arm);
  describeBoth(&metrics);
  if (metrics.ticks > 0) metrics.engaged = static_cast<double>(engaged_ticks_) / static_cast<double>(metrics.ticks);
  metrics.camera_time = toSeconds(camera_ticks_);
  if (settings_.camera) metrics.out_of_view = toSeconds(hidden_ticks_);
  metrics.touches = contacts_.touches();
  metrics.contact_force = contacts_.force();
  metrics.haptic_force = haptic_.summary();
  return metrics;
}

}  // namespace raven2_trainer::training
