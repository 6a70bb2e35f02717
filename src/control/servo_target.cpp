#include "raven2_trainer/control/servo_target.h"

#include <algorithm>
#include <cmath>

#include "control/servo_math.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::control {
namespace {

constexpr double kNormError = 0.02;    // of a quaternion, as ITP's receivers allow (sources.md 2.2)
constexpr double kLeastRatio = 0.001;  // below it a move takes hours

// A set point farther than this from the mapping's result was not accepted: a limit, or a fault in between.
// The mapping rounds to half a micrometre and half a milliradian of the jaws.
constexpr double kLeash = 1e-4;      // [m]
constexpr double kLeashTurn = 1e-3;  // [rad]
constexpr double kLeashJaw = 0.02;   // [rad]

// [rad] Clients of a dVRK squeeze with goals beyond closed: -20 degrees in dvrk_python, -34 in others. Farther is a
// mistake.
constexpr double kSqueezed = -60.0 * kPi / 180.0;

// Between poses looked at on a straight line: one of them is near enough to the next for the robot's choice of a
// solution, which takes 17 mm of insertion for too far (raven2.md 2.5).
constexpr double kReachStep = 0.01;     // [m]
constexpr double kReachTurn = 0.2;      // [rad]
constexpr double kMostReachSteps = 64;  // 0.64 m: farther than an arm reaches
constexpr double kMostJointSteps = 32;  // 0.33 m of insertion and 364 degrees of roll: all that arms.yaml allows

constexpr double kSameJoint = 1e-3;  // [rad; m] at the end of a path in joints: another solution is farther away

template <std::size_t N>
bool areFinite(const std::array<double, N>& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool isTurn(const Quat& q) noexcept {
  return areFinite(q) && std::abs(toEigen(q).norm() - 1.0) <= kNormError;
}

bool isPast(double value, double limit) noexcept {
  return value > limit * (1.0 + 1e-9);  // what was computed to be at the limit is
}

/** Fields that `kind` does not use may be anything. */
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
    case ServoKind::kMoveJawBy:
      return std::isfinite(c.jaw);
    case ServoKind::kServoRates:
    case ServoKind::kMoveJointsBy:
      return areFinite(c.joints);
    case ServoKind::kRatio:
      return std::isfinite(c.number);
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

/** [rad; m] Between two arms' joints, the largest difference. */
double farthest(const JointArray& a, const JointArray& b) noexcept {
  double most = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    most = std::max(most, std::abs(a[j] - b[j]));
  return most;
}

ServoJoints withShoulder(ServoJoints joints, const ServoCommand& command) noexcept {
  joints.front() = command.joints.front();
  return joints;
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
    : limits_(limits), geometry_(geometry), arm_(arm), twist_ticks_(toTicks(twistTimeout(limits))) {
  startFrom(poseOf(geometry.home), geometry.home, kinematics::jawOpening(geometry.home));
}

void ServoTarget::startFrom(const Pose& X_BT, const JointArray& q, double opening) noexcept {
  startFrom(X_BT, q);
  opening_ = std::clamp(opening, kMinOpening, kMaxOpening);
  if (moves_jaw_) beginJaw(jaw_.to);
}

void ServoTarget::startFrom(const Pose& X_BT, const JointArray& q) noexcept {
  X_ = X_BT;
  q_ = q;
  if (motion_ == Motion::kMove) beginMove();
  if (isServoTooFar()) servo(Motion::kHold);
}

/** Where the arm was taken elsewhere meanwhile, a servo command leads farther than it may. */
bool ServoTarget::isServoTooFar() const noexcept {
  if (motion_ == Motion::kJoints) return checkStep(servoJoints(goal_q_)).reason != ServoRefusal::kNone;
  return motion_ == Motion::kPose && checkStep(goal_X_).reason != ServoRefusal::kNone;
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
      return takeJoints(command.is_shoulder != 0 ? withShoulder(servoJoints(joints_from), command) : command.joints);
    case ServoKind::kServoJointsBy:
      return takeJoints(sum(servoJoints(joints_from), command.joints));
    case ServoKind::kServoPose:
    case ServoKind::kServoPoseBy:
      return takePose(command);
    case ServoKind::kServoTwist:
      return takeTwist(command);
    case ServoKind::kServoRates:
      return takeRates(command.joints);
    case ServoKind::kMoveJoints:
    case ServoKind::kMoveJointsBy:
    case ServoKind::kMovePose:
      return takeMove(command);
    case ServoKind::kServoJaw:
    case ServoKind::kMoveJaw:
    case ServoKind::kServoJawBy:
    case ServoKind::kMoveJawBy:
      return takeJawCommand(command);
    case ServoKind::kRatio:
      return takeRatio(command.number);
    case ServoKind::kEndTwist:
      return endLasting(Motion::kTwist);
    case ServoKind::kEndRates:
      return endLasting(Motion::kRates);
    case ServoKind::kEndForces:
      return {};  // no force acts here
    default:
      return {ServoRefusal::kNotOffered};  // kState, kFree, forces: not an arm's own
  }
}

ServoVerdict ServoTarget::takeJawCommand(const ServoCommand& command) noexcept {
  switch (command.kind) {
    case ServoKind::kServoJawBy:
      return takeJaw((servos_jaw_ ? goal_jaw_ : opening_) + command.jaw, /*is_move=*/false);
    case ServoKind::kMoveJawBy:
      return takeJaw((servos_jaw_ || moves_jaw_ ? goal_jaw_ : opening_) + command.jaw, /*is_move=*/true);
    default:
      return takeJaw(command.jaw < kMinOpening && command.jaw >= kSqueezed ? kMinOpening : command.jaw,
                     command.kind == ServoKind::kMoveJaw);
  }
}

/** The arm slows down, if this is its motion. */
ServoVerdict ServoTarget::endLasting(Motion motion) noexcept {
  if (motion_ == motion) twist_left_ = std::min<Tick>(twist_left_, -1);
  return {};
}

void ServoTarget::hold() noexcept {
  holdArm();
  holdJaw();
}

void ServoTarget::servo(Motion motion) noexcept {
  motion_ = motion;
  move_count_ = 0;
}

/** The path of a motion that was accepted is looked at in steps of kReachStep: it may end between two of them. */
void ServoTarget::endEarly() noexcept {
  servo(Motion::kHold);
  ++ended_;
}

ServoVerdict ServoTarget::takeJoints(const ServoJoints& wanted) noexcept {
  ServoJoints joints = wanted;
  ServoVerdict verdict = fitJoints(&joints);
  if (verdict.reason == ServoRefusal::kNone) verdict = checkStep(joints);
  if (verdict.reason != ServoRefusal::kNone) return verdict;
  const JointArray to = withServoJoints(q_, joints);
  if (!reaches(q_, to)) return {ServoRefusal::kUnreachable};
  servo(Motion::kJoints);
  goal_q_ = to;
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
  Pose to = X_BT;
  if (!reaches(X_, &to, &q)) return {ServoRefusal::kUnreachable};
  servo(Motion::kPose);
  goal_X_ = to;
  return {};
}

ServoVerdict ServoTarget::takeTwist(const ServoCommand& command) noexcept {
  const Vector3 v = toEigen(command.v_B), w = toEigen(command.w_B);
  if (isPast(v.norm(), limits_.max_speed)) return {ServoRefusal::kTooFast, 0, 0, v.norm(), limits_.max_speed};
  if (isPast(w.norm(), limits_.max_turn_rate)) return {ServoRefusal::kTooFast, 0, 1, w.norm(), limits_.max_turn_rate};
  servo(v.isZero(0.0) && w.isZero(0.0) ? Motion::kHold : Motion::kTwist);
  v_ = v;
  w_ = w;
  twist_left_ = twist_ticks_;
  return {};
}

ServoVerdict ServoTarget::takeRates(const ServoJoints& rates) noexcept {
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const bool is_turn = j != kInsertion;
    const double limit = is_turn ? limits_.max_turn_rate : limits_.max_speed;
    if (isPast(std::abs(rates[j]), limit))
      return {ServoRefusal::kTooFast, static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(is_turn),
              std::abs(rates[j]), limit};
  }
  servo(rates == ServoJoints{} ? Motion::kHold : Motion::kRates);
  rates_ = rates;
  twist_left_ = twist_ticks_;
  return {};
}

ServoVerdict ServoTarget::takeRatio(double ratio) noexcept {
  if (ratio < kLeastRatio || ratio > 1.0) return {ServoRefusal::kNoRatio, 0, 0, ratio, ratio > 1.0 ? 1.0 : kLeastRatio};
  ratio_ = ratio;
  return {};
}

/** Where the moves before it lead is where it starts. */
ServoVerdict ServoTarget::takeMove(const ServoCommand& command) noexcept {
  const std::size_t waiting = motion_ == Motion::kMove ? move_count_ : 0;
  if (waiting == kMoves) return {ServoRefusal::kQueueFull};
  const Pose from = waiting > 0 ? moves_[waiting - 1].X : X_;
  Move move;
  move.q = waiting > 0 ? moves_[waiting - 1].q : q_;
  move.in_joints = command.kind != ServoKind::kMovePose;
  if (move.in_joints) {
    const bool is_by = command.kind == ServoKind::kMoveJointsBy;
    const ServoJoints from_q = servoJoints(motion_ == Motion::kJoints ? goal_q_ : move.q);
    ServoJoints joints = is_by ? sum(from_q, command.joints) : command.joints;
    const ServoVerdict verdict = fitJoints(&joints);
    if (verdict.reason != ServoRefusal::kNone) return verdict;
    const JointArray to = withServoJoints(move.q, joints);
    if (!reaches(move.q, to)) return {ServoRefusal::kUnreachable};
    move.q = to;
    move.X = poseOf(to);
  } else {
    move.X = poseIn(command);
    if (!reaches(from, &move.X, &move.q)) return {ServoRefusal::kUnreachable};
  }
  moves_[waiting] = move;
  move_count_ = waiting + 1;
  motion_ = Motion::kMove;
  ++moved_;
  if (waiting == 0) beginMove();
  return {};
}

/** The jaws are no arm's length: what leads them far is their range, and their rate is limited. */
ServoVerdict ServoTarget::takeJaw(double opening, bool is_move) noexcept {
  constexpr auto kJaws = static_cast<std::uint8_t>(kServoJointCount);
  opening = ontoLimit(opening, kMinOpening, kMaxOpening);
  if (opening < kMinOpening) return {ServoRefusal::kOutOfRange, kJaws, 1, opening, kMinOpening};
  if (opening > kMaxOpening) return {ServoRefusal::kOutOfRange, kJaws, 1, opening, kMaxOpening};
  servos_jaw_ = !is_move;
  moves_jaw_ = is_move;
  moved_ += is_move ? 1 : 0;
  goal_jaw_ = opening;
  beginJaw(opening);
  return {};
}

void ServoTarget::beginJaw(double to) noexcept {
  const double seconds = kPeakRate * std::abs(to - opening_) / (ratio_ * limits_.move_turn_rate);
  jaw_ = {opening_, to, std::max(seconds, kShortestMove), 0};
}

/** Puts joints that are hardly beyond their limits onto them. A client that commands one joint, or sends a published
 * set point back, would otherwise be refused at a limit. */
ServoVerdict ServoTarget::fitJoints(ServoJoints* joints) const noexcept {
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const bool is_midline = j + 1 == kServoJointCount;  // which the robot holds against the lower one alone
    const double low = is_midline ? geometry_.q_min[kGrasp1] : geometry_.q_min[j];
    const double high = is_midline ? geometry_.q_max[kGrasp2] : geometry_.q_max[j];
    double& value = (*joints)[j];
    value = ontoLimit(value, low, high);
    if (value >= low && value <= high) continue;
    const auto is_turn = static_cast<std::uint8_t>(j != kInsertion);
    return {ServoRefusal::kOutOfRange, static_cast<std::uint8_t>(j), is_turn, value, value < low ? low : high};
  }
  return {};
}

bool ServoTarget::areWithinLimits(const ServoJoints& joints) const noexcept {
  ServoJoints fitted = joints;
  return fitJoints(&fitted).reason == ServoRefusal::kNone && fitted == joints;
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

/** Along the straight line. @param[in,out] to one that is hardly beyond a joint's limit becomes the pose at the limit.
 *  @param[in,out] q [rad; m] joints at its start, then at its end. */
bool ServoTarget::reaches(const Pose& from, Pose* to, JointArray* q) const noexcept {
  const double wanted = std::max(distance(from, *to) / kReachStep, turnBetween(to->R, from.R) / kReachTurn);
  const double steps = std::clamp(std::ceil(wanted), 1.0, kMostReachSteps);
  JointArray start = *q;
  std::optional<double> beyond = solve(from, &start);
  const double most_beyond = std::min(beyond.value_or(0.0), kBeyondLimit) + kLimitRounding;  // as stepAlong()
  for (double i = 1.0; i <= steps; i += 1.0) {
    beyond = solve(between(from, *to, i / steps), q);
    if (!beyond || *beyond > (i < steps ? most_beyond : kBeyondLimit)) return false;
  }
  if (*beyond > 0.0) *to = poseOf(*q);
  return true;
}

/** The same in joints: the arm receives poses, so each must lead back to joints, and the last one to the requested
 * ones. */
bool ServoTarget::reaches(const JointArray& from, const JointArray& to) const noexcept {
  const ServoJoints begin = servoJoints(from), end = servoJoints(to);
  double wanted = 1.0;
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    wanted = std::max(wanted, std::abs(end[j] - begin[j]) / (j == kInsertion ? kReachStep : kReachTurn));
  const double steps = std::min(std::ceil(wanted), kMostJointSteps);
  JointArray q = from;
  for (double i = 0.0; i <= steps; i += 1.0) {
    if (!solve(poseOf(withServoJoints(from, between(begin, end, i / steps))), &q)) return false;
  }
  const ServoJoints reached = servoJoints(q);
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    if (std::abs(reached[j] - end[j]) > kSameJoint) return false;
  }
  return true;
}

/** Joints within their limits for a pose, near those given: by the model's inverse, where the robot's has any.
 *  @param[in,out] q [rad; m] unchanged without a solution.
 *  @return [rad; m] how far the solution was beyond the limits; nothing without a solution. */
std::optional<double> ServoTarget::solve(const Pose& X_BT, JointArray* q) const noexcept {
  if (kinematics::isFirstWristPointAtRcm(geometry_, X_BT)) return std::nullopt;
  const auto ik = kinematics::inverse(geometry_, arm_, X_BT, opening_, *q);
  if (!kinematics::isUsable(ik.status)) return std::nullopt;
  *q = ik.q;
  return kinematics::applyJointLimits(geometry_, q) ? farthest(ik.q, *q) : 0.0;
}

/** A pose that is hardly beyond a joint's limit becomes the pose at the limit. */
Pose ServoTarget::ontoLimits(const Pose& X_BT) const noexcept {
  JointArray q = q_;
  const auto beyond = solve(X_BT, &q);
  return beyond && *beyond > 0.0 && *beyond <= kBeyondLimit ? poseOf(q) : X_BT;
}

}  // namespace raven2_trainer::control
