#include "raven2_trainer/loop/servo_queue.h"

#include <gtest/gtest.h>

#include <memory>

namespace raven2_trainer {
namespace {

ServoCommand commandOf(ServoKind kind, std::uint32_t id = 0) {
  ServoCommand command;
  command.kind = kind;
  command.id = id;
  return command;
}

/** Offers commands of one kind. @return how many the queue accepts. */
std::size_t pushed(ServoQueue* queue, ServoKind kind, int offered) {
  std::size_t count = 0;
  for (int i = 0; i < offered; ++i)
    count += queue->tryPush(commandOf(kind)) ? 1 : 0;
  return count;
}

TEST(ServoQueue, AFloodOfMotionsLeavesRoomForEveryOrder) {
  for (std::size_t i = 0; i < kServoKindCount; ++i) {
    const auto kind = static_cast<ServoKind>(i);
    const auto queue = std::make_unique<ServoQueue>();
    pushed(queue.get(), ServoKind::kServoPose, 1000);
    const bool moves = kind != ServoKind::kState && kind != ServoKind::kHold && kind != ServoKind::kFree;
    EXPECT_EQ(queue->tryPush(commandOf(kind)), !moves) << kServoKindNames[i];
  }
}

TEST(ServoQueue, AnOrderSaysBehindHowManyMotionsItCame) {
  const auto queue = std::make_unique<ServoQueue>();
  pushed(queue.get(), ServoKind::kServoJoints, 3);
  ASSERT_TRUE(queue->tryPush(commandOf(ServoKind::kHold, 77)));
  pushed(queue.get(), ServoKind::kMovePose, 2);
  ServoCommand motion;
  ASSERT_TRUE(queue->popMotion(&motion));
  EXPECT_EQ(motion.kind, ServoKind::kServoJoints);
  ServoOrder order;
  ASSERT_TRUE(queue->popOrder(&order));
  EXPECT_EQ(order.command.id, 77U);
  EXPECT_EQ(order.behind, 3U);
  EXPECT_EQ(queue->asked(), 5U);
  EXPECT_EQ(queue->taken(), 1U) << "only motions count";
  EXPECT_FALSE(queue->popOrder(&order));
}

TEST(ServoQueue, CountsBothRings) {
  const auto queue = std::make_unique<ServoQueue>();
  EXPECT_EQ(pushed(queue.get(), ServoKind::kServoTwist, 300), ServoQueue::kMotions);
  EXPECT_EQ(pushed(queue.get(), ServoKind::kFree, 100), ServoQueue::kOrders);
  ServoOrder order;
  ServoCommand motion;
  ASSERT_TRUE(queue->popOrder(&order) && queue->popMotion(&motion) && queue->popMotion(&motion));
  const RingCounts counts = queue->counts();
  EXPECT_EQ(counts.pushed, 256U + 64U);
  EXPECT_EQ(counts.taken, 3U);
  EXPECT_EQ(counts.dropped, 44U + 36U);
}

}  // namespace
}  // namespace raven2_trainer
