#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/console/expert.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/runtime/lockstep_stack.h"
#include "support/rig.h"

// An attempt at the ring task in the shipped scene: the scripted surgeon at the console, daemon and virtual Raven in
// lockstep. What became of it is told from the model's poses and contacts alone.

namespace raven2_trainer::testing {

/** The parts of the shipped scene that the task is about: meshes/dimensions.yaml. */
inline SceneRoles ringScene() {
  SceneRoles roles;
  roles.objects.push_back({"ring", "ring", /*square=*/1, /*inner_radius=*/0.007, /*bar_radius=*/0.002});
  roles.pegs.push_back({"near_right", "tower_near_right", {-0.018, -0.028, 0.0}, 0.026, 0.004});
  roles.pegs.push_back({"near_left", "tower_near_left", {-0.018, 0.028, 0.0}, 0.026, 0.004});
  return roles;
}

/** Gold picks the ring up, carries it to the middle, green takes it over and puts it over the near right tower. */
inline std::vector<console::Verb> ringTask() {
  using console::Verb;
  using console::VerbKind;
  Verb grip, carry, take, put;
  grip.kind = VerbKind::kGrip;
  carry.kind = VerbKind::kCarry;
  take.kind = VerbKind::kTakeOver;
  put.kind = VerbKind::kPutOver;
  grip.object = carry.object = take.object = put.object = 0;
  grip.arm = carry.arm = Arm::kGold;
  take.arm = put.arm = Arm::kGreen;
  carry.to_W = {0.010, 0.0, 0.045};
  put.peg = 0;
  return {grip, carry, take, put};
}

/** Tells that a source is finished; gives it the pictures that somebody else puts into `sight`, if somebody does. */
class SeeingSource : public console::MotionSource {
 public:
  SeeingSource(std::unique_ptr<console::MotionSource> source, std::shared_ptr<std::optional<Sight>> sight)
      : source_(std::move(source)), sight_(std::move(sight)) {}
  console::Intent tick(const console::Senses& senses) override {
    console::Senses seen = senses;
    if (*sight_) seen.sight = *sight_;
    const console::Intent intent = source_->tick(seen);
    *finished = intent.finished;
    return intent;
  }

  std::shared_ptr<bool> finished{std::make_shared<bool>(false)};

 private:
  std::unique_ptr<console::MotionSource> source_;
  std::shared_ptr<std::optional<Sight>> sight_;
};

class Attempt {
 public:
  Attempt(const TrainerConfig& config, std::unique_ptr<console::MotionSource> source) {
    auto seeing = std::make_unique<SeeingSource>(std::move(source), std::make_shared<std::optional<Sight>>());
    finished_ = seeing->finished;
    stack_ = std::make_unique<runtime::LockstepStack>(config, std::move(seeing));
    const std::vector<std::string> names = stack_->bodyNames();
    ring_ = static_cast<std::uint16_t>(std::find(names.begin(), names.end(), "ring") - names.begin());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string end = names[i].substr(names[i].size() - std::min<std::size_t>(2, names[i].size()));
      is_tool_.push_back(end == "_L" || end == "_R");
    }
  }

  /** Until the hands are finished and the ring had a second to come to rest, or the time is over. */
  void run(double seconds) {
    Tick rest = 1000;
    for (Tick i = 0; i < static_cast<Tick>(seconds / kTickSeconds) && rest > 0; ++i) {
      step();
      rest -= *finished_ ? 1 : 0;
    }
  }

  void step() {
    stack_->tick();
    stack_->discardRecords();
    const ModelState& model = stack_->view().model;
    observe(model);
  }

  bool finished() const { return *finished_; }
  /** Ring around a tower that stands there, below its top, at rest, and touched by no arm. */
  bool isDone(const ScenePeg& tower) const { return isAround(tower) && !is_touched_ && speed_ < 1e-3; }

  bool isAround(const ScenePeg& tower) const {
    const Vector3 normal = ring().R.col(2), foot = toEigen(tower.base_W);
    if (std::abs(normal.z()) < 0.3) return false;
    const Vector3 off = foot - ring().p;
    const double z = ring().p.z() - (normal.x() * off.x() + normal.y() * off.y()) / normal.z();
    const Vector3 p_R = ring().inverse() * Vector3(foot.x(), foot.y(), z);
    return std::abs(p_R.x()) < 0.007 && std::abs(p_R.y()) < 0.007 && z < foot.z() + tower.height && z > foot.z();
  }
  Pose ring() const { return toEigen(stack_->view().model.bodies[0]); }
  double seconds() const { return static_cast<double>(stack_->view().model.tick) * kTickSeconds; }
  double highest() const { return highest_; }  ///< [m] that the ring ever was
  const ModelState& model() const { return stack_->view().model; }
  const RobotState& robot() const { return stack_->view().robot; }
  double largestForce() const { return largest_force_; }  ///< [N] on a hand
  runtime::LockstepStack& stack() { return *stack_; }

 private:
  void observe(const ModelState& model) {
    const Vector3 p = toEigen(model.bodies[0].p);
    speed_ = (p - last_).norm() / kTickSeconds;
    last_ = p;
    highest_ = std::max(highest_, p.z());
    for (const Arm arm : kArms)
      largest_force_ = std::max(largest_force_, toEigen(at(stack_->view().haptic.force_I, arm)).norm());
    const ContactList list = stack_->shared()->contacts.load();
    is_touched_ = false;
    for (std::uint32_t i = 0; i < list.count; ++i) {
      const Contact& c = list.contacts[i];
      if (c.a == ring_ && is_tool_.at(c.b)) is_touched_ = true;
      if (c.b == ring_ && is_tool_.at(c.a)) is_touched_ = true;
    }
  }

  std::shared_ptr<bool> finished_;
  std::unique_ptr<runtime::LockstepStack> stack_;
  std::uint16_t ring_{};
  std::vector<bool> is_tool_;
  Vector3 last_{0, 0, 0};
  double speed_{0.0}, highest_{0.0}, largest_force_{0.0};
  bool is_touched_{false};
};

}  // namespace raven2_trainer::testing
