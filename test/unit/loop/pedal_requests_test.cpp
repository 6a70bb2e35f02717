#include <gtest/gtest.h>

#include <vector>

#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::packagedConfig;
using raven2_trainer::testing::Rig;

Request numbered(RequestKind kind, std::uint32_t id) {
  Request request;
  request.kind = kind;
  request.id = id;
  return request;
}

/** Every test with a Rig ends with counters that add up: every request that was taken was recorded. */
class PedalRequests : public ::testing::Test {
 protected:
  PedalRequests() : rig(packagedConfig()) {
    rig.record = [this] {
      const auto& ring = rig.shared->request_records;
      for (std::uint64_t i = ring.head(); i < ring.tail(); ++i)
        records.push_back(ring.at(i));
    };
  }
  static void SetUpTestSuite() { raven2_trainer::testing::useOde(); }

  Rig rig;
  std::vector<RequestRecord> records;
};

TEST_F(PedalRequests, AreTakenAndRecordedAheadOfTheOperators) {
  rig.tick(false);
  rig.shared->requests.tryPush(numbered(RequestKind::kEngage, 3));
  rig.shared->pedal_requests.tryPush(numbered(RequestKind::kDisengage, 1));
  rig.shared->pedal_requests.tryPush(numbered(RequestKind::kSetCollisions, 2));
  rig.tick(false);
  ASSERT_EQ(records.size(), 3U);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(records[i].request.id, i + 1) << "the pedals' requests come first, each kind in its order of arrival";
    EXPECT_EQ(records[i].tick, rig.model().tick);
  }
  EXPECT_EQ(rig.model().engaged, 1) << "the operator's request came last";
  EXPECT_EQ(ring(rig.counts(), RingId::kPedalRequests).taken, 2U);
}

TEST_F(PedalRequests, OfEveryKindAreRecorded) {
  for (std::size_t kind = 0; kind < kRequestKindCount; ++kind) {
    rig.shared->pedal_requests.tryPush(numbered(static_cast<RequestKind>(kind), static_cast<std::uint32_t>(kind)));
    rig.tick(false);
  }
  ASSERT_EQ(records.size(), kRequestKindCount);
  for (std::size_t kind = 0; kind < kRequestKindCount; ++kind)
    EXPECT_EQ(static_cast<std::size_t>(records[kind].request.kind), kind);
}

}  // namespace
}  // namespace raven2_trainer::loop
