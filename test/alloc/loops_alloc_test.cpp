#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <mutex>

#include "support/allocation_counter.h"
#include "support/effort.h"
#include "support/rig.h"

#ifdef RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::allocatorCalls;
using raven2_trainer::testing::effort;
using raven2_trainer::testing::mutexLocks;

TEST(LoopsAlloc, ALockIsSeenWhereThereIsOne) {
  std::mutex mutex;
  EXPECT_EQ(allocatorCalls([&] { const std::lock_guard<std::mutex> lock(mutex); }), 0);
  EXPECT_EQ(mutexLocks(), 1);
}

TEST(LoopsAlloc, AMinuteInContactUnderAFaultTouchesNoHeapAndNoLock) {
  // GIVEN a fault that repeats every second for the whole session
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "sudden_jump";
  config.runtime.plan_at = -1.0;
  Fault& fault = raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump");
  fault.site = FaultSite::kNetworkLayer;
  fault.kind = FaultKind::kAdd;
  fault.variable = FaultVariable::kIncrement;
  fault.channel = 0;
  fault.value = 2.0;
  fault.first_tick = 500;
  fault.duration_ticks = 300;
  fault.period_ticks = 1000;
  fault.count = 0;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  std::int64_t ticks = 0, in_contact = 0, faulty = 0, both = 0;
  bool touched = false;
  // moves down to the scene, then presses and lifts alternately, with a clutch between
  const auto tick = [&] {
    const std::int64_t stroke = ticks / 300;
    const double speed = !touched ? 100e-6 : stroke % 2 == 0 ? 50e-6 : -50e-6;
    rig.tick(ticks % 300 >= 60, {0.0, 0.0, speed});
    const bool contact = rig.model().arms[0].contacts > 0, acts = rig.robot().active_fault != 0;
    touched = touched || contact;
    in_contact += contact ? 1 : 0;
    faulty += acts ? 1 : 0;
    both += contact && acts ? 1 : 0;
    ++ticks;
  };
  while (!touched && ticks < 6000)
    tick();
  for (int i = 0; i < 1000; ++i)
    tick();
  in_contact = faulty = both = 0;
  // THEN
  const std::int64_t counted = effort(3000, 60000);
  EXPECT_EQ(allocatorCalls([&] {
              for (std::int64_t i = 0; i < counted; ++i)
                tick();
            }),
            0);
  EXPECT_EQ(mutexLocks(), 0);
  EXPECT_GT(both, 0) << "no tick had both contacts and the fault: the test shows less than it says";
  EXPECT_GT(in_contact, counted / 20);
  EXPECT_GT(faulty, counted / 10);
  std::printf("%lld ticks, %lld in contact, %lld under the fault, %lld both\n", static_cast<long long>(counted),
              static_cast<long long>(in_contact), static_cast<long long>(faulty), static_cast<long long>(both));
}

TEST(LoopsAlloc, AHapticTickWithAllItsPartsTouchesNoHeapAndNoLock) {
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.haptics.guidance.enabled = config.haptics.edge.enabled = true;
  const auto shared = std::make_unique<SharedState>();
  loop::HapticLoop loop(config, shared.get());
  ModelState model;
  RobotState robot;
  GuidePath path;
  HapticRecord record;
  ForcePacket packet;
  std::int64_t guided = 0, at_edge = 0, felt = 0;
  EXPECT_EQ(allocatorCalls([&] {
              for (int k = 1; k <= 3000; ++k) {
                const std::int64_t now_ns = k * kTickNanoseconds;
                model.time_ns = robot.received_ns = now_ns;
                model.linked = model.pedal = k % 1000 < 900 ? 1 : 0;
                model.master_I[0] = {0.001 * (k % 10), 0.0, 0.0};
                model.arms[0].p_BT = {0.01, 0.005, 0.0};
                robot.connected = 1;
                robot.frame = robot.cycle = static_cast<std::uint64_t>(k);
                path.count = 200;
                path.plan = model.guide_plan = static_cast<std::uint32_t>(1 + k / 500);
                if (k % 500 == 0) shared->guide_path.store(path);
                shared->model.store(model);
                shared->robot.store(robot);
                loop.tick(now_ns);
                shared->haptic_records.tryPop(&record);
                shared->force_packets.tryPop(&packet);
                guided += record.haptic.guidance_B[0] != Vec3{} ? 1 : 0;
                at_edge += record.haptic.edge_B[0] != Vec3{} ? 1 : 0;
                felt += record.haptic.cue_B[0] != Vec3{} ? 1 : 0;
              }
            }),
            0);
  EXPECT_EQ(mutexLocks(), 0);
  EXPECT_GT(guided, 1000);
  EXPECT_GT(at_edge, 100);
  EXPECT_GT(felt, 2000);
}

TEST(LoopsAlloc, TicksOfDaemonAndVirtualRavenDoNotTouchTheHeap) {
  // GIVEN the whole chain from the master's datagram to the force, warmed up, teleoperating, with an acting fault
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "sudden_jump";
  raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump").first_tick = 2000;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  for (int i = 0; i < 1500; ++i)
    rig.tick(true, {10e-6, 0.0, 0.0});
  // THEN 2000 more ticks, 300 of them faulty, allocate nothing
  bool faulty = false;
  EXPECT_EQ(allocatorCalls([&] {
              for (int i = 0; i < 2000; ++i) {
                rig.tick(true, {i % 2 == 0 ? 10e-6 : -10e-6, 0.0, 0.0});
                faulty = faulty || rig.robot().active_fault != 0;
              }
            }),
            0);
  EXPECT_TRUE(faulty) << "no fault acted: the test shows less than it says";
}

TEST(LoopsAlloc, ClutchingPressingOnTheSceneAndRequestsDoNotTouchTheHeap) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  std::uint32_t contacts = 0;
  const auto press = [&] {
    for (int i = 0; i < 1500; ++i) {
      rig.tick(i % 300 >= 60, {0.0, 0.0, 50e-6});  // moves down, with a clutch now and then
      contacts += rig.model().arms[0].contacts;
    }
    Request request;
    request.kind = RequestKind::kSetCollisions;
    request.enabled = 0;
    rig.shared->requests.tryPush(request);
    for (int i = 0; i < 100; ++i)
      rig.tick(true);
    request.enabled = 1;
    rig.shared->requests.tryPush(request);
  };
  press();  // warm up
  contacts = 0;
  EXPECT_EQ(allocatorCalls(press), 0);
  EXPECT_GT(contacts, 0u) << "no contact: the test shows less than it says";
}

/** Chooses a goal and abandons it, then plans, arms, executes and releases. The test is the planner.
 *  @return ticks of executing. */
int planAndExecute(raven2_trainer::testing::Rig* rig) {
  const auto ask = [rig](RequestKind kind, std::uint8_t on_robot) {
    Request request;
    request.kind = kind;
    request.id = 5;
    request.on_robot = on_robot;
    rig->shared->requests.tryPush(request);
    rig->tick(false);
  };
  ask(RequestKind::kBeginPlanning, 0);
  for (int i = 0; i < 200; ++i)
    rig->tick(true, {20e-6, 10e-6, 0.0});
  ask(RequestKind::kEndPlanning, 0);
  ask(RequestKind::kPlan, 0);
  PlanRequest request;
  rig->shared->plan_requests.tryPop(&request);
  PlanResult plan;
  plan.id = request.id;
  plan.status = PlanStatus::kSuccess;
  plan.robot_follows = 1;
  plan.waypoint_count = 2;
  plan.waypoints[0] = plan.waypoints[1] = request.start;
  plan.waypoints[1][kShoulder] += 0.1;
  plan.arrival[1] = 1.0;
  plan.clearance = 0.002;
  rig->shared->plan_results.tryPush(plan);
  rig->tick(false);
  ask(RequestKind::kExecutePlan, 1);
  int executing = 0;
  for (int i = 0; i < 800; ++i) {
    rig->tick(true);
    executing += rig->model().mode == Mode::kExecuting && rig->model().linked != 0 ? 1 : 0;
  }
  for (int i = 0; i < 50; ++i)
    rig->tick(false);
  return executing;
}

TEST(LoopsAlloc, ChoosingArmingAndExecutingDoNotTouchTheHeap) {
  raven2_trainer::testing::useOde();
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  raven2_trainer::testing::Rig rig(config);
  ASSERT_TRUE(rig.home());
  for (int i = 0; i < 200; ++i)
    rig.tick(false);
  planAndExecute(&rig);  // warm up
  int executing = 0;
  EXPECT_EQ(allocatorCalls([&] { executing = planAndExecute(&rig); }), 0);
  EXPECT_EQ(mutexLocks(), 0);
  EXPECT_GT(executing, 700);
  EXPECT_EQ(rig.shared->last_execution.load().end, ExecutionEnd::kReleased);
}

}  // namespace
}  // namespace raven2_trainer::lockstep

#endif
