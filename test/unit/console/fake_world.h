#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::console {

inline TrainerConfig shippedConfig() {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  config.console.start_delay = 0.0;
  return config;
}

/** The ring of the shipped scene and two towers (meshes/dimensions.yaml). */
inline SceneRoles fakeScene() {
  SceneRoles roles;
  roles.objects.push_back({"ring", "ring", /*square=*/1, /*inner_radius=*/0.007, /*bar_radius=*/0.002});
  roles.pegs.push_back({"near_right", "tower_near_right", {-0.018, -0.028, 0.0}, 0.026, 0.004});
  roles.pegs.push_back({"near_left", "tower_near_left", {-0.018, 0.028, 0.0}, 0.026, 0.004});
  return roles;
}

/** W from B, by model/raven_model.h's rule. */
inline Pose baseOf(const ArmsConfig& arms, Arm arm) {
  Pose X_WB;
  if (arm == Arm::kGold) {
    X_WB.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  } else {
    X_WB.R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  }
  X_WB.p = toEigen(at(arms.rcm_W, arm));
  return X_WB;
}

/**
 * A robot without mass that accepts ITP by the rules of the real one, and a ring that sticks between closed jaws and
 * falls straight down otherwise. The robot sags, so that a tool is not where it was commanded to be.
 */
class FakeWorld {
 public:
  FakeWorld(const TrainerConfig& config, std::unique_ptr<MotionSource> source)
      : arms_(config.arms),
        scene_(fakeScene()),
        console_(config.console, std::move(source)),
        mappers_{control::TeleopMapper(arms_.geometry, Arm::kGold),
                 control::TeleopMapper(arms_.geometry, Arm::kGreen)} {
    for (const Arm arm : kArms)
      at(q_, arm) = arms_.geometry.home;
    ring_.p = {0.012, 0.0, 0.016};
    console_.setReady(true);
  }

  void tick() {
    ForcePacket force;
    force.sequence = static_cast<std::uint32_t>(now_) + 1;
    force.runlevel = static_cast<std::uint8_t>(isDown() ? RunLevel::kPedalDown : RunLevel::kPedalUp);
    at(force.force_I, Arm::kGold) = toArray(push_I);
    console_.applyForce(force);
    if (now_ % 33 == 0 && !is_blind) console_.applySight(sight());
    take(console_.tick());
    ++now_;
  }

  void run(double seconds) {
    for (Tick end = now_ + static_cast<Tick>(seconds / kTickSeconds); now_ < end && !console_.finished();)
      tick();
  }

  /** Until the next press of the pedal has just begun. */
  void runToPress() {
    for (const int wanted : {0, 1}) {
      while (packet_.surgeon_mode != wanted && !console_.finished())
        tick();
    }
  }

  ExerciseStatus exercise{ExerciseStatus::kNone};  ///< as the surgeon sees it
  Mode mode{Mode::kTeleoperating};                 ///< the same
  RunLevel runlevel{RunLevel::kPedalDown};         ///< the same
  bool finished() const { return console_.finished(); }
  const Pose& ring() const { return ring_; }
  bool isHeldBy(Arm arm) const { return at(X_TR_, arm).has_value(); }
  double opening(Arm arm) const { return kinematics::jawOpening(at(q_, arm)); }
  void place(const Pose& X_WR) { ring_ = X_WR; }
  Pose tool(Arm arm) const {
    Pose X_WT = baseOf(arms_, arm) * kinematics::forward(arms_.geometry, arm, at(q_, arm));
    X_WT.p.z() -= sag;
    return X_WT;
  }
  const wire::ItpPacket& packet() const { return packet_; }
  double leastMargin() const { return least_margin_; }  ///< [rad] of joints 0 to 4 but the insertion, so far
  int drops() const { return drops_; }
  int pedalUps() const { return pedal_ups_; }
  int refusals() const { return refusals_; }   ///< increments that led nowhere
  double highest() const { return highest_; }  ///< [m] of the ring, so far
  double seconds() const { return static_cast<double>(now_) * kTickSeconds; }

  double sag{0.0};                                           ///< [m]
  Vector3 eye_W{-0.2, 0.0, 0.15}, target_W{0.0, 0.0, 0.02};  ///< [m] of the camera
  double eye_by_tip{3.0};                                    ///< [-]
  bool is_blind{false};                                      ///< no pictures
  Vector3 push_I{0.0, 0.0, 0.0};                             ///< [N] on the gold hand
  int slips{0};                                              ///< number of grips that fail

 private:
  bool isDown() const { return pedal_ticks_ > 20; }  // the robot's brakes take their time

  void take(const wire::ItpPacket& packet) {
    packet_ = packet;
    const bool pedal = packet.surgeon_mode != 0;
    if (!pedal && pedal_ticks_ > 0) ++pedal_ups_;
    if (pedal && pedal_ticks_ == 0) {
      for (const Arm arm : kArms)
        at(mappers_, arm).rebasePose(at(q_, arm));
    }
    pedal_ticks_ = pedal ? pedal_ticks_ + 1 : 0;
    const bool moves_camera = (console_.pedals() & bit(Pedal::kCamera)) != 0;
    if (isDown() && moves_camera) moveCamera(wire::toCommand(packet));
    if (isDown() && !moves_camera) {
      for (const Arm arm : kArms)
        moveArm(arm, wire::toCommand(packet));
    }
    moveRing();
  }

  void moveArm(Arm arm, const MasterCommand& command) {
    control::TeleopMapper& mapper = at(mappers_, arm);
    const auto status = mapper.add(at(command.dp_I, arm), at(command.dq_I, arm), at(command.dgrasp, arm), at(q_, arm));
    refusals_ += status == kinematics::IkStatus::kOk ? 0 : 1;
    const double before = opening(arm);
    at(q_, arm) = mapper.desired();
    for (const std::size_t j : {kShoulder, kElbow, kToolRotation, kWrist}) {
      least_margin_ =
          std::min({least_margin_, at(q_, arm)[j] - arms_.geometry.q_min[j], arms_.geometry.q_max[j] - at(q_, arm)[j]});
    }
    if (before >= kGripOpening && opening(arm) < kGripOpening) grip(arm);
    if (opening(arm) > kGripOpening) at(X_TR_, arm).reset();
  }

  /** An eye on a sphere. The mean of both hands moves it: right and up around the sphere, forward nearer to it. */
  void moveCamera(const MasterCommand& command) {
    const Vector3 mean_I = 0.5 * (toEigen(command.dp_I[0]) + toEigen(command.dp_I[1]));
    const Vector3 from = eye_W - target_W;
    const double flat = from.head<2>().norm();
    const double azimuth = std::atan2(from.y(), from.x()) + eye_by_tip * mean_I.y() / flat;
    const double elevation = std::atan2(from.z(), flat) - eye_by_tip * mean_I.z() / from.norm();
    const double distance = from.norm() - eye_by_tip * mean_I.x();
    eye_W = target_W + distance * Vector3(std::cos(elevation) * std::cos(azimuth),
                                          std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  }

  /** The bar's middle line must be between the jaws. */
  void grip(Arm arm) {
    const Vector3 p_R = ring_.inverse() * (tool(arm) * Vector3(0.0075, 0.0, 0.0));
    const double off = std::max(std::abs(p_R.x()), std::abs(p_R.y())) - 0.009;
    if (std::abs(off) > 0.0025 || std::abs(p_R.z()) > 0.0025) return;
    if (slips-- > 0) return;
    at(X_TR_, arm) = tool(arm).inverse() * ring_;
  }

  void moveRing() {
    for (const Arm arm : kArms) {
      if (!isHeldBy(arm)) continue;
      ring_ = tool(arm) * *at(X_TR_, arm);
      highest_ = std::max(highest_, ring_.p.z());
      was_held_ = true;
      return;
    }
    if (!was_held_) return;
    was_held_ = false;
    ring_.R = Eigen::AngleAxisd(std::atan2(ring_.R(1, 0), ring_.R(0, 0)), Vector3::UnitZ()).toRotationMatrix();
    if (!isOverPeg()) ++drops_;
    ring_.p.z() = 0.002;
  }
  bool isOverPeg() const {
    for (const ScenePeg& peg : scene_.pegs) {
      const Vector3 from_foot = ring_.p - toEigen(peg.base_W);
      if (from_foot.head<2>().norm() < 0.003 && from_foot.z() < peg.height) return true;
    }
    return false;
  }

  Sight sight() {
    Sight sight;
    sight.sequence = ++pictures_;
    sight.tick = now_;
    sight.exercise = exercise;
    sight.mode = mode;
    sight.runlevel = runlevel;
    for (const Arm arm : kArms) {
      at(sight.tool_W, arm) = toArray(tool(arm));
      // a held bar keeps the jaws apart: it is 4 mm thick, 7.5 mm from the pivot
      at(sight.opening, arm) = isHeldBy(arm) ? std::max(0.5, opening(arm)) : opening(arm);
    }
    sight.camera.eye_W = toArray(eye_W);
    sight.camera.target_W = toArray(target_W);
    sight.bodies_W[0] = toArray(ring_);
    return sight;
  }

  static constexpr double kGripOpening = 0.4;  // [rad]

  const ArmsConfig arms_;
  const SceneRoles scene_;
  Console console_;
  PerArm<control::TeleopMapper> mappers_;
  PerArm<JointArray> q_{};
  PerArm<std::optional<Pose>> X_TR_;
  Pose ring_;
  wire::ItpPacket packet_;
  Tick now_{0};
  int pedal_ticks_{0}, pedal_ups_{0}, drops_{0}, refusals_{0};
  double least_margin_{10.0}, highest_{0.0};
  bool was_held_{false};
  std::uint32_t pictures_{0};
};

}  // namespace raven2_trainer::console
