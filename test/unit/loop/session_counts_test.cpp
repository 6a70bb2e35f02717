#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer {
namespace {

RingCounts& at(SessionCounts& counts, RingId id) {
  return counts.rings[static_cast<std::size_t>(id)];
}

/** The counts of a session of 1000 ticks in which every sum is right. */
SessionCounts rightSums() {
  SessionCounts c;
  c.master.received = 980;
  c.master.applied = 975;
  c.master.rejected[static_cast<std::size_t>(Reject::kDuplicate)] = 3;
  c.master.rejected[static_cast<std::size_t>(Reject::kQueueFull)] = 2;
  at(c, RingId::kMasterCommands) = {975, 970, 2};  // five still wait for a tick
  at(c, RingId::kCommandRecords) = {969, 969, 1};
  c.master_used = 900;
  c.relay_sent = 986;
  c.relay_network = {3, 1, 2};
  c.relay_failed = 4;
  at(c, RingId::kRelayPackets) = {994, 994, 6};
  c.force_sent = 999;
  c.force_failed = 2;
  c.force_silent = 1;
  at(c, RingId::kForcePackets) = {1000, 1000, 0};
  at(c, RingId::kTickRecords) = {998, 998, 2};
  at(c, RingId::kHapticRecords) = {1000, 1000, 0};
  at(c, RingId::kRequests) = {3, 3, 0};
  at(c, RingId::kPedalRequests) = {5, 4, 1};  // one still waits
  at(c, RingId::kRequestRecords) = {7, 7, 0};
  c.records_dropped = 3;
  c.loops[0].ticks = 1000;
  c.loops[0].on_time = 990;
  c.loops[0].slips = 10;
  c.loops[1].ticks = 1000;
  c.loops[1].on_time = 1000;
  return c;
}

TEST(SessionCounts, AddUpWhereEverythingIsAccountedFor) {
  EXPECT_EQ(wrongSum(rightSums()), nullptr);
  EXPECT_TRUE(addsUp(SessionCounts{}));
  SessionCounts doubled = rightSums();
  doubled.master_used = 1900;
  doubled.master_faults.added = 970;
  EXPECT_EQ(wrongSum(doubled), nullptr) << "duplicated commands move the model too";
}

TEST(SessionCounts, AddUpWhereClientsAreMastersToo) {
  SessionCounts c = rightSums();
  c.master_overruled = 300;  // the console's commands
  c.servo_made = 290;
  at(c, RingId::kCommandRecords) = {959, 959, 1};
  EXPECT_EQ(wrongSum(c), nullptr);
  c.master_used = 961;
  EXPECT_NE(wrongSum(c), nullptr) << "more commands were used than recorded";
}

TEST(SessionCounts, DoNotAddUpAsSoonAsOneIsUnaccountedFor) {
  const std::function<void(SessionCounts&)> losses[] = {
      [](SessionCounts& c) { ++c.master.received; },
      [](SessionCounts& c) { ++c.robot_state.received; },
      [](SessionCounts& c) { ++c.relay.applied; },
      [](SessionCounts& c) { ++c.master.received, ++c.master.applied; },
      [](SessionCounts& c) { ++at(c, RingId::kMasterCommands).dropped; },
      [](SessionCounts& c) { ++at(c, RingId::kMasterCommands).taken; },
      [](SessionCounts& c) { c.master_used = 971; },
      [](SessionCounts& c) { ++c.master_overruled; },
      [](SessionCounts& c) { ++c.servo_made; },
      [](SessionCounts& c) { ++c.efforts_made; },
      [](SessionCounts& c) { --c.relay_sent; },
      [](SessionCounts& c) { ++at(c, RingId::kRelayPackets).pushed; },
      [](SessionCounts& c) { --c.force_sent; },
      [](SessionCounts& c) { ++c.force_silent; },
      [](SessionCounts& c) { ++c.relay_network.lost; },
      [](SessionCounts& c) { ++c.relay_network.added; },
      [](SessionCounts& c) { --c.relay_network.held; },
      [](SessionCounts& c) { ++at(c, RingId::kForcePackets).pushed; },
      [](SessionCounts& c) { --at(c, RingId::kTickRecords).taken; },
      [](SessionCounts& c) { ++at(c, RingId::kHapticRecords).dropped; },
      [](SessionCounts& c) { ++c.records_dropped; },
      [](SessionCounts& c) { --at(c, RingId::kRequestRecords).pushed, --at(c, RingId::kRequestRecords).taken; },
      [](SessionCounts& c) { ++at(c, RingId::kPedalRequests).taken; },
      [](SessionCounts& c) { ++at(c, RingId::kExerciseRecords).pushed; },
      [](SessionCounts& c) { ++at(c, RingId::kExerciseRecords).dropped; },
      [](SessionCounts& c) { ++c.loops[0].ticks; },
      [](SessionCounts& c) { ++c.loops[1].slips; },
      [](SessionCounts& c) {
        at(c, RingId::kPlanResults) = {1, 1, 0};
      },
      [](SessionCounts& c) {
        at(c, RingId::kFaultRequests) = {1, 2, 0};
      },
  };
  int number = 0;
  for (const auto& lose : losses) {
    SessionCounts counts = rightSums();
    lose(counts);
    EXPECT_FALSE(addsUp(counts)) << "loss " << number;
    ++number;
  }
}

TEST(SessionCounts, OfTheSharedStateAreThoseOfEveryRing) {
  const auto shared = std::make_unique<SharedState>();
  Request request;
  for (int i = 0; i < 40; ++i)
    shared->requests.tryPush(request);
  for (int i = 0; i < 5; ++i)
    shared->requests.tryPop(&request);
  for (std::size_t i = 0; i < decltype(RecordRings::faults)::kCapacity + 4; ++i)
    shared->fault_records.tryPush({});
  for (std::size_t i = 0; i < decltype(RecordRings::exercises)::kCapacity + 1; ++i)
    shared->exercise_records.tryPush({});
  shared->pedal_requests.tryPush(request);
  const SessionCounts counts = sharedCounts(*shared);
  const RingCounts& requests = ring(counts, RingId::kRequests);
  EXPECT_EQ(requests.pushed, 32U) << "as many as the ring holds";
  EXPECT_EQ(requests.taken, 5U);
  EXPECT_EQ(requests.dropped, 8U);
  EXPECT_EQ(ring(counts, RingId::kFaultRecords).dropped, 4U);
  EXPECT_EQ(ring(counts, RingId::kPedalRequests).pushed, 1U);
  EXPECT_EQ(ring(counts, RingId::kExerciseRecords).dropped, 1U);
  EXPECT_EQ(counts.records_dropped, 5U) << "records alone, not requests";
}

TEST(SessionCounts, TakeEachCounterOfTheSharedStateForWhatItIs) {
  const auto shared = std::make_unique<SharedState>();
  struct Row {
    Counter SharedState::*counter;
    std::uint64_t SessionCounts::*total;
  };
  const Row rows[] = {
      {&SharedState::master_used, &SessionCounts::master_used},
      {&SharedState::master_overruled, &SessionCounts::master_overruled},
      {&SharedState::servo_made, &SessionCounts::servo_made},
      {&SharedState::efforts_made, &SessionCounts::efforts_made},
      {&SharedState::relay_sent, &SessionCounts::relay_sent},
      {&SharedState::relay_failed, &SessionCounts::relay_failed},
      {&SharedState::relay_released, &SessionCounts::relay_released},
      {&SharedState::force_sent, &SessionCounts::force_sent},
      {&SharedState::force_failed, &SessionCounts::force_failed},
      {&SharedState::force_silent, &SessionCounts::force_silent},
      {&SharedState::ik_clamped, &SessionCounts::ik_clamped},
      {&SharedState::frames, &SessionCounts::frames},
      {&SharedState::contacts_dropped, &SessionCounts::contacts_dropped},
  };
  std::uint64_t number = 100;
  for (const Row& row : rows)
    ((*shared).*row.counter).add(number++);
  shared->master_faults.store({1, 2, 3});
  shared->relay_faults.store({4, 5, 6});
  shared->relay_network.store({7, 8, 9});
  shared->fault_changes_lost.add(10);
  shared->fault_changes_unreported.add(20);
  const SessionCounts counts = sharedCounts(*shared);
  number = 100;
  for (const Row& row : rows)
    EXPECT_EQ(counts.*row.total, number++) << &row - rows;
  EXPECT_EQ(counts.master_faults.held, 3U);
  EXPECT_EQ(counts.relay_faults.held, 6U);
  EXPECT_EQ(counts.relay_network.held, 9U);
  EXPECT_EQ(counts.fault_changes_lost, 30U) << "both kinds of loss";
}

TEST(SessionCounts, FindEachRingUnderItsName) {
  const auto shared = std::make_unique<SharedState>();
  const std::map<std::string, std::function<bool()>> push{
      {"master_commands", [&] { return shared->master_commands.tryPush({}); }},
      {"requests", [&] { return shared->requests.tryPush({}); }},
      {"pedal_requests", [&] { return shared->pedal_requests.tryPush({}); }},
      {"fault_requests", [&] { return shared->fault_requests.tryPush({}); }},
      {"fault_changes", [&] { return shared->fault_changes.tryPush({}); }},
      {"plan_requests", [&] { return shared->plan_requests.tryPush({}); }},
      {"plan_results", [&] { return shared->plan_results.tryPush({}); }},
      {"relay_packets", [&] { return shared->relay_packets.tryPush({}); }},
      {"force_packets", [&] { return shared->force_packets.tryPush({}); }},
      {"servo_commands", [&] { return shared->servo_commands.tryPush({}); }},
      {"servo_refused", [&] { return shared->servo_refused.tryPush({}); }},
      {"tick_records", [&] { return shared->records.ticks.tryPush({}); }},
      {"haptic_records", [&] { return shared->records.haptics.tryPush({}); }},
      {"command_records", [&] { return shared->records.commands.tryPush({}); }},
      {"request_records", [&] { return shared->records.requests.tryPush({}); }},
      {"plan_records", [&] { return shared->records.plans.tryPush({}); }},
      {"fault_records", [&] { return shared->records.faults.tryPush({}); }},
      {"contact_records", [&] { return shared->records.contacts.tryPush({}); }},
      {"fault_change_records", [&] { return shared->records.changes.tryPush({}); }},
      {"execution_records", [&] { return shared->records.executions.tryPush({}); }},
      {"exercise_records", [&] { return shared->records.exercises.tryPush({}); }},
  };
  ASSERT_EQ(push.size(), kRingCount);
  for (std::size_t i = 0; i < kRingCount; ++i) {
    ASSERT_EQ(sharedCounts(*shared).rings[i].pushed, 0U) << kRingNames[i];
    ASSERT_TRUE(push.at(kRingNames[i])());
    ASSERT_EQ(sharedCounts(*shared).rings[i].pushed, 1U) << kRingNames[i];
  }
}

}  // namespace
}  // namespace raven2_trainer
