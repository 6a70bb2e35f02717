#include "raven2_trainer/raven/control_software.h"

#include <algorithm>
#include <optional>

#include "raven/command_guard.h"
#include "raven/gravity_compensation.h"
#include "raven/motor_controller.h"
#include "raven/network_layer.h"
#include "raven/quick_homing.h"
#include "raven/state_estimator.h"
#include "raven/state_machine.h"
#include "raven/stop_search.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/faults/packet_stream.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/low_pass.h"

// One cycle of the robot's control program, function by function in its order and by its names, to be read side by side
// with raven2's sources: that is why this file is long.

namespace raven2_trainer::raven {
namespace {

/** The software's data of one arm ("mechanism"). */
struct Mechanism {
  Mechanism(Arm which, const VirtualRavenConfig& config)
      : arm(which),
        coupling(which, config),
        estimator(which, config.low_pass),
        controller(which, config),
        gravity(which, config) {}

  Arm arm;
  CableCoupling coupling;
  StateEstimator estimator;
  MotorController controller;
  GravityCompensation gravity;
  LowPass published_velocity;

  UsbIn read{}, in{};   // as the board sent it; as the software takes it
  UsbOutBytes sent{};   // what the arm's board was last sent
  JointArray mpos{};    // [rad] as the estimator says, and after faults
  JointArray mvel{};    // [rad/s] the same
  JointArray jpos{};    // [rad; m]
  JointArray jvel{};    // [rad/s; m/s] only shown
  JointArray jpos_d{};  // [rad; m] stays where it is when the inverse refuses
  JointArray mpos_d{};  // [rad]
  Pose X_BT;            // actual tip
  MasterTarget actual;  // the same, in the target's integers
  MasterTarget pos_d;   // desired tip
  JointArray tau{};     // [Nm] capstan
  DacArray dac{};
};

constexpr std::int32_t kBoards = 2;  // activeAtStart

/** State frames: only the time is their own. */
struct FrameTraits {
  static std::uint64_t& sequence(RobotState& state) noexcept { return state.cycle; }
  static void takeMotion(RobotState* to, const RobotState& from) noexcept {
    const RobotState own = *to;
    *to = from;
    to->cycle = own.cycle;
    to->time_ns = own.time_ns;
    to->active_fault = own.active_fault;  // the ground truth is not the robot's to freeze
    to->fault_mask = own.fault_mask;
  }
  static void forge(RobotState*, Arm, std::size_t, double) noexcept {}
};

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
  Impl(const ArmsConfig& arms_config, const VirtualRavenConfig& virtual_raven, const wire::ItpKey* key)
      : arms(arms_config),
        geometry(arms.geometry),
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
  void beginCycle() noexcept;
  const PerArm<UsbOutBytes>& die(const PerArm<UsbOutBytes>& last) noexcept;
  void runCycle(const PerArm<UsbRead>& boards) noexcept;
  void getUsbPackets(const PerArm<UsbRead>& boards) noexcept;
  void getUsbPacket(const PerArm<UsbRead>& boards, Mechanism* mech) noexcept;
  RunLevel faultedLevel(FaultVariable variable, RunLevel level) noexcept;
  void readLevel() noexcept;
  void estimateState() noexcept;
  void corruptTip(Mechanism* mech) noexcept;
  void trackActual() noexcept;
  void updateTargets() noexcept;
  void control() noexcept;
  void runQuickHoming() noexcept;
  void runStopSearch() noexcept;
  void runCartesian() noexcept;
  void torqueToDac() noexcept;
  void detectOverdrive() noexcept;
  std::uint8_t atmelOutputs() noexcept;
  PerArm<UsbOutBytes> putUsbPackets() noexcept;
  UsbOutBytes packetFor(Mechanism* mech, std::uint8_t pins) noexcept;
  void putUsbPacket(Mechanism* mech, std::uint8_t pins) noexcept;
  void guardCommands() noexcept;
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
  bool solveInverse(Mechanism* mech) noexcept;
  void addGravity(Mechanism* mech) noexcept;
  void couple(Mechanism* mech) noexcept;
  JointArray track(Mechanism* mech) noexcept;
  void rebaseMaster() noexcept { network.rebase({&mechanisms[0].pos_d, &mechanisms[1].pos_d}); }

  ArmsConfig arms;
  ArmGeometry geometry;
  VirtualRavenConfig config;
  faults::FaultEngine faults{FaultHost::kRobot};
  FaultSignals signals{};
  bool has_last_words{false};
  faults::PacketStream<RobotState, FrameTraits> returned{FaultVariable::kFrame};
  NetworkLayer network;
  StateMachine machine;
  OverdriveCheck overdrive;
  std::optional<CommandGuard> guard;  // none: mitigate off
  QuickHoming quick_homing;
  StopSearch stop_search;
  bool homed{false};  // control mode cartesian, for good
  std::uint64_t usb_errors{0};
  PerArm<Mechanism> mechanisms;
  RobotState state;
  RavenReport report;
};

/** The boards count from 0 at power-on; the joints' places at that time give the offsets. */
void ControlSoftware::Impl::placeAt(const JointArray& offset_from_home) noexcept {
  for (Mechanism& mech : mechanisms) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      mech.jpos_d[j] = geometry.home[j] + offset_from_home[j];
    mech.estimator.setMotor(mech.coupling.toMotor(mech.jpos_d));
    mech.mpos = mech.estimator.mpos();
  }
}

void ControlSoftware::Impl::getUsbPackets(const PerArm<UsbRead>& boards) noexcept {
  std::int32_t count = faults.applyInt(FaultVariable::kGetBoardCount, Arm::kGold, 0, kBoards);
  for (Mechanism& mech : mechanisms) {
    if (count-- > 0) getUsbPacket(boards, &mech);
    mech.in = mech.read;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      std::int32_t& counts = mech.in.encoder[channelOf(j)];
      counts = clampCount(faults.applyInt(FaultVariable::kEncoder, mech.arm, j, counts));
    }
    mech.in.pins = static_cast<std::uint8_t>(faults.applyInt(FaultVariable::kInputs, mech.arm, 0, mech.in.pins));
  }
}

/** A read that fails leaves the old counts and pins; so does another type of packet, which is no error. */
void ControlSoftware::Impl::getUsbPacket(const PerArm<UsbRead>& boards, Mechanism* mech) noexcept {
  const auto own = static_cast<std::int32_t>(index(mech->arm));
  const std::int32_t board = faults.applyInt(FaultVariable::kGetBoardIndex, mech->arm, 0, own);
  if (board < 0 || board >= kBoards) {
    ++usb_errors;
    return;
  }
  const UsbRead& read = boards[static_cast<std::size_t>(board)];
  if (faults.applyInt(FaultVariable::kReadResult, mech->arm, 0, read.result) != UsbRead::kComplete) {
    ++usb_errors;
    return;
  }
  UsbInBytes bytes = read.bytes;
  for (std::size_t k = 0; faults.isArmed() && k < kMaxFaultChannels; ++k) {
    std::uint8_t& byte = bytes[bytes.size() - kMaxFaultChannels + k];
    byte = static_cast<std::uint8_t>(faults.applyInt(FaultVariable::kBuffer, mech->arm, k, byte));
  }
  decodeIn(bytes, &mech->read);
}

/** Whatever a fault adds or turns round, there are four levels. */
RunLevel ControlSoftware::Impl::faultedLevel(FaultVariable variable, RunLevel level) noexcept {
  const std::int32_t faulted = faults.applyInt(variable, Arm::kGold, 0, static_cast<std::int32_t>(level));
  return static_cast<RunLevel>(std::clamp(faulted, 0, 3));
}

void ControlSoftware::Impl::readLevel() noexcept {
  const RunLevel wanted = StateMachine::levelOf(mechanisms[0].in.pins, mechanisms[1].in.pins);
  // PLCState is shown and no more (raven2.md 4.3).
  faults.applyInt(FaultVariable::kPlcState, Arm::kGold, 0, static_cast<std::int32_t>(wanted));
  machine.follow(faultedLevel(FaultVariable::kRunLevelDesired, wanted));
}

void ControlSoftware::Impl::estimateState() noexcept {
  for (Mechanism& mech : mechanisms) {
    mech.estimator.update(mech.in.encoder);
    mech.mpos = mech.estimator.mpos();
    mech.mvel = mech.estimator.mvel();
    faults.applyAll(FaultVariable::kMpos, mech.arm, &mech.mpos);
    faults.applyAll(FaultVariable::kMvel, mech.arm, &mech.mvel);
    mech.jpos = mech.coupling.toJoint(mech.mpos);
    faults.applyAll(FaultVariable::kJpos, mech.arm, &mech.jpos);
    mech.jvel = mech.coupling.toJoint(mech.published_velocity.update(mech.mvel));
    faults.applyAll(FaultVariable::kJvel, mech.arm, &mech.jvel);
    mech.X_BT = kinematics::forward(geometry, mech.arm, mech.jpos);
    mech.actual.set(mech.X_BT, kinematics::jawOpening(mech.jpos));
    corruptTip(&mech);
  }
}

void ControlSoftware::Impl::corruptTip(Mechanism* mech) noexcept {
  if (!faults.isArmed()) return;
  for (std::size_t k = 0; k < 3; ++k)
    mech->actual.p_um[k] = faults.applyInt(FaultVariable::kPos, mech->arm, k, mech->actual.p_um[k]);
  const Matrix3 R = mech->X_BT.R;
  Matrix3 faulted = R;
  for (Eigen::Index k = 0; k < 9; ++k)
    faulted(k / 3, k % 3) = faults.apply(FaultVariable::kOri, mech->arm, static_cast<std::size_t>(k), R(k / 3, k % 3));
  if (faulted != R) mech->actual.R_BT = Quaternion(faulted).normalized();
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
    for (std::size_t k = 0; k < 3; ++k)
      mech.pos_d.p_um[k] = faults.applyInt(FaultVariable::kPosD, mech.arm, k, mech.pos_d.p_um[k]);
  }
}

void ControlSoftware::Impl::couple(Mechanism* mech) noexcept {
  mech->mpos_d = mech->coupling.toMotorMeasured(mech->jpos_d, mech->mpos[kInsertion]);
  faults.applyAll(FaultVariable::kMposD, mech->arm, &mech->mpos_d);
}

JointArray ControlSoftware::Impl::track(Mechanism* mech) noexcept {
  JointArray gains{1, 1, 1, 1, 1, 1, 1};
  faults.applyAll(FaultVariable::kGain, mech->arm, &gains);
  mech->controller.scaleGains(gains);
  JointArray tau = mech->controller.torque(mech->mpos_d, mech->mpos, mech->mvel);
  faults.applyAll(FaultVariable::kTauD, mech->arm, &tau);
  return tau;
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
    couple(&mech);
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
    couple(&mech);
    mech.tau = track(&mech);
  }
  torqueToDac();
  for (Mechanism& mech : mechanisms) {
    if (!stop_search.check(mech.arm, mech.jpos, &mech.dac)) continue;
    mech.jpos_d = mech.jpos = stop_search.arm(mech.arm).desired();
    mech.mpos_d = mech.coupling.toMotor(mech.jpos_d);
    mech.estimator.setMotor(mech.mpos_d);
    mech.mpos = mech.mpos_d;
    mech.mvel = JointArray{};
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

bool ControlSoftware::Impl::solveInverse(Mechanism* mech) noexcept {
  if (!mech->pos_d.isFinite()) return false;
  const Pose X_BT = mech->pos_d.pose();
  if (kinematics::isFirstWristPointAtRcm(geometry, X_BT)) return false;
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
  // A refused gold target ends the robot's loop over the arms, so green freezes with it (raven2.md 4.5).
  for (Mechanism& mech : mechanisms) {
    if (!solveInverse(&mech) && mech.arm == Arm::kGold) break;
  }
  for (Mechanism& mech : mechanisms) {
    faults.applyAll(FaultVariable::kJposD, mech.arm, &mech.jpos_d);
    couple(&mech);
    if (machine.runLevel() == RunLevel::kPedalDown) mech.tau = track(&mech);
    addGravity(&mech);
  }
  torqueToDac();
}

void ControlSoftware::Impl::torqueToDac() noexcept {
  for (Mechanism& mech : mechanisms) {
    mech.dac = machine.softEstopped() ? DacArray{} : mech.controller.toDac(mech.tau);
    for (std::size_t j = 0; j < kJointCount; ++j)
      mech.dac[j] = faults.applyInt(FaultVariable::kCurrentCmd, mech.arm, j, mech.dac[j]);
  }
}

void ControlSoftware::Impl::detectOverdrive() noexcept {
  const bool clips = machine.runLevel() >= RunLevel::kInit;
  for (Mechanism& mech : mechanisms) {
    if (overdrive.check(clips, &mech.dac)) machine.softEstop();
  }
}

std::uint8_t ControlSoftware::Impl::atmelOutputs() noexcept {
  const auto faulted = [this](FaultVariable variable, std::int32_t value) {
    return faults.applyInt(variable, Arm::kGold, 0, value);
  };
  StateMachine::Outputs outputs;
  outputs.pedal = faulted(FaultVariable::kSurgeonMode, network.pedal() ? 1 : 0) != 0;
  outputs.level = faultedLevel(FaultVariable::kRunLevel, machine.runLevel());
  outputs.initialized = faulted(FaultVariable::kInitialized, machine.initialized() ? 1 : 0) != 0;
  return machine.outputPins(outputs);
}

/** A board that is not written keeps its last command; writing beyond the array of boards ends the program. */
PerArm<UsbOutBytes> ControlSoftware::Impl::putUsbPackets() noexcept {
  const std::uint8_t pins = atmelOutputs();
  std::int32_t count = faults.applyInt(FaultVariable::kPutBoardCount, Arm::kGold, 0, kBoards);
  if (count > kBoards) state.program = ProgramState::kCrashed;
  for (Mechanism& mech : mechanisms) {
    if (count-- > 0) putUsbPacket(&mech, pins);
  }
  if (guard) guardCommands();
  return {mechanisms[0].sent, mechanisms[1].sent};
}

void ControlSoftware::Impl::guardCommands() noexcept {
  const auto commandOf = [](Mechanism* mech) {
    return CommandGuard::ArmCommand{&mech->mpos, &mech->jpos, &mech->dac, &mech->sent};
  };
  const bool engaged = machine.runLevel() == RunLevel::kPedalDown && !machine.softEstopped();
  if (guard->check({commandOf(&mechanisms[0]), commandOf(&mechanisms[1])}, engaged, machine.softEstopped()))
    machine.softEstop();
}

void ControlSoftware::Impl::putUsbPacket(Mechanism* mech, std::uint8_t pins) noexcept {
  const auto own = static_cast<std::int32_t>(index(mech->arm));
  const std::int32_t board = faults.applyInt(FaultVariable::kPutBoardIndex, mech->arm, 0, own);
  const UsbOutBytes bytes = packetFor(mech, pins);
  if (board >= 0 && board < kBoards) mechanisms[static_cast<std::size_t>(board)].sent = bytes;
}

UsbOutBytes ControlSoftware::Impl::packetFor(Mechanism* mech, std::uint8_t pins) noexcept {
  UsbOut out;
  out.pins = static_cast<std::uint8_t>(faults.applyInt(FaultVariable::kOutputs, mech->arm, 0, pins));
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::int16_t dac = low16(faults.applyInt(FaultVariable::kDac, mech->arm, j, mech->dac[j]));
    mech->dac[j] = out.dac[channelOf(j)] = dac;
  }
  return encodeOut(out);
}

void ControlSoftware::Impl::publishState() noexcept {
  state.last_sequence = network.lastSequence();
  state.active_fault = faults.activeId();
  state.fault_mask = faults.activeMask();
  state.runlevel = machine.runLevel();
  state.sublevel = machine.subLevel();
  state.homed = homed ? 1 : 0;
  state.soft_estopped = machine.softEstopped() ? 1 : 0;
  state.itp = network.counts();
  for (Mechanism& mech : mechanisms) {
    RobotArmState& arm = at(state.arms, mech.arm);
    arm.q = mech.jpos;
    arm.dq = mech.jvel;
    arm.motor = mech.mpos;
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
    report.mpos[k] = mech.mpos[j];
    report.mvel[k] = mech.mvel[j];
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
  if (!isAlive()) return;
  impl_->network.receive(impl_->arrival(bytes, size, source), &impl_->faults);
  impl_->state.itp = impl_->network.counts();
}

bool ControlSoftware::receive(const std::uint8_t* bytes,
                              std::size_t size,
                              std::uint64_t source,
                              const wire::Nonce& fresh,
                              wire::HandshakeBytes* reply) noexcept {
  const wire::Arrival arrival = impl_->arrival(bytes, size, source);
  if (!isAlive()) return false;
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

void ControlSoftware::Impl::beginCycle() noexcept {
  ++state.cycle;
  const RunLevel level = machine.runLevel();
  faults.beginCycle({level == RunLevel::kPedalDown, static_cast<int>(level), signals});
  if (faults.acting(FaultVariable::kProgram, FaultKind::kCrash) != nullptr) state.program = ProgramState::kCrashed;
  if (faults.acting(FaultVariable::kProgram, FaultKind::kHang) != nullptr) state.program = ProgramState::kHung;
}

void ControlSoftware::Impl::runCycle(const PerArm<UsbRead>& boards) noexcept {
  getUsbPackets(boards);
  readLevel();
  network.release(&faults);
  network.tick();
  network.idle(nowNs());
  for (Mechanism& mech : mechanisms) {
    mech.tau = JointArray{};
    mech.dac = DacArray{};
  }
  machine.step(homed);
  estimateState();
  updateTargets();
  control();
  detectOverdrive();
}

PerArm<UsbOutBytes> ControlSoftware::cycle(const PerArm<UsbRead>& boards) noexcept {
  Impl& s = *impl_;
  const PerArm<UsbOutBytes> last{s.mechanisms[0].sent, s.mechanisms[1].sent};
  if (!isAlive()) return last;
  s.beginCycle();
  if (!isAlive()) return s.die(last);
  s.runCycle(boards);
  const PerArm<UsbOutBytes> out = s.putUsbPackets();
  if (!isAlive()) return s.die(last);
  s.publishState();
  s.publishReport();
  return out;
}

/** The program says nothing more; the injector does, once, so that the record knows what ended it. */
const PerArm<UsbOutBytes>& ControlSoftware::Impl::die(const PerArm<UsbOutBytes>& last) noexcept {
  publishState();
  has_last_words = true;
  return last;
}

bool ControlSoftware::isAlive() const noexcept {
  return impl_->state.program == ProgramState::kRunning;
}

void ControlSoftware::setDetector(const DetectorConfig& detector) {
  if (detector.mitigate == Mitigation::kOff) return;
  impl_->guard.emplace(impl_->arms, impl_->config, detector);
}

DetectorReport ControlSoftware::detectorReport() const noexcept {
  return impl_->guard ? impl_->guard->report() : DetectorReport{};
}

void ControlSoftware::setSignals(const FaultSignals& signals) noexcept {
  impl_->signals = signals;
}

bool ControlSoftware::nextFaultChange(FaultChange* change) noexcept {
  if (!impl_->faults.nextChange(change)) return false;
  change->cycle = impl_->state.cycle;
  return true;
}

void ControlSoftware::returnState(std::int64_t time_ns) noexcept {
  Impl& s = *impl_;
  if (!isAlive() && !s.has_last_words) return;
  s.has_last_words = false;
  RobotState state = s.state;
  state.time_ns = time_ns;
  for (const Arm arm : kArms)
    s.faults.applyAll(FaultVariable::kReturnedJpos, arm, &at(state.arms, arm).q);
  state.runlevel = s.faultedLevel(FaultVariable::kReturnedRunLevel, state.runlevel);
  s.returned.offer(state, &s.faults);
}

bool ControlSoftware::nextReturned(RobotState* state) noexcept {
  return impl_->returned.take(state, impl_->faults);
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
