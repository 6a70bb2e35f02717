#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/control/joint_pid.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"

// A simulated surgeon's two hands. They drive the nominal model along Cartesian paths through its own controller, as a
// session does: desired tool poses, inverse kinematics each tick, the PID of config/model.yaml with gravity
// compensation, and the physics step.

namespace raven2_trainer::testing {

inline TrainerConfig trainerConfig() {
  physics::initialiseOde();
  physics::attachOdeToThread();
  return config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
}

/** A hand's tremor at the model's tool: one sine for each axis. */
struct Tremor {
  double amplitude{0.0};                       ///< [m]
  std::array<double, 3> frequency{}, phase{};  ///< [Hz], [rad]

  static Tremor draw(double amplitude, Random* random) {
    Tremor tremor;
    tremor.amplitude = amplitude;
    for (std::size_t i = 0; i < 3; ++i) {
      tremor.frequency[i] = random->uniform(8.0, 12.0);
      tremor.phase[i] = random->uniform(0.0, 2.0 * kPi);
    }
    return tremor;
  }
  Vector3 at(double t) const {
    Vector3 p;
    for (std::size_t i = 0; i < 3; ++i)
      p(static_cast<int>(i)) = amplitude * std::sin(2.0 * kPi * frequency[i] * t + phase[i]);
    return p;
  }
};

/** One hand's desired tool pose, T in W, and desired opening of the jaws. */
struct Wish {
  Pose X_WT;
  double opening{};  ///< [rad] less than the object between the jaws: they press on it
};

class Hands {
 public:
  /** @param[in] X_WR Start pose of the ring; on its stand if null.
   *  @param[in] solid_scene False: the scene has no contacts. */
  explicit Hands(const TrainerConfig& config, const Pose* X_WR = nullptr, bool solid_scene = true)
      : config_(config),
        raven_(model::loadRavenModel(config)),
        scene_(sceneWith(config, X_WR, solid_scene)),
        world_(raven_, scene_, config.model),
        pids_{control::JointPid(config.model.gains), control::JointPid(greenGains(config.model))} {
    for (const Arm arm : kArms) {
      at(q_d_, arm) = config.arms.geometry.home;
      world_.setJointState(arm, at(q_d_, arm), JointArray{});
      at(wishes_, arm) = {at(raven_.X_WB, arm) * kinematics::forward(geometry(), arm, at(q_d_, arm)),
                          kinematics::jawOpening(at(q_d_, arm))};
    }
  }

  void setTremor(Arm arm, const Tremor& tremor) { at(tremors_, arm) = tremor; }
  /** Called after each tick. */
  void setObserver(std::function<void(const Hands&)> observer) { observer_ = std::move(observer); }

  /** Minimum-jerk move of one tool at this mean speed [m/s], in at least 0.3 s. The other tool is held. */
  void move(Arm arm, const Wish& goal, double speed) {
    const Wish start = at(wishes_, arm);
    const double turn = Eigen::AngleAxisd(start.X_WT.R.transpose() * goal.X_WT.R).angle();
    const double seconds = std::max({0.3, (goal.X_WT.p - start.X_WT.p).norm() / speed, turn / kTurning,
                                     std::abs(goal.opening - start.opening) / kClosing});
    const int ticks = static_cast<int>(seconds / kTickSeconds);
    for (int i = 1; i <= ticks; ++i) {
      at(wishes_, arm) = between(start, goal, minimumJerk(static_cast<double>(i) / ticks));
      tick();
    }
  }
  void moveTo(Arm arm, const Pose& X_WT, double speed) { move(arm, {X_WT, at(wishes_, arm).opening}, speed); }
  void open(Arm arm, double opening) { move(arm, {at(wishes_, arm).X_WT, opening}, 1.0); }

  /** Sets the tool's desired pose from the next tick on. */
  void place(Arm arm, const Wish& wish) { at(wishes_, arm) = wish; }

  void hold(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / kTickSeconds); ++i)
      tick();
  }

  void tick() {
    controls();
    step();
  }

  /** The two parts of a tick, public for benchmarks: controls() and step(). */
  void controls() {
    for (const Arm arm : kArms) {
      aim(arm);
      JointArray q, dq;
      world_.jointState(arm, &q, &dq);
      at(tau_, arm) = at(pids_, arm).torque(at(q_d_, arm), q, dq, world_.gravityTorque(arm));
    }
  }
  void step() {
    world_.step(tau_);
    ++ticks_;
    if (observer_) observer_(*this);
  }

  /** Joints for this tool pose, inside all limits, near the current desired joints. @return false if there is no
   *  solution. */
  bool reaches(Arm arm, const Wish& wish, JointArray* q) const { return solve(arm, wish, at(q_d_, arm), q); }

  const physics::RavenWorld& world() const { return world_; }
  physics::RavenWorld& world() { return world_; }
  const model::SceneModel& scene() const { return scene_; }
  const TrainerConfig& config() const { return config_; }
  const ArmGeometry& geometry() const { return config_.arms.geometry; }
  const Wish& wish(Arm arm) const { return at(wishes_, arm); }
  const PerArm<JointArray>& torque() const { return tau_; }
  Tick ticks() const { return ticks_; }
  int outOfReach() const { return out_of_reach_; }  ///< ticks whose wish had no solution: the tool was held

  Pose tool(Arm arm) const {
    JointArray q, dq;
    world_.jointState(arm, &q, &dq);
    return at(raven_.X_WB, arm) * kinematics::forward(geometry(), arm, q);
  }
  Pose ring() const {
    std::array<RigidPose, kMaxSceneBodies> poses;
    world_.bodyPoses(&poses);
    return toEigen(poses[0]);
  }

 private:
  static constexpr double kTurning = 1.0, kClosing = 1.5;  // [rad/s]

  static model::SceneModel sceneWith(const TrainerConfig& config, const Pose* X_WR, bool solid) {
    model::SceneModel scene = model::loadSceneModel(config);
    if (X_WR != nullptr) scene.X_WL.at(static_cast<std::size_t>(scene.free_bodies.at(0))) = *X_WR;
    for (model::Link& link : scene.description.links) {
      if (!solid) link.collisions.clear();
    }
    return scene;
  }
  static std::array<JointGains, kJointCount> greenGains(const ModelConfig& model) {
    std::array<JointGains, kJointCount> gains = model.gains;
    gains[kInsertion].kd = model.green_insertion_kd;
    return gains;
  }
  static double minimumJerk(double s) { return s * s * s * (10.0 + s * (-15.0 + 6.0 * s)); }
  static Wish between(const Wish& a, const Wish& b, double s) {
    const Eigen::AngleAxisd turn(a.X_WT.R.transpose() * b.X_WT.R);
    Wish wish;
    wish.X_WT.R = a.X_WT.R * Eigen::AngleAxisd(s * turn.angle(), turn.axis()).toRotationMatrix();
    wish.X_WT.p = a.X_WT.p + s * (b.X_WT.p - a.X_WT.p);
    wish.opening = a.opening + s * (b.opening - a.opening);
    return wish;
  }

  bool solve(Arm arm, const Wish& wish, const JointArray& current, JointArray* q) const {
    const Pose X_BT = at(raven_.X_WB, arm).inverse() * wish.X_WT;
    const kinematics::IkResult result = kinematics::inverse(geometry(), arm, X_BT, wish.opening, current);
    if (result.status != kinematics::IkStatus::kOk) return false;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      if (result.q[j] < geometry().q_min[j] || result.q[j] > geometry().q_max[j]) return false;
    }
    *q = result.q;
    return true;
  }

  void aim(Arm arm) {
    Wish wish = at(wishes_, arm);
    wish.X_WT.p += at(tremors_, arm).at(static_cast<double>(ticks_) * kTickSeconds);
    if (!solve(arm, wish, at(q_d_, arm), &at(q_d_, arm))) ++out_of_reach_;
  }

  TrainerConfig config_;
  model::RavenModel raven_;
  model::SceneModel scene_;
  physics::RavenWorld world_;
  PerArm<control::JointPid> pids_;
  PerArm<JointArray> q_d_{}, tau_{};
  PerArm<Wish> wishes_{};
  PerArm<Tremor> tremors_{};
  Tick ticks_{0};
  int out_of_reach_{0};
  std::function<void(const Hands&)> observer_;
};

}  // namespace raven2_trainer::testing
