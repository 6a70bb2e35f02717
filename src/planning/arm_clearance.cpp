#include "planning/arm_clearance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::planning {
namespace {

/** [m] Nearer than this is touching: FCL's iteration ends within 1e-6 of the answer. */
constexpr double kTouch = 2e-6;
constexpr double kLeastStep = 5e-4;  // [m] of sphere stepping; where it would have to be shorter, exact distances
constexpr double kNearby = 4e-3;     // [m] nearer than this interpolation is worth its eight reads
constexpr double kShare = 0.7;       // [-] of the room at a point, asked for along the whole axis
constexpr double kHope = 0.7;        // [-] of a ball's radius, beyond which the next point is looked at
constexpr double kMiddle = 0.15;     // [m] axes shorter than this are first looked at from their middle
constexpr int kIntervals = 64;       // bisection halves the rest each time: 2^64 is more than a double can distinguish

/** The order in which shapes are judged, by joint, the shaft's first: what collides most comes first. */
constexpr std::array<Joint, 6> kAfterShaft{kWrist, kGrasp1, kGrasp2, kInsertion, kElbow, kShoulder};

}  // namespace

double ArmClearance::Reach::cap(double speed) const noexcept {
  return kTouch + speed * value;
}

bool ArmClearance::Reach::take(double margin, double speed) noexcept {
  if (!(margin >= kTouch)) return false;
  if (margin < cap(speed)) value = (margin - kTouch) / speed;
  return true;
}

void ArmClearance::ask(const JointArray& u) noexcept {
  ++question_;
  u_ = u;
  chain_.placeShaft(u_, &X_WJ_);
  chain_.placeTool(u_, &X_WJ_);
}

double ArmClearance::closestToFixed(int joint, const JointArray& u) noexcept {
  ask(u);
  double closest = kTableCap;
  for (const std::size_t i : groups_[static_cast<std::size_t>(joint)].shapes)
    closest = std::min(closest, marginToFixed(i, kTableCap));
  return closest;
}

double ArmClearance::closestToOther(int joint, const JointArray& u) noexcept {
  ask(u);
  double closest = kTableCap;
  for (const std::size_t i : groups_[static_cast<std::size_t>(joint)].shapes)
    for (const OtherShape& other : others_)
      closest = std::min(closest, marginToOther(i, other, closest));
  return closest;
}

/** From the memo of shoulder or elbow; what it does not know yet is found out and the question taken up again. */
double ArmClearance::recalledMargin(int joint) noexcept {
  const JointArray asked = u_;
  const std::uint64_t before = question_;
  const auto find = [&](double s, double e) { return closestToOther(joint, {s, e}); };
  double margin = -1.0;
  if (joint == static_cast<int>(kShoulder)) margin = shoulder_memo_.recall(asked[kShoulder], 0.0, find);
  if (joint == static_cast<int>(kElbow)) margin = elbow_memo_.recall(asked[kShoulder], asked[kElbow], find);
  if (question_ != before) ask(asked);
  return margin;
}

double ArmClearance::closestToSelf(const Solid& tool_J, const JointArray& u) noexcept {
  ask(u);
  double closest = kTableCap;
  for (const SelfGroup& group : self_groups_) {
    if (!group.tabled) continue;
    for (const SelfPair& pair : group.pairs) {
      const double margin =
          group.outer < static_cast<int>(kWrist)
              ? marginToSelf(pair, kTableCap)
              : signedDistance(inWorld(pair.inner, shapes_[pair.inner].solid_J), X_WJ_[kWrist].p) - tool_J.radius;
      closest = std::min(closest, margin);
    }
  }
  return closest;
}

void ArmClearance::placeOther(const JointArray& other) noexcept {
  other_known_ = isSound(other);
  if (!other_known_) return;
  shoulder_memo_.forget();
  elbow_memo_.forget();
  ArmChain::Frames X_WJ;
  const JointArray u = other_chain_.positions(other);
  other_chain_.placeShaft(u, &X_WJ);
  other_chain_.placeTool(u, &X_WJ);
  for (OtherShape& shape : others_) {
    shape.solid = moved(shape.solid_J, X_WJ[static_cast<std::size_t>(shape.joint)]);
    shape.bounds = Bounds::around(shape.solid.axis, shape.solid.radius);
  }
  for (OtherGroup& group : other_groups_) {
    group.bounds = others_[group.begin].bounds;
    for (std::size_t k = group.begin; k < group.end; ++k)
      group.bounds.add(others_[k].bounds);
    if (group.begin == 0) other_bounds_ = group.bounds;
    other_bounds_.add(group.bounds);
  }
}

bool ArmClearance::isFree(const JointArray& q) noexcept {
  return reachAt(q, still_, 1.0) >= 0.0;
}

double ArmClearance::clearance(const JointArray& q, double cap) noexcept {
  const double beyond = reachAt(q, unit_, std::max(0.0, cap - clearance_));
  return beyond >= 0.0 ? std::min(cap, clearance_ + beyond) : 0.0;
}

double ArmClearance::reachAt(const JointArray& q, const Motion& motion, double most) noexcept {
  if (!other_known_ || !isSound(q)) return -1.0;
  Reach reach{most};
  ++question_;
  u_ = chain_.positions(q);
  chain_.placeShaft(u_, &X_WJ_);
  if (!judgeJoint(kToolRotation, motion, &reach)) return -1.0;
  chain_.placeTool(u_, &X_WJ_);
  for (const Joint joint : kAfterShaft)
    if (!judgeJoint(joint, motion, &reach)) return -1.0;
  return judgeSelf(motion, &reach) ? reach.value : -1.0;
}

bool ArmClearance::judgeJoint(int joint, const Motion& motion, Reach* reach) noexcept {
  if (groups_[static_cast<std::size_t>(joint)].shapes.empty()) return true;
  if (!judgeFixed(joint, motion, reach)) return false;
  bound(joint);
  return judgeOthers(joint, motion, reach);
}

double ArmClearance::tabledMargin(int joint) const noexcept {
  if (joint == static_cast<int>(kShoulder)) return shoulder_table_.at(u_[kShoulder], 0.0);
  if (joint == static_cast<int>(kElbow)) return elbow_table_.at(u_[kShoulder], u_[kElbow]);
  return -1.0;
}

bool ArmClearance::judgeFixed(int joint, const Motion& motion, Reach* reach) noexcept {
  const auto group = static_cast<std::size_t>(joint);
  if (tabledMargin(joint) >= reach->cap(motion.group[group][0])) return true;
  for (const std::size_t i : groups_[group].shapes) {
    const double speed = motion.shape[i][0];
    if (!reach->take(marginToFixed(i, reach->cap(speed)), speed)) return false;
  }
  return true;
}

/** Sets the box around a joint's shapes: around their ball where they are many and not placed yet. */
void ArmClearance::bound(int joint) noexcept {
  Group& group = groups_[static_cast<std::size_t>(joint)];
  if (joint < static_cast<int>(kInsertion)) {
    const Vector3 centre = X_WJ_[static_cast<std::size_t>(joint)] * group.centre_J.a;
    group.bounds = Bounds::around({centre, centre}, group.radius);
    return;
  }
  group.bounds = place(group.shapes.front()).bounds;
  for (const std::size_t i : group.shapes)
    group.bounds.add(place(i).bounds);
}

bool ArmClearance::judgeOthers(int joint, const Motion& motion, Reach* reach) noexcept {
  const auto group = static_cast<std::size_t>(joint);
  const double speed = motion.group[group][0];
  const Bounds& mine = groups_[group].bounds;
  if (apart(mine, other_bounds_, reach->cap(speed)) || recalledMargin(joint) >= reach->cap(speed)) return true;
  for (const OtherGroup& other : other_groups_) {
    if (apart(mine, other.bounds, reach->cap(speed))) continue;
    if (!judgeOtherGroup(joint, other, speed, reach)) return false;
  }
  return true;
}

bool ArmClearance::judgeOtherGroup(int joint, const OtherGroup& other, double speed, Reach* reach) noexcept {
  for (const std::size_t i : groups_[static_cast<std::size_t>(joint)].shapes) {
    if (apart(place(i).bounds, other.bounds, reach->cap(speed))) continue;
    for (std::size_t k = other.begin; k < other.end; ++k)
      if (!reach->take(marginToOther(i, others_[k], reach->cap(speed)), speed)) return false;
  }
  return true;
}

double ArmClearance::speedOf(const SelfGroup& group, const Motion& motion) const noexcept {
  const double outer = motion.group[static_cast<std::size_t>(group.outer)][group.from];
  return group.branched ? outer + motion.group[static_cast<std::size_t>(group.inner)][0] : outer;
}

bool ArmClearance::judgeSelf(const Motion& motion, Reach* reach) noexcept {
  const bool clear = self_table_.at(u_[kElbow], u_[kInsertion]) >= reach->cap(motion.self);
  for (const SelfGroup& group : self_groups_)
    if (!(clear && group.tabled) && !judgeSelfGroup(group, motion, reach)) return false;
  return true;
}

bool ArmClearance::judgeSelfGroup(const SelfGroup& group, const Motion& motion, Reach* reach) noexcept {
  const double speed = speedOf(group, motion);
  const Bounds &inner = groups_[static_cast<std::size_t>(group.inner)].bounds,
               &outer = groups_[static_cast<std::size_t>(group.outer)].bounds;
  if (apart(inner, outer, reach->cap(speed))) return true;
  for (const SelfPair& pair : group.pairs)
    if (!reach->take(marginToSelf(pair, reach->cap(speed)), speed)) return false;
  return true;
}

const ArmClearance::Placed& ArmClearance::place(std::size_t i) noexcept {
  Placed& placed = placed_[i];
  if (placed.question == question_) return placed;
  const Pose& X = X_WJ_[static_cast<std::size_t>(shapes_[i].joint)];
  const Solid& solid = shapes_[i].solid_J;
  placed.question = question_;
  placed.axis = {X * solid.axis.a, X * solid.axis.b};
  placed.bounds = Bounds::around(placed.axis, solid.radius);
  return placed;
}

Solid ArmClearance::inWorld(std::size_t i, const Solid& solid_J) const noexcept {
  return moved(solid_J, X_WJ_[static_cast<std::size_t>(shapes_[i].joint)]);
}

double ArmClearance::marginToOther(std::size_t i, const OtherShape& other, double cap) noexcept {
  const Placed& mine = place(i);
  if (apart(mine.bounds, other.bounds, cap)) return cap;
  const Solid& solid_J = shapes_[i].solid_J;
  const double margin = std::sqrt(squaredDistance(mine.axis, other.solid.axis)) - solid_J.radius - other.solid.radius;
  if (margin >= cap || (solid_J.round && other.solid.round)) return margin;
  return std::max(margin, separation(inWorld(i, solid_J), other.solid));
}

double ArmClearance::marginToSelf(const SelfPair& pair, double cap) noexcept {
  const Solid &grown = shapes_[pair.inner].solid_J, &bare = shapes_[pair.outer].bare_J;
  const Placed &inner = place(pair.inner), &outer = place(pair.outer);
  if (apart(inner.bounds, outer.bounds, cap)) return cap;  // the outer one's hold its grown shape: wide enough
  const double margin = std::sqrt(squaredDistance(inner.axis, outer.axis)) - grown.radius - bare.radius;
  if (margin >= cap || (grown.round && bare.round)) return margin;
  return std::max(margin, separation(inWorld(pair.inner, grown), inWorld(pair.outer, bare)));
}

double ArmClearance::marginToFixed(std::size_t i, double cap) noexcept {
  return shapes_[i].on_grid ? marginOnGrid(i, cap) : exactMarginToFixed(i, cap);
}

/**
 * Sphere stepping: around a point of the axis at a distance d from anything, all points within d - radius - margin keep
 * the margin. The next point is looked at farther on than that, in the hope that its ball reaches back; if not, at the
 * ball's end. Where balls get small the margin asked for is lowered; where that does not help, the exact distance is
 * taken.
 */
double ArmClearance::marginOnGrid(std::size_t i, double cap) noexcept {
  const Segment& axis = place(i).axis;
  const Shape& shape = shapes_[i];
  const double length = shape.length, radius = shape.solid_J.radius;
  const Vector3 along = (axis.b - axis.a) / std::max(length, kOnAxis);
  double margin = cap, covered = 0.0, ahead = length < kMiddle ? length / 2 : 0.0;
  do {
    const double s = std::min(covered + ahead, length);
    const Vector3 p = axis.a + s * along;
    const DistanceBounds distance = grid_.at(p, radius + margin + kNearby);
    if (distance.upper < shape.inner && s >= shape.inset && s <= length - shape.inset) return -1.0;
    const double room = distance.lower - radius;
    if (room - margin >= std::max(s - covered, kLeastStep)) {
      ahead = kHope * (room - margin);
      covered = s + (room - margin);
    } else if (ahead > 0.0) {
      ahead = 0.0;
    } else {
      margin = std::min(margin, kShare * room);
      if (room - margin < kLeastStep) return exactMarginToFixed(i, cap);
    }
  } while (covered < length);
  return margin;
}

double ArmClearance::exactMarginToFixed(std::size_t i, double cap) noexcept {
  const Placed& mine = place(i);
  const Solid solid = inWorld(i, shapes_[i].solid_J);
  double margin = cap;
  for (const int k : shapes_[i].obstacles) {
    const auto index = static_cast<std::size_t>(k);
    if (apart(mine.bounds, obstacle_bounds_[index], margin)) continue;
    const Solid& obstacle = grid_.obstacles()[index];
    double gap = std::sqrt(squaredDistance(mine.axis, obstacle.axis)) - solid.radius - obstacle.radius;
    if (gap < margin && !(solid.round && obstacle.round)) gap = std::max(gap, separation(solid, obstacle));
    margin = std::min(margin, gap);
    if (margin < kTouch) break;
  }
  return margin;
}

void ArmClearance::motionAlong(const JointArray& a, const JointArray& b, Motion* motion) const noexcept {
  const double insertion_a = chain_.positions(a)[kInsertion], insertion_b = chain_.positions(b)[kInsertion];
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    const Levers levers = shapes_[i].motion.levers(insertion_a, insertion_b);
    Speeds& speeds = motion->shape[i];
    speeds[kJointCount] = 0.0;
    for (std::size_t j = kJointCount; j-- > 0;)
      speeds[j] = speeds[j + 1] + levers[j] * std::abs(b[j] - a[j]);
  }
  sumUp(motion);
}

void ArmClearance::sumUp(Motion* motion) const noexcept {
  motion->self = motion->fastest = 0.0;
  for (std::size_t group = 0; group < kJointCount; ++group) {
    motion->group[group].fill(0.0);
    for (const std::size_t i : groups_[group].shapes)
      for (std::size_t j = 0; j <= kJointCount; ++j)
        motion->group[group][j] = std::max(motion->group[group][j], motion->shape[i][j]);
    motion->fastest = std::max(motion->fastest, motion->group[group][0]);
  }
  for (const SelfGroup& group : self_groups_)
    if (group.tabled) motion->self = std::max(motion->self, speedOf(group, *motion));
}

bool ArmClearance::isEdgeFree(const JointArray& a, const JointArray& b) noexcept {
  if (!isSound(a) || !isSound(b)) return false;
  motionAlong(a, b, &edge_);
  std::array<std::pair<double, double>, kIntervals> open;
  std::size_t count = 0;
  open[count++] = {0.0, 1.0};
  while (count > 0) {
    const auto [low, high] = open[--count];
    const double middle = (low + high) / 2, half = (high - low) / 2;
    JointArray q;
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] = a[j] + middle * (b[j] - a[j]);
    const double reach = reachAt(q, edge_, half);
    if (reach >= half) continue;
    if (reach * edge_.fastest < kLeastMargin || count + 2 > open.size()) return false;
    open[count++] = {middle + reach, high};
    open[count++] = {low, middle - reach};
  }
  return true;
}

}  // namespace raven2_trainer::planning
