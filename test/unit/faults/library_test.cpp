// The scenarios of config/faults in the engine: each acts as its file says, and at that time.

#include <gtest/gtest.h>

#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/faults/arming.h"
#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/faults/packet_stream.h"

namespace raven2_trainer::faults {
namespace {

// A session, in cycles: homing, a pause, teleoperation with a packet a cycle, the tool-change button.
constexpr std::int64_t kReady = 2500, kPedalDown = 3000, kToolChange = 9000, kEnd = 30000;

FaultCycle cycleAt(std::int64_t t) {
  FaultCycle cycle;
  cycle.pedal_down = t >= kPedalDown;
  cycle.run_level = t < kReady ? 1 : t < kPedalDown ? 2 : 3;
  cycle.signals.tool_changes = t >= kToolChange ? 1 : 0;
  return cycle;
}

/** Cycle at which the trigger comes; -1 if it never does. */
std::int64_t triggerOf(const Fault& fault) {
  switch (fault.trigger) {
    case FaultTrigger::kPedalDown:
    case FaultTrigger::kPacket:
      return kPedalDown;
    case FaultTrigger::kPowerOn:
      return 0;
    case FaultTrigger::kRunLevel:
      return fault.threshold == 3.0 ? kPedalDown : -1;
    case FaultTrigger::kToolChange:
      return kToolChange;
    default:
      return -1;
  }
}

bool shouldAct(const Fault& fault, std::int64_t t) {
  const std::int64_t since = t - triggerOf(fault) - fault.first_tick;
  if (since < 0) return false;
  const std::int64_t phase = fault.period_ticks > 0 ? since % fault.period_ticks : since;
  return fault.duration_ticks == 0 || phase < fault.duration_ticks;
}

const TrainerConfig& packaged() {
  static const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  return config;
}

FaultPlan planOf(const std::string& name) {
  return faults::planFor(packaged(), config::faultId(packaged(), name), 1);
}

TEST(FaultLibrary, EveryFaultActsFromItsFirstTickToItsLast) {
  for (const Scenario& scenario : packaged().scenarios) {
    const FaultPlan plan = planOf(scenario.name);
    ASSERT_EQ(plan.count, scenario.faults.size());
    for (std::size_t i = 0; i < plan.count; ++i) {
      const Fault& fault = plan.faults[i];
      ASSERT_GE(triggerOf(fault), 0) << scenario.name << ": nothing in a session brings its trigger";
      FaultEngine engine(fault.host);
      engine.setPlan(plan);
      std::int64_t wrong = 0, active = 0;
      for (std::int64_t t = 0; t < kEnd; ++t) {
        engine.beginPacket(t >= kPedalDown);
        engine.beginCycle(cycleAt(t));
        const bool acts = (engine.activeMask() >> i & 1U) != 0;
        wrong += acts != shouldAct(fault, t) ? 1 : 0;
        active += acts ? 1 : 0;
      }
      EXPECT_EQ(wrong, 0) << scenario.name << ", row " << i;
      EXPECT_GT(active, 0) << scenario.name << ", row " << i;
    }
  }
}

/** The robot's plain receiver (raven2 network_layer.cpp:257-312): in order only, the packet behind a gap is dropped. */
class PlainReceiver {
 public:
  void receive(const MasterCommand& packet) {
    const bool is_next = packet.sequence == last_ + 1;
    if (packet.sequence > last_) last_ = packet.sequence;
    if (!is_next) return;
    const Vec3& dp = at(packet.dp_I, Arm::kGold);
    moved_um += (dp[0] + dp[1] + dp[2]) * 1e6;
    ++used;
  }

  int used{0};
  double moved_um{0.0};

 private:
  std::uint32_t last_{0};
};

/** The receiver after `packets` packets without motion, with the pedal down. */
PlainReceiver received(const std::string& name, std::uint32_t packets) {
  FaultEngine engine(FaultHost::kRelay);
  engine.setPlan(planOf(name));
  CommandStream stream(FaultVariable::kPacket);
  PlainReceiver robot;
  for (std::uint32_t n = 1; n <= packets; ++n) {
    engine.beginCycle(cycleAt(kPedalDown));
    engine.beginPacket(true);
    MasterCommand packet{};
    packet.sequence = n;
    packet.pedal = 1;
    stream.offer(packet, &engine);
    while (stream.take(&packet, engine))
      robot.receive(packet);
  }
  return robot;
}

TEST(FaultLibrary, AHijackedRobotFollowsTheForgedPackets) {
  // 20 um in each of 1000 forged packets, of which the first only opens the gap
  EXPECT_NEAR(received("wire_hijack", 8000).moved_um, 999 * 20.0, 1e-3);
}

TEST(FaultLibrary, AStopIsOneCraftedPacket) {
  // 15 mm along x: over the 12 mm that stop the robot's software (raven2.md 4.5)
  EXPECT_NEAR(received("e_stop_flood", 8000).moved_um, 15000.0, 1e-3);
}

TEST(FaultLibrary, MixedUpPacketsMakeMotionJerkyAndDoNotEndIt) {
  const int used = received("intent_reorder_delay", 12000).used - 2000;  // acts from 2000 on
  EXPECT_GT(used, 2000);
  EXPECT_LT(used, 6000);  // half of the time no packet comes in order
}

}  // namespace
}  // namespace raven2_trainer::faults
