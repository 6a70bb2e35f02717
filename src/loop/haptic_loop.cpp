#include "raven2_trainer/loop/haptic_loop.h"

#include <cmath>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/haptics/path_guidance.h"
#include "raven2_trainer/haptics/spring_damper.h"
#include "raven2_trainer/haptics/workspace_edge.h"

namespace raven2_trainer::loop {
namespace {

constexpr double kNoForce = 1e-9;  ///< [N] rounding of two limiters that act in one direction

}  // namespace

HapticLoop::HapticLoop(const LoopConfig& config, SharedState* shared)
    : gains_(config.haptics),
      scale_(config.master_scale),
      stale_ns_(static_cast<std::int64_t>(config.stale_after * 1e9)),
      shared_(*shared),
      has_fixtures_(gains_.guidance.enabled || gains_.edge.enabled),
      limiters_{haptics::ForceLimiter(gains_), haptics::ForceLimiter(gains_)},
      fixture_limiters_(limiters_),
      guards_{haptics::PassivityGuard(gains_.passivity), haptics::PassivityGuard(gains_.passivity)},
      cue_guards_(guards_),
      console_limiters_(limiters_) {}

void HapticLoop::tick(std::int64_t now_ns) noexcept {
  readCells();
  observe(model_.master_I);
  const double seconds = static_cast<double>(now_ns - last_.time_ns) * 1e-9;
  account(compute(model_, robot_, path_, now_ns));
  send(seconds);
}

void HapticLoop::readCells() noexcept {
  if (!shared_.model.tryLoad(&model_)) ++stale_reads_;
  if (!shared_.robot.tryLoad(&robot_)) ++stale_reads_;
  if (!shared_.servo.tryLoad(&servo_)) ++stale_reads_;
  if (!gains_.guidance.enabled) return;
  const std::uint64_t version = shared_.guide_path.version();  // 6 KiB: only when there is another
  if (version == path_version_) return;
  if (shared_.guide_path.tryLoad(&path_)) {
    path_version_ = version;
  } else {
    ++stale_reads_;
  }
}

void HapticLoop::send(double seconds) noexcept {
  shared_.haptic.store(last_);
  shared_.haptic_records.tryPush({last_});
  ForcePacket packet;
  packet.sequence = static_cast<std::uint32_t>(last_.count);
  packet.last_sequence = robot_.last_sequence;
  const bool has_robot = robot_.connected != 0 && robot_.frame > 0;  // a console must not take a gone one for ready
  packet.runlevel = static_cast<std::uint8_t>(has_robot ? robot_.runlevel : RunLevel::kEStop);
  for (const Arm arm : kArms)
    at(packet.force_I, arm) = forConsole(arm, seconds);
  shared_.force_packets.tryPush(packet);
}

/** [N] From the one to the other no faster than any force. */
Vec3 HapticLoop::forConsole(Arm arm, double seconds) noexcept {
  haptics::ForceLimiter& limiter = at(console_limiters_, arm);
  const Vector3 force_I = toEigen(at(last_.force_I, arm));
  const bool is_clients = servo_.holds_pedal != 0;
  if (!is_clients && !at(is_spared_, arm)) {
    limiter.resume(force_I);
    return at(last_.force_I, arm);
  }
  const Vector3 given_I = limiter.step(is_clients ? Vector3(Vector3::Zero()) : force_I, seconds);
  at(is_spared_, arm) = is_clients || given_I != force_I;
  return toArray(given_I);
}

void HapticLoop::observe(const PerArm<Vec3>& master_I) noexcept {
  for (const Arm arm : kArms) {
    const Vector3 hand_I = toEigen(at(master_I, arm)) / scale_;
    at(guards_, arm).observe(hand_I);
    if (has_fixtures_) at(cue_guards_, arm).observe(hand_I);
  }
}

void HapticLoop::account(const HapticState& state) noexcept {
  const double seconds = static_cast<double>(state.time_ns - last_.time_ns) * 1e-9;
  last_ = state;
  for (const Arm arm : kArms)
    accountArm(arm, state, seconds);
  forgotten_ = forgotten_ && !(guards_[0].isResting() && guards_[1].isResting());
}

void HapticLoop::accountArm(Arm arm, const HapticState& state, double seconds) noexcept {
  at(limiters_, arm).resume(toEigen(at(state.force_B, arm)));
  const bool is_asked =
      at(state.cue_B, arm) != Vec3{} || at(state.guidance_B, arm) != Vec3{} || at(state.edge_B, arm) != Vec3{};
  // by the accounts as they were when the force was computed
  if (has_fixtures_) at(fixture_limiters_, arm).resume(fixtures(arm, state, seconds));
  at(guards_, arm).given(toEigen(at(state.force_I, arm)), is_asked);
  if (has_fixtures_) accountCue(arm, state);
}

/** Once the whole port rests, nothing of the past is left in its parts either, whatever they were taken for. */
void HapticLoop::accountCue(Arm arm, const HapticState& state) noexcept {
  haptics::PassivityGuard& guard = at(cue_guards_, arm);
  if (at(guards_, arm).isResting()) {
    at(fixture_limiters_, arm).resume(Vector3::Zero());
    if (!guard.isResting()) guard.startAgain();
    return;
  }
  Vector3 cue_B = toEigen(at(state.force_B, arm)) - at(fixture_limiters_, arm).force();
  if (cue_B.norm() < kNoForce) cue_B.setZero();
  guard.given(control::itpToBase(arm).transpose() * cue_B, at(state.cue_B, arm) != Vec3{});
}

void HapticLoop::forget() noexcept {
  for (const Arm arm : kArms) {
    at(guards_, arm).forget();
    at(cue_guards_, arm).forget();
  }
  forgotten_ = true;
}

bool HapticLoop::knowsItself() const noexcept {
  return !forgotten_;
}

bool HapticLoop::isFresh(const Inputs& in, std::int64_t now_ns) const noexcept {
  const bool has_robot = in.robot.connected != 0 && in.robot.frame > 0;
  return has_robot && now_ns - in.robot.received_ns <= stale_ns_ && now_ns - in.model.time_ns <= stale_ns_;
}

HapticState HapticLoop::compute(const ModelState& model,
                                const RobotState& robot,
                                const GuidePath& path,
                                std::int64_t now_ns) const noexcept {
  const Inputs in{model, robot, path, static_cast<double>(now_ns - last_.time_ns) * 1e-9};
  HapticState out;
  out.tick = model.tick;
  out.count = last_.count + 1;
  out.robot_cycle = robot.cycle;
  out.time_ns = now_ns;
  out.master_I = model.master_I;
  out.pedal = model.pedal;
  out.active = isFresh(in, now_ns) && model.linked != 0 ? 1 : 0;
  const bool has_path = gains_.guidance.enabled && model.guide_plan != 0 && path.plan == model.guide_plan;
  out.guide_plan = has_path ? path.plan : 0;
  for (const Arm arm : kArms)
    computeArm(arm, in, &out);
  return out;
}

void HapticLoop::computeArm(Arm arm, const Inputs& in, HapticState* out) const noexcept {
  const double error = (toEigen(at(in.model.arms, arm).p_BT) - toEigen(at(in.robot.arms, arm).p_BT)).norm();
  if (in.robot.frame > 0 && std::isfinite(error)) at(out->error, arm) = error;
  at(out->hand_I, arm) = toArray(handFromMiddle(arm, in.model));
  // what is asked for
  Vector3 cue_B = Vector3::Zero(), guidance_B = Vector3::Zero(), edge_B = Vector3::Zero();
  if (out->active != 0) {
    cue_B = cue(arm, in);
    guidance_B = guidance(arm, in, out);
    edge_B = edge(arm, *out);
  }
  at(out->cue_B, arm) = toArray(cue_B);
  at(out->guidance_B, arm) = toArray(guidance_B);
  at(out->edge_B, arm) = toArray(edge_B);
  // what is given
  at(out->gain, arm) = cueGuard(arm).gain();
  at(out->energy, arm) = at(guards_, arm).energy();
  at(out->allowance, arm) = at(guards_, arm).allowance();
  Vector3 wanted = haptics::shortened(cue_B, at(out->gain, arm), gains_.min_force);
  if (has_fixtures_ && out->active != 0) wanted += fixtures(arm, *out, in.seconds);  // else all falls to nothing
  if (in.model.faults.console != 0 && out->active != 0)  // size and slew stay limited whatever a fault does
    wanted = at(in.model.faults.force_gain, arm) * wanted + toEigen(at(in.model.faults.force_offset_B, arm));
  haptics::ForceLimiter limiter = at(limiters_, arm);
  const Vector3 force_B = limiter.step(wanted, in.seconds);
  at(out->force_B, arm) = toArray(force_B);
  at(out->force_I, arm) = toArray(Vector3(control::itpToBase(arm).transpose() * force_B));
}

const haptics::PassivityGuard& HapticLoop::cueGuard(Arm arm) const noexcept {
  return has_fixtures_ ? at(cue_guards_, arm) : at(guards_, arm);
}

/** [N] of guidance and edge, in B: the guidance yields first. Limited by itself, so that the rest is the cue's. */
Vector3 HapticLoop::fixtures(Arm arm, const HapticState& asked, double seconds) const noexcept {
  const haptics::PassivityGuard& guard = at(guards_, arm);
  haptics::ForceLimiter limiter = at(fixture_limiters_, arm);
  return limiter.step(
      guard.yieldingGain() * toEigen(at(asked.guidance_B, arm)) + guard.gain() * toEigen(at(asked.edge_B, arm)),
      seconds);
}

/** [m] The masters send increments alone: where the middle is, is an assumption (WorkspaceOrigin). A hand that takes
 * the pedal from a CRTK client, which moved no hand, presses it there. */
Vector3 HapticLoop::handFromMiddle(Arm arm, const ModelState& model) const noexcept {
  const bool pressed = model.pedal == kSurgeonsPedal && last_.pedal != kSurgeonsPedal;
  if (pressed && gains_.edge.origin == WorkspaceOrigin::kPedalDown) return Vector3::Zero();
  const Vector3 moved = (toEigen(at(model.master_I, arm)) - toEigen(at(last_.master_I, arm))) / scale_;
  return toEigen(at(last_.hand_I, arm)) + moved;
}

Vector3 HapticLoop::cue(Arm arm, const Inputs& in) const noexcept {
  const ArmState& model = at(in.model.arms, arm);
  const RobotArmState& robot = at(in.robot.arms, arm);
  return haptics::springDamper(gains_, toEigen(model.p_BT), toEigen(robot.p_BT), toEigen(model.v_BT),
                               toEigen(robot.v_BT));
}

Vector3 HapticLoop::guidance(Arm arm, const Inputs& in, HapticState* out) const noexcept {
  const bool is_guided = out->guide_plan != 0 && in.path.arm == arm && in.model.pedal != 0;
  const double fade = haptics::nextFade(gains_.guidance, at(last_.guidance_fade, arm), is_guided, in.seconds);
  at(out->guidance_fade, arm) = fade;
  if (fade <= 0.0) return Vector3::Zero();
  return fade * haptics::pathGuidance(gains_.guidance, in.path, toEigen(at(in.model.arms, arm).p_BT));
}

Vector3 HapticLoop::edge(Arm arm, const HapticState& out) const noexcept {
  if (!gains_.edge.enabled) return Vector3::Zero();
  return control::itpToBase(arm) * haptics::workspaceEdge(gains_.edge, toEigen(at(out.hand_I, arm)));
}

}  // namespace raven2_trainer::loop
