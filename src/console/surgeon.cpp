#include "surgeon.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::console {
namespace {

constexpr std::uint64_t kSkillStream = 11;  // none of the other script's

constexpr double kTurning = 1.0;                              ///< [rad/s] mean
constexpr double kUnhurried = 0.020;                          ///< [m/s] slower than this, turns are slower, too
constexpr double kClosing = 1.5;                              ///< [rad/s] mean, of the jaws
constexpr double kNearEnough = 0.0003, kTurnedEnough = 0.02;  ///< [m, rad] not worth a correction
constexpr double kRunLevelTimeout = 1.5;                      ///< [s] to wait for the robot's
constexpr double kStopTime = 0.5;                             ///< [s] pedal up at least, after a stop
constexpr double kHoldsOpening = 0.15;                        ///< [rad] jaws closed on nothing open less
constexpr double kHoldsWithin = 0.006;                        ///< [m] of a ring from where its grip would have it
constexpr double kEyeByTip = 3.0;                             ///< [-] way of the camera's eye by a tool's, about
constexpr double kEyeNearEnough = 0.01;                       ///< [m]

bool isLevel(std::uint8_t runlevel, RunLevel wanted) noexcept {
  return runlevel == static_cast<std::uint8_t>(wanted);
}

/** Motion of both hands for the camera [m], as of a tool [@frame I]: right and up around the camera's target, forward
 *  nearer to it. As in control/camera_orbit.h, whose factor need not be met, since the eye is seen. */
Vector3 cameraWay(const CameraState& camera, const Vec3& to_W) noexcept {
  const Vector3 target = toEigen(camera.target_W), from = toEigen(camera.eye_W) - target, to = toEigen(to_W) - target;
  const double flat = from.head<2>().norm();
  const double around = std::remainder(std::atan2(to.y(), to.x()) - std::atan2(from.y(), from.x()), 2.0 * kPi);
  const double upward = std::atan2(to.z(), to.head<2>().norm()) - std::atan2(from.z(), flat);
  return Vector3(from.norm() - to.norm(), flat * around, -from.norm() * upward) / kEyeByTip;
}

}  // namespace

Surgeon::Surgeon(const ConsoleConfig& config,
                 const ArmsConfig& arms,
                 const SceneRoles& roles,
                 const Skill& skill,
                 std::uint64_t seed)
    : arms_(arms),
      roles_(roles),
      skill_(skill),
      scale_(config.scale),
      random_(seed, kSkillStream),
      joints_{arms.geometry.home, arms.geometry.home},
      hands_{ToolHand(config, skill.tremor, kinematics::jawOpening(arms.geometry.home), &random_),
             ToolHand(config, skill.tremor, kinematics::jawOpening(arms.geometry.home), &random_)} {
  begin();
}

Intent Surgeon::tick(const Senses& senses) {
  see(senses);
  const bool waits = waitsForStop();
  if (senses.was_interrupted) free_at_ = std::max(free_at_, now_ + takeUpAgain());
  while (now_ >= free_at_ && !finished_ && !waits)
    free_at_ = now_ + next();
  Intent intent;
  intent.finished = finished_;
  intent.pedal = pedal_ && !finished_ && !waits;
  intent.pedals = finished_ ? 0 : pedals_;
  for (const Arm arm : kArms) {
    at(intent.hand_I, arm) = hand(arm).position(now_);
    at(intent.turn_I, arm) = hand(arm).turn(now_);
    at(intent.grasp, arm) = hand(arm).jaws(now_);
  }
  if (!waits) ++now_;
  return intent;
}

/** A stop that somebody on the surgeon's side asked for: the pedal is up, and the hands rest, until it is cleared and
 *  for a moment after that. The stop of a robot can be seen as well, but what to do about it is the Reaction's. */
bool Surgeon::waitsForStop() {
  const bool is_stopped = sight_ && sight_->mode == Mode::kStopped && sight_->runlevel != RunLevel::kEStop;
  if (is_stopped) wait_ = toTicks(kStopTime);
  if (wait_ == 0) return false;
  if (!is_stopped && --wait_ == 0) free_at_ = std::max(free_at_, now_ + takeUpAgain());
  return wait_ > 0;
}

// ---- eyes ---------------------------------------------------------------------------------------------------------

void Surgeon::see(const Senses& senses) {
  sequence_ = senses.sequence;
  runlevel_ = senses.force.runlevel;
  if (!senses.sight || (sight_ && senses.sight->sequence == sight_->sequence)) return;
  sight_ = senses.sight;
  giveUpWhatHasFailed();
  for (const Arm arm : kArms)
    followJoints(arm);
  for (std::uint8_t object = 0; object < roles_.objects.size(); ++object)
    followRing(object);
}

/** Of an attempt that was open while these hands were at work: what failed before is not theirs. */
void Surgeon::giveUpWhatHasFailed() {
  const ExerciseStatus status = sight_->exercise;
  if (status == ExerciseStatus::kWaiting || status == ExerciseStatus::kRunning) saw_open_attempt_ = true;
  if (status == ExerciseStatus::kFailed && saw_open_attempt_) finish();
}

/** Joints that put the tool where it is seen. */
void Surgeon::followJoints(Arm arm) {
  JointTrail trail(arms_, arm, at(joints_, arm));
  trail.go(tool(arm));
  at(joints_, arm) = trail.joints();
}

/** Of its two sides the upper one is taken; as long as it is held, the one that was. */
void Surgeon::followRing(std::uint8_t object) {
  const bool is_held = holds_[0].object == object || holds_[1].object == object;
  const Vector3 up_W = is_held ? Vector3(rings_.at(object).R.col(2)) : Vector3::UnitZ();
  rings_.at(object) = facing(toEigen(sight_->bodies_W.at(object)), up_W);
}

bool Surgeon::isClosedOnSomething(Arm arm) const {
  return at(sight_->opening, arm) >= kHoldsOpening;
}

bool Surgeon::holds(Arm arm) const {
  const Hold& hold = at(holds_, arm);
  if (hold.object == kNobody || !isClosedOnSomething(arm)) return false;
  return errorOf(ringInTool(arm, hold.object), hold.X_TR).distance < kHoldsWithin;
}

const ScenePeg* Surgeon::pegIn(std::uint8_t object) const {
  const Vector3 p = ring(object).p;
  for (const ScenePeg& peg : roles_.pegs) {
    const Vector3 from_foot = p - toEigen(peg.base_W);
    const bool is_over = from_foot.head<2>().norm() < roles_.objects[object].inner_radius;
    if (is_over && from_foot.z() < peg.height) return &peg;
  }
  return nullptr;
}

// ---- steps --------------------------------------------------------------------------------------------------------

Tick Surgeon::next() {
  if (steps_.empty()) nextVerb();
  if (steps_.empty()) return 0;
  const Step step = std::move(steps_.front());
  steps_.pop_front();
  return step();
}

void Surgeon::rest(double seconds) {
  then([seconds] { return toTicks(seconds); });
}

Surgeon::Step Surgeon::until(std::function<bool()> is_so, double timeout) {
  const Tick end = now_ + toTicks(timeout);
  return [this, is_so, end]() -> Tick {
    if (is_so() || now_ > end) return 0;
    first({until(is_so, static_cast<double>(end - now_) * kTickSeconds)});
    return 1;
  };
}

/** With the first picture the pedal goes down, and the tools are taken up where they are. */
void Surgeon::begin() {
  then([this]() -> Tick {
    if (sight_) return 0;
    steps_.clear();
    begin();
    return 1;
  });
  then([this] { return press(); });
  then([this] {
    for (const Arm arm : kArms) {
      hand(arm).takeUp(tool(arm));
      at(start_, arm) = tool(arm);
    }
    return Tick{0};
  });
}

/** Pedal down, until the robot follows and the picture shows it. */
Tick Surgeon::press() {
  pedal_ = true;
  first({until([this] { return isLevel(runlevel_, RunLevel::kPedalDown); }, kRunLevelTimeout),
         [] { return toTicks(kSettle); }});
  return 1;
}

Tick Surgeon::takeUpAgain() {
  if (!sight_) return 0;
  double way = 0.0;
  for (const Arm arm : kArms)
    way = std::max(way, errorOf(tool(arm), hand(arm).wished(now_)).distance);
  const Tick length = toTicks(std::max(kLookAgain, way / skill_.slowest));
  for (const Arm arm : kArms)
    hand(arm).rebase(now_, tool(arm), length);
  return length;
}

std::vector<Surgeon::Step> Surgeon::clutch() {
  const Step release = [this] {
    pedal_ = false;
    for (const Arm arm : kArms)
      hand(arm).comeBack(now_, toTicks(skill_.clutch_time) - 1);
    first({until([this] { return isLevel(runlevel_, RunLevel::kPedalUp); }, kRunLevelTimeout)});
    return toTicks(skill_.clutch_time);
  };
  const Step look = [this] { return takeUpAgain(); };
  return {[] { return toTicks(0.1); }, release, [this] { return press(); }, look};
}

Surgeon::Step Surgeon::travel(Arm arm, Target target, double speed) {
  return [this, arm, target, speed] {
    const Pose to = target();
    const Pose from = hand(arm).goal();
    if (hand(arm).stretch(now_, to) <= skill_.clutch_reach) return move(arm, to, speed);
    std::vector<Step> steps = clutch();
    steps.push_back(travel(arm, target, speed));
    first(std::move(steps));
    const double part = reachable(arm, from, to);
    return part > 0.05 ? move(arm, between(from, to, part), speed) : Tick{0};
  };
}

/** Share of the path that needs no clutch. */
double Surgeon::reachable(Arm arm, const Pose& from, const Pose& to) {
  double part = 1.0;
  while (part > 0.0 && hand(arm).stretch(now_, between(from, to, part)) > skill_.clutch_reach)
    part -= 0.02;
  return part;
}

Tick Surgeon::move(Arm arm, const Pose& to, double speed) {
  const PoseError way = errorOf(hand(arm).goal(), to);
  const double turning = kTurning * std::min(1.0, speed / kUnhurried);
  const Tick length = toTicks(std::max({kShortestMove, way.distance / speed, way.angle / turning}));
  hand(arm).move(now_, to, length);
  return length;
}

Surgeon::Step Surgeon::settle(Arm arm, int looks) {
  const Step look = [this, arm, looks]() -> Tick {
    const PoseError error = errorOf(tool(arm), hand(arm).goal());
    const bool is_good = error.distance < kNearEnough && error.angle < kTurnedEnough;
    if (is_good || looks == 0) return 0;
    hand(arm).correct(now_, tool(arm), toTicks(kLookAgain));
    first({settle(arm, looks - 1)});
    return toTicks(kLookAgain);
  };
  return [this, look] {
    first({look});
    return toTicks(kSettle);
  };
}

Surgeon::Step Surgeon::carryTo(Arm arm, const Vector3& to_W, double speed) {
  const Target target = [this, arm, to_W] {
    const Hold& hold = at(holds_, arm);
    return level(to_W, hold.heading) * hold.X_TR.inverse();
  };
  return travel(arm, target, speed);
}

Surgeon::Step Surgeon::settleRing(Arm arm, const Vector3& to_W, int looks) {
  const Step look = [this, arm, to_W, looks]() -> Tick {
    Hold& hold = at(holds_, arm);
    if (!holds(arm)) return 0;
    const Pose wanted = level(to_W, hold.heading);
    const PoseError error = errorOf(ring(hold.object), wanted);
    if ((error.distance < 2 * kNearEnough && error.angle < 2 * kTurnedEnough) || looks == 0) return 0;
    hand(arm).correct(now_, tool(arm), toTicks(kLookAgain));
    hold.X_TR = ringInTool(arm, hold.object);
    hand(arm).move(now_, wanted * hold.X_TR.inverse(), toTicks(kLookAgain));
    first({settleRing(arm, to_W, looks - 1)});
    return toTicks(kLookAgain);
  };
  return [this, look] {
    first({look});
    return toTicks(kSettle);
  };
}

void Surgeon::jaws(Arm arm, double opening) {
  then([this, arm, opening] {
    const Tick length = toTicks(std::abs(opening - hand(arm).jawGoal()) / kClosing);
    hand(arm).moveJaws(now_, opening, length);
    return length + toTicks(kSettle);
  });
}

void Surgeon::leave(Arm arm) {
  const Target back = [this, arm, from = std::optional<Pose>()]() mutable {
    if (!from) from = hand(arm).goal();
    return drawnBack(*from, kStandOff);
  };
  then(travel(arm, back, speed()));
  then([this, arm]() -> Tick {
    at(holds_, arm) = Hold{};
    return 0;
  });
}

Surgeon::Step Surgeon::pedalStep(Pedal pedal, bool is_down) {
  return [this, pedal, is_down] {
    pedals_ = is_down ? pedals_ | bit(pedal) : pedals_ & ~bit(pedal);
    return Tick{0};
  };
}

bool Surgeon::isEyeAt(const Vec3& to_W) const {
  return (toEigen(sight_->camera.eye_W) - toEigen(to_W)).norm() < kEyeNearEnough;
}

Surgeon::Step Surgeon::leadCamera(const Vec3& to_W, int legs) {
  return [this, to_W, legs]() -> Tick {
    if (legs == 0 || isEyeAt(to_W)) return 0;
    const Vector3 way_I = cameraWay(sight_->camera, to_W);
    const double part = std::min(1.0, 0.9 * skill_.clutch_reach * scale_ / way_I.norm());
    const Step wait = [] { return toTicks(kSettle); };
    std::vector<Step> steps{wait, pedalStep(Pedal::kCamera, false), wait};
    for (Step& step : clutch())
      steps.push_back(std::move(step));
    steps.insert(steps.end(), {pedalStep(Pedal::kCamera, true), wait, leadCamera(to_W, legs - 1)});
    first(std::move(steps));
    const Tick length = toTicks(std::max(kShortestMove, part * way_I.norm() / skill_.slowest));
    for (const Arm arm : kArms)
      hand(arm).moveHand(now_, part * way_I, length);
    return length;
  };
}

}  // namespace raven2_trainer::console
