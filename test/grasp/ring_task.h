#pragma once

#include "grasp/hands.h"

// The ring task for two hands: pick the ring up, carry and rotate it, hand it over, put it over a tower. Open loop,
// except that each reach aims at the ring's pose. ring_judge.h judges the result.

namespace raven2_trainer::testing {

constexpr double kRingSide = 0.018, kBarRadius = 0.002;  // [m] meshes/dimensions.yaml: middle lines of the bars

/** One of the ring's four bars, by the direction from the ring's middle to it, in the ring's frame. */
enum class Bar { kFar, kLeft, kNear, kRight };

inline Vector3 outward(Bar bar) {
  switch (bar) {
    case Bar::kFar:
      return Vector3::UnitX();
    case Bar::kLeft:
      return Vector3::UnitY();
    case Bar::kNear:
      return -Vector3::UnitX();
    case Bar::kRight:
      break;
  }
  return -Vector3::UnitY();
}

/** How a bar is gripped: the jaws' hinge along the bar, the tool from the ring's upper side. */
struct Grip {
  Bar bar{Bar::kLeft};
  bool turned{false};    ///< jaws exchanged
  double along{0.0};     ///< [m] from the bar's middle
  double lean{0.17};     ///< [rad] of the tool about the bar, 0 = along the ring's axis, positive = leaning outward
  double reach{0.0075};  ///< [m] pivot to the bar's middle line; the jaws are 10 mm long
};

// Feasible for each arm with the joints 8 degrees or more inside their limits on the whole path (found by a search).
// The grip is off the bar's middle, because the ring's stand has its rib under the middle.
inline Grip usualGrip(Arm arm) {
  Grip grip;
  grip.bar = arm == Arm::kGold ? Bar::kLeft : Bar::kRight;
  grip.turned = arm == Arm::kGold;
  grip.along = arm == Arm::kGold ? -0.0035 : 0.0035;
  return grip;
}

/** The tool pose of a grip in the ring's frame. */
inline Pose toolInRing(const Grip& grip) {
  const Vector3 out = outward(grip.bar), up = Vector3::UnitZ(), bar = up.cross(out);
  const Vector3 approach = -(std::cos(grip.lean) * up + std::sin(grip.lean) * out);
  Pose X_RT;
  X_RT.R.col(0) = approach;
  X_RT.R.col(2) = grip.turned ? Vector3(-bar) : bar;
  X_RT.R.col(1) = X_RT.R.col(2).cross(approach);
  X_RT.p = kRingSide / 2 * out + grip.along * bar - grip.reach * approach;
  return X_RT;
}

/** The tool pose, drawn back along the tool's axis. */
inline Pose drawnBack(Pose X_WT, double distance) {
  X_WT.p -= distance * X_WT.R.col(0);
  return X_WT;
}

inline Pose level(const Vector3& p_W, double yaw = 0.0) {
  return {Eigen::AngleAxisd(yaw, Vector3::UnitZ()).toRotationMatrix(), p_W};
}

inline const Vector3 kTower{-0.018, -0.028, 0.0};  // [m] foot of tower_near_right
constexpr double kTowerHeight = 0.026;             // [m]

/** Errors and speeds of a simulated surgeon. */
struct Skill {
  double aim_error{0.0005};               ///< [m] along each axis
  double aim_angle{0.087};                ///< [rad] about any axis
  double tremor{0.0001};                  ///< [m]
  double slowest{0.020}, fastest{0.060};  ///< [m/s]
};

class RingTask {
 public:
  static constexpr double kReady = 0.8;   ///< [rad] jaws open for a bar
  static constexpr double kHeld = -0.05;  ///< [rad] closed a little beyond each other

  RingTask(Hands* hands, std::uint64_t seed, const Skill& skill = {}) : hands_(*hands), random_(seed), skill_(skill) {
    for (const Arm arm : kArms)
      hands_.setTremor(arm, Tremor::draw(skill_.tremor, &random_));
  }

  /** Reaches for the ring and closes the jaws on it. */
  void grip(Arm arm) {
    const Pose X_WT = hands_.ring() * toolInRing(usualGrip(arm)) * miss();
    hands_.move(arm, {drawnBack(X_WT, 0.018), kReady}, speed());
    hands_.moveTo(arm, X_WT, skill_.slowest);
    hands_.hold(0.2);  // the arm lags behind its target by some 80 ms
    hands_.open(arm, kHeld);
    hands_.hold(0.2);
    look(arm);
  }

  /** Notes the ring's pose in the tool. */
  void look(Arm arm) { at(X_TR_, arm) = hands_.wish(arm).X_WT.inverse() * hands_.ring(); }

  /** Carries the held ring to this pose. */
  void carry(Arm arm, const Pose& X_WR) {
    hands_.moveTo(arm, X_WR * at(X_TR_, arm).inverse(), speed());
    hands_.hold(0.2);
  }

  void letGo(Arm arm) {
    hands_.open(arm, kReady);
    hands_.hold(0.2);
    hands_.moveTo(arm, drawnBack(hands_.wish(arm).X_WT, 0.018), speed());
  }

  /** Picks the ring up, so that gold's jaws hold it in the air. */
  void pickUp() {
    grip(Arm::kGold);
    carry(Arm::kGold, level({0.010, 0.0, 0.045}));
  }

  void carryAndTurn() {
    carry(Arm::kGold, level({0.010, -0.030, 0.045}));
    carry(Arm::kGold, level({-0.030, 0.050, 0.100}));
    carry(Arm::kGold, level({-0.012, 0.0, 0.050}));
    carry(Arm::kGold, level({-0.012, 0.0, 0.050}, 1.0));
    carry(Arm::kGold, level({-0.012, 0.0, 0.050}));
  }

  void handOver() {
    grip(Arm::kGreen);
    letGo(Arm::kGold);
    look(Arm::kGreen);
  }

  /** Moves the ring over a tower, lowers it around the tower, and releases it. */
  void putOver(const Vector3& foot) {
    carry(Arm::kGreen, level(foot + Vector3(0, 0, 0.045)));
    look(Arm::kGreen);
    carry(Arm::kGreen, level(foot + Vector3(0, 0, 0.045)));
    carry(Arm::kGreen, level(foot + Vector3(0, 0, 0.014)));
    letGo(Arm::kGreen);
    hands_.hold(1.0);
  }

 private:
  double speed() { return random_.uniform(skill_.slowest, skill_.fastest); }
  Pose miss() {
    Pose X;
    for (int i = 0; i < 3; ++i)
      X.p(i) = random_.uniform(-skill_.aim_error, skill_.aim_error);
    const Vector3 axis = Vector3(random_.normal(), random_.normal(), random_.normal()).normalized();
    X.R = Eigen::AngleAxisd(random_.uniform(-skill_.aim_angle, skill_.aim_angle), axis).toRotationMatrix();
    return X;
  }

  Hands& hands_;
  Random random_;
  Skill skill_;
  PerArm<Pose> X_TR_{};
};

}  // namespace raven2_trainer::testing
