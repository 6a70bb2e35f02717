#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/console/script.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/training/motion_metrics.h"
#include "support/rig.h"

// An attempt at a shipped exercise: the scripted surgeon at the console, daemon and virtual Raven in lockstep. The
// result comes from the exercise's judge and, independently, from the model's poses and contacts.

namespace raven2_trainer::testing {

inline TrainerConfig trainingConfig(const std::string& exercise) {
  TrainerConfig config = packagedConfig();
  config::loadTraining({exercise, "none", "", "none"}, &config);
  return config;
}

/** Whether an upright peg passes through an object's opening, below the peg's top. Uses the peg's axis in the object's
 *  frame. */
inline bool surrounds(const SceneObject& object, const Pose& X_WO, const ScenePeg& peg) {
  const Pose X_OW = X_WO.inverse();
  const Vector3 foot_O = X_OW * toEigen(peg.base_W), up_O = X_OW.R.col(2);
  if (std::abs(up_O.z()) < 0.3) return false;
  const double height = -foot_O.z() / up_O.z();
  const Vector3 p_O = foot_O + height * up_O;
  const double r = object.square != 0 ? p_O.cwiseAbs().head<2>().maxCoeff() : p_O.head<2>().norm();
  return height > 0.0 && height < peg.height && r < object.inner_radius;
}

inline training::MotionSettings motionSettings(const ArmsConfig& arms) {
  training::MotionSettings settings;
  for (const Arm arm : kArms)
    at(settings.X_WB, arm) = {model::armBaseRotation(arm), toEigen(at(arms.rcm_W, arm))};
  return settings;
}

/** One attempt. @param[in] clumsy Name of the exercise's clumsy surgeon; empty: the expert. */
class Attempt {
 public:
  Attempt(const TrainerConfig& config, std::uint64_t seed, const std::string& clumsy = "")
      : config_(config), verbs_(console::verbsOf(config.exercise, config.roles)), motion_(motionSettings(config.arms)) {
    config_.seed = seed;
    const std::string motion = clumsy.empty() ? "expert" : "clumsy:" + clumsy;
    stack_ = std::make_unique<lockstep::LockstepStack>(config_, console::makeMotion(config_, {motion, {}}, &truth_));
    names_ = stack_->bodyNames();
    for (const SceneObject& object : config_.roles.objects) {
      bodies_.push_back(numberOf(object.link));
      at_last_.emplace_back(0, 0, 0);
    }
    for (const std::string& name : names_) {
      const std::string end = name.substr(name.size() - std::min<std::size_t>(2, name.size()));
      is_tool_.push_back(end == "_L" || end == "_R");
    }
  }

  /** Runs until two seconds after the surgeon is finished, until the exercise has failed, or until the time is over.
   *  @param[in] seen Ends the run two seconds after it first returns true; may be empty. */
  void run(const std::function<bool()>& seen = {}) {
    bool was_seen = false;
    Tick rest = 2000;
    const auto most = static_cast<Tick>((config_.exercise.time_limit + 30.0) / kTickSeconds);
    for (Tick i = 0; i < most && rest > 0 && exercise().status != ExerciseStatus::kFailed; ++i) {
      step();
      was_seen = was_seen || (seen && seen());
      rest -= finished() || was_seen ? 1 : 0;
    }
  }

  void step() {
    stack_->tick();
    takeRecords();
    observe();
  }

  // the judge's results
  const ExerciseState& exercise() const { return model().exercise; }
  const std::vector<ExerciseRecord>& events() const { return events_; }
  double seconds() const { return static_cast<double>(exercise().ended - exercise().began) * kTickSeconds; }
  /** [-] spectral arc length of both tips while the exercise ran. */
  double smoothness() const {
    return training::overHands(motion_.result(), &training::HandMotion::sparc).value_or(0.0);
  }
  /** [m] RMS of the tips in 6 to 14 Hz. */
  double tremor() const { return training::overHands(motion_.result(), &training::HandMotion::tremor).value_or(0.0); }
  std::uint32_t mistakes(Mistake kind) const { return exercise().mistakes[static_cast<std::size_t>(kind)]; }

  // by poses and contacts: an object is around a peg, at rest, and no arm touches it
  bool isPlaced(std::uint8_t object, std::uint8_t peg) const {
    return surrounds(config_.roles.objects[object], pose(object), config_.roles.pegs[peg]) && speeds_[object] < 1e-3 &&
           !touched_[object];
  }
  /** Whether every `around` in the last steps of the tracks is fulfilled. */
  bool isAllPlaced() const {
    for (const ExerciseTrack& track : config_.exercise.tracks) {
      for (const Predicate& p : track.steps.back().until) {
        if (p.kind == PredicateKind::kAround && p.negated == 0 && !isPlaced(p.object, p.place)) return false;
      }
    }
    return true;
  }
  Pose pose(std::uint8_t object) const { return toEigen(model().bodies[object]); }
  double largestForce() const { return largest_force_; }  ///< [N] on a hand

  // the surgeon's own record
  bool finished() const { return stack_->finished(); }
  const std::vector<console::Verb>& verbs() const { return verbs_; }
  const console::TruthLog& truth() const { return truth_; }
  /** Tick that used the packet. */
  Tick tickOf(std::uint32_t sequence) const {
    const auto used = used_.lower_bound(sequence);
    return used == used_.end() ? model().tick : used->second;
  }

  const TrainerConfig& config() const { return config_; }
  const ModelState& model() const { return stack_->view().model; }
  const RobotState& robot() const { return stack_->view().robot; }
  const std::string& nameOf(std::uint16_t body) const { return body < names_.size() ? names_[body] : kNone; }
  lockstep::LockstepStack& stack() { return *stack_; }

 private:
  std::uint16_t numberOf(const std::string& link) const {
    return static_cast<std::uint16_t>(std::find(names_.begin(), names_.end(), link) - names_.begin());
  }

  void takeRecords() {
    ExerciseRecord told;
    while (stack_->shared()->records.exercises.tryPop(&told))
      events_.push_back(told);
    CommandRecord used;
    while (stack_->shared()->records.commands.tryPop(&used))
      used_[used.command.sequence] = used.tick;
    TickRecord tick;
    while (stack_->shared()->records.ticks.tryPop(&tick)) {
      if (tick.model.exercise.status == ExerciseStatus::kRunning) motion_.add(tick);
    }
    stack_->discardRecords();
  }

  void observe() {
    speeds_.resize(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Vector3 p = toEigen(model().bodies[i].p);
      speeds_[i] = (p - at_last_[i]).norm() / kTickSeconds;
      at_last_[i] = p;
    }
    for (const Arm arm : kArms)
      largest_force_ = std::max(largest_force_, toEigen(at(stack_->view().haptic.force_I, arm)).norm());
    touched_.assign(bodies_.size(), false);
    const ContactList list = stack_->shared()->contacts.load();
    for (std::uint32_t i = 0; i < list.count; ++i) {
      const Contact& c = list.contacts[i];
      for (std::size_t object = 0; object < bodies_.size(); ++object) {
        if (c.a == bodies_[object] && is_tool_.at(c.b)) touched_[object] = true;
        if (c.b == bodies_[object] && is_tool_.at(c.a)) touched_[object] = true;
      }
    }
  }

  const std::string kNone{"-"};
  TrainerConfig config_;
  std::vector<console::Verb> verbs_;
  training::MotionAccumulator motion_;
  console::TruthLog truth_;
  std::unique_ptr<lockstep::LockstepStack> stack_;
  std::vector<std::string> names_;
  std::vector<std::uint16_t> bodies_;  ///< numbers of the scene's objects in contacts
  std::vector<bool> is_tool_, touched_;
  std::vector<Vector3> at_last_;
  std::vector<double> speeds_;
  std::vector<ExerciseRecord> events_;
  std::map<std::uint32_t, Tick> used_;
  double largest_force_{0.0};
};

}  // namespace raven2_trainer::testing
