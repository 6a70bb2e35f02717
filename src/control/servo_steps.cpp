#include <algorithm>
#include <cmath>

#include "control/servo_math.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/control/teleop_mapper.h"

// One tick of each kind of command.

namespace raven2_trainer::control {
namespace {

constexpr Tick kSlowDown = 200;  // in which a twist that timed out comes to rest: 0.5 m/s2 at max_speed; ours
// On a straight line joints' rates are met within this, or the path ends: near its singularities an arm cannot go on.
constexpr double kRateRounding = 1e-3;
constexpr int kMostAttempts = 4;
constexpr int kTipSamples = 16;  // of a move in joints, for the highest rate of its tip

}  // namespace

void ServoTarget::step() noexcept {
  stepJaw();
  switch (motion_) {
    case Motion::kHold:
      return;
    case Motion::kJoints:
      return stepJoints();
    case Motion::kPose:
      return stepPose();
    case Motion::kTwist:
      return stepTwist();
    case Motion::kRates:
      return stepRates();
    case Motion::kMove:
      return stepMove();
  }
}

void ServoTarget::stepJaw() noexcept {
  if (servos_jaw_) {
    const double most = limits_.max_turn_rate * kTickSeconds;
    opening_ += std::clamp(goal_jaw_ - opening_, -most, most);
  } else if (moves_jaw_) {
    const double share = static_cast<double>(++jaw_.elapsed) * kTickSeconds / jaw_.duration;
    moves_jaw_ = share < 1.0;
    opening_ = moves_jaw_ ? jaw_.from + quinticBlend(share) * (jaw_.to - jaw_.from) : jaw_.to;
  }
}

/** All joints arrive together. How far the tip comes is known afterwards: then they go as far as it may. */
void ServoTarget::stepJoints() noexcept {
  stepJointsTo(servoJoints(goal_q_));
}

void ServoTarget::stepJointsTo(const ServoJoints& to) noexcept {
  const ServoJoints from = servoJoints(q_);
  const double most = limits_.max_speed * kTickSeconds, most_turn = limits_.max_turn_rate * kTickSeconds;
  double share = 1.0;
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const double step = std::abs(to[j] - from[j]), limit = j == kInsertion ? most : most_turn;
    if (step > limit) share = std::min(share, limit / step);
  }
  const Pose before = poseOf(q_);
  JointArray q = q_;
  for (int attempt = 0; attempt < 2; ++attempt) {
    q = withServoJoints(q_, between(from, to, share));
    const Pose X = poseOf(q);
    const double over = std::max(distance(X, before) / most, turnBetween(X.R, before.R) / most_turn);
    if (over <= 1.0) break;
    share /= over;
  }
  q_ = q;
  X_ = poseOf(q);
}

void ServoTarget::stepPose() noexcept {
  const double step = distance(goal_X_, X_), turn = turnBetween(goal_X_.R, X_.R);
  const double ticks = std::max(step / limits_.max_speed, turn / limits_.max_turn_rate) / kTickSeconds;
  stepTo(between(X_, goal_X_, ticks > 1.0 ? 1.0 / ticks : 1.0));
}

/** [-] Of a twist or of rates: 1, and after the time-out down to 0, which ends them. */
double ServoTarget::timedShare() noexcept {
  if (twist_left_ == 0) ++run_out_;
  --twist_left_;
  const double share = 1.0 + static_cast<double>(twist_left_ + 1) / kSlowDown;
  return std::clamp(share, 0.0, 1.0);
}

void ServoTarget::stepTwist() noexcept {
  const double share = timedShare();
  if (share <= 0.0) return servo(Motion::kHold);
  const Vector3 turn = share * w_ * kTickSeconds;
  Pose next{X_.R, X_.p + share * v_ * kTickSeconds};
  const double angle = turn.norm();
  if (angle > 0.0) {
    const Quaternion R_BT(Eigen::AngleAxisd(angle, turn / angle) * Quaternion(X_.R));
    next.R = R_BT.normalized().toRotationMatrix();
  }
  stepTo(next);
}

/** Stops where a joint's range or the path ends. */
void ServoTarget::stepRates() noexcept {
  const double share = timedShare();
  if (share <= 0.0) return servo(Motion::kHold);
  ServoJoints to = servoJoints(q_);
  fitJoints(&to);  // a joint at its limit does not stop the others
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    to[j] += share * rates_[j] * kTickSeconds;
  JointArray q = q_;
  const bool goes_on = areWithinLimits(to) && solve(poseOf(withServoJoints(q_, to)), &q);
  goes_on ? stepJointsTo(to) : endEarly();
}

/** Stops where the path ends. */
void ServoTarget::stepTo(const Pose& X_BT) noexcept {
  const Pose from = X_;
  const auto way = [&](double share) { return between(from, X_BT, share); };
  if (stepAlong(way, limits_.max_speed, limits_.max_turn_rate) <= 0.0) endEarly();
}

/** As much of a tick's way as leaves every joint within its rate: how far they come is known afterwards.
 *  @param[in] way pose at 0 to 1 of it. @return that share; 0 if the path ends here. */
template <typename Way>
double ServoTarget::stepAlong(const Way& way, double most_speed, double most_rate) noexcept {
  JointArray here = q_;
  const auto beyond_here = solve(X_, &here);
  if (!beyond_here) return 0.0;
  const double most_beyond = std::min(*beyond_here, kBeyondLimit) + kLimitRounding;  // no farther out than it is
  double share = 1.0;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    const Pose next = way(share);
    JointArray q = here;
    const auto beyond = solve(next, &q);
    if (!beyond || *beyond > most_beyond) return 0.0;
    const double over = jointStep(here, q, most_speed, most_rate);
    if (over <= 1.0 + kRateRounding) {
      X_ = *beyond > 0.0 ? poseOf(q) : next;
      return share;
    }
    share /= over;
  }
  return 0.0;
}

void ServoTarget::stepMove() noexcept {
  const Move& move = moves_[0];
  if (move.in_joints) {
    const double share = shareAt(elapsed_ += 1.0);
    for (std::size_t j = 0; j < kJointCount; ++j)
      q_[j] = from_q_[j] + share * (move.q[j] - from_q_[j]);
    X_ = poseOf(q_);
  } else {
    const auto way = [&](double ticks) { return between(from_X_, move.X, shareAt(elapsed_ + ticks)); };
    const double ticks = stepAlong(way, pace_ * limits_.move_speed, pace_ * limits_.move_turn_rate);
    if (ticks <= 0.0) return endEarly();
    elapsed_ += ticks;
  }
  if (shareAt(elapsed_) < 1.0) return;
  std::copy(moves_.begin() + 1, moves_.begin() + static_cast<std::ptrdiff_t>(move_count_), moves_.begin());
  if (--move_count_ == 0) return servo(Motion::kHold);
  beginMove();
}

void ServoTarget::beginMove() noexcept {
  from_X_ = ontoLimits(X_);
  from_q_ = q_;
  elapsed_ = 0.0;
  pace_ = ratio_;
  duration_ = duration(moves_[0]);
}

double ServoTarget::shareAt(double ticks) const noexcept {
  return quinticBlend(ticks * kTickSeconds / duration_);
}

/** [s] so that the tip is no faster than a move may be, nor a joint of one in joints. */
double ServoTarget::duration(const Move& move) const noexcept {
  const double speed = ratio_ * limits_.move_speed, rate = ratio_ * limits_.move_turn_rate;
  double mean = std::max(distance(move.X, X_) / speed, turnBetween(move.X.R, X_.R) / rate);
  if (move.in_joints) {
    const ServoJoints from = servoJoints(q_), to = servoJoints(move.q);
    for (std::size_t j = 0; j < kServoJointCount; ++j)
      mean = std::max(mean, std::abs(to[j] - from[j]) / (j == kInsertion ? speed : rate));
    Pose before = poseOf(q_);
    for (int i = 1; i <= kTipSamples; ++i) {
      const Pose X = poseOf(withServoJoints(q_, between(from, to, static_cast<double>(i) / kTipSamples)));
      mean =
          std::max({mean, kTipSamples * distance(X, before) / speed, kTipSamples * turnBetween(X.R, before.R) / rate});
      before = X;
    }
  }
  return std::max(kPeakRate * mean, kShortestMove);
}

bool ServoTarget::isMoving() const noexcept {
  return motion_ == Motion::kMove || moves_jaw_;
}

bool ServoTarget::hasGoal() const noexcept {
  return motion_ == Motion::kJoints || motion_ == Motion::kPose || motion_ == Motion::kMove;
}

Pose ServoTarget::goal() const noexcept {
  switch (motion_) {
    case Motion::kJoints:
      return poseOf(goal_q_);
    case Motion::kPose:
      return goal_X_;
    case Motion::kMove:
      return moves_[move_count_ - 1].X;
    default:
      return X_;
  }
}

}  // namespace raven2_trainer::control
