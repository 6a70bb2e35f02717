#include "loop/activity/trial_store.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::loop {
namespace {

double distance(const Vec3& a, const Vec3& b) noexcept {
  return (toEigen(a) - toEigen(b)).norm();
}

double tipSpeed(const Vec3& v) noexcept {
  return toEigen(v).norm();
}

/** The larger one; what is not a number is worse than any. */
double worse(double a, double b) noexcept {
  return b <= a || std::isnan(a) ? a : b;
}

control::IncrementLimits limitsOf(const ItpRules& rules) {
  return {static_cast<double>(rules.max_increment_um), rules.max_rotation};
}

}  // namespace

TrialStore::TrialStore(const LoopConfig& config,
                       const model::RavenModel& raven,
                       const model::SceneModel& scene,
                       Answers* answers,
                       SharedState* shared,
                       double limit)
    : config_(config.execution),
      geometry_(config.arms.geometry),
      answers_(*answers),
      shared_(*shared),
      tape_(static_cast<std::size_t>(toTicks(limit))),
      execution_(config.execution),
      relays_{control::PathRelay(config.arms.geometry, limitsOf(config.itp)),
              control::PathRelay(config.arms.geometry, limitsOf(config.itp))},
      gauge_(raven, scene) {}

void TrialStore::open(const PerArm<JointArray>& now) noexcept {
  tape_.clear();
  start_ = now;
  is_open_ = true;
}

void TrialStore::keep(const PerArm<ArmState>& arms) noexcept {
  control::TrialSample sample;
  for (const Arm arm : kArms) {
    at(sample.q_d, arm) = at(arms, arm).q_d;
    at(sample.tip_B, arm) = at(arms, arm).p_BT;
  }
  tape_.add(sample);
}

/** Also if anything is not a number. The jaws follow the tape from any opening. */
bool TrialStore::hasMoved(const PerArm<JointArray>& q) const noexcept {
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kGrasp1; ++j) {
      if (!(std::abs(at(q, arm)[j] - at(start_, arm)[j]) <= config_.start_tolerance[j])) return true;
    }
  }
  return false;
}

void TrialStore::arm(const Request& request) noexcept {
  ExecutionReport asked;
  asked.id = request.id;
  asked.on_robot = request.on_robot != 0 ? 1 : 0;
  asked.path_time = static_cast<double>(tape_.size()) * kTickSeconds;
  tally_.start(asked);
  on_robot_ = request.on_robot != 0;
  under_way_ = true;
  has_begun_ = false;
  armed_ticks_ = 0;
}

bool TrialStore::waitForPedal() noexcept {
  return static_cast<double>(++armed_ticks_) * kTickSeconds <= config_.pedal_timeout;
}

void TrialStore::begin(const PerArm<JointArray>& from, Tick tick) noexcept {
  has_begun_ = true;
  execution_.start(tape_, from);
  tally_.begin(tick);
  for (const Arm arm : kArms)
    at(sent_opening_, arm) = kinematics::jawOpening(at(from, arm));
}

void TrialStore::follow(const PerArm<RobotArmState>& robot) noexcept {
  for (const Arm arm : kArms)
    at(relays_, arm).start(arm, at(robot, arm).q);
}

const PerArm<JointArray>& TrialStore::advance(bool may_move) noexcept {
  return execution_.tick(may_move).q_d;
}

control::TipIncrement TrialStore::tipIncrement(Arm arm) noexcept {
  return at(relays_, arm).advance(at(execution_.desired().q_d, arm));
}

double TrialStore::graspIncrement(Arm arm) noexcept {
  const double missing = at(sent_opening_, arm) - kinematics::jawOpening(at(execution_.desired().q_d, arm));
  const double step = std::round(missing * 1e3) * 1e-3;
  at(sent_opening_, arm) -= step;
  return step;
}

control::ExecutionSample TrialStore::sample(Arm arm, const ModelState& model, const RobotState& robot) const noexcept {
  const ArmState& state = at(model.arms, arm);
  control::ExecutionSample sample;
  sample.path_B = at(execution_.desired().tip_B, arm);
  sample.goal_B = toArray(kinematics::forward(geometry_, arm, at(execution_.goal(), arm)).p);
  sample.model_B = state.p_BT;
  sample.robot_B = at(robot.arms, arm).p_BT;
  sample.contacts = state.contacts;
  return sample;
}

/** At the end both shall rest; where, the tape's tips say, for what the model was pressed against then is there now. */
ExecutionEnd TrialStore::supervise(const ModelState& model, const RobotState& robot) noexcept {
  PerArm<control::ExecutionSample> samples;
  PerArm<double> off{};
  double near = planning::ClearanceGauge::kRange, real_near = near, fastest = 0.0;
  for (const Arm arm : kArms) {
    const ArmState& state = at(model.arms, arm);
    const RobotArmState& real = at(robot.arms, arm);
    control::ExecutionSample& now = at(samples, arm) = sample(arm, model, robot);
    at(off, arm) = worse(distance(now.model_B, now.path_B), on_robot_ ? distance(now.robot_B, now.path_B) : 0.0);
    near = std::min(near, gauge_.measure(arm, state.q, at(model.arms, otherArm(arm)).q));
    if (on_robot_) real_near = std::min(real_near, gauge_.measure(arm, real.q, at(robot.arms, otherArm(arm)).q));
    fastest = std::max({fastest, tipSpeed(state.v_BT), on_robot_ ? tipSpeed(real.v_BT) : 0.0});
  }
  control::ExecutionSample& counted = std::isnan(off[0]) || off[0] >= off[1] ? samples[0] : samples[1];
  counted.model_clearance = near;
  counted.robot_clearance = on_robot_ ? real_near : 0.0;
  counted.contacts = model.arms[0].contacts + model.arms[1].contacts;
  tally_.add(counted);
  if (!(tally_.deviation() <= config_.deviation_limit)) return ExecutionEnd::kOffPath;
  if (execution_.waited() > config_.robot_timeout) return ExecutionEnd::kRobotLost;
  if (!execution_.isOver()) return ExecutionEnd::kNone;
  if (execution_.rested() > 0.0 && fastest <= config_.settle_speed) return ExecutionEnd::kFinished;
  return execution_.rested() > config_.settle_time ? ExecutionEnd::kNotSettled : ExecutionEnd::kNone;
}

void TrialStore::end(ExecutionEnd end, Tick tick) noexcept {
  if (!under_way_) return;
  under_way_ = false;
  const ExecutionReport report = tally_.finish(end, tick, has_begun_ ? execution_.progress() : 0.0);
  answers_.give(report);
  shared_.execution_records.tryPush({tick, report});
}

PlanningState TrialStore::overlay(PlanningState state) const noexcept {
  if (!under_way_) return state;
  state.status = has_begun_ ? PlanningStatus::kExecuting : PlanningStatus::kArmed;
  state.on_robot = on_robot_ ? 1 : 0;
  state.plan = 0;
  state.progress = has_begun_ ? execution_.progress() : 0.0;
  return state;
}

}  // namespace raven2_trainer::loop
