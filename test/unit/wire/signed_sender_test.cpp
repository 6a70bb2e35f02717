#include "raven2_trainer/wire/signed_sender.h"

#include "gate_bench.h"
#include "raven2_trainer/wire/session_table.h"

// The two sides of the handshake: when a sender asks, and the records that a receiver keeps of the senders.

namespace raven2_trainer::wire {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Nonce nonceOf(std::uint8_t fill) {
  Nonce nonce;
  nonce.fill(fill);
  return nonce;
}

HandshakeBytes answerTo(const Nonce& sender, const Nonce& receiver) {
  return encodeChallenge(benchKey(), Audience::kRobot, sender, receiver);
}

/** [ms] from a hello to the next one that is due. */
std::int64_t pauseAfter(SignedSender* sender, std::int64_t* now_ns) {
  sender->hello(nonceOf(1), *now_ns);
  std::int64_t ms = 0;
  for (; !sender->isHelloDue(*now_ns); *now_ns += kMs)
    ++ms;
  return ms;
}

TEST(SignedSender, AsksAtOnceThenLessAndLessOftenDownToOnceASecond) {
  SignedSender sender(&benchKey(), Audience::kRobot);
  std::int64_t now = 7'000 * kMs;
  ASSERT_TRUE(sender.isHelloDue(now));
  for (int round = 0; round < 2; ++round) {
    for (const std::int64_t ms : {100, 200, 400, 800, 1000, 1000, 1000})
      EXPECT_EQ(pauseAfter(&sender, &now), ms);
    // an answer, and the next question is due in a second; unanswered, it is soon asked again
    sender.hello(nonceOf(2), now);
    const HandshakeBytes answer = answerTo(nonceOf(2), nonceOf(3));
    ASSERT_TRUE(sender.receive(answer.data(), answer.size(), now));
    EXPECT_FALSE(sender.isHelloDue(now + 999 * kMs));
    EXPECT_TRUE(sender.isHelloDue(now + 1000 * kMs));
    now += 1000 * kMs;
  }
}

TEST(SignedSender, TakesOneAnswerToItsNewestHelloAndNoOther) {
  SignedSender sender(&benchKey(), Audience::kRobot);
  const HandshakeBytes early = answerTo(Nonce{}, nonceOf(3));
  EXPECT_FALSE(sender.receive(early.data(), early.size(), 0)) << "it asked nothing yet";
  sender.hello(nonceOf(1), 0);
  sender.hello(nonceOf(2), 0);
  const HandshakeBytes old = answerTo(nonceOf(1), nonceOf(3)), newest = answerTo(nonceOf(2), nonceOf(4));
  EXPECT_FALSE(sender.receive(old.data(), old.size(), 0));
  EXPECT_FALSE(sender.isOpen());
  EXPECT_TRUE(sender.receive(newest.data(), newest.size(), 0));
  EXPECT_TRUE(sender.isOpen());
  EXPECT_FALSE(sender.receive(newest.data(), newest.size(), 0)) << "a second copy";
}

std::uint32_t sessionOf(const SignedItpBytes& bytes) {
  Trailer trailer;
  EXPECT_TRUE(decodeTrailer(bytes.data(), &trailer));
  return trailer.session;
}

TEST(SignedSender, GoesOverToTheNextSessionWithThePedalUpAndNotBefore) {
  SignedSender sender(&benchKey(), Audience::kRobot);
  const auto open = [&sender](std::uint8_t number) {
    sender.hello(nonceOf(number), 0);
    const HandshakeBytes answer = answerTo(nonceOf(number), nonceOf(100));
    EXPECT_TRUE(sender.receive(answer.data(), answer.size(), 0));
    return ItpSession(benchKey(), Audience::kRobot, nonceOf(number), nonceOf(100)).id();
  };
  const std::uint32_t first = open(1);
  EXPECT_EQ(sessionOf(sender.sign({}, true)), first) << "there is no other yet";
  const std::uint32_t second = open(2);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(sessionOf(sender.sign({}, true)), first);
  EXPECT_EQ(sessionOf(sender.sign({}, false)), second);
  EXPECT_EQ(sessionOf(sender.sign({}, true)), second);
}

TEST(SessionTable, ARepeatedHelloGetsTheSameAnswerAndFourMayWait) {
  SessionTable table(&benchKey(), Audience::kRobot);
  const auto answer = [&table](std::uint8_t sender, std::uint8_t fresh) {
    HandshakeBytes reply;
    table.answer(nonceOf(sender), nonceOf(fresh), &reply);
    return reply;
  };
  const auto session = [](std::uint8_t sender, std::uint8_t fresh) {
    return ItpSession(benchKey(), Audience::kRobot, nonceOf(sender), nonceOf(fresh)).id();
  };
  for (std::uint8_t i = 1; i <= SessionTable::kPending; ++i)
    EXPECT_EQ(answer(i, 100 + i), answerTo(nonceOf(i), nonceOf(100 + i)));
  for (std::uint8_t i = 1; i <= SessionTable::kPending; ++i) {
    EXPECT_EQ(answer(i, 200), answerTo(nonceOf(i), nonceOf(100 + i))) << "however often it is sent";
    EXPECT_NE(table.find(session(i, 100 + i)), nullptr);
  }
  answer(9, 109);  // a fifth, in place of the oldest
  EXPECT_EQ(table.find(session(1, 101)), nullptr);
  for (const std::uint8_t i : {2, 3, 4, 9})
    EXPECT_NE(table.find(session(i, 100 + i)), nullptr) << int{i};
}

TEST(SessionTable, PromotesOneAndForgetsTheOneBeforeIt) {
  SessionTable table(&benchKey(), Audience::kRobot);
  std::vector<std::uint32_t> ids;
  for (std::uint8_t i = 1; i <= 3; ++i) {
    HandshakeBytes reply;
    table.answer(nonceOf(i), nonceOf(100), &reply);
    ids.push_back(ItpSession(benchKey(), Audience::kRobot, nonceOf(i), nonceOf(100)).id());
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    SessionTable::Entry* entry = table.find(ids[i]);
    ASSERT_NE(entry, nullptr);
    EXPECT_FALSE(table.isInForce(*entry));
    EXPECT_TRUE(table.isInForce(*table.promote(entry)));
    for (std::size_t k = 0; k < ids.size(); ++k)
      EXPECT_EQ(table.find(ids[k]) != nullptr, k >= i) << k;
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
