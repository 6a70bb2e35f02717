#include "ros/raven/raven_state_reader.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/ticks.h"
#include "ros/node/seconds_between.h"
#include "ros/raven/raven_conversion.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kRadians = kPi / 180.0;
constexpr int kRestart = 0;              // of the stream: no velocity can be reported
constexpr double kRestartGap = 0.1;      // [s] a longer one is a restart
constexpr double kStampNoise = 0.25e-3;  // [s]
constexpr std::int32_t kReadyLevel = 2;  // PEDAL_UP: reached only homed, which happens once (raven2.md 4.3)

JointArray radians(const raven_2::Floats16& degrees, Arm arm) {
  JointArray values = jointsOf(degrees, arm);
  for (double& value : values)
    value *= kRadians;
  return values;
}

bool isFinite(const raven_2::Floats16& values) {
  return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

std::array<std::int32_t, kJointCount> counts(const raven_2::Ints16& channels, Arm arm) {
  const JointArray values = jointsOf(channels, arm);
  std::array<std::int32_t, kJointCount> result{};
  std::transform(values.begin(), values.end(), result.begin(), [](double x) { return static_cast<std::int32_t>(x); });
  return result;
}

}  // namespace

RavenStateReader::RavenStateReader(const VirtualRavenConfig& config)
    : couplings_{raven::CableCoupling(Arm::kGold, config), raven::CableCoupling(Arm::kGreen, config)} {}

bool RavenStateReader::read(const raven_2::RavenState& message, std::int64_t now_ns, RobotState* state) {
  return readAny(message, message.dac_val, now_ns, state);
}

bool RavenStateReader::read(const raven_2::ForkRavenState& message, std::int64_t now_ns, RobotState* state) {
  return readAny(message, message.current_cmd, now_ns, state);
}

template <typename Message>
bool RavenStateReader::readAny(const Message& message,
                               const raven_2::Ints16& dac,
                               std::int64_t now_ns,
                               RobotState* state) {
  const bool is_known = message.runlevel >= 0 && message.runlevel < static_cast<std::int32_t>(kRunLevelNames.size());
  if (!is_known || !isFinite(message.mpos) || !isFinite(message.jpos)) return false;
  const int cycles = cyclesSince(message.hdr.stamp, message.dt);
  RobotState next;
  next.cycle = cycle_;
  next.time_ns = now_ns;
  next.last_sequence = static_cast<std::uint32_t>(message.last_seq);
  next.runlevel = static_cast<RunLevel>(message.runlevel);
  next.sublevel = static_cast<std::uint8_t>(std::clamp(message.sublevel, 0, 255));
  homed_ = message.runlevel >= kReadyLevel || (homed_ && cycles != kRestart);
  next.homed = homed_ ? 1 : 0;
  for (const Arm arm : kArms) {
    RobotArmState& to = at(next.arms, arm);
    to.q = radians(message.jpos, arm);
    to.dac = counts(dac, arm);
    readArm(arm, cycles, radians(message.mpos, arm), &to);
  }
  *state = next;
  return true;
}

void RavenStateReader::readArm(Arm arm, int cycles, const JointArray& motor, RobotArmState* state) {
  raven::LowPass& filter = at(filters_, arm);
  const bool is_steady = homed_ && cycles != kRestart;  // homing gives the encoders a new reference: no motion
  if (!is_steady) filter = raven::LowPass();
  JointArray rate{}, smooth{};
  for (std::size_t j = 0; j < kJointCount && is_steady; ++j)
    rate[j] = (motor[j] - at(motor_, arm)[j]) / (cycles * kTickSeconds);
  for (int i = 0; i < std::max(cycles, 1); ++i)
    smooth = filter.update(rate);
  at(motor_, arm) = motor;
  state->motor = motor;
  state->dq = at(couplings_, arm).toJoint(smooth);
}

/**
 * Cycles since the message before, by its time stamp: the real robot does not number its messages. `dt` is the robot's
 * time since it published last. Where the stamps agree with it, nothing was lost, even with uneven cycles.
 * kRestart after a gap, a step back, or a dt of zero, which only the first message of a start has.
 */
int RavenStateReader::cyclesSince(const ros::Time& stamp, const ros::Duration& dt) {
  const double step = secondsBetween(stamp_, stamp);
  const bool is_first = cycle_ == 0;
  const bool is_restart = dt.isZero() && step != 0.0;
  stamp_ = stamp;
  const bool is_gap = is_first || is_restart || step < 0.0 || step > kRestartGap;
  const bool is_next = std::abs(step - dt.toSec()) < kStampNoise;
  const int cycles = is_gap ? kRestart : is_next ? 1 : std::max(1, static_cast<int>(toTicks(step)));
  cycle_ += static_cast<std::uint64_t>(std::max(cycles, 1));
  return cycles;
}

}  // namespace raven2_trainer::ros_bridge
