#include "grip_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/shortest_turn.h"
#include "tool_hand.h"

namespace raven2_trainer::console {
namespace {

constexpr double kWireStep = 0.001;                     ///< [m]
constexpr double kMaxJointStep = 0.5;                   ///< [rad] in one such step: farther is a jump to another branch
constexpr double kInsertionScale = 8.7;                 ///< [rad/m] 16 mm of insertion are as far as 8 degrees
constexpr double kOutOfReach = -2.0, kNotThere = -1.0;  ///< scores of a ring that cannot be taken, or not carried so
constexpr double kBlocked = 100.0;                      ///< [-] by which a score shrinks for each blocked place
constexpr double kOverAll = 0.016;      ///< [m] of a tool's pivot over what it passes: jaws, and room for them
constexpr double kPlentyMargin = 0.35;  ///< [rad] more is no better

// Turns of the ring from the heading it has, the nearest first.
constexpr std::array<double, 7> kSpins{0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2};
constexpr std::array<double, 5> kLeans{0.17, 0.0, 0.52, 0.79, 1.05};  ///< [rad]

// On a bar, the jaws reach 9.9 mm beyond their pivot, and shall keep off what the ring may lie on.
constexpr double kJawsReach = 0.0099, kGripOffFloor = 0.0008;  ///< [m]
constexpr double kGripReach = 0.0075, kFarReach = 0.0092;      ///< [m] pivot to bar

/** W from B: rotations from ITP axes, remote centre. */
Pose baseInWorld(const ArmsConfig& arms, Arm arm) noexcept {
  Pose X_WB;
  const Matrix3 R_IB = control::itpToBase(arm).transpose();
  for (int i = 0; i < 3; ++i)
    X_WB.R.col(i) = worldToItp(R_IB.col(i));
  X_WB.p = toEigen(at(arms.rcm_W, arm));
  return X_WB;
}

double marginOf(const ArmGeometry& geometry, const JointArray& q) noexcept {
  double least = 1e9;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double scale = j == kInsertion ? kInsertionScale : 1.0;
    least = std::min({least, scale * (q[j] - geometry.q_min[j]), scale * (geometry.q_max[j] - q[j])});
  }
  return least;
}

bool jumps(const JointArray& from, const JointArray& to) noexcept {
  for (std::size_t j = 0; j <= kWrist; ++j) {
    const double scale = j == kInsertion ? kInsertionScale : 1.0;
    if (scale * std::abs(to[j] - from[j]) > kMaxJointStep) return true;
  }
  return std::abs(kinematics::jawMidline(to) - kinematics::jawMidline(from)) > kMaxJointStep;
}

double reachFor(double above_floor) noexcept {
  return std::clamp(kJawsReach + kGripOffFloor - above_floor, kGripReach, kFarReach);
}

Pose raisedTo(Pose X_WT, double height) noexcept {
  X_WT.p.z() = std::max(X_WT.p.z(), height);
  return X_WT;
}

/** Ways to try, the shortest first, each but for its end. */
std::vector<std::vector<Pose>> waysBetween(const Pose& from,
                                           const Pose& to,
                                           const Surroundings& around,
                                           const std::optional<Pose>& X_WT_start) {
  double top = around.floor;
  for (const Capsule& solid : around.solids)
    top = std::max({top, solid.a.z() + solid.radius, solid.b.z() + solid.radius});
  const Pose up = raisedTo(from, top + kOverAll), over = raisedTo(to, top + kOverAll);
  std::vector<std::vector<Pose>> ways{{}, {over}, {up, over}};
  if (!X_WT_start) return ways;
  for (const std::vector<Pose>& way : {std::vector<Pose>{*X_WT_start}, {up, *X_WT_start}, {up, *X_WT_start, over}})
    ways.push_back(way);
  return ways;
}

std::vector<Grip> candidates(const SceneObject& ring, double reach) {
  std::vector<Grip> grips;
  const int azimuths = ring.square != 0 ? 4 : 24;
  // The support or peg of a square ring may reach under the middle of its bars: 1.25 mm are left between a rib of 3 mm
  // and a jaw of 3.6 mm. Aims err by half a millimetre, tools by 0.3 mm, and jaws that close turn the ring a little.
  const double offset = 0.65 * ring.inner_radius;
  const std::vector<double> along = ring.square != 0 ? std::vector<double>{-offset, offset} : std::vector<double>{0.0};
  for (const double lean : kLeans) {
    for (int i = 0; i < azimuths; ++i) {
      const double azimuth = 2.0 * kPi * i / azimuths;
      for (const double place : along) {
        for (const bool turned : {false, true})
          grips.push_back({{std::cos(azimuth), std::sin(azimuth), 0.0}, turned, place, lean, reach});
      }
    }
  }
  return grips;
}

/** Axis of a ring on a wire that goes there. */
Vector3 axisOn(const Vector3& along) noexcept {
  const Vector3 up = Vector3::UnitZ(), t = along.normalized(), across = t.cross(up);
  if (across.norm() < 1e-6) return t;
  const double angle = std::atan2(across.norm(), t.dot(up));
  return Eigen::AngleAxisd(std::min(kWireLean, angle), across.normalized()) * t;
}

/** A millimetre apart on a Catmull-Rom curve through the points. */
std::vector<Vector3> smooth(const std::vector<Vector3>& points) {
  std::vector<Vector3> line;
  const std::size_t last = points.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    const Vector3 &a = points[i > 0 ? i - 1 : 0], &b = points[i], &c = points[i + 1],
                  &d = points[std::min(i + 2, last)];
    const int parts = std::max(1, static_cast<int>((c - b).norm() / kWireStep));
    for (int k = 0; k < parts; ++k) {
      const double t = static_cast<double>(k) / parts;
      const Vector3 linear = c - a, square = 2.0 * a - 5.0 * b + 4.0 * c - d, cubic = 3.0 * (b - c) + d - a;
      line.push_back(b + 0.5 * t * (linear + t * (square + t * cubic)));
    }
  }
  line.push_back(points[last]);
  return line;
}

/** As findWay() says. */
int blockedOn(const ArmsConfig& arms,
              Arm arm,
              const std::vector<Pose>& way,
              const Surroundings& around,
              JointTrail* trail) {
  int blocked = 0;
  for (const Pose& next : way) {
    const Pose here = trail->pose();
    if (!trail->go(next)) return -1;
    blocked += blockedBetween(arms, arm, here, next, around);
  }
  return blocked;
}

}  // namespace

Pose toolInRing(const Grip& grip, const SceneObject& ring) noexcept {
  const Vector3 up = Vector3::UnitZ(), bar = up.cross(grip.outward);
  const Vector3 approach = -(std::cos(grip.lean) * up + std::sin(grip.lean) * grip.outward);
  Pose X_RT;
  X_RT.R.col(0) = approach;
  X_RT.R.col(2) = grip.turned ? Vector3(-bar) : bar;
  X_RT.R.col(1) = X_RT.R.col(2).cross(approach);
  X_RT.p = (ring.inner_radius + ring.bar_radius) * grip.outward + grip.along * bar - grip.reach * approach;
  return X_RT;
}

Pose drawnBack(Pose X_WT, double distance) noexcept {
  X_WT.p -= distance * X_WT.R.col(0);
  return X_WT;
}

Pose facing(const Pose& X_WR, const Vector3& up_W) noexcept {
  if (X_WR.R.col(2).dot(up_W) >= 0.0) return X_WR;
  const Vector3 half_turn(1.0, -1.0, -1.0);
  return {X_WR.R * half_turn.asDiagonal(), X_WR.p};
}

Pose level(const Vector3& p_W, double heading) noexcept {
  return {Eigen::AngleAxisd(heading, Vector3::UnitZ()).toRotationMatrix(), p_W};
}

double headingOf(const Pose& X_WR) noexcept {
  return std::atan2(X_WR.R(1, 0), X_WR.R(0, 0));
}

Pose spun(Pose X_WR, double angle) noexcept {
  X_WR.R = X_WR.R * Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
  return X_WR;
}

std::vector<Pose> alongWire(const std::vector<Vec3>& line_W, double heading, double beyond) {
  std::vector<Vector3> points;
  for (const Vec3& p : line_W)
    points.push_back(toEigen(p));
  std::vector<Vector3> line = smooth(points);
  const Vector3 end = (line.back() - line[line.size() - 2]).normalized();
  for (double s = kWireStep; s <= beyond; s += kWireStep)
    line.push_back(toEigen(line_W.back()) + s * end);
  std::vector<Pose> poses;
  Pose X_WR = level(line.front(), heading);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vector3 along = line[std::min(i + 1, line.size() - 1)] - line[i > 0 ? i - 1 : 0];
    X_WR.R = kinematics::shortestTurn(X_WR.R.col(2), axisOn(along)).toRotationMatrix() * X_WR.R;
    X_WR.p = line[i];
    poses.push_back(X_WR);
  }
  return poses;
}

Pose levelled(const Pose& X_WR) noexcept {
  const Vector3 axis = X_WR.R.col(2);
  return {kinematics::shortestTurn(axis, Vector3::UnitZ()).toRotationMatrix() * X_WR.R, X_WR.p};
}

double spinOf(const Pose& X_WR, const Pose& other) noexcept {
  const Matrix3 R = other.R.transpose() * X_WR.R;
  return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
}

std::size_t nearestTo(const Vector3& p_W, const std::vector<Pose>& poses) noexcept {
  std::size_t best = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if ((poses[i].p - p_W).norm() < (poses[best].p - p_W).norm()) best = i;
  }
  return best;
}

Pose JointTrail::pose() const noexcept {
  return baseInWorld(*arms_, arm_) * kinematics::forward(arms_->geometry, arm_, q_);
}

bool JointTrail::go(const Pose& X_WT) noexcept {
  const Pose from = pose();
  const PoseError way = errorOf(from, X_WT);
  const int steps =
      std::max(1, static_cast<int>(std::ceil(std::max(way.distance / kStepLength, way.angle / kStepAngle))));
  for (int i = 1; i <= steps; ++i) {
    if (!step(between(from, X_WT, static_cast<double>(i) / steps))) return false;
  }
  return true;
}

bool JointTrail::step(const Pose& X_WT) noexcept {
  const Pose X_BT = baseInWorld(*arms_, arm_).inverse() * X_WT;
  const kinematics::IkResult result = kinematics::inverse(arms_->geometry, arm_, X_BT, kOpenJaws, q_);
  if (result.status != kinematics::IkStatus::kOk || jumps(q_, result.q)) return false;
  q_ = result.q;
  margin_ = std::min(margin_, marginOf(arms_->geometry, q_));
  return margin_ > 0.0;
}

int findWay(const ArmsConfig& arms,
            Arm arm,
            const Surroundings& around,
            const std::optional<Pose>& X_WT_start,
            const Pose& to,
            JointTrail* trail,
            std::vector<Pose>* via) {
  const JointTrail from = *trail;
  int least = -1;
  for (std::vector<Pose>& way : waysBetween(from.pose(), to, around, X_WT_start)) {
    way.push_back(to);
    JointTrail tried = from;
    const int blocked = blockedOn(arms, arm, way, around, &tried);
    if (blocked < 0 || (least >= 0 && blocked >= least)) continue;
    least = blocked;
    *trail = tried;
    way.pop_back();
    *via = way;
    if (least == 0) break;
  }
  return least;
}

GripSearch::GripSearch(const ArmsConfig& arms, const GripTask& task)
    : arms_(arms),
      task_(task),
      grips_(candidates(task.ring, reachFor(task.X_WR.p.z() - task.around.floor))),
      before_(task.around) {
  if (task.X_WT_other) before_.X_WT_other = task.X_WT_other;
}

bool GripSearch::proceed(int count) {
  const std::size_t spins = task_.stations_W.empty() ? 1 : kSpins.size();
  const std::size_t all = grips_.size() * spins;
  for (int i = 0; i < count && next_ < all; ++i, ++next_) {
    const GripPlan plan = judge(grips_[next_ / spins], kSpins[next_ % spins]);
    if (plan.score > best_.score) best_ = plan;
    if (best_.score >= kPlentyMargin) next_ = all;  // no other is better
    if (plan.score <= kOutOfReach) next_ += spins - 1 - next_ % spins;
  }
  return next_ >= all;
}

/** Least margin on the whole path: there, with the ring from station to station, and off it. */
GripPlan GripSearch::judge(const Grip& grip, double spin) const {
  GripPlan plan{grip, spin, kOutOfReach, {}};
  const Pose X_RT = toolInRing(grip, task_.ring);
  const Pose X_WT = task_.X_WR * X_RT, before = drawnBack(X_WT, kStandOff);
  if (!keepsApart(X_WT) || !keepsApart(before)) return plan;
  JointTrail trail(arms_, task_.arm, task_.q);
  int blocked = findWay(arms_, task_.arm, before_, task_.X_WT_start, before, &trail, &plan.via);
  if (blocked < 0 || !follow(X_WT, &trail, &blocked)) return plan;
  plan.score = kNotThere;
  Pose last = X_WT;
  if (task_.lifted_W) {
    last = level(*task_.lifted_W, headingOf(task_.X_WR)) * X_RT;
    if (!follow(last, &trail, &blocked)) return plan;
  }
  for (std::size_t i = 0; i < task_.stations_W.size(); ++i) {
    const double share = i < task_.shares.size() ? task_.shares[i] : 1.0;
    last = spun(task_.stations_W[i], share * spin) * X_RT;
    if (!follow(last, &trail, &blocked)) return plan;
  }
  if (!follow(drawnBack(last, kStandOff), &trail, &blocked)) return plan;
  plan.score = std::min(kPlentyMargin, trail.margin()) / (1.0 + kBlocked * blocked);
  return plan;
}

bool GripSearch::follow(const Pose& to, JointTrail* trail, int* blocked) const {
  const Pose from = trail->pose();
  if (!trail->go(to)) return false;
  *blocked += blockedBetween(arms_, task_.arm, from, to, task_.around);
  return true;
}

bool GripSearch::keepsApart(const Pose& X_WT) const {
  if (!task_.X_WT_other) return true;
  for (const Capsule& one : shapeOf(arms_, task_.arm, X_WT)) {
    for (const Capsule& other : shapeOf(arms_, otherArm(task_.arm), *task_.X_WT_other)) {
      if (gapBetween(one, other) < 0.0) return false;
    }
  }
  return true;
}

}  // namespace raven2_trainer::console
