#include "raven2_trainer/raven/control_software.h"

#include <algorithm>
#include <cmath>

#include "raven/gravity_compensation.h"
#include "raven/homing.h"
#include "raven/motor_controller.h"
#include "raven/network_layer.h"
#include "raven/state_machine.h"
#include "raven/velocity_filter.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/cable_coupling.h"

namespace raven2_trainer::raven {
namespace {

/** What the software keeps of one arm ("mechanism"). */
struct Mechanism {
  Mechanism(Arm which, const ArmsConfig& arms, const VirtualRavenConfig& config)
      : arm(which),
        coupling(which, config),
        controller(which, config),
        gravity(which, config),
        jpos_d(arms.geometry.home) {}

  Arm arm;
  CableCoupling coupling;
  MotorController controller;
  GravityCompensation gravity;
  VelocityFilter published_velocity;

  UsbIn in{};
  JointArray mpos{}, mvel{};  // [rad, rad/s]
  JointArray jpos{};          // [rad; m]
  JointArray jpos_d;          // [rad; m] stays where it is when the inverse refuses
  Pose X_BT;                  // actual tip
  MasterTarget pos_d;         // desired tip
  JointArray tau{};           // [Nm] capstan
  DacArray dac{};
};

double clampCount(double value, double low, double high) noexcept {
  return std::isnan(value) ? 0.0 : std::clamp(std::round(value), low, high);
}

}  // namespace

struct ControlSoftware::Impl {
  Impl(const ArmsConfig& arms, const VirtualRavenConfig& virtual_raven)
      : geometry(arms.geometry),
        config(virtual_raven),
        network(virtual_raven.master_timeout),
        homing(arms.geometry.home, virtual_raven.homing_time),
        mechanisms{Mechanism(Arm::kGold, arms, virtual_raven), Mechanism(Arm::kGreen, arms, virtual_raven)} {
    state.is_virtual = 1;
  }

  // The steps of one cycle, in the order of raven2.md 4.2.
  void getUsbPackets(const PerArm<UsbInBytes>& boards) noexcept;
  void estimateState() noexcept;
  void updateTargets() noexcept;
  void runHoming() noexcept;
  void runCartesian() noexcept;
  void torqueToDac() noexcept;
  void detectOverdrive() noexcept;
  PerArm<UsbOutBytes> putUsbPackets() noexcept;
  void publish() noexcept;

  bool solveInverse(Mechanism* mech) noexcept;
  void addGravity(Mechanism* mech) noexcept;
  JointArray track(Mechanism* mech) noexcept;

  ArmGeometry geometry;
  VirtualRavenConfig config;
  faults::FaultEngine faults{FaultHost::kRobot};
  NetworkLayer network;
  StateMachine machine;
  Homing homing;
  PerArm<Mechanism> mechanisms;
  RobotState state;
};

void ControlSoftware::Impl::getUsbPackets(const PerArm<UsbInBytes>& boards) noexcept {
  for (Mechanism& mech : mechanisms) {
    decodeIn(at(boards, mech.arm), &mech.in);  // another type of packet leaves the old counts, as on the robot
    for (std::size_t j = 0; j < kJointCount; ++j) {
      std::int32_t& count = mech.in.encoder[channelOf(j)];
      const double read =
          faults.apply(FaultSite::kGetUsbPacket, FaultTarget::kEncoder, mech.arm, static_cast<int>(j), count);
      count = static_cast<std::int32_t>(clampCount(read, -8388608.0, 8388607.0));
    }
  }
}

void ControlSoftware::Impl::estimateState() noexcept {
  for (Mechanism& mech : mechanisms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double mpos = kMotorRadPerCount * encoderSign(mech.arm, j) * mech.in.encoder[channelOf(j)];
      mech.mvel[j] = state.cycle > 1 ? (mpos - mech.mpos[j]) / kTickSeconds : 0.0;  // NO_LPF (raven2.md 3.7)
      mech.mpos[j] = mpos;
    }
    mech.jpos = mech.coupling.toJoint(mech.mpos);
    mech.X_BT = kinematics::forward(geometry, mech.arm, mech.jpos);
  }
}

void ControlSoftware::Impl::updateTargets() noexcept {
  const RunLevel level = machine.runLevel();
  for (Mechanism& mech : mechanisms) {
    MasterTarget& master = network.target(mech.arm);
    const double opening = kinematics::jawOpening(mech.jpos);
    if (level == RunLevel::kEStop || level == RunLevel::kPedalUp) master.rebase(mech.X_BT, opening);
    if (level == RunLevel::kPedalDown) {
      mech.pos_d = master;
    } else {
      mech.pos_d.rebasePose(mech.X_BT);
      mech.pos_d.grasp_mrad = master.grasp_mrad;
    }
  }
}

JointArray ControlSoftware::Impl::track(Mechanism* mech) noexcept {
  const JointArray mpos_d = mech->coupling.toMotorMeasured(mech->jpos_d, mech->mpos[kInsertion]);
  return mech->controller.torque(mpos_d, mech->mpos, mech->mvel);
}

void ControlSoftware::Impl::addGravity(Mechanism* mech) noexcept {
  if (!config.gravity_compensation) return;
  const std::array<double, 3> tau = mech->gravity.torque(mech->jpos);
  for (std::size_t j = 0; j < tau.size(); ++j)
    mech->tau[j] += tau[j];
}

void ControlSoftware::Impl::runHoming() noexcept {
  if (!machine.mayHome()) {
    homing.hold({mechanisms[0].jpos, mechanisms[1].jpos});
    return;
  }
  homing.tick();
  for (Mechanism& mech : mechanisms) {
    mech.jpos_d = homing.desired(mech.arm);
    mech.tau = track(&mech);
    addGravity(&mech);
  }
  if (!homing.done()) return;
  for (Mechanism& mech : mechanisms) {
    MasterTarget& master = network.target(mech.arm);
    master.rebasePose(mech.X_BT);
    master.grasp_mrad = static_cast<std::int32_t>(kinematics::jawOpening(mech.jpos) * 1e3);
  }
}

bool ControlSoftware::Impl::solveInverse(Mechanism* mech) noexcept {
  const kinematics::IkResult ik =
      kinematics::inverseWithinLimits(geometry, mech->arm, mech->pos_d.pose(), mech->pos_d.opening(), mech->jpos);
  if (!kinematics::isUsable(ik.status)) return false;
  if (ik.status == kinematics::IkStatus::kClamped) {
    // Re-based to the limit, so that the master cannot wind up past it.
    mech->pos_d.rebasePose(kinematics::forward(geometry, mech->arm, ik.q));
    network.target(mech->arm).rebasePose(mech->pos_d.pose());
  }
  mech->jpos_d = ik.q;
  return true;
}

void ControlSoftware::Impl::runCartesian() noexcept {
  // A refused gold target ends the robot's loop over the arms, so green freezes with it (raven2.md 4.5b).
  for (Mechanism& mech : mechanisms) {
    if (!solveInverse(&mech) && mech.arm == Arm::kGold) break;
  }
  for (Mechanism& mech : mechanisms) {
    if (machine.runLevel() == RunLevel::kPedalDown) mech.tau = track(&mech);
    addGravity(&mech);
  }
}

void ControlSoftware::Impl::torqueToDac() noexcept {
  for (Mechanism& mech : mechanisms) {
    mech.dac = machine.softEstopped() ? DacArray{} : mech.controller.toDac(mech.tau);
  }
}

void ControlSoftware::Impl::detectOverdrive() noexcept {
  const bool clips = machine.runLevel() >= RunLevel::kInit;
  for (Mechanism& mech : mechanisms) {
    if (overdriveDetect(config, clips, &mech.dac)) machine.softEstop();
  }
}

PerArm<UsbOutBytes> ControlSoftware::Impl::putUsbPackets() noexcept {
  PerArm<UsbOutBytes> boards;
  const std::uint8_t pins = machine.outputPins(network.pedal());
  for (Mechanism& mech : mechanisms) {
    UsbOut out;
    out.pins = pins;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double sent =
          faults.apply(FaultSite::kPutUsbPacket, FaultTarget::kDac, mech.arm, static_cast<int>(j), mech.dac[j]);
      mech.dac[j] = static_cast<std::int32_t>(clampCount(sent, -32768.0, 32767.0));
      out.dac[channelOf(j)] = static_cast<std::int16_t>(mech.dac[j]);
    }
    at(boards, mech.arm) = encodeOut(out);
  }
  return boards;
}

void ControlSoftware::Impl::publish() noexcept {
  state.last_sequence = network.lastSequence();
  state.active_fault = faults.activeId();
  state.runlevel = machine.runLevel();
  state.sublevel = machine.subLevel();
  state.homed = homing.done() ? 1 : 0;
  state.soft_estopped = machine.softEstopped() ? 1 : 0;
  state.itp = network.counts();
  for (Mechanism& mech : mechanisms) {
    RobotArmState& arm = at(state.arms, mech.arm);
    arm.q = mech.jpos;
    arm.dq = mech.coupling.toJoint(mech.published_velocity.update(mech.mvel));
    arm.motor = mech.mpos;
    arm.dac = mech.dac;
  }
}

ControlSoftware::ControlSoftware(const ArmsConfig& arms, const VirtualRavenConfig& config) {
  if (config.behaviour != "compat") {
    throw ConfigException("virtual_raven: behaviour is \"" + config.behaviour + "\", expected compat");
  }
  impl_ = std::make_unique<Impl>(arms, config);
}

ControlSoftware::~ControlSoftware() = default;

void ControlSoftware::receive(const std::uint8_t* bytes, std::size_t size) noexcept {
  impl_->network.receive(bytes, size, &impl_->faults);
  impl_->state.itp = impl_->network.counts();
}

void ControlSoftware::setFaults(const FaultPlan& plan) noexcept {
  impl_->faults.setPlan(plan);
}

PerArm<UsbOutBytes> ControlSoftware::cycle(const PerArm<UsbInBytes>& boards) noexcept {
  Impl& s = *impl_;
  ++s.state.cycle;
  s.faults.beginCycle(s.machine.runLevel() == RunLevel::kPedalDown);
  s.getUsbPackets(boards);
  s.machine.readPins(s.mechanisms[0].in.pins, s.mechanisms[1].in.pins);
  s.network.tick();
  for (Mechanism& mech : s.mechanisms)
    mech.tau = JointArray{};
  s.machine.step(s.homing.done());
  s.estimateState();
  s.updateTargets();
  if (s.homing.done()) {
    s.runCartesian();
  } else {
    s.runHoming();
  }
  s.torqueToDac();
  s.detectOverdrive();
  const PerArm<UsbOutBytes> out = s.putUsbPackets();
  s.publish();
  return out;
}

const RobotState& ControlSoftware::state() const noexcept {
  return impl_->state;
}

}  // namespace raven2_trainer::raven
