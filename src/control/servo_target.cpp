#include "raven2_trainer/control/servo_target.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/control/teleop_mapper.h"

namespace raven2_trainer::control {
namespace {

using kinematics::IkStatus;

constexpr double kNormError = 0.02;     // of a quaternion, as ITP's receivers allow (reliability.md 2.2)
constexpr double kPeakRate = 15.0 / 8;  // of the quintic, over its mean
constexpr double kShortestMove = 0.2;   // [s] so that a move of a millimetre stays below 0.15 m/s2; ours

// A set point farther than this from what the arm's mapping made of it was not taken: a limit, or a fault on the way.
// What the mapping rounds is half a micrometre and half a milliradian of the jaws.
constexpr double kLeash = 1e-4;      // [m]
constexpr double kLeashTurn = 1e-3;  // [rad]
constexpr double kLeashJaw = 0.02;   // [rad]

// Between poses looked at on a straight line: one of them is near enough to the next for the robot's choice of a
// solution, which takes 17 mm of insertion for too far (raven2.md 2.5).
constexpr double kReachStep = 0.01;     // [m]
constexpr double kReachTurn = 0.2;      // [rad]
constexpr double kMostReachSteps = 64;  // 0.64 m: farther than an arm reaches

constexpr int kTipSamples = 16;  // of a move in joints, for the highest rate of its tip

double turnBetween(const Matrix3& a, const Matrix3& b) noexcept {
  const Quaternion turn(a * b.transpose());
  return 2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

double distance(const Pose& a, const Pose& b) noexcept {
  return (a.p - b.p).norm();
}

/** The straight line and the shortest turn. @param[in] share [-] 0 `from`, 1 `to`, which is given exactly. */
Pose between(const Pose& from, const Pose& to, double share) noexcept {
  if (share >= 1.0) return to;
  const Quaternion turn = Quaternion(from.R).slerp(share, Quaternion(to.R));
  return {turn.normalized().toRotationMatrix(), from.p + share * (to.p - from.p)};
}

template <std::size_t N>
bool areFinite(const std::array<double, N>& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool isTurn(const Quat& q) noexcept {
  return areFinite(q) && std::abs(toEigen(q).norm() - 1.0) <= kNormError;
}

bool isReached(IkStatus status) noexcept {
  return status == IkStatus::kOk || status == IkStatus::kSingularWrist;
}

bool isPast(double value, double limit) noexcept {
  return value > limit * (1.0 + 1e-9);  // what was computed to be at the limit is
}

/** What `kind` does not look at may be anything. */
bool isWhole(const ServoCommand& c) noexcept {
  switch (c.kind) {
    case ServoKind::kServoJoints:
    case ServoKind::kServoJointsBy:
    case ServoKind::kMoveJoints:
      return areFinite(c.joints);
    case ServoKind::kServoPose:
    case ServoKind::kServoPoseBy:
    case ServoKind::kMovePose:
      return areFinite(c.pose_B.p) && isTurn(c.pose_B.q);
    case ServoKind::kServoTwist:
      return areFinite(c.v_B) && areFinite(c.w_B);
    case ServoKind::kServoJaw:
    case ServoKind::kServoJawBy:
    case ServoKind::kMoveJaw:
      return std::isfinite(c.jaw);
    default:
      return true;
  }
}

Pose poseIn(const ServoCommand& c) noexcept {
  return {toEigen(c.pose_B.q).normalized().toRotationMatrix(), toEigen(c.pose_B.p)};
}

ServoJoints sum(const ServoJoints& a, const ServoJoints& b) noexcept {
  ServoJoints result{};
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    result[j] = a[j] + b[j];
  return result;
}

}  // namespace

ServoJoints servoJoints(const JointArray& q) noexcept {
  ServoJoints joints{};
  std::copy_n(q.begin(), kServoJointCount - 1, joints.begin());
  joints.back() = kinematics::jawMidline(q);
  return joints;
}

JointArray withServoJoints(const JointArray& q, const ServoJoints& joints) noexcept {
  JointArray result = q;
  std::copy_n(joints.begin(), kServoJointCount - 1, result.begin());
  kinematics::setJaws(joints.back(), kinematics::jawOpening(q), &result);
  return result;
}

ServoTarget::ServoTarget(const CrtkConfig& limits, const ArmGeometry& geometry, Arm arm) noexcept
    : limits_(limits),
      geometry_(geometry),
      arm_(arm),
      twist_ticks_(static_cast<Tick>(std::llround(limits.twist_timeout / kTickSeconds))) {
  startFrom(poseOf(geometry.home), geometry.home, kinematics::jawOpening(geometry.home));
}

void ServoTarget::startFrom(const Pose& X_BT, const JointArray& q, double opening) noexcept {
  X_ = X_BT;
  q_ = q;
  opening_ = std::clamp(opening, kMinOpening, kMaxOpening);
  if (motion_ == Motion::kMove) beginMove();
  if (!moves_jaw_) return;
  jaw_.from = opening_;
  jaw_.elapsed = 0;
}

/** Joints that are not asked for follow from the pose, and the mapping is who knows which. */
void ServoTarget::keepTo(const Pose& X_BT, const JointArray& q, double opening) noexcept {
  const bool in_joints = motion_ == Motion::kJoints || (motion_ == Motion::kMove && moves_[0].in_joints);
  const bool is_off = distance(X_, X_BT) > kLeash || turnBetween(X_.R, X_BT.R) > kLeashTurn;
  if (is_off || !in_joints) q_ = q;
  if (is_off) {
    X_ = X_BT;
    if (motion_ == Motion::kMove) beginMove();
  }
  if (std::abs(opening_ - opening) <= kLeashJaw) return;
  opening_ = std::clamp(opening, kMinOpening, kMaxOpening);
  moves_jaw_ = false;
}

// ---- what is asked for -------------------------------------------------------------------------------------------

ServoVerdict ServoTarget::take(const ServoCommand& command) noexcept {
  if (!isWhole(command)) return {ServoRefusal::kNotFinite};
  const JointArray& joints_from = motion_ == Motion::kJoints ? goal_q_ : q_;
  switch (command.kind) {
    case ServoKind::kHold:
      hold();
      return {};
    case ServoKind::kServoJoints:
      return takeJoints(command.joints);
    case ServoKind::kServoJointsBy:
      return takeJoints(sum(servoJoints(joints_from), command.joints));
    case ServoKind::kServoPose:
    case ServoKind::kServoPoseBy:
      return takePose(command);
    case ServoKind::kServoTwist:
      return takeTwist(command);
    case ServoKind::kMoveJoints:
    case ServoKind::kMovePose:
      return takeMove(command);
    case ServoKind::kServoJaw:
    case ServoKind::kMoveJaw:
      return takeJaw(command.jaw, command.kind == ServoKind::kMoveJaw);
    case ServoKind::kServoJawBy:
      return takeJaw((servos_jaw_ ? goal_jaw_ : opening_) + command.jaw, /*is_move=*/false);
    default:
      return {ServoRefusal::kNotOffered};  // kState, kFree: not an arm's own
  }
}

void ServoTarget::hold() noexcept {
  servo(Motion::kHold);
  servos_jaw_ = moves_jaw_ = false;
}

void ServoTarget::servo(Motion motion) noexcept {
  motion_ = motion;
  move_count_ = 0;
}

ServoVerdict ServoTarget::takeJoints(const ServoJoints& joints) noexcept {
  ServoVerdict verdict = checkJoints(joints);
  if (verdict.reason == ServoRefusal::kNone) verdict = checkStep(joints);
  if (verdict.reason != ServoRefusal::kNone) return verdict;
  servo(Motion::kJoints);
  goal_q_ = withServoJoints(q_, joints);
  return {};
}

/** One that is relative counts from where the one before leads. */
ServoVerdict ServoTarget::takePose(const ServoCommand& command) noexcept {
  const Pose X = poseIn(command);
  if (command.kind == ServoKind::kServoPose) return takePose(X);
  const Pose& from = motion_ == Motion::kPose ? goal_X_ : X_;
  const Quaternion R_BT(X.R * from.R);
  return takePose(Pose{R_BT.normalized().toRotationMatrix(), from.p + X.p});
}

ServoVerdict ServoTarget::takePose(const Pose& X_BT) noexcept {
  const ServoVerdict verdict = checkStep(X_BT);
  if (verdict.reason != ServoRefusal::kNone) return verdict;
  JointArray q = q_;
  if (!reaches(X_, X_BT, &q)) return {ServoRefusal::kUnreachable};
  servo(Motion::kPose);
  goal_X_ = X_BT;
  return {};
}

ServoVerdict ServoTarget::takeTwist(const ServoCommand& command) noexcept {
  const Vector3 v = toEigen(command.v_B), w = toEigen(command.w_B);
  if (isPast(v.norm(), limits_.max_speed)) return {ServoRefusal::kTooFast, 0, 0, v.norm(), limits_.max_speed};
  if (isPast(w.norm(), limits_.max_turn_rate)) return {ServoRefusal::kTooFast, 0, 1, w.norm(), limits_.max_turn_rate};
  servo(Motion::kTwist);
  v_ = v;
  w_ = w;
  twist_left_ = twist_ticks_;
  return {};
}

/** Where the moves before it lead is where it starts. */
ServoVerdict ServoTarget::takeMove(const ServoCommand& command) noexcept {
  const std::size_t waiting = motion_ == Motion::kMove ? move_count_ : 0;
  if (waiting == kMoves) return {ServoRefusal::kQueueFull};
  const Pose from = waiting > 0 ? moves_[waiting - 1].X : X_;
  Move move;
  move.q = waiting > 0 ? moves_[waiting - 1].q : q_;
  move.in_joints = command.kind == ServoKind::kMoveJoints;
  if (move.in_joints) {
    const ServoVerdict verdict = checkJoints(command.joints);
    if (verdict.reason != ServoRefusal::kNone) return verdict;
    move.q = withServoJoints(move.q, command.joints);
    move.X = poseOf(move.q);
  } else {
    move.X = poseIn(command);
    if (!reaches(from, move.X, &move.q)) return {ServoRefusal::kUnreachable};
  }
  moves_[waiting] = move;
  move_count_ = waiting + 1;
  motion_ = Motion::kMove;
  if (waiting == 0) beginMove();
  return {};
}

/** The jaws are no arm's length: what leads them far is their range, and their rate is limited. */
ServoVerdict ServoTarget::takeJaw(double opening, bool is_move) noexcept {
  constexpr auto kJaws = static_cast<std::uint8_t>(kServoJointCount);
  if (opening < kMinOpening) return {ServoRefusal::kOutOfRange, kJaws, 1, opening, kMinOpening};
  if (opening > kMaxOpening) return {ServoRefusal::kOutOfRange, kJaws, 1, opening, kMaxOpening};
  servos_jaw_ = !is_move;
  moves_jaw_ = is_move;
  goal_jaw_ = opening;
  const double seconds = kPeakRate * std::abs(opening - opening_) / limits_.move_turn_rate;
  jaw_ = {opening_, opening, std::max(seconds, kShortestMove), 0};
  return {};
}

ServoVerdict ServoTarget::checkJoints(const ServoJoints& joints) const noexcept {
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const bool is_midline = j + 1 == kServoJointCount;  // which the robot holds against the lower one alone
    const double low = is_midline ? geometry_.q_min[kGrasp1] : geometry_.q_min[j];
    const double high = is_midline ? geometry_.q_max[kGrasp2] : geometry_.q_max[j];
    if (joints[j] >= low && joints[j] <= high) continue;
    const auto is_turn = static_cast<std::uint8_t>(j != kInsertion);
    return {ServoRefusal::kOutOfRange, static_cast<std::uint8_t>(j), is_turn, joints[j], joints[j] < low ? low : high};
  }
  return {};
}

ServoVerdict ServoTarget::checkStep(const ServoJoints& joints) const noexcept {
  const ServoJoints now = servoJoints(q_);
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const bool is_turn = j != kInsertion;
    const double step = std::abs(joints[j] - now[j]), limit = is_turn ? limits_.max_step_turn : limits_.max_step;
    if (isPast(step, limit))
      return {ServoRefusal::kTooFar, static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(is_turn), step, limit};
  }
  return checkStep(poseOf(withServoJoints(q_, joints)));
}

ServoVerdict ServoTarget::checkStep(const Pose& X_BT) const noexcept {
  const double step = distance(X_, X_BT), turn = turnBetween(X_BT.R, X_.R);
  if (isPast(step, limits_.max_step)) return {ServoRefusal::kTooFar, 0, 0, step, limits_.max_step};
  if (isPast(turn, limits_.max_step_turn)) return {ServoRefusal::kTooFar, 0, 1, turn, limits_.max_step_turn};
  return {};
}

/** Along the straight line. @param[in,out] q [rad; m] joints at its start, then at its end. */
bool ServoTarget::reaches(const Pose& from, const Pose& to, JointArray* q) const noexcept {
  const double wanted = std::max(distance(from, to) / kReachStep, turnBetween(to.R, from.R) / kReachTurn);
  const double steps = std::clamp(std::ceil(wanted), 1.0, kMostReachSteps);
  for (double i = 1.0; i <= steps; i += 1.0) {
    const auto ik = kinematics::inverseWithinLimits(geometry_, arm_, between(from, to, i / steps), opening_, *q);
    if (!isReached(ik.status)) return false;
    *q = ik.q;
  }
  return true;
}

// ---- a tick ------------------------------------------------------------------------------------------------------

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
  const ServoJoints from = servoJoints(q_), to = servoJoints(goal_q_);
  const double most = limits_.max_speed * kTickSeconds, most_turn = limits_.max_turn_rate * kTickSeconds;
  double share = 1.0;
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const double step = std::abs(to[j] - from[j]), limit = j == kInsertion ? most : most_turn;
    if (step > limit) share = std::min(share, limit / step);
  }
  const Pose before = poseOf(q_);
  JointArray q = q_;
  for (int attempt = 0; attempt < 2; ++attempt) {
    ServoJoints next = to;
    for (std::size_t j = 0; j < kServoJointCount && share < 1.0; ++j)
      next[j] = from[j] + share * (to[j] - from[j]);
    q = withServoJoints(q_, next);
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

void ServoTarget::stepTwist() noexcept {
  if (twist_left_-- <= 0) return servo(Motion::kHold);
  const Vector3 turn = w_ * kTickSeconds;
  Pose next{X_.R, X_.p + v_ * kTickSeconds};
  const double angle = turn.norm();
  if (angle > 0.0) {
    const Quaternion R_BT(Eigen::AngleAxisd(angle, turn / angle) * Quaternion(X_.R));
    next.R = R_BT.normalized().toRotationMatrix();
  }
  stepTo(next);
}

/** Stands where the way ends. */
void ServoTarget::stepTo(const Pose& X_BT) noexcept {
  const auto ik = kinematics::inverseWithinLimits(geometry_, arm_, X_BT, opening_, q_);
  if (!isReached(ik.status)) return servo(Motion::kHold);
  X_ = X_BT;
}

void ServoTarget::stepMove() noexcept {
  const Move& move = moves_[0];
  const double share = quinticBlend(static_cast<double>(++elapsed_) * kTickSeconds / duration_);
  if (move.in_joints) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      q_[j] = from_q_[j] + share * (move.q[j] - from_q_[j]);
    X_ = poseOf(q_);
  } else {
    X_ = between(from_X_, move.X, share);
  }
  if (share < 1.0) return;
  std::copy(moves_.begin() + 1, moves_.begin() + static_cast<std::ptrdiff_t>(move_count_), moves_.begin());
  if (--move_count_ == 0) return servo(Motion::kHold);
  beginMove();
}

void ServoTarget::beginMove() noexcept {
  from_X_ = X_;
  from_q_ = q_;
  elapsed_ = 0;
  duration_ = duration(moves_[0]);
}

/** [s] so that neither the tip nor a joint is faster than a move may be. */
double ServoTarget::duration(const Move& move) const noexcept {
  double mean =
      std::max(distance(move.X, X_) / limits_.move_speed, turnBetween(move.X.R, X_.R) / limits_.move_turn_rate);
  if (move.in_joints) {
    const ServoJoints from = servoJoints(q_), to = servoJoints(move.q);
    for (std::size_t j = 0; j < kServoJointCount; ++j)
      mean =
          std::max(mean, std::abs(to[j] - from[j]) / (j == kInsertion ? limits_.move_speed : limits_.move_turn_rate));
    Pose before = poseOf(q_);
    for (int i = 1; i <= kTipSamples; ++i) {
      ServoJoints on_way{};
      for (std::size_t j = 0; j < kServoJointCount; ++j)
        on_way[j] = from[j] + (to[j] - from[j]) * i / kTipSamples;
      const Pose X = poseOf(withServoJoints(q_, on_way));
      mean = std::max({mean, kTipSamples * distance(X, before) / limits_.move_speed,
                       kTipSamples * turnBetween(X.R, before.R) / limits_.move_turn_rate});
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
