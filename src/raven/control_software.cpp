#include "raven2_trainer/raven/control_software.h"

#include <algorithm>
#include <cmath>

#include "raven/gravity_compensation.h"
#include "raven/motor_controller.h"
#include "raven/network_layer.h"
#include "raven/quick_homing.h"
#include "raven/state_estimator.h"
#include "raven/state_machine.h"
#include "raven/stop_search.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/low_pass.h"

namespace raven2_trainer::raven {
namespace {

/** What the software keeps of one arm ("mechanism"). */
struct Mechanism {
  Mechanism(Arm which, const VirtualRavenConfig& config)
      : arm(which),
        coupling(which, config),
        estimator(which, config.low_pass),
        controller(which, config),
        gravity(which, config) {}

  const JointArray& mpos() const noexcept { return estimator.mpos(); }

  Arm arm;
  CableCoupling coupling;
  StateEstimator estimator;
  MotorController controller;
  GravityCompensation gravity;
  LowPass published_velocity;

  UsbIn read{}, in{};   // as the board sent it; as the software takes it
  JointArray jpos{};    // [rad; m]
  JointArray jpos_d{};  // [rad; m] stays where it is when the inverse refuses
  JointArray mpos_d{};  // [rad]
  Pose X_BT;            // actual tip
  MasterTarget actual;  // the same, in the target's integers
  MasterTarget pos_d;   // desired tip
  JointArray tau{};     // [Nm] capstan
  DacArray dac{};
};

double clampCount(double value, double low, double high) noexcept {
  return std::isnan(value) ? 0.0 : std::clamp(std::round(value), low, high);
}

/** Serial numbers of the boards, raven2 defines.h:52-55. */
constexpr std::array<std::int32_t, kArmCount> kBoardSerials{49, 22};

void reportPose(const MasterTarget& pose, std::size_t arm, std::array<std::int32_t, 6>* um, std::array<float, 18>* R) {
  std::copy(pose.p_um.begin(), pose.p_um.end(), um->begin() + static_cast<std::ptrdiff_t>(3 * arm));
  const Matrix3 rotation = pose.R_BT.toRotationMatrix();
  for (std::size_t k = 0; k < 9; ++k)
    (*R)[9 * arm + k] =
        static_cast<float>(rotation(static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3)));
}

}  // namespace

struct ControlSoftware::Impl {
  Impl(const ArmsConfig& arms, const VirtualRavenConfig& virtual_raven, const wire::ItpKey* key)
      : geometry(arms.geometry),
        config(virtual_raven),
        network(virtual_raven, key),
        overdrive(virtual_raven),
        quick_homing(arms.geometry.home, virtual_raven.homing_time),
        stop_search(arms.geometry.home, virtual_raven.homing_dac),
        mechanisms{Mechanism(Arm::kGold, virtual_raven), Mechanism(Arm::kGreen, virtual_raven)} {
    state.is_virtual = 1;
    report.board = kBoardSerials;
    if (!config.full_homing) placeAt(config.start_offset);
  }

  // The steps of one cycle, in the order of raven2.md 4.2.
  void getUsbPackets(const PerArm<UsbRead>& boards) noexcept;
  void estimateState() noexcept;
  void trackActual() noexcept;
  void updateTargets() noexcept;
  void control() noexcept;
  void runQuickHoming() noexcept;
  void runStopSearch() noexcept;
  void runCartesian() noexcept;
  void torqueToDac() noexcept;
  void detectOverdrive() noexcept;
  PerArm<UsbOutBytes> putUsbPackets() noexcept;
  void publishState() noexcept;
  void fillHoming(Arm arm, std::array<std::uint8_t, kJointCount>* jstate) const noexcept;
  void publishReport() noexcept;
  void reportJoints(const Mechanism& mech) noexcept;

  /** The robot's clock is its cycles. */
  std::int64_t nowNs() const noexcept { return static_cast<std::int64_t>(state.cycle) * kTickNanoseconds; }
  wire::Arrival arrival(const std::uint8_t* bytes, std::size_t size, std::uint64_t source) const noexcept {
    return {bytes, size, source, nowNs()};
  }
  void placeAt(const JointArray& offset_from_home) noexcept;
  bool isFirstWristPointAtRcm(const Pose& X_BT) const noexcept;
  bool solveInverse(Mechanism* mech) noexcept;
  void addGravity(Mechanism* mech) noexcept;
  JointArray track(Mechanism* mech) noexcept;
  void rebaseMaster() noexcept { network.rebase({&mechanisms[0].pos_d, &mechanisms[1].pos_d}); }

  ArmGeometry geometry;
  VirtualRavenConfig config;
  faults::FaultEngine faults{FaultHost::kRobot};
  NetworkLayer network;
  StateMachine machine;
  OverdriveCheck overdrive;
  QuickHoming quick_homing;
  StopSearch stop_search;
  bool homed{false};  // control mode cartesian, for good
  std::uint64_t usb_errors{0};
  PerArm<Mechanism> mechanisms;
  RobotState state;
  RavenReport report;
};

/** The boards count from 0 at power-on; whoever knows where the joints stood then knows the offsets. */
void ControlSoftware::Impl::placeAt(const JointArray& offset_from_home) noexcept {
  for (Mechanism& mech : mechanisms) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      mech.jpos_d[j] = geometry.home[j] + offset_from_home[j];
    mech.estimator.setMotor(mech.coupling.toMotor(mech.jpos_d));
  }
}

void ControlSoftware::Impl::getUsbPackets(const PerArm<UsbRead>& boards) noexcept {
  for (Mechanism& mech : mechanisms) {
    const UsbRead& read = at(boards, mech.arm);
    if (read.result == UsbRead::kComplete) {
      decodeIn(read.bytes, &mech.read);  // another type of packet leaves the old counts and is no error
    } else {
      ++usb_errors;
    }
    mech.in = mech.read;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      std::int32_t& count = mech.in.encoder[channelOf(j)];
      const double faulted =
          faults.apply(FaultSite::kGetUsbPacket, FaultTarget::kEncoder, mech.arm, static_cast<int>(j), count);
      count = static_cast<std::int32_t>(clampCount(faulted, -8388608.0, 8388607.0));
    }
  }
}

void ControlSoftware::Impl::estimateState() noexcept {
  for (Mechanism& mech : mechanisms) {
    mech.estimator.update(mech.in.encoder);
    mech.jpos = mech.coupling.toJoint(mech.mpos());
    mech.X_BT = kinematics::forward(geometry, mech.arm, mech.jpos);
    mech.actual.set(mech.X_BT, kinematics::jawOpening(mech.jpos));
  }
}

/** The desired pose follows the actual one, and the accumulators with it. */
void ControlSoftware::Impl::trackActual() noexcept {
  for (Mechanism& mech : mechanisms)
    mech.pos_d = mech.actual;
  rebaseMaster();
}

void ControlSoftware::Impl::updateTargets() noexcept {
  const RunLevel level = machine.runLevel();
  if (level == RunLevel::kEStop || level == RunLevel::kPedalUp || !homed) return trackActual();
  for (Mechanism& mech : mechanisms) {
    if (level == RunLevel::kPedalDown) mech.pos_d = network.target(mech.arm);
    if (level == RunLevel::kInit && !machine.initialized()) mech.pos_d = mech.actual;
  }
}

JointArray ControlSoftware::Impl::track(Mechanism* mech) noexcept {
  mech->mpos_d = mech->coupling.toMotorMeasured(mech->jpos_d, mech->mpos()[kInsertion]);
  return mech->controller.torque(mech->mpos_d, mech->mpos(), mech->estimator.mvel());
}

void ControlSoftware::Impl::addGravity(Mechanism* mech) noexcept {
  if (!config.gravity_compensation) return;
  const std::array<double, 3> tau = mech->gravity.torque(mech->jpos);
  for (std::size_t j = 0; j < tau.size(); ++j)
    mech->tau[j] += tau[j];
}

void ControlSoftware::Impl::runQuickHoming() noexcept {
  if (!machine.mayHome()) {
    quick_homing.hold({mechanisms[0].jpos, mechanisms[1].jpos});
    return;
  }
  quick_homing.tick();
  for (Mechanism& mech : mechanisms) {
    mech.jpos_d = quick_homing.desired(mech.arm);
    mech.tau = track(&mech);
    addGravity(&mech);
  }
  torqueToDac();
  homed = quick_homing.done();
}

void ControlSoftware::Impl::runStopSearch() noexcept {
  if (!machine.mayHome()) return stop_search.interrupt();
  if (!stop_search.advance({mechanisms[0].jpos, mechanisms[1].jpos})) return;
  for (Mechanism& mech : mechanisms) {
    mech.jpos_d = stop_search.arm(mech.arm).desired();
    mech.tau = track(&mech);
  }
  torqueToDac();
  for (Mechanism& mech : mechanisms) {
    if (!stop_search.check(mech.arm, mech.jpos, &mech.dac)) continue;
    mech.jpos_d = mech.jpos = stop_search.arm(mech.arm).desired();
    mech.mpos_d = mech.coupling.toMotor(mech.jpos_d);
    mech.estimator.setMotor(mech.mpos_d);
  }
  homed = stop_search.done();
}

void ControlSoftware::Impl::control() noexcept {
  if (homed) {
    runCartesian();
  } else if (config.full_homing) {
    runStopSearch();
  } else {
    runQuickHoming();
  }
}

/** The first of the two wrist points (step 1 of raven2.md 2.5) within lw of the remote centre: the robot's inverse
 * gives up there, whatever the second one offers. */
bool ControlSoftware::Impl::isFirstWristPointAtRcm(const Pose& X_BT) const noexcept {
  Vector3 rcm_T = X_BT.inverse().p;
  rcm_T.z() = 0.0;
  const double off_axis = rcm_T.norm();
  return off_axis > 0.0 && (X_BT * Vector3(rcm_T * (geometry.lw / off_axis))).norm() <= geometry.lw;
}

bool ControlSoftware::Impl::solveInverse(Mechanism* mech) noexcept {
  if (!mech->pos_d.isFinite()) return false;
  const Pose X_BT = mech->pos_d.pose();
  if (isFirstWristPointAtRcm(X_BT)) return false;
  const kinematics::IkResult ik =
      kinematics::inverseWithinLimits(geometry, mech->arm, X_BT, mech->pos_d.opening(), mech->jpos);
  if (!kinematics::isUsable(ik.status)) return false;
  if (ik.status == kinematics::IkStatus::kClamped) {
    // Re-based to the limit, so that the master cannot wind up past it.
    mech->pos_d.setPose(kinematics::forward(geometry, mech->arm, ik.q));
    rebaseMaster();
  }
  mech->jpos_d = ik.q;
  return true;
}

void ControlSoftware::Impl::runCartesian() noexcept {
  if (machine.runLevel() < RunLevel::kPedalUp) return;
  // A refused gold target ends the robot's loop over the arms, so green freezes with it (raven2.md 4.5b).
  for (Mechanism& mech : mechanisms) {
    if (!solveInverse(&mech) && mech.arm == Arm::kGold) break;
  }
  for (Mechanism& mech : mechanisms) {
    mech.mpos_d = mech.coupling.toMotorMeasured(mech.jpos_d, mech.mpos()[kInsertion]);
    if (machine.runLevel() == RunLevel::kPedalDown) mech.tau = track(&mech);
    addGravity(&mech);
  }
  torqueToDac();
}

void ControlSoftware::Impl::torqueToDac() noexcept {
  for (Mechanism& mech : mechanisms) {
    mech.dac = machine.softEstopped() ? DacArray{} : mech.controller.toDac(mech.tau);
  }
}

void ControlSoftware::Impl::detectOverdrive() noexcept {
  const bool clips = machine.runLevel() >= RunLevel::kInit;
  for (Mechanism& mech : mechanisms) {
    if (overdrive.check(clips, &mech.dac)) machine.softEstop();
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

void ControlSoftware::Impl::publishState() noexcept {
  state.last_sequence = network.lastSequence();
  state.active_fault = faults.activeId();
  state.runlevel = machine.runLevel();
  state.sublevel = machine.subLevel();
  state.homed = homed ? 1 : 0;
  state.soft_estopped = machine.softEstopped() ? 1 : 0;
  state.itp = network.counts();
  for (Mechanism& mech : mechanisms) {
    RobotArmState& arm = at(state.arms, mech.arm);
    arm.q = mech.jpos;
    arm.dq = mech.coupling.toJoint(mech.published_velocity.update(mech.estimator.mvel()));
    arm.motor = mech.mpos();
    arm.dac = mech.dac;
    fillHoming(mech.arm, &arm.jstate);
  }
}

/** Quick homing knows all joints and only moves them home. */
void ControlSoftware::Impl::fillHoming(Arm arm, std::array<std::uint8_t, kJointCount>* jstate) const noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    JointHoming homing = config.full_homing ? stop_search.arm(arm).states()[j] : JointHoming::kHoming2;
    if (homed) homing = JointHoming::kReady;
    (*jstate)[j] = static_cast<std::uint8_t>(homing);
  }
}

void ControlSoftware::Impl::publishReport() noexcept {
  report.cycle = state.cycle;
  report.runlevel = static_cast<std::int32_t>(machine.runLevel());
  report.sublevel = machine.subLevel();
  report.last_sequence = static_cast<std::int32_t>(network.lastAccepted());
  for (const Mechanism& mech : mechanisms) {
    reportPose(mech.actual, index(mech.arm), &report.pos_um, &report.ori);
    reportPose(mech.pos_d, index(mech.arm), &report.pos_d_um, &report.ori_d);
    at(report.grasp_d, mech.arm) = mech.pos_d.opening();
    reportJoints(mech);
  }
}

void ControlSoftware::Impl::reportJoints(const Mechanism& mech) noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::size_t k = index(mech.arm) * kChannels + channelOf(j);
    report.encoder[k] = -mech.in.encoder[channelOf(j)];
    report.encoder_offset[k] = static_cast<float>(mech.estimator.offset()[j]);
    report.dac[k] = mech.dac[j];
    report.tau[k] = mech.tau[j];
    report.mpos[k] = mech.mpos()[j];
    report.mvel[k] = mech.estimator.mvel()[j];
    report.jpos[k] = mech.jpos[j];
    // Only three joints, and without the coupling (fwd_cable_coupling.cpp:177-180).
    report.jvel[k] = j <= kInsertion ? report.mvel[k] / config.axes[j].transmission : 0.0;
    report.mpos_d[k] = mech.mpos_d[j];
    report.jpos_d[k] = mech.jpos_d[j];
  }
}

ControlSoftware::ControlSoftware(const ArmsConfig& arms, const VirtualRavenConfig& config, const wire::ItpKey* key) {
  if (config.behaviour != "compat" && config.behaviour != "hardened") {
    throw ConfigException("virtual_raven: behaviour is \"" + config.behaviour + "\": there are compat and hardened");
  }
  impl_ = std::make_unique<Impl>(arms, config, key);
}

ControlSoftware::~ControlSoftware() = default;

void ControlSoftware::receive(const std::uint8_t* bytes, std::size_t size, std::uint64_t source) noexcept {
  impl_->network.receive(impl_->arrival(bytes, size, source), &impl_->faults);
  impl_->state.itp = impl_->network.counts();
}

bool ControlSoftware::receive(const std::uint8_t* bytes,
                              std::size_t size,
                              std::uint64_t source,
                              const wire::Nonce& fresh,
                              wire::HandshakeBytes* reply) noexcept {
  const wire::Arrival arrival = impl_->arrival(bytes, size, source);
  if (!impl_->network.isHello(arrival)) {
    receive(bytes, size, source);
    return false;
  }
  const bool answered = impl_->network.answer(arrival, fresh, reply) == Reject::kNone;
  impl_->state.itp = impl_->network.counts();
  return answered;
}

void ControlSoftware::setFaults(const FaultPlan& plan) noexcept {
  impl_->faults.setPlan(plan);
}

void ControlSoftware::startAtHome() noexcept {
  impl_->placeAt(JointArray{});
  impl_->quick_homing.assumeDone();
  impl_->homed = true;
  impl_->machine.startInPedalUp();
}

void ControlSoftware::automove(const PerArm<Vec3>& dp_um_base0, const PerArm<Quat>& dq) noexcept {
  impl_->network.automove(dp_um_base0, dq);
}

PerArm<UsbOutBytes> ControlSoftware::cycle(const PerArm<UsbInBytes>& boards) noexcept {
  PerArm<UsbRead> reads;
  for (const Arm arm : kArms)
    at(reads, arm).bytes = at(boards, arm);
  return cycle(reads);
}

PerArm<UsbOutBytes> ControlSoftware::cycle(const PerArm<UsbRead>& boards) noexcept {
  Impl& s = *impl_;
  ++s.state.cycle;
  s.faults.beginCycle(s.machine.runLevel() == RunLevel::kPedalDown);
  s.getUsbPackets(boards);
  s.machine.readPins(s.mechanisms[0].in.pins, s.mechanisms[1].in.pins);
  s.network.tick();
  s.network.idle(s.nowNs());
  for (Mechanism& mech : s.mechanisms) {
    mech.tau = JointArray{};
    mech.dac = DacArray{};
  }
  s.machine.step(s.homed);
  s.estimateState();
  s.updateTargets();
  s.control();
  s.detectOverdrive();
  const PerArm<UsbOutBytes> out = s.putUsbPackets();
  s.publishState();
  s.publishReport();
  return out;
}

const RobotState& ControlSoftware::state() const noexcept {
  return impl_->state;
}

const RavenReport& ControlSoftware::report() const noexcept {
  return impl_->report;
}

std::uint64_t ControlSoftware::usbReadErrors() const noexcept {
  return impl_->usb_errors;
}

}  // namespace raven2_trainer::raven
