#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "gtest/gtest.h"
#include "motion_support.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/training/metric_names.h"
#include "raven2_trainer/training/session_score.h"
#include "support/scratch_path.h"

// Every metric of doc/scores.md against a value that is derived here, on a session made for it. Either arm leads: an
// index that is always gold, or that is used twice, gives another number in one of the two.

namespace raven2_trainer::training {
namespace {

using raven2_trainer::testing::scratchPath;

// ---- names, units and directions

struct Expected {
  const char *name, *unit;
  MetricGroup group;
  Better better;
  double value;
};

constexpr auto kEfficiency = MetricGroup::kEfficiency;
constexpr auto kSafety = MetricGroup::kSafety;
constexpr auto kControl = MetricGroup::kControl;
constexpr auto kLess = Better::kLower;
constexpr auto kMore = Better::kHigher;

/** doc/scores.md, with the values of makeMotion(), makeEconomy() and makeOutcome(). Hands weigh 0.03 to 0.01. */
const std::vector<Expected> kTable{
    {"time", "s", kEfficiency, kLess, 51.0},
    {"path", "mm", kEfficiency, kLess, 40.0},
    {"economy", "-", kEfficiency, kMore, 0.53},
    {"off_path", "mm", kEfficiency, kLess, 2.0},
    {"off_path_p95", "mm", kEfficiency, kLess, 7.0},
    {"idle", "-", kEfficiency, kLess, 0.59},
    {"mean_jerk", "m/s^3", kEfficiency, kLess, 0.75 * 1.1 + 0.25 * 2.1},
    {"sparc", "-", kEfficiency, kMore, 0.75 * -1.3 + 0.25 * -2.3},
    {"stroke_sparc", "-", kEfficiency, kMore, 0.75 * -1.7 + 0.25 * -2.7},
    {"ldlj", "-", kEfficiency, kMore, 0.75 * -1.9 + 0.25 * -2.9},
    {"tremor", "um", kEfficiency, kLess, 0.75 * 31.0 + 0.25 * 37.0},
    {"collisions", "count", kSafety, kLess, 2.0},
    {"collision_time", "s", kSafety, kLess, 0.001 + 0.004 + 0.008 + 0.016 + 0.032},
    {"wire_touches", "count", kSafety, kLess, 1.0},
    {"wire_time", "s", kSafety, kLess, 0.002 + 0.128},
    {"drops", "count", kSafety, kLess, 3.0},
    {"break_offs", "count", kSafety, kLess, 4.0},
    {"out_of_order", "count", kSafety, kLess, 5.0},
    {"wrong_arm", "count", kSafety, kLess, 6.0},
    {"peak_force", "N", kSafety, kLess, 6.1},
    {"force_p95", "N", kSafety, kLess, 6.7},
    {"force_impulse", "Ns", kSafety, kLess, 7.1},
    {"force_above", "s", kSafety, kLess, 0.073},
    {"out_of_view", "s", kSafety, kLess, 7.9},
    {"clutches", "count", kControl, kLess, 8.0},
    {"clutch_time", "s", kControl, kLess, 8.3},
    {"engaged", "-", kControl, kMore, 0.89},
    {"camera_moves", "count", kControl, kLess, 9.0},
    {"camera_time", "s", kControl, kLess, 9.7},
    {"master_radius", "mm", kControl, kLess, 107.0},
    {"master_deviation", "mm", kControl, kLess, 109.0},
    {"bimanual", "-", kControl, kMore, 0.113},
    {"speed_correlation", "-", kControl, kMore, -0.127},
    {"tracking", "mm", kControl, kLess, 1.5},
};

HandMotion makeLead() {
  HandMotion hand;
  hand.path = 0.03;
  hand.mean_jerk = 1.1;
  hand.sparc = -1.3;
  hand.stroke_sparc = -1.7;
  hand.ldlj = -1.9;
  hand.tremor = 31e-6;
  hand.master_radius = 0.107;
  hand.master_deviation = 0.103;
  hand.out_of_view = 1e3;
  return hand;
}

HandMotion makeOther() {
  HandMotion hand;
  hand.path = 0.01;
  hand.mean_jerk = 2.1;
  hand.sparc = -2.3;
  hand.stroke_sparc = -2.7;
  hand.ldlj = -2.9;
  hand.tremor = 37e-6;
  hand.master_radius = 0.101;
  hand.master_deviation = 0.109;
  hand.out_of_view = 1e3;
  return hand;
}

MotionMetrics makeMotion(Arm lead) {
  MotionMetrics motion;
  at(motion.hands, lead) = makeLead();
  at(motion.hands, otherArm(lead)) = makeOther();
  motion.ticks = 51000;
  motion.duration = 51.0;
  motion.idle = 0.59;
  for (std::size_t i = 0; i < kPartnerCount; ++i)
    motion.touches[i] = {1000 + i, Tick{1} << i};  // a bit for each kind; touching an object is no mistake
  motion.contact_force = {6.1, 6.7, 7.1, 73, 1000};
  motion.haptic_force = {1e3, 1e3, 1e3, 1000, 1000};
  motion.out_of_view = 7.9;
  motion.clutches = 8;
  motion.clutch_time = 8.3;
  motion.engaged = 0.89;
  motion.camera_moves = 9;
  motion.camera_time = 9.7;
  motion.bimanual = 0.113;
  motion.speed_correlation = -0.127;
  for (const double error : {0.001, 0.002})
    motion.tracking.add(error);
  return motion;
}

Economy makeEconomy() {
  Economy economy;
  economy.ratio = 0.53;
  economy.off_path = 0.002;
  economy.off_path_p95 = 0.007;
  return economy;
}

AttemptOutcome makeOutcome() {
  AttemptOutcome outcome;
  outcome.status = ExerciseStatus::kDone;
  for (std::size_t i = 0; i < kMistakeCount; ++i)
    outcome.mistakes[i] = static_cast<std::uint32_t>(i) + 1;
  return outcome;
}

class EitherArm : public ::testing::TestWithParam<Arm> {
 protected:
  Arm lead() const { return GetParam(); }
  Arm other() const { return otherArm(GetParam()); }
};

using MetricTable = EitherArm;
using MetricReference = EitherArm;
INSTANTIATE_TEST_SUITE_P(Leads, MetricTable, ::testing::ValuesIn(kArms), [](const auto& p) { return name(p.param); });
INSTANTIATE_TEST_SUITE_P(Leads, MetricReference, ::testing::ValuesIn(kArms), [](const auto& p) {
  return name(p.param);
});

TEST_P(MetricTable, HasNameUnitGroupDirectionAndValueOfEachMetric) {
  const std::vector<Metric> metrics = listMetrics(makeMotion(lead()), makeOutcome(), makeEconomy());
  ASSERT_EQ(metrics.size(), kTable.size());
  ASSERT_EQ(metrics.size(), kMetrics.size());
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    const Metric& metric = metrics[i];
    EXPECT_EQ(metric.name, kTable[i].name);
    EXPECT_EQ(metric.unit, kTable[i].unit) << metric.name;
    EXPECT_EQ(metric.group, kTable[i].group) << metric.name;
    EXPECT_EQ(metric.better, kTable[i].better) << metric.name;
    ASSERT_TRUE(metric.value) << metric.name;
    EXPECT_NEAR(*metric.value, kTable[i].value, 1e-9) << metric.name;
  }
}

/** Without an exercise, the judge counts no mistakes: contacts count as touches, and other metrics have no value. */
TEST(MetricTable, WithoutAnExerciseTouchesAreThoseOfAllContacts) {
  AttemptOutcome free = makeOutcome();
  free.status = ExerciseStatus::kNone;
  std::map<std::string, std::optional<double>> values;
  for (const Metric& metric : listMetrics(makeMotion(Arm::kGold), free, makeEconomy()))
    values[metric.name] = metric.value;
  EXPECT_EQ(values["collisions"], 1000.0 + 1002.0 + 1003.0 + 1004.0 + 1005.0);  // tower, dome, plate, other, arm
  EXPECT_EQ(values["wire_touches"], 1001.0 + 1007.0);                           // wire, object_wire
  for (const char* name : {"drops", "break_offs", "out_of_order", "wrong_arm"})
    EXPECT_FALSE(values[name]) << name;
}

// ---- a session of six seconds

constexpr Tick kTicks = 6000;
constexpr double kSeconds = 6.0;
constexpr double kScale = 0.1;
constexpr double kHeight = 1.0;  // [m] of the camera above the tips

/** A minimum-jerk stroke. */
struct Stroke {
  Vec3 from;
  Vec3 along;  ///< unit vector
  double length, begin, duration;

  Vec3 at(double t) const {
    Vec3 place = from;
    for (std::size_t i = 0; i < 3; ++i)
      place[i] += along[i] * length * minimumJerk(t - begin, duration);
    return place;
  }
  /** [m/s] Derivative of 10 s^3 - 15 s^4 + 6 s^5. */
  double speed(double t) const {
    const double s = (t - begin) / duration;
    return s <= 0.0 || s >= 1.0 ? 0.0 : length / duration * 30.0 * s * s * (1.0 - s) * (1.0 - s);
  }
  /** [s] faster than v: 30 D/T s^2 (1-s)^2 > v between both roots of s (1-s) = sqrt(v T / 30 D). */
  double timeAbove(double v) const {
    return duration * std::sqrt(1.0 - 4.0 * std::sqrt(v * duration / (30.0 * length)));
  }
  /** [m^2/s^6] Integral of the squared jerk over time, by time: 720 D^2 / T^5. */
  double squaredJerk() const { return 720.0 * length * length / std::pow(duration, 5); }
  /** [m^2/s] Integral of the squared speed: 900 D^2 / T B(5, 5), B(5, 5) = 1 / 630. */
  double squaredSpeed() const { return 900.0 / 630.0 * length * length / duration; }
};

// The leading tip leaves the picture at x = 0.1 m in the middle of its stroke, the other one at y = -0.2 m.
const Stroke kLead{{0.07, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.060, 1.0, 2.0};
const Stroke kOther{{0.0, -0.19, 0.0}, {0.0, -1.0, 0.0}, 0.020, 4.0, 1.0};

/** Each arm's base is elsewhere, and turned. */
PerArm<Pose> bases(Arm lead) {
  PerArm<Pose> X_WB;
  at(X_WB, lead).R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  at(X_WB, lead).p = {0.3, -0.2, 0.1};
  at(X_WB, otherArm(lead)).R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  at(X_WB, otherArm(lead)).p = {-0.4, 0.5, 0.2};
  return X_WB;
}

Vec3 inBase(const Pose& X_WB, const Vec3& p_W) {
  return toArray(Vector3(X_WB.R.transpose() * (toEigen(p_W) - X_WB.p)));
}

constexpr std::uint16_t kLeadTool = 0, kOtherTool = 1, kTower = 2, kDome = 3, kWire = 4, kRing = 5;

session::LogHeader makeHeader(Arm lead) {
  session::LogHeader header;
  header.tolerance = 0.003;
  header.exercise = "peg_transfer";
  header.body_names = {"grasper1_L", "grasper1_R", "tower_a", "dome_wall", "wire_left", "ring"};
  if (lead == Arm::kGreen) std::swap(header.body_names[0], header.body_names[1]);
  return header;
}

ScoreSettings makeSettings(Arm lead) {
  ScoreSettings settings;
  settings.motion.X_WB = bases(lead);
  settings.motion.bodies = classifyBodies(makeHeader(lead).body_names, {});
  settings.motion.motion_scale = kScale;
  CameraConfig camera;  // from above; x is up in the picture, of which it sees 0.1 m to both sides
  camera.eye_W = {0.0, 0.0, kHeight};
  camera.up_W = {1.0, 0.0, 0.0};
  camera.vertical_fov = 2.0 * std::atan(0.1 / kHeight);
  settings.motion.camera = camera;
  settings.motion.image_width = 640;
  settings.motion.image_height = 320;
  settings.hand.hand_mass = 0.3;
  settings.hand.hand_stiffness = 300.0;
  settings.hand.hand_damping = 17.0;
  // Three fifths of the distance, then no farther.
  settings.plan = [](const Transit& transit) {
    const Vec3 &a = transit.way_W.front(), &b = transit.way_W.back();
    return std::vector<Vec3>{a, {a[0] + 0.6 * (b[0] - a[0]), a[1], a[2]}};
  };
  return settings;
}

bool isWithin(Tick k, Tick begin, Tick end) {
  return k >= begin && k < end;
}

void setPedals(Tick k, ModelState* model) {
  model->pedal = isWithin(k, 3200, 3400) || isWithin(k, 5200, 5300) ? 0 : 1;
  if (isWithin(k, 200, 400)) model->pedals = bit(Pedal::kCamera);
  if (isWithin(k, 3600, 3700)) model->mode = Mode::kCameraMoving;
}

/** The leading hand goes 80 mm in the second engagement, the other one 20 mm: 8 and 2 mm of the tips. */
void setMasters(Tick k, Arm lead, ModelState* model) {
  const double share = std::clamp((static_cast<double>(k) - 3400.0) / 1800.0, 0.0, 1.0);
  at(model->master_I, lead) = {0.3, 0.008 * share, 0.0};
  at(model->master_I, otherArm(lead)) = {0.0, 0.1, -0.002 * share};
}

/** The larger error is 2 mm (other arm) for 3 s, then 3 mm (leading arm); while it is unknown, it is 1 m. */
void setRobot(Tick k, Arm lead, TickRecord* record) {
  const bool is_first = k < 3000;
  const double of_lead = is_first ? 0.001 : 0.003, of_other = is_first ? 0.002 : 0.0005;
  record->model.robot_fresh = isWithin(k, 500, 600) ? 0 : 1;
  record->robot.frame = isWithin(k, 700, 800) ? 0 : 1;
  record->model.linked = isWithin(k, 900, 1000) ? 0 : 1;
  const bool is_known = !isWithin(k, 500, 600) && !isWithin(k, 700, 800) && !isWithin(k, 900, 1000);
  record->robot.arms = {};
  for (const Arm arm : kArms) {
    Vec3 tip = at(record->model.arms, arm).p_BT;
    tip[2] += is_known ? (arm == lead ? of_lead : of_other) : 1.0;
    at(record->robot.arms, arm).p_BT = tip;
  }
}

TickRecord makeTick(Tick k, Arm lead) {
  const double t = kTickSeconds * static_cast<double>(k);
  const PerArm<Pose> X_WB = bases(lead);
  TickRecord record = makeRecord(k);
  at(record.model.arms, lead).p_BT = inBase(at(X_WB, lead), kLead.at(t));
  at(record.model.arms, otherArm(lead)).p_BT = inBase(at(X_WB, otherArm(lead)), kOther.at(t));
  record.model.exercise.attempt = 1;
  record.model.exercise.status = ExerciseStatus::kRunning;
  record.model.exercise.step = 1;
  record.model.exercise.mistakes = {3, 2, 1, 4, 5, 6};
  setPedals(k, &record.model);
  setMasters(k, lead, &record.model);
  setRobot(k, lead, &record);
  return record;
}

ContactRecord makeContact(Tick k, std::uint16_t a, std::uint16_t b, double newton) {
  ContactRecord contact;
  contact.tick = kFirstTick + k;
  contact.a = std::min(a, b);
  contact.b = std::max(a, b);
  contact.points = 1;
  contact.f_W = {2.0 / 7.0 * newton, -3.0 / 7.0 * newton, 6.0 / 7.0 * newton};
  return contact;
}

/** Forces of 0.5, 1, 2, 4 and 6 N for 40, 20, 50, 25 and 5 ms; the ring, which a wire meets, and a jaw, are no part. */
void writeContacts(Tick k, session::LogWriter* log) {
  if (isWithin(k, 100, 150)) log->write(makeContact(k, kLeadTool, kTower, 2.0));
  if (isWithin(k, 300, 325)) log->write(makeContact(k, kOtherTool, kDome, 4.0));
  if (isWithin(k, 325, 330)) log->write(makeContact(k, kOtherTool, kDome, 6.0));
  if (isWithin(k, 500, 520)) log->write(makeContact(k, kLeadTool, kOtherTool, 1.0));
  if (isWithin(k, 700, 740)) log->write(makeContact(k, kOtherTool, kWire, 0.5));
  if (isWithin(k, 900, 960)) log->write(makeContact(k, kWire, kRing, 9.0));
  if (isWithin(k, 1100, 1200)) log->write(makeContact(k, kLeadTool, kRing, 9.0));
}

ExerciseRecord makeHold(Tick k, ExerciseEventKind kind, Arm arm) {
  ExerciseRecord record;
  record.tick = kFirstTick + k;
  record.event.kind = kind;
  record.event.arm = arm == Arm::kGold ? Hand::kGold : Hand::kGreen;
  return record;
}

SessionScore scoreMadeSession(Arm lead) {
  const std::string path = scratchPath("reference.rlog");
  session::LogWriter log(path, makeHeader(lead));
  for (Tick k = 0; k < kTicks; ++k) {
    if (k == 500) log.write(makeHold(k, ExerciseEventKind::kHeld, lead));
    if (k == 3500) log.write(makeHold(k, ExerciseEventKind::kReleased, lead));
    log.write(makeTick(k, lead));
    writeContacts(k, &log);
  }
  log.finish({});
  return scoreSession(path, makeSettings(lead));
}

// ---- expected values

/** Speeds as doc/scores.md takes them: differences of places that are means of ten ticks. */
std::vector<double> speedsOf(const Stroke& stroke) {
  std::vector<double> places, speeds;
  for (Tick k = 0; k < kTicks; k += 10) {
    double sum = 0.0;
    for (Tick i = 0; i < 10; ++i)
      sum += minimumJerk(kTickSeconds * static_cast<double>(k + i) - stroke.begin, stroke.duration) / 10.0;
    places.push_back(stroke.length * sum);
  }
  for (std::size_t k = 1; k < places.size(); ++k)
    speeds.push_back((places[k] - places[k - 1]) * 100.0);
  return speeds;
}

/** The spectral arc length of Balasubramanian 2015, by a sum over all samples for each frequency up to 10 Hz. */
double slowArcLength(const std::vector<double>& speed) {
  double length = 16.0;
  while (length < 16.0 * static_cast<double>(speed.size()))
    length *= 2.0;
  std::vector<double> spectrum;
  for (double k = 0.0; k * 100.0 / length <= 10.0; k += 1.0) {
    const std::complex<double> step = std::polar(1.0, -2.0 * kPi * k / length);
    std::complex<double> sum = 0.0;
    for (std::size_t n = speed.size(); n-- > 0;)
      sum = sum * step + speed[n];
    spectrum.push_back(std::abs(sum));
  }
  const double peak = spectrum.front();  // speeds are positive: their mean is the greatest
  while (spectrum.back() < 0.05 * peak)
    spectrum.pop_back();
  double arc = 0.0;
  for (std::size_t k = 1; k < spectrum.size(); ++k)
    arc -= std::hypot(1.0 / static_cast<double>(spectrum.size() - 1), (spectrum[k] - spectrum[k - 1]) / peak);
  return arc;
}

/** Of the part that is faster than 5 mm/s. */
double strokeArcLength(const Stroke& stroke) {
  std::vector<double> fast;
  for (const double v : speedsOf(stroke)) {
    if (v > 0.005) fast.push_back(v);
  }
  return slowArcLength(fast);
}

/** The mean of a figure of both tips, weighted by how far they went. */
double byPaths(double of_lead, double of_other) {
  return (kLead.length * of_lead + kOther.length * of_other) / (kLead.length + kOther.length);
}

constexpr double kSpeeds = 599.0;  // differences of 600 samples

double meanJerkOf(const Stroke& stroke) {
  return std::sqrt(stroke.squaredJerk() * 100.0 / (kSpeeds - 2.0));
}

/** -ln(T^3 / v_peak^2 times 720 D^2 / T_s^5), v_peak = 15/8 D / T_s. */
double ldljOf(const Stroke& stroke) {
  const double peak = 15.0 / 8.0 * stroke.length / stroke.duration;
  return -std::log(std::pow(kSpeeds / 100.0, 3) / (peak * peak) * stroke.squaredJerk());
}

double varianceOfSpeed(const Stroke& stroke) {
  const double all = kSpeeds / 100.0;
  return stroke.squaredSpeed() / all - std::pow(stroke.length / all, 2);
}

/** Both strokes lie apart in time: the mean of their product is 0. */
double correlationOfSpeeds() {
  const double all = kSpeeds / 100.0;
  return -kLead.length * kOther.length / (all * all) / std::sqrt(varianceOfSpeed(kLead) * varianceOfSpeed(kOther));
}

/** [m] by which each sample of the transit is beyond three fifths of its length. */
std::vector<double> beyondThePlan() {
  std::vector<double> places;
  for (double t = 1.0045; t < 3.0; t += 0.01) {
    const double place = kLead.length * minimumJerk(t - kLead.begin, kLead.duration);
    if (place > kTransitEnd && place < kLead.length - kTransitEnd) places.push_back(place - kTransitEnd);
  }
  const double end = places.front() + 0.6 * (places.back() - places.front());
  for (double& place : places)
    place = std::max(0.0, place - end);
  return places;
}

double meanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values)
    sum += v / static_cast<double>(values.size());
  return sum;
}

/** [mm] RMS of the hand: a line of 80 mm in 180 of the 570 samples with the pedal down, at rest in the others. */
double spreadOfTheHand() {
  return std::sqrt(180.0 / 570.0) * 80.0 / std::sqrt(12.0);
}

struct Reference {
  double value, tolerance;
};

std::map<std::string, Reference> references() {
  const double active = kLead.timeAbove(0.001), active_other = kOther.timeAbove(0.001);
  std::vector<double> beyond = beyondThePlan();
  const double p95 = beyond[beyond.size() * 95 / 100];
  return {
      {"time", {kSeconds, 1e-9}},
      {"path", {80.0, 1e-3}},
      {"economy", {0.6, 1e-9}},
      {"off_path", {1e3 * meanOf(beyond), 0.06}},
      {"off_path_p95", {1e3 * p95, 0.4}},
      {"idle", {1.0 - (active + active_other) / (kSpeeds / 100.0), 0.006}},
      {"mean_jerk", {byPaths(meanJerkOf(kLead), meanJerkOf(kOther)), 0.006}},
      {"sparc", {byPaths(slowArcLength(speedsOf(kLead)), slowArcLength(speedsOf(kOther))), 1e-3}},
      {"stroke_sparc", {byPaths(strokeArcLength(kLead), strokeArcLength(kOther)), 1e-3}},
      {"ldlj", {byPaths(ldljOf(kLead), ldljOf(kOther)), 0.06}},
      {"tremor", {0.0, 2.0}},  // strokes are no tremor: less than half of the least spread of a band
      {"collisions", {2.0, 0.0}},
      {"collision_time", {0.050 + 0.030 + 0.020, 1e-9}},
      {"wire_touches", {3.0, 0.0}},
      {"wire_time", {0.040 + 0.060, 1e-9}},
      {"drops", {1.0, 0.0}},
      {"break_offs", {4.0, 0.0}},
      {"out_of_order", {5.0, 0.0}},
      {"wrong_arm", {6.0, 0.0}},
      {"peak_force", {6.0, 1e-6}},
      {"force_p95", {4.0, 1e-6}},  // of 140 ticks the 133rd
      {"force_impulse", {0.5 * 0.040 + 1.0 * 0.020 + 2.0 * 0.050 + 4.0 * 0.025 + 6.0 * 0.005, 1e-9}},
      {"force_above", {0.030, 1e-9}},
      {"out_of_view", {4.0, 0.002}},
      {"clutches", {2.0, 0.0}},
      {"clutch_time", {0.3, 1e-9}},
      {"engaged", {5.7 / 6.0, 1e-9}},
      {"camera_moves", {2.0, 0.0}},
      {"camera_time", {0.3, 1e-9}},
      {"master_radius", {40.0, 0.4}},
      {"master_deviation", {spreadOfTheHand(), 0.1}},
      {"bimanual", {active_other / active, 0.01}},
      {"speed_correlation", {correlationOfSpeeds(), 0.002}},
      {"tracking", {(2.7 * 2.0 + 3.0 * 3.0) / 5.7, 1e-9}},
  };
}

TEST_P(MetricReference, IsReachedByEveryMetricWhicheverArmLeads) {
  const SessionScore score = scoreMadeSession(lead());
  ASSERT_EQ(score.attempts.size(), 1U);
  const std::map<std::string, Reference> expected = references();
  ASSERT_EQ(expected.size(), kMetrics.size());
  ASSERT_EQ(score.attempts[0].metrics.size(), kMetrics.size());
  for (const MetricScore& metric : score.attempts[0].metrics) {
    const Reference& reference = expected.at(metric.metric.name);
    ASSERT_TRUE(metric.metric.value) << metric.metric.name;
    EXPECT_NEAR(*metric.metric.value, reference.value, reference.tolerance) << metric.metric.name;
  }
  const MotionMetrics& motion = score.attempts[0].motion;
  const HandMotion &hand = at(motion.hands, lead()), &helper = at(motion.hands, other());
  EXPECT_NEAR(hand.path, kLead.length, 1e-6);
  EXPECT_NEAR(helper.path, kOther.length, 1e-6);
  EXPECT_NEAR(helper.max_speed, 15.0 / 8.0 * kOther.length / kOther.duration, 1e-4);
  EXPECT_NEAR(helper.mean_jerk.value(), meanJerkOf(kOther), 0.03 * meanJerkOf(kOther));
  EXPECT_NEAR(helper.master_radius.value(), 0.010, 1e-4);
  EXPECT_NEAR(hand.out_of_view.value(), 4.0, 0.002);
  EXPECT_NEAR(helper.out_of_view.value(), 1.5, 0.002);
  EXPECT_EQ(score.attempts[0].economy.transits, 1U);
}

/** Both tips tremble, at their own frequency and by their own amplitude, on straight ways of different lengths. */
TEST_P(MetricReference, OfTremorIsTheRmsOfEachTipByItsPath) {
  constexpr double kBig = 40e-6, kSmall = 15e-6;
  MotionAccumulator motion({});
  for (Tick k = 0; k < 4000; ++k) {
    const double t = kTickSeconds * static_cast<double>(k);
    const Vec3 big{0.015 * t, kBig * std::sin(2.0 * kPi * 9.0 * t), 0.0};
    const Vec3 small{0.0, 0.005 * t, kSmall * std::sin(2.0 * kPi * 11.0 * t)};
    motion.add(lead() == Arm::kGold ? makeRecord(k, big, small) : makeRecord(k, small, big));
  }
  const MotionMetrics metrics = motion.result();
  const double of_lead = kBig / std::sqrt(2.0), of_other = kSmall / std::sqrt(2.0);
  EXPECT_NEAR(at(metrics.hands, lead()).tremor.value(), of_lead, 0.05 * of_lead);
  EXPECT_NEAR(at(metrics.hands, other()).tremor.value(), of_other, 0.05 * of_other);
}

// ---- score.json

/** All numbers below a value, by their keys joined by dots. */
void flatten(const nlohmann::json& json, const std::string& place, std::map<std::string, double>* numbers) {
  if (json.is_number()) (*numbers)[place] = json.get<double>();
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items())
    flatten(value, place.empty() ? key : place + "." + key, numbers);
}

std::map<std::string, double> numbersOf(const std::string& path) {
  std::ifstream file(path);
  std::map<std::string, double> numbers;
  flatten(nlohmann::json::parse(file), "", &numbers);
  return numbers;
}

HandMotion numbered(double n) {
  HandMotion hand;
  hand.path = n + 0.01;
  hand.mean_speed = n + 0.02;
  hand.max_speed = n + 0.03;
  hand.active_time = n + 0.04;
  hand.mean_jerk = n + 0.05;
  hand.sparc = n + 0.06;
  hand.dlj = n + 0.07;
  hand.ldlj = n + 0.08;
  hand.stroke_sparc = n + 0.09;
  hand.strokes = static_cast<std::uint64_t>(n) + 11;
  hand.tremor = (n + 0.1) * 1e-6;
  hand.master_radius = n + 0.11;
  hand.master_deviation = n + 0.12;
  hand.out_of_view = n + 0.13;
  return hand;
}

void expectHand(std::map<std::string, double>* numbers, const std::string& place, double n) {
  const std::map<std::string, double> expected{{"path_mm", 1e3 * (n + 0.01)},
                                               {"mean_speed_mm_s", 1e3 * (n + 0.02)},
                                               {"max_speed_mm_s", 1e3 * (n + 0.03)},
                                               {"active_time_s", n + 0.04},
                                               {"mean_jerk_m_s3", n + 0.05},
                                               {"sparc", n + 0.06},
                                               {"dlj", n + 0.07},
                                               {"ldlj", n + 0.08},
                                               {"stroke_sparc", n + 0.09},
                                               {"strokes", n + 11},
                                               {"tremor_um", n + 0.1},
                                               {"master_radius_mm", 1e3 * (n + 0.11)},
                                               {"master_deviation_mm", 1e3 * (n + 0.12)},
                                               {"out_of_view_s", n + 0.13}};
  for (const auto& [name, value] : expected)
    EXPECT_NEAR((*numbers)[place + name], value, 1e-9) << place << name;
}

void expectForce(std::map<std::string, double>* numbers, const std::string& place, double n) {
  const std::map<std::string, double> expected{{"peak_N", n},
                                               {"p95_N", n + 1},
                                               {"impulse_Ns", n + 2},
                                               {"above_s", 0.001 * (n + 3)},
                                               {"with_force_s", 0.001 * (n + 4)}};
  for (const auto& [name, value] : expected)
    EXPECT_NEAR((*numbers)[place + name], value, 1e-9) << place << name;
}

HazardScore makeHazard() {
  HazardScore hazard;
  hazard.scenario = "sudden_jump";
  hazard.injection = 1201;
  HazardResponse& r = hazard.response;
  r.force_after = 21;
  r.cue_after = 22;
  r.reaction = {Response::kSlow, 323};
  r.deciding = {Response::kPedalUp, 424};
  r.coincidences = {{Response::kRetreat, 25}};
  r.verdict = Verdict::kRight;
  r.recovered = true;
  r.duration = 926;
  r.excursion = 0.027;
  r.error = 0.028;
  r.peak_force = 2.9;
  r.impulse = 3.1;
  r.answer_time = 2345;
  r.release = 2456;
  r.release_needed = 2567;
  r.touches[static_cast<std::size_t>(Partner::kDome)] = {3, 33};
  return hazard;
}

void expectHazard(std::map<std::string, double>* numbers, const std::string& place) {
  const std::map<std::string, double> expected{
      {"injection_tick", 1201},       {"force_after_ms", 21},        {"cue_after_ms", 22},
      {"reaction.after_ms", 323},     {"deciding.after_ms", 424},    {"coincidences.0.after_ms", 25},
      {"duration_ms", 926},           {"excursion_mm", 27},          {"error_mm", 28},
      {"peak_force_N", 2.9},          {"impulse_Ns", 3.1},           {"touches.dome.count", 3},
      {"touches.dome.time_s", 0.033}, {"touches.tower.time_s", 0.0}, {"answer_time_ms", 2345},
      {"release_ms", 2456},           {"release_needed_ms", 2567}};
  for (const auto& [name, value] : expected)
    EXPECT_NEAR((*numbers)[place + name], value, 1e-9) << place << name;
}

/** Each figure of the file has the right number, in the unit of its name (doc/scores.md). */
TEST(ScoreFile, SaysEveryNumberInTheUnitOfItsName) {
  SessionScore score;
  score.hazards = {makeHazard()};
  score.hazards_beyond = 7;
  MotionMetrics motion = makeMotion(Arm::kGold);
  at(motion.hands, Arm::kGold) = numbered(1.0);
  at(motion.hands, Arm::kGreen) = numbered(2.0);
  motion.contact_force = {10.0, 11.0, 12.0, 13, 14};
  motion.haptic_force = {20.0, 21.0, 22.0, 23, 24};
  AttemptOutcome outcome = makeOutcome();
  outcome.number = 3;
  outcome.steps = 5;
  outcome.first = 100;
  outcome.last = 5100;
  Economy economy = makeEconomy();
  economy.transits = 9;
  economy.planned = 8;
  score.attempts = {scoreAttempt(outcome, motion, economy, score.hazards, {})};
  score.histories = {{{{"lift", 1.25}}, {{"drop", 2.5}}}};
  ScoreSettings settings;
  settings.motion.motion_scale = 0.25;
  settings.motion.force_limit = 3.5;
  settings.response.within = 1.75;
  const std::string path = scratchPath("numbers.json");
  writeScore(path, score, settings);
  std::map<std::string, double> numbers = numbersOf(path);
  expectHand(&numbers, "attempts.0.hands.gold.", 1.0);
  expectHand(&numbers, "attempts.0.hands.green.", 2.0);
  expectForce(&numbers, "attempts.0.contact_force.", 10.0);
  expectForce(&numbers, "attempts.0.haptic_force.", 20.0);
  expectHazard(&numbers, "attempts.0.hazards.0.");
  expectHazard(&numbers, "hazards.0.");
  const std::map<std::string, double> rest{{"hazards_beyond", 7},
                                           {"motion_scale", 0.25},
                                           {"force_limit_N", 3.5},
                                           {"response_rule.within_s", 1.75},
                                           {"attempts.0.number", 3},
                                           {"attempts.0.first_tick", 100},
                                           {"attempts.0.last_tick", 5100},
                                           {"attempts.0.steps_done", 5},
                                           {"attempts.0.steps.0.at_s", 1.25},
                                           {"attempts.0.mistake_times.0.at_s", 2.5},
                                           {"attempts.0.transits", 9},
                                           {"attempts.0.transits_planned", 8}};
  for (const auto& [name, value] : rest)
    EXPECT_EQ(numbers[name], value) << name;
  for (std::size_t i = 0; i < kMistakeCount; ++i)
    EXPECT_EQ(numbers[std::string("attempts.0.mistakes.") + kMistakeNames[i]], static_cast<double>(i + 1));
  for (std::size_t i = 0; i < kPartnerCount; ++i) {
    const std::string place = std::string("attempts.0.touches.") + kPartnerNames[i];
    EXPECT_EQ(numbers[place + ".count"], static_cast<double>(1000 + i)) << place;
    EXPECT_NEAR(numbers[place + ".time_s"], 0.001 * static_cast<double>(1U << i), 1e-12) << place;
  }
}

}  // namespace
}  // namespace raven2_trainer::training
