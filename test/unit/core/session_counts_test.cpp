#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "raven2_trainer/core/shared_state.h"

namespace raven2_trainer {
namespace {

RingCounts& at(SessionCounts& counts, RingId id) {
  return counts.rings[static_cast<std::size_t>(id)];
}

/** A session of 1000 ticks of which every sum is right. */
SessionCounts rightSums() {
  SessionCounts c;
  c.master.received = 980;
  c.master.applied = 975;
  c.master.rejected[static_cast<std::size_t>(Reject::kDuplicate)] = 3;
  c.master.rejected[static_cast<std::size_t>(Reject::kQueueFull)] = 2;
  at(c, RingId::kMasterCommands) = {975, 970, 2};  // five wait for a tick that never came
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
  at(c, RingId::kPedalRequests) = {5, 4, 1};  // one waits
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
  EXPECT_EQ(wrongSum(doubled), nullptr) << "second copies move the model too";
}

TEST(SessionCounts, AddUpWhereClientsAreMastersToo) {
  SessionCounts c = rightSums();
  c.master_overruled = 300;  // of the console
  c.servo_made = 290;
  at(c, RingId::kCommandRecords) = {959, 959, 1};
  EXPECT_EQ(wrongSum(c), nullptr);
  c.master_used = 961;
  EXPECT_NE(wrongSum(c), nullptr) << "more than were recorded";
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
  for (int i = 0; i < 20; ++i)
    shared->fault_records.tryPush({});
  for (int i = 0; i < 4097; ++i)
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

}  // namespace
}  // namespace raven2_trainer
