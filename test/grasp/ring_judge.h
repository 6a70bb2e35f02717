#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "grasp/hands.h"

namespace raven2_trainer::testing {

/**
 * Judges the ring's handling from contacts and poses alone. Call observe() in every tick.
 * An arm holds the ring while both of its jaws press on it. It holds the ring alone if neither the other arm, nor the
 * stand, the plate or a tower touches the ring.
 */
class RingJudge {
 public:
  explicit RingJudge(const Hands& hands) : names_(hands.world().bodyNames()) {
    ring_ = number("ring");
    for (const Arm arm : kArms) {
      const std::string side = arm == Arm::kGold ? "_L" : "_R";
      at(jaws_, arm) = {number("grasper1" + side), number("grasper2" + side)};
    }
  }

  void observe(const Hands& hands) {
    hands.world().contactList(&list_);
    readContacts();
    const Pose X_WR = hands.ring();
    speed_ = (X_WR.p - last_.p).norm() / kTickSeconds;
    last_ = X_WR;
    for (const Arm arm : kArms) {
      if (holdsAlone(arm)) follow(arm, X_WR);
    }
    loose_ticks_ += free() && rest_ == 0 ? 1 : 0;
    both_ticks_ += holds(Arm::kGold) && holds(Arm::kGreen) ? 1 : 0;
  }

  bool holds(Arm arm) const { return std::min(at(press_, arm)[0], at(press_, arm)[1]) > kPress; }
  bool holdsAlone(Arm arm) const { return holds(arm) && !touches(other(arm)) && rest_ == 0; }
  bool touches(Arm arm) const { return std::max(at(press_, arm)[0], at(press_, arm)[1]) > 0.0; }
  bool free() const { return !touches(Arm::kGold) && !touches(Arm::kGreen); }

  double heldSeconds(Arm arm) const { return at(paths_, arm).ticks * kTickSeconds; }
  double carried(Arm arm) const { return at(paths_, arm).displacement; }  ///< [m] largest between two points
  double turned(Arm arm) const { return at(paths_, arm).turn; }           ///< [rad] largest from the first pose held
  double bothSeconds() const { return both_ticks_ * kTickSeconds; }
  double looseSeconds() const { return loose_ticks_ * kTickSeconds; }  ///< without any contact
  double speed() const { return speed_; }                              ///< [m/s] of the ring's middle
  double deepest() const { return deepest_; }                          ///< [m] of the ring in another body, so far
  double press(Arm arm) const { return std::min(at(press_, arm)[0], at(press_, arm)[1]); }  ///< [N] of the weaker jaw
  const Pose& ring() const { return last_; }
  void forgetDepth() { deepest_ = 0.0; }

  /** Whether the ring is around a tower: the tower's axis goes through the opening, and the ring is below its top. */
  bool isAround(const Vector3& foot_W, double height) const {
    const Vector3 normal = last_.R.col(2);
    if (std::abs(normal.z()) < 0.3) return false;
    const double z = last_.p.z() - (normal.x() * (foot_W.x() - last_.p.x()) + normal.y() * (foot_W.y() - last_.p.y())) /
                                       normal.z();  // where the axis meets the ring's plane
    const Vector3 p_R = last_.inverse() * Vector3(foot_W.x(), foot_W.y(), z);
    const double inside = 0.009 - 0.002;  // half the opening
    return std::abs(p_R.x()) < inside && std::abs(p_R.y()) < inside && z < foot_W.z() + height && z > foot_W.z();
  }

 private:
  static constexpr double kPress = 0.05;  // [N] well above the ring's weight of 8 mN

  struct Path {
    int ticks{0};
    double displacement{0.0}, turn{0.0};
    Matrix3 first{Matrix3::Identity()};
    std::vector<Vector3> points;
  };

  static Arm other(Arm arm) { return arm == Arm::kGold ? Arm::kGreen : Arm::kGold; }

  int number(const std::string& name) const {
    return static_cast<int>(std::find(names_.begin(), names_.end(), name) - names_.begin());
  }

  void readContacts() {
    press_ = {};
    rest_ = 0;
    for (std::uint32_t i = 0; i < list_.count; ++i) {
      const Contact& c = list_.contacts[i];
      if (c.a != ring_ && c.b != ring_) continue;
      deepest_ = std::max(deepest_, static_cast<double>(c.depth));
      const double normal = toEigen(c.f_W).dot(toEigen(c.n_W));
      double* jaw = pressOf(c.a == ring_ ? c.b : c.a);
      if (jaw != nullptr) *jaw += normal;
      if (jaw == nullptr && normal > 0.0) ++rest_;
    }
  }

  /** A jaw's sum of forces; null for other bodies. */
  double* pressOf(int body) {
    for (const Arm arm : kArms) {
      for (std::size_t k = 0; k < 2; ++k) {
        if (at(jaws_, arm)[k] == body) return &at(press_, arm)[k];
      }
    }
    return nullptr;
  }

  void follow(Arm arm, const Pose& X_WR) {
    Path& path = at(paths_, arm);
    if (path.ticks++ == 0) path.first = X_WR.R;
    path.turn = std::max(path.turn, Eigen::AngleAxisd(path.first.transpose() * X_WR.R).angle());
    if (path.ticks % 20 != 1) return;
    for (const Vector3& p : path.points)
      path.displacement = std::max(path.displacement, (p - X_WR.p).norm());
    path.points.push_back(X_WR.p);
  }

  std::vector<std::string> names_;
  int ring_;
  PerArm<std::array<int, 2>> jaws_{};
  ContactList list_{};
  PerArm<std::array<double, 2>> press_{};
  int rest_{0};
  int both_ticks_{0}, loose_ticks_{0};
  double speed_{0.0}, deepest_{0.0};
  Pose last_;
  PerArm<Path> paths_{};
};

}  // namespace raven2_trainer::testing
