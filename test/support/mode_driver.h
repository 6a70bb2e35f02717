#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "support/made_up_session.h"
#include "support/rig.h"

namespace raven2_trainer::testing {

inline double apart(const Vec3& a, const Vec3& b) {
  return (toEigen(a) - toEigen(b)).norm();
}

/** Brings the loops into any mode, as surgeon and operator would. */
class ModeDriver {
 public:
  static TrainerConfig configuration() {
    TrainerConfig config = packagedConfig();
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    return config;
  }

  explicit ModeDriver(const TrainerConfig& config = configuration(), double trial_limit = loop::kTrialLimit)
      : rig(config, trial_limit) {}

  /** Homes the robot. @return whether it is homed. */
  bool begin() {
    if (!rig.home()) return false;
    rest(false, 200);
    return true;
  }

  void tick(const MasterCommand& command) {
    rig.tick(command);
    if (watch) watch();
  }

  void rest(bool pedal, int ticks) {
    MasterCommand command;
    command.pedal = pedal ? 1 : 0;
    for (int i = 0; i < ticks; ++i)
      tick(command);
  }

  /** Moves both masters forward and up, clear of the scene, and rotates the gold one; from rest to rest, in whole
   *  micrometres. */
  void stroke(int ticks, double direction, double grasp = 0.0) {
    for (int i = 0; i < ticks; ++i) {
      const double speed = std::round(direction * 25.0 * (1.0 - std::cos(2.0 * kPi * i / ticks))) * 1e-6;
      MasterCommand command;
      command.pedal = 1;
      command.dp_I = {Vec3{speed, 0.0, -0.5 * speed}, Vec3{0.7 * speed, 0.0, -0.5 * speed}};
      for (Vec3& dp : command.dp_I) {
        for (double& d : dp)
          d = std::round(d * 1e6) * 1e-6;
      }
      const double half = 2.0 * speed;  // [rad] 4 rad a metre
      command.dq_I[0] = toArray(Quaternion(std::cos(half), 0.0, std::sin(half), 0.0));
      command.dgrasp = {i % 10 == 0 ? grasp : 0.0, 0.0};
      tick(command);
    }
  }

  /** Sends the request and lets a tick pass. @return the answer. */
  PlanningAnswer ask(RequestKind kind, bool pedal = false, std::uint8_t on_robot = 0, std::uint8_t enabled = 0) {
    Request request;
    request.kind = kind;
    request.on_robot = on_robot;
    request.enabled = enabled;
    return ask(request, pedal);
  }

  /** Asks for the replay of an invented session. */
  PlanningAnswer beginReplay(int ticks, bool ends, bool pedal = false) {
    Request request;
    request.kind = RequestKind::kBeginReplay;
    request.plan = ++replays;
    offerSession(rig.shared.get(), replays, ticks, ends);
    return ask(request, pedal);
  }

  PlanningAnswer ask(Request request, bool pedal) {
    request.id = ++last_id;
    EXPECT_TRUE(rig.shared->requests.tryPush(request));
    rest(pedal, 1);
    return rig.model().planning.answered == last_id ? rig.model().planning.answer : PlanningAnswer::kNone;
  }

  /** Answers a waiting plan request, if there is one, with a path of some millimetres to the side. */
  void answerPlan(bool pedal = false) {
    PlanRequest asked;
    if (!rig.shared->plan_requests.tryPop(&asked)) return;
    PlanResult plan;
    plan.id = asked.id;
    plan.status = PlanStatus::kSuccess;
    plan.arm = asked.arm;
    plan.waypoint_count = 2;
    plan.waypoints = {asked.start, asked.start};
    plan.waypoints[1][kShoulder] += 0.05;
    plan.arrival[1] = 0.4;
    plan.clearance = 0.002;
    plan.robot_follows = 1;
    EXPECT_TRUE(rig.shared->plan_results.tryPush(plan));
    rest(pedal, 1);
  }

  Mode mode() const { return rig.model().mode; }
  Vec3 modelTip(Arm arm = Arm::kGold) const { return at(rig.model().arms, arm).p_BT; }
  Vec3 robotTip(Arm arm = Arm::kGold) const { return at(rig.robot().arms, arm).p_BT; }
  ExecutionReport report() const { return rig.shared->last_execution.load(); }

  /** The robot's true tip, whatever the robot reports. */
  Vec3 trueTip(Arm arm) const {
    return toArray(kinematics::forward(rig.config.arms.geometry, arm, rig.plant.jointPositions(arm)).p);
  }

  /** Waits for this mode. @return whether it came. */
  bool waitFor(Mode wanted, int limit = 6000, bool pedal = false) {
    for (int i = 0; i < limit && mode() != wanted; ++i)
      rest(pedal, 1);
    return mode() == wanted;
  }

  Rig rig;
  std::function<void()> watch;  ///< called after every tick
  std::uint32_t last_id{0}, replays{0};
};

}  // namespace raven2_trainer::testing
