#include "loop/robot_relay.h"

#include "raven2_trainer/faults/packet_faults.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::loop {

void RobotRelay::tick() noexcept {
  const RobotTie& robot = stage_.robot;
  if (robot.isHeard() && !is_in_step_) sequence_ = robot.state().last_sequence;
  is_in_step_ = robot.isHeard();
  if (!robot.wasHeard()) return;
  RelayPacket packet;  // a robot whose state no longer reaches us is sent pedal-up: its last word must not be "down"
  packet.tick = stage_.thisTick();
  packet.command.sequence = ++sequence_;
  if (robot.isLed()) {
    packet.command.pedal = 1;
    packet.command.dp_I = stage_.increments.dp_I;
    packet.command.dq_I = stage_.increments.dq_I;
    packet.command.dgrasp = stage_.increments.dgrasp;
  }
  const int runlevel = static_cast<int>(robot.state().runlevel);
  faults_.relay.beginCycle({robot.isLinked(), runlevel, stage_.state.faults.signals});
  faults_.relay.beginPacket(robot.isLinked());
  if (!faults_.relay.isArmed() && faults_.relay_stream.isEmpty()) {
    faults_.relay_stream.pass(packet.command);
    return send(packet);
  }
  faults_.relay_stream.offer(packet.command, &faults_.relay);
  while (faults_.relay_stream.take(&packet.command, faults_.relay)) {
    faults::applyToCommand(&faults_.relay, &packet.command);
    send(packet);
  }
}

void RobotRelay::send(const RelayPacket& packet) noexcept {
  const Fault* const network = faults_.relay.acting(FaultVariable::kPacket, FaultKind::kImpair);
  RelayPacket sent = packet;
  sent.is_held = faults_.relay.isHeld() ? 1 : 0;
  sent.impairment = network != nullptr ? 1 + static_cast<std::uint32_t>(network->value) : 0;
  stage_.shared.relay_packets.tryPush(sent);
}

const PerArm<JointArray>& RobotRelay::setPoints() noexcept {
  const ModeTraits traits = traitsOf(stage_.mode());
  const bool is_common = traits.follows_robot || traits.moves == Moves::kBoth;
  const bool is_models = stage_.robot.isLinked() || !stage_.robot.wasHeard() || is_common;
  if (is_models) q_d_ = stage_.arms.wanted();
  if (is_models || !stage_.robot.isFresh()) return q_d_;
  for (const Arm arm : kArms) {
    JointArray& q_d = at(q_d_, arm);
    const double opening = kinematics::jawOpening(q_d);
    q_d = at(stage_.robot.state().arms, arm).q;
    kinematics::setJaws(kinematics::jawMidline(q_d), opening, &q_d);
  }
  return q_d_;
}

}  // namespace raven2_trainer::loop
