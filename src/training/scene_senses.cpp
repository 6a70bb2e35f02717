#include "training/scene_senses.h"

#include <algorithm>
#include <cmath>

#include "training/opening.h"
#include "training/units.h"

namespace raven2_trainer::training {
namespace {

constexpr double kRestSpeed = 0.001;  // [m/s]
constexpr double kRestTurn = 0.05;    // [rad/s]
/** [rad] between two attitudes, small angles. */
double turned(const Matrix3& a, const Matrix3& b) noexcept {
  const Matrix3 R = a.transpose() * b;
  return 0.5 * Vector3(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1)).norm() + (R.trace() < 1.0 ? kPi : 0.0);
}

bool isIn(const SceneRegion& region, const Vector3& p) noexcept {
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!(p(i) >= region.low_W[k] && p(i) <= region.high_W[k])) return false;
  }
  return true;
}

double distanceToRegion(const SceneRegion& region, const Vector3& p) noexcept {
  return (p - p.cwiseMax(toEigen(region.low_W)).cwiseMin(toEigen(region.high_W))).norm();
}

double distanceToPeg(const ScenePeg& peg, const Vector3& p) noexcept {
  const Vector3 foot = toEigen(peg.base_W);
  const double height = std::clamp(p.z() - foot.z(), 0.0, peg.height);
  return (p - foot - height * Vector3::UnitZ()).norm();
}

}  // namespace

void RestWatch::observe(const Pose& X_WO) noexcept {
  if (ticks_ < 0) first_ = X_WO;
  if (++ticks_ < kWindow) return;
  constexpr double kSpan = kWindow * kTickSeconds;
  rests_ = (X_WO.p - first_.p).norm() < kRestSpeed * kSpan && turned(first_.R, X_WO.R) < kRestTurn * kSpan;
  first_ = X_WO;
  ticks_ = 0;
}

SceneSenses::SceneSenses(const SceneRoles& roles,
                         const JudgeScene& scene,
                         const ArmsConfig& arms,
                         const CameraConfig& camera)
    : roles_(roles), scene_(scene), half_view_(std::tan(0.5 * camera.vertical_fov)), hands_(scene_) {
  for (const Arm arm : kArms)
    at(X_WB_, arm) = {model::armBaseRotation(arm), toEigen(at(arms.rcm_W, arm))};
  for (const SceneWire& wire : roles.wires)
    wire_lengths_.push_back(lengthOf(wire));
}

void SceneSenses::clear() noexcept {
  hands_.clear();
  for (RestWatch& rest : rests_)
    rest.clear();
}

void SceneSenses::look(const ModelState& state) noexcept {
  for (std::size_t i = 0; i < scene_.objects.size(); ++i)
    objects_W_[i] = toEigen(state.bodies[scene_.objects[i].slot]);
  for (const Arm arm : kArms) {
    const ArmState& s = at(state.arms, arm);
    at(tools_W_, arm) = at(X_WB_, arm) * Pose{toEigen(s.q_BT).toRotationMatrix(), toEigen(s.p_BT)};
  }
  camera_ = state.camera;
}

void SceneSenses::observe(const ModelState& state, const ContactList& list) noexcept {
  look(state);
  hands_.observe(list);
  for (std::size_t i = 0; i < scene_.objects.size(); ++i)
    rests_[i].observe(objects_W_[i]);
}

bool SceneSenses::holds(const Predicate& predicate, double along) const noexcept {
  return isMet(predicate, along) != (predicate.negated != 0);
}

bool SceneSenses::isMet(const Predicate& p, double along) const noexcept {
  switch (p.kind) {
    case PredicateKind::kHeld:
      return isHeld(p, false);
    case PredicateKind::kHeldAlone:
      return isHeld(p, true);
    case PredicateKind::kUntouched:
      return !hands_.touchedByArm(p.object);
    case PredicateKind::kAround:
      return isAround(roles_.objects[p.object], objects_W_[p.object], roles_.pegs[p.place]);
    case PredicateKind::kLifted:
      return isLifted(p.object);
    case PredicateKind::kResting:
      return rests_[p.object].rests();
    case PredicateKind::kAt:
      return (objects_W_[p.object].p - toEigen(roles_.points[p.place].p_W)).norm() <= p.value;
    case PredicateKind::kTipNear:
      return tips(p, [&](const Vector3& tip) { return (tip - toEigen(roles_.points[p.place].p_W)).norm() <= p.value; });
    case PredicateKind::kTipInside:
      return tips(p, [&](const Vector3& tip) { return isIn(roles_.regions[p.place], tip); });
    case PredicateKind::kTipOutside:
      return tips(p, [&](const Vector3& tip) { return !isIn(roles_.regions[p.place], tip); });
    case PredicateKind::kAlong:
      return along >= p.value;
    case PredicateKind::kUnthreaded:
      return threaded(p.object, p.place) < 0.0;
    case PredicateKind::kInView:
      return isInView(p);
    case PredicateKind::kCameraNear:
      return (toEigen(camera_.eye_W) - toEigen(roles_.points[p.place].p_W)).norm() <= p.value;
  }
  return false;
}

bool SceneSenses::isHeld(const Predicate& p, bool alone) const noexcept {
  if (p.hand == Hand::kBoth)
    return alone ? hands_.heldByBothAlone(p.object) : hands_.held(p.object, 0) && hands_.held(p.object, 1);
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    if (p.hand != Hand::kAny && static_cast<std::size_t>(p.hand) != arm) continue;
    if (alone ? hands_.heldAlone(p.object, arm) : hands_.held(p.object, arm)) return true;
  }
  return false;
}

template <typename Test>
bool SceneSenses::tips(const Predicate& p, const Test& test) const noexcept {
  const bool gold = test(tools_W_[0].p), green = test(tools_W_[1].p);
  switch (p.hand) {
    case Hand::kGold:
      return gold;
    case Hand::kGreen:
      return green;
    case Hand::kAny:
      return gold || green;
    case Hand::kBoth:
      return gold && green;
  }
  return false;
}

/** In a circle about the picture's middle: no matter how wide the picture is. */
bool SceneSenses::isInView(const Predicate& p) const noexcept {
  const Vector3 eye = toEigen(camera_.eye_W), view = toEigen(camera_.target_W) - eye;
  const double distance = view.norm();
  if (!(distance > 0.0)) return false;
  const Vector3 to = toEigen(roles_.points[p.place].p_W) - eye;
  const double ahead = to.dot(view) / distance;
  return ahead > 0.0 && to.cross(view).norm() / distance <= p.value * half_view_ * ahead;
}

double SceneSenses::threaded(std::size_t object, std::size_t wire) const noexcept {
  return threadedAt(roles_.objects[object], objects_W_[object], roles_.wires[wire]);
}

bool SceneSenses::isLifted(std::size_t object) const noexcept {
  if (hands_.contacts(object).fixed) return false;
  return std::none_of(roles_.pegs.begin(), roles_.pegs.end(),
                      [&](const ScenePeg& peg) { return isAround(roles_.objects[object], objects_W_[object], peg); });
}

bool SceneSenses::isAroundAny(std::size_t object, const std::vector<std::uint8_t>& pegs) const noexcept {
  return std::any_of(pegs.begin(), pegs.end(), [&](std::uint8_t peg) {
    return isAround(roles_.objects[object], objects_W_[object], roles_.pegs[peg]);
  });
}

template <typename Measure>
double SceneSenses::nearerTip(const Measure& measure) const noexcept {
  return std::min(measure(tools_W_[0].p), measure(tools_W_[1].p));
}

double SceneSenses::distanceTo(const Predicate& p) const noexcept {
  if (p.negated != 0) return kInfinity;
  const auto toPoint = [&](const Vector3& q) {
    return nearerTip([&](const Vector3& tip) { return (tip - q).norm(); });
  };
  switch (p.kind) {
    case PredicateKind::kAround:
      return nearerTip([&](const Vector3& tip) { return distanceToPeg(roles_.pegs[p.place], tip); });
    case PredicateKind::kAt:
    case PredicateKind::kTipNear:
      return toPoint(toEigen(roles_.points[p.place].p_W));
    case PredicateKind::kTipInside:
      return nearerTip([&](const Vector3& tip) { return distanceToRegion(roles_.regions[p.place], tip); });
    case PredicateKind::kAlong:
      return toPoint(pointAt(roles_.wires[p.place], p.value * wire_lengths_[p.place]));
    case PredicateKind::kUnthreaded:
      return toPoint(pointAt(roles_.wires[p.place], wire_lengths_[p.place]));
    default:
      return kInfinity;
  }
}

}  // namespace raven2_trainer::training
