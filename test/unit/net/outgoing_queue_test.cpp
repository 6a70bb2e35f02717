#include "net/outgoing_queue.h"

#include <gtest/gtest.h>

#include <vector>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::net {
namespace {

std::size_t push(OutgoingQueue* queue, std::uint8_t value, std::size_t size = 4) {
  const std::vector<std::uint8_t> frame(size, value);
  return queue->push(frame.data(), frame.size());
}

std::vector<int> takeAll(OutgoingQueue* queue) {
  std::vector<int> taken;
  while (queue->size() > 0) {
    taken.push_back(queue->data()[0]);
    queue->consume(queue->size());
  }
  return taken;
}

TEST(OutgoingQueue, GivesFramesInOrder) {
  OutgoingQueue queue(4);
  EXPECT_EQ(queue.size(), 0U);
  for (const std::uint8_t value : {1, 2, 3})
    EXPECT_EQ(push(&queue, value), 0U);
  EXPECT_EQ(takeAll(&queue), (std::vector<int>{1, 2, 3}));
}

TEST(OutgoingQueue, DropsTheOldestWhenFull) {
  OutgoingQueue queue(3);
  std::size_t dropped = 0;
  for (std::uint8_t value = 1; value <= 10; ++value)
    dropped += push(&queue, value);
  EXPECT_EQ(dropped, 7U);
  EXPECT_EQ(takeAll(&queue), (std::vector<int>{8, 9, 10}));
}

TEST(OutgoingQueue, NeverDropsAFrameOfWhichAPartHasGone) {
  OutgoingQueue queue(2);
  push(&queue, 1, 10);
  ASSERT_EQ(queue.size(), 10U);
  queue.consume(3);
  for (std::uint8_t value = 2; value <= 6; ++value)
    push(&queue, value);
  EXPECT_EQ(queue.size(), 7U);  // the rest of the first
  EXPECT_EQ(queue.data()[0], 1);
  EXPECT_EQ(takeAll(&queue), (std::vector<int>{1, 5, 6}));
}

TEST(OutgoingQueue, EveryFrameIsSentDroppedOrStillThere) {
  OutgoingQueue queue(3);
  Random random(4);
  std::size_t pushed = 0, dropped = 0, sent = 0;
  for (int i = 0; i < 10000; ++i) {
    if (random.uniform(0.0, 1.0) < 0.5) {
      dropped += push(&queue, 1, 1 + random.next() % 20);
      ++pushed;
    } else if (queue.size() > 0) {
      const std::size_t part = 1 + random.next() % queue.size();
      if (queue.consume(part)) ++sent;
    }
    ASSERT_EQ(pushed, sent + dropped + queue.frames()) << i;
  }
  EXPECT_GT(dropped, 100U);
  EXPECT_GT(sent, 100U);
}

TEST(OutgoingQueue, TakesTheLargestFrame) {
  OutgoingQueue queue(1);
  push(&queue, 9, wire::kMaxFrame);
  EXPECT_EQ(queue.size(), wire::kMaxFrame);
  EXPECT_EQ(queue.data()[wire::kMaxFrame - 1], 9);
}

}  // namespace
}  // namespace raven2_trainer::net
