#include <gtest/gtest.h>

#include <array>
#include <map>
#include <vector>

#include "net_support.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/types.h"
#include "raven2_trainer/net/itp_sender.h"
#include "raven2_trainer/net/key_file.h"
#include "raven2_trainer/net/udp_receiver.h"
#include "raven2_trainer/net/udp_sender.h"
#include "raven2_trainer/net/udp_socket.h"
#include "raven2_trainer/wire/itp_gate.h"
#include "raven2_trainer/wire/itp_rules.h"

namespace raven2_trainer::net {
namespace {

const char* const kLoopback = "127.0.0.1";
constexpr int kLongMs = 10000;  // a deadline: passes return at once

std::vector<std::uint8_t> bytes(std::size_t size, std::uint8_t first) {
  std::vector<std::uint8_t> result(size);
  for (std::size_t i = 0; i < size; ++i)
    result[i] = static_cast<std::uint8_t>(first + i);
  return result;
}

TEST(Udp, CarriesADatagramAsItIs) {
  UdpReceiver receiver(kLoopback, 0);
  ASSERT_NE(receiver.port(), 0);
  UdpSender sender(kLoopback, receiver.port());
  const auto sent = bytes(124, 3);
  ASSERT_TRUE(sender.send(sent.data(), sent.size()));
  ASSERT_TRUE(receiver.wait(kLongMs));
  std::vector<std::uint8_t> buffer(200, 0);
  const auto datagram = receiver.receive(buffer.data(), buffer.size());
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->size, sent.size());
  EXPECT_EQ(datagram->source, (Endpoint{INADDR_LOOPBACK, sender.port()}));
  EXPECT_FALSE(datagram->foreign);
  buffer.resize(sent.size());
  EXPECT_EQ(buffer, sent);
}

TEST(Udp, HasNothingWhenNothingWasSent) {
  UdpReceiver receiver(kLoopback, 0);
  std::array<std::uint8_t, 8> buffer;
  EXPECT_FALSE(receiver.wait(0));
  EXPECT_FALSE(receiver.wait(-1));  // never for ever
  EXPECT_FALSE(receiver.receive(buffer.data(), buffer.size()));
}

TEST(Udp, ShowsThatADatagramWasTooLong) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender sender(kLoopback, receiver.port());
  const auto sent = bytes(134, 0);
  ASSERT_TRUE(sender.send(sent.data(), sent.size()));
  ASSERT_TRUE(receiver.wait(kLongMs));
  std::array<std::uint8_t, 125> buffer{};
  buffer[124] = 0xEE;
  const auto datagram = receiver.receive(buffer.data(), 124);
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->size, 134U);
  EXPECT_EQ(buffer[124], 0xEE);  // nothing written past the capacity
}

TEST(Udp, SeesAnEmptyDatagram) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender sender(kLoopback, receiver.port());
  ASSERT_TRUE(sender.send(nullptr, 0));
  ASSERT_TRUE(receiver.wait(kLongMs));
  std::uint8_t byte = 0;
  const auto datagram = receiver.receive(&byte, 1);
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->size, 0U);
}

TEST(Udp, HearsOnlyThePinnedSourceAndSeesWhoElseSends) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender master(kLoopback, receiver.port());
  UdpSender intruder(kLoopback, receiver.port());  // same address, other port
  std::uint8_t byte = 1;
  const auto next = [&](UdpSender& from) {
    from.send(&byte, 1);
    EXPECT_TRUE(receiver.wait(kLongMs));
    return receiver.receive(&byte, 1).value();
  };
  receiver.pinSource(next(master).source);
  EXPECT_EQ(receiver.pinnedSource()->port, master.port());
  EXPECT_FALSE(next(master).foreign);
  intruder.send(&byte, 1);
  EXPECT_FALSE(receiver.wait(50)) << "a stranger does not even wake us";
  EXPECT_FALSE(receiver.receive(&byte, 1));
  const auto foreign = receiver.receiveForeign(&byte, 1);
  ASSERT_TRUE(foreign);
  EXPECT_TRUE(foreign->foreign);
  EXPECT_EQ(foreign->source.port, intruder.port());
  receiver.unpinSource();
  EXPECT_FALSE(next(intruder).foreign);
  EXPECT_FALSE(next(master).foreign);
}

TEST(Udp, WhatStrangersSentBeforeThePinIsMarked) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender master(kLoopback, receiver.port());
  UdpSender intruder(kLoopback, receiver.port());
  std::uint8_t byte = 1;
  intruder.send(&byte, 1);
  ASSERT_TRUE(receiver.wait(kLongMs));
  receiver.pinSource({INADDR_LOOPBACK, master.port()});
  auto datagram = receiver.receive(&byte, 1);
  if (!datagram) datagram = receiver.receiveForeign(&byte, 1);
  ASSERT_TRUE(datagram);
  EXPECT_TRUE(datagram->foreign);
}

TEST(Udp, AFloodOfStrangersIsDroppedBeforeThisProcess) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender master(kLoopback, receiver.port());
  UdpSender intruder(kLoopback, receiver.port());
  receiver.pinSource({INADDR_LOOPBACK, master.port()});
  const auto flood = bytes(124, 0);
  for (int i = 0; i < 20000; ++i)
    intruder.send(flood.data(), flood.size());
  std::uint8_t byte = 9;
  ASSERT_TRUE(master.send(&byte, 1));
  std::array<std::uint8_t, 124> buffer{};
  const auto datagram = receiver.receive(buffer.data(), buffer.size());
  ASSERT_TRUE(datagram) << "the first there is: the master's";
  EXPECT_EQ(datagram->size, 1U);
  int seen = 0;
  while (receiver.receiveForeign(buffer.data(), buffer.size()))
    ++seen;
  EXPECT_GT(seen, 0);
  EXPECT_LT(seen, 100);
}

TEST(Udp, AnswersWhoAskedAndTheAnswerIsHeard) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender asking(kLoopback, receiver.port());
  std::uint8_t byte = 5;
  asking.send(&byte, 1);
  ASSERT_TRUE(receiver.wait(kLongMs));
  const auto datagram = receiver.receive(&byte, 1);
  ASSERT_TRUE(datagram);
  ASSERT_TRUE(receiver.sendTo(datagram->source, &byte, 1));
  byte = 0;
  EXPECT_EQ(asking.receive(&byte, 1), 1U);
  EXPECT_EQ(byte, 5);
  EXPECT_EQ(asking.receive(&byte, 1), 0U);
}

TEST(Udp, ADepartedAskerDoesNotSilenceTheReceiver) {
  UdpReceiver receiver(kLoopback, 0);
  std::uint8_t byte = 5;
  Endpoint gone;
  {
    UdpSender asking(kLoopback, receiver.port());
    gone = {INADDR_LOOPBACK, asking.port()};
  }
  receiver.pinSource(gone);
  for (int i = 0; i < 3; ++i)
    receiver.sendTo(gone, &byte, 1);  // refused: the next call reports it
  EXPECT_FALSE(receiver.receive(&byte, 1));
  receiver.unpinSource();
  UdpSender next(kLoopback, receiver.port());
  next.send(&byte, 1);
  ASSERT_TRUE(receiver.wait(kLongMs));
  EXPECT_TRUE(receiver.receive(&byte, 1));
}

TEST(Udp, NamesAnAddressThatIsNotOurs) {
  try {
    UdpReceiver receiver("192.0.2.1", 36010);  // TEST-NET-1 (RFC 5737): nobody's
    FAIL();
  } catch (const NetworkException& e) {
    EXPECT_NE(std::string(e.what()).find("192.0.2.1:36010"), std::string::npos) << e.what();
  }
}

TEST(Udp, RefusesAnEmptyHost) {
  EXPECT_THROW(UdpReceiver("", 0), NetworkException);
  EXPECT_THROW(UdpSender("", 36000), NetworkException);
}

TEST(Udp, SendsToNobodyWithoutFailingAndReachesALateReceiver) {
  std::uint16_t port = 0;
  {
    UdpReceiver gone(kLoopback, 0);
    port = gone.port();
  }
  UdpSender sender(kLoopback, port);
  std::uint8_t byte = 7;
  // an odd number: if a refusal were reported in place of a send, the next packet would be lost
  for (int i = 0; i < 101; ++i)
    EXPECT_TRUE(sender.send(&byte, 1)) << i;
  UdpReceiver late(kLoopback, port);
  ASSERT_TRUE(sender.send(&byte, 1));  // the very next one arrives, although an earlier one was refused
  byte = 0;
  ASSERT_TRUE(late.wait(kLongMs));
  ASSERT_TRUE(late.receive(&byte, 1));
  EXPECT_EQ(byte, 7);
}

TEST(Udp, ReportsADatagramThatNoNetworkCanCarry) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender sender(kLoopback, receiver.port());
  const auto huge = bytes(70000, 0);
  EXPECT_FALSE(sender.send(huge.data(), huge.size()));
}

TEST(Udp, LeavesNoDescriptorsBehind) {
  const int before = openDescriptors();
  for (int i = 0; i < 200; ++i) {
    UdpReceiver receiver(kLoopback, 0);
    UdpSender sender(kLoopback, receiver.port());
    EXPECT_THROW(UdpReceiver(kLoopback, receiver.port(), 0.0), NetworkException);
  }
  EXPECT_EQ(openDescriptors(), before);
}

TEST(Endpoint, IsWrittenAsDottedNumbersAndPort) {
  EXPECT_EQ(toString(Endpoint{0x7F000001, 36010}), "127.0.0.1:36010");
  EXPECT_EQ(resolve("10.1.2.3", 5), (Endpoint{0x0A010203, 5}));
  EXPECT_EQ(resolve("localhost", 5), (Endpoint{0x7F000001, 5}));
}

TEST(Endpoint, IsAnotherIfAddressOrPortIsAnother) {
  const Endpoint one{0x7F000001, 36010};
  EXPECT_EQ(one, (Endpoint{0x7F000001, 36010}));
  EXPECT_NE(one, (Endpoint{0x7F000002, 36010}));
  EXPECT_NE(one, (Endpoint{0x7F000001, 36011}));
  for (const Endpoint each : {Endpoint{0, 0}, Endpoint{0xFFFFFFFF, 0xFFFF}, Endpoint{0x80000001, 0x8001}, one})
    EXPECT_EQ(endpointOf(sourceId(each)), each) << toString(each);
}

/** Every address of 127.0.0.0/8 is this computer's: one that has the master's port is not the master. */
TEST(Udp, AStrangerWithTheMastersPortIsAStranger) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender master(kLoopback, receiver.port());
  receiver.pinSource({INADDR_LOOPBACK, master.port()});
  UdpSocket stranger = UdpSocket::bound("127.0.0.2", master.port());
  std::uint8_t byte = 1;
  ASSERT_TRUE(stranger.sendTo({INADDR_LOOPBACK, receiver.port()}, &byte, 1));
  EXPECT_FALSE(receiver.receive(&byte, 1));
  const auto datagram = receiver.receiveForeign(&byte, 1);
  ASSERT_TRUE(datagram);
  EXPECT_TRUE(datagram->foreign);
  EXPECT_EQ(datagram->source, (Endpoint{0x7F000002, master.port()}));
}

/** One master after another, with and without a pause between them. */
TEST(Udp, ALaterPinTakesThePlaceOfTheOneBefore) {
  UdpReceiver receiver(kLoopback, 0);
  UdpSender first(kLoopback, receiver.port()), second(kLoopback, receiver.port());
  std::uint8_t byte = 1;
  for (const bool is_unpinned : {true, false}) {
    receiver.pinSource({INADDR_LOOPBACK, first.port()});
    if (is_unpinned) receiver.unpinSource();
    receiver.pinSource({INADDR_LOOPBACK, second.port()});
    EXPECT_EQ(receiver.pinnedSource(), (Endpoint{INADDR_LOOPBACK, second.port()}));
    second.send(&byte, 1);
    ASSERT_TRUE(receiver.wait(kLongMs));
    EXPECT_FALSE(receiver.receive(&byte, 1).value().foreign);
    first.send(&byte, 1);
    EXPECT_FALSE(receiver.receive(&byte, 1));
    EXPECT_TRUE(receiver.receiveForeign(&byte, 1).value().foreign);
    receiver.unpinSource();
  }
}

/** Of sockets that share a port, the one that was bound last gets the datagrams. */
TEST(Udp, NobodyElseGetsItsPortHoweverItAsks) {
  UdpReceiver receiver(kLoopback, 0);
  for (const std::uint32_t address : {INADDR_LOOPBACK, INADDR_ANY}) {
    const FileDescriptor other(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const int on = 1;
    ASSERT_EQ(::setsockopt(other.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)), 0);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(address);
    name.sin_port = htons(receiver.port());
    EXPECT_NE(::bind(other.get(), reinterpret_cast<const sockaddr*>(&name), sizeof(name)), 0) << address;
  }
}

/** All that has come goes through the gate. @return packets that were used. */
int takeAll(UdpReceiver* receiver, wire::ItpGate* gate, std::int64_t now_ns) {
  int used = 0;
  std::array<std::uint8_t, 512> buffer{};
  while (const auto datagram = receiver->receive(buffer.data(), buffer.size())) {
    const wire::Arrival arrival{buffer.data(), datagram->size, sourceId(datagram->source), now_ns};
    wire::ItpPacket packet;
    wire::HandshakeBytes reply;
    if (!gate->isHello(arrival)) {
      used += gate->judge(arrival, &packet) == Reject::kNone ? 1 : 0;
    } else if (gate->answer(arrival, freshNonce(), &reply) == Reject::kNone) {
      receiver->sendTo(datagram->source, reply.data(), reply.size());
    }
  }
  return used;
}

/** The unmodified robot does not know signatures: it gets plain packets. A daemon that wants them gets none. */
TEST(ItpSender, SendsPlainToAReceiverThatNeverAnswersUnlessItIsToBeSilent) {
  const wire::ItpKey key(std::array<std::uint8_t, wire::ItpKey::kSize>{});
  for (const auto unanswered : {ItpSender::Unanswered::kPlain, ItpSender::Unanswered::kSilence}) {
    const bool is_plain = unanswered == ItpSender::Unanswered::kPlain;
    UdpReceiver receiver(kLoopback, 0);
    ItpSender sender(kLoopback, receiver.port(), wire::Audience::kRobot, &key, unanswered);
    const std::array<std::uint8_t, 12> pedals{};
    for (int i = 1; i <= 100; ++i) {
      wire::ItpPacket packet;
      packet.sequence = static_cast<std::uint32_t>(i);
      EXPECT_EQ(sender.send(packet, i * kTickNanoseconds), is_plain);
    }
    EXPECT_EQ(sender.sendPedals(pedals.data(), pedals.size()), is_plain);
    std::map<std::size_t, int> sizes;
    std::array<std::uint8_t, 512> buffer{};
    while (const auto datagram = receiver.receive(buffer.data(), buffer.size()))
      ++sizes[datagram->size];
    EXPECT_EQ(sizes[wire::kItpSize], is_plain ? 100 : 0);
    EXPECT_EQ(sizes[pedals.size()], is_plain ? 1 : 0);
    EXPECT_GT(sizes[wire::kHandshakeSize], 0) << "it asks";
  }
}

TEST(ItpSender, SignsForAReceiverThatStartedAgain) {
  const wire::ItpKey key(std::array<std::uint8_t, wire::ItpKey::kSize>{});
  ItpRules rules;
  rules.auth = ItpAuth::kRequired;
  rules.max_increment_um = 2000;
  rules.max_rotation = 0.1;
  rules.max_rate = 1200;
  rules.max_burst = 40;
  rules.master_timeout = 0.2;
  UdpReceiver receiver(kLoopback, 0);
  ItpSender sender(kLoopback, receiver.port(), wire::Audience::kRobot, &key, ItpSender::Unanswered::kSilence);
  std::int64_t now_ns = 0;
  wire::ItpPacket packet;  // pedal up
  for (int life = 1; life <= 2; ++life) {
    wire::ItpGate gate(rules, wire::Audience::kRobot, &key);  // the second one knows no session
    int used = 0;
    for (int i = 0; i < 3000; ++i) {
      ++packet.sequence;
      sender.send(packet, now_ns += kTickNanoseconds);
      used += takeAll(&receiver, &gate, now_ns);
    }
    EXPECT_GT(used, 1500) << life;
  }
}

}  // namespace
}  // namespace raven2_trainer::net
