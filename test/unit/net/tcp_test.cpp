#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "net_support.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/net/tcp_client.h"
#include "raven2_trainer/net/tcp_server.h"
#include "raven2_trainer/wire/robot_frame.h"
#include "support/effort.h"

namespace raven2_trainer::net {
namespace {

const char* const kLoopback = "127.0.0.1";
using Event = TcpClient::Event;
using Bytes = std::vector<std::uint8_t>;

/** Records the server's events. */
class Notes : public TcpServer::Listener {
 public:
  void onConnect(TcpServer::ClientId client) override { connected.push_back(client); }
  void onBytes(TcpServer::ClientId client, const std::uint8_t* data, std::size_t size) override {
    received[client].insert(received[client].end(), data, data + size);
  }
  void onDisconnect(TcpServer::ClientId client) override { disconnected.push_back(client); }

  std::vector<TcpServer::ClientId> connected, disconnected;
  std::map<TcpServer::ClientId, Bytes> received;
};

/** A client with its events and the frames that it received, on the real clock. */
struct Reader {
  explicit Reader(std::uint16_t port) : client(kLoopback, port, 0.001, 0.01) {}

  void poll(int timeout_ms = 0) {
    const Event event = client.poll(monotonicNow(), timeout_ms);
    if (event == Event::kConnected) ++connects;
    if (event == Event::kDisconnected) ++disconnects;
    if (event == Event::kReadable) read();
  }

  void read() {
    std::array<std::uint8_t, 3000> buffer;
    while (const std::size_t size = client.receive(buffer.data(), buffer.size())) {
      bytes += size;
      parser.feed(buffer.data(), size);
      wire::Frame frame;
      wire::FrameParser::Result result = parser.next(&frame);
      for (; result == wire::FrameParser::Result::kFrame; result = parser.next(&frame)) {
        sequences.push_back(frame.sequence);
      }
      broken = broken || result == wire::FrameParser::Result::kBroken;
    }
  }

  TcpClient client;
  wire::FrameParser parser;
  std::vector<std::uint32_t> sequences;
  std::size_t bytes{0};
  int connects{0};
  int disconnects{0};
  bool broken{false};
};

Bytes stateFrame(std::uint32_t sequence) {
  Bytes frame(wire::kMaxFrame);
  frame.resize(wire::encodeState(sequence, RobotState{}, frame.data()));
  return frame;
}

bool meet(TcpServer* server, Notes* notes, Reader* reader) {
  const std::size_t before = notes->connected.size();
  return eventually([&] {
    server->poll(1, *notes);
    reader->poll();
    return reader->client.isConnected() && notes->connected.size() > before;
  });
}

TEST(Tcp, CarriesFramesToTheClientAndBytesToTheServer) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader reader(server.port());
  ASSERT_TRUE(meet(&server, &notes, &reader));
  EXPECT_EQ(reader.connects, 1);
  EXPECT_EQ(server.clientCount(), 1U);

  const Bytes frame = stateFrame(42);
  EXPECT_EQ(server.broadcast(frame.data(), frame.size()), 1U);
  EXPECT_TRUE(server.send(notes.connected[0], frame.data(), frame.size()));
  const Bytes words{1, 2, 3, 4, 5};
  EXPECT_TRUE(reader.client.send(words.data(), words.size()));
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    reader.poll();
    return reader.sequences.size() == 2 && notes.received[notes.connected[0]] == words;
  }));
  EXPECT_EQ(reader.sequences, (std::vector<std::uint32_t>{42, 42}));
}

TEST(Tcp, ServerAnswersFromInsideItsListener) {
  // a robot says hello before anything else
  class Greeter : public Notes {
   public:
    void onConnect(TcpServer::ClientId client) override {
      Notes::onConnect(client);
      const Bytes frame = stateFrame(1);
      server->send(client, frame.data(), frame.size());
    }
    TcpServer* server{nullptr};
  };
  TcpServer server(kLoopback, 0);
  Greeter greeter;
  greeter.server = &server;
  Reader reader(server.port());
  EXPECT_TRUE(eventually([&] {
    server.poll(1, greeter);
    reader.poll();
    return !reader.sequences.empty();
  }));
}

TEST(Tcp, ASlowReaderLosesOldFramesAndDelaysNobody) {
  constexpr std::uint32_t kFrames = 5000;  // 2.8 MB: far more than all buffers between the two hold
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader slow(server.port());
  ASSERT_TRUE(meet(&server, &notes, &slow));
  Reader fast(server.port());
  ASSERT_TRUE(meet(&server, &notes, &fast));

  // WHEN one reads everything at once and the other nothing
  for (std::uint32_t sequence = 0; sequence < kFrames; ++sequence) {
    const Bytes frame = stateFrame(sequence);
    ASSERT_EQ(server.broadcast(frame.data(), frame.size()), 2U);
    ASSERT_TRUE(eventually([&] {
      server.poll(0, notes);
      fast.poll();
      return fast.sequences.size() == sequence + 1;
    })) << "the fast reader waits for frame "
        << sequence;
  }
  // THEN the fast one has all
  for (std::uint32_t i = 0; i < kFrames; ++i)
    ASSERT_EQ(fast.sequences[i], i);
  EXPECT_GT(server.framesDropped(), 0U);

  // and the slow one, once it reads, gets whole frames, in order, the newest among them
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    slow.poll();
    return !slow.sequences.empty() && slow.sequences.back() == kFrames - 1;
  }));
  EXPECT_FALSE(slow.broken);
  EXPECT_TRUE(std::is_sorted(slow.sequences.begin(), slow.sequences.end(), std::less_equal<>()));  // strictly rising
  EXPECT_EQ(slow.sequences.size() + server.framesDropped(), kFrames);
  for (const TcpServer::ClientId client : notes.connected) {
    const FrameTotals frames = server.reader(client).frames;
    EXPECT_EQ(frames.pushed, kFrames);
    EXPECT_TRUE(frames.addsUp());
  }
  EXPECT_EQ(server.totals().pushed, 2 * kFrames);
  EXPECT_EQ(server.totals().sent, slow.sequences.size() + fast.sequences.size());
  EXPECT_TRUE(server.totals().addsUp());
}

TEST(Tcp, RefusesAReaderTooManyAndTakesOneWhenAnotherLeaves) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  std::vector<std::unique_ptr<Reader>> readers;
  for (std::size_t i = 0; i < TcpServer::kMaxClients; ++i) {
    readers.push_back(std::make_unique<Reader>(server.port()));
    ASSERT_TRUE(meet(&server, &notes, readers.back().get()));
  }
  Reader extra(server.port());
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    extra.poll();
    return extra.disconnects > 0 && server.clientsRefused() > 0;
  }));
  EXPECT_EQ(server.clientCount(), TcpServer::kMaxClients);

  readers.pop_back();
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    extra.poll();
    return notes.connected.size() == TcpServer::kMaxClients + 1 && extra.client.isConnected();
  }));
  EXPECT_EQ(notes.disconnected.size(), 1U);
  std::vector<TcpServer::ClientId> ids = notes.connected;
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::unique(ids.begin(), ids.end()), ids.end()) << "an identity was used twice";
}

TEST(Tcp, SurvivesSendingToAReaderThatLeft) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  auto reader = std::make_unique<Reader>(server.port());
  ASSERT_TRUE(meet(&server, &notes, reader.get()));
  reader.reset();
  // a SIGPIPE would end this program
  const Bytes frame = stateFrame(1);
  for (int i = 0; i < 100; ++i)
    server.broadcast(frame.data(), frame.size());
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    return notes.disconnected == notes.connected;
  }));
  EXPECT_EQ(server.clientCount(), 0U);
  EXPECT_FALSE(server.send(notes.connected[0], frame.data(), frame.size()));
}

TEST(Tcp, DropClosesTheConnection) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader reader(server.port());
  ASSERT_TRUE(meet(&server, &notes, &reader));
  server.drop(notes.connected[0]);
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    reader.poll();
    return reader.disconnects == 1;
  }));
  EXPECT_EQ(notes.disconnected, (std::vector<TcpServer::ClientId>{notes.connected[0]}));
}

TEST(Tcp, RefusesAFrameLargerThanAnyFrame) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader reader(server.port());
  ASSERT_TRUE(meet(&server, &notes, &reader));
  const Bytes huge(wire::kMaxFrame + 1);
  EXPECT_FALSE(server.send(notes.connected[0], huge.data(), huge.size()));
  EXPECT_EQ(server.broadcast(huge.data(), huge.size()), 0U);
}

TEST(Tcp, ClientComesBackAfterTheServerRestarted) {
  auto server = std::make_unique<TcpServer>(kLoopback, 0);
  const std::uint16_t port = server->port();
  Notes notes;
  Reader reader(port);
  for (int restart = 1; restart <= 5; ++restart) {
    ASSERT_TRUE(meet(server.get(), &notes, &reader)) << restart;
    EXPECT_EQ(reader.connects, restart);
    server.reset();
    ASSERT_TRUE(eventually([&] {
      reader.poll(1);
      return reader.disconnects == restart;
    }));
    EXPECT_FALSE(reader.client.isConnected());
    server = std::make_unique<TcpServer>(kLoopback, port);
  }
}

TEST(Tcp, TwoHundredQuickConnectionsLeaveNoDescriptorsBehind) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  const int before = openDescriptors();
  for (int i = 0; i < 200; ++i) {
    Reader reader(server.port());
    ASSERT_TRUE(meet(&server, &notes, &reader)) << i;
  }
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    return notes.disconnected.size() == 200;
  }));
  EXPECT_EQ(openDescriptors(), before);
}

TEST(Tcp, AStormOfConnectionsWithWritesLeavesNoDescriptorsAndTheCountersAddUp) {
  const int storms = static_cast<int>(raven2_trainer::testing::effort(200, 1000));
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader good(server.port());
  ASSERT_TRUE(meet(&server, &notes, &good));
  const int before = openDescriptors();
  // WHEN visitors come and go, each with some bytes, while frames are sent on the test's clock, so that all get a place
  std::int64_t now_ns = monotonicNow();
  Random random(5);
  std::uint32_t sequence = 0;
  for (int i = 0; i < storms; ++i) {
    PlainSocket visitor;
    ASSERT_TRUE(visitor.connect(server.port()));
    visitor.write(Bytes(random.next() % 700, 7));
    if (random.next() % 2 == 0) server.poll(1, notes, now_ns);
    visitor.close(/*reset=*/random.next() % 2 == 0);
    const Bytes frame = stateFrame(++sequence);
    server.broadcast(frame.data(), frame.size());
    server.poll(0, notes, now_ns += TcpServer::kAdmitIntervalNs);
    good.poll();
  }
  // THEN all are gone, nobody was turned away, and the good reader has every frame
  ASSERT_TRUE(eventually([&] {
    server.poll(1, notes, now_ns);
    good.poll();
    return server.clientCount() == 1 && good.sequences.size() == sequence;
  }));
  EXPECT_EQ(notes.disconnected.size() + 1, notes.connected.size());
  EXPECT_GT(notes.connected.size(), static_cast<std::size_t>(storms) / 4);
  EXPECT_EQ(server.clientsRefused(), 0U);
  EXPECT_EQ(openDescriptors(), before);
  EXPECT_TRUE(server.totals().addsUp());
  EXPECT_EQ(server.reader(notes.connected[0]).frames.sent, sequence);
}

/** Fills all places. The `marked` clients have sent a part of a message. */
struct FullHouse {
  explicit FullHouse(const std::vector<std::size_t>& marked) {
    for (std::size_t i = 0; i < TcpServer::kMaxClients; ++i) {
      readers.push_back(std::make_unique<Reader>(server.port()));
      EXPECT_TRUE(meet(&server, &notes, readers.back().get()));
    }
    for (const std::size_t i : marked)
      server.markPart(notes.connected[i], true);
  }

  /** @return true if the newcomer has a place. */
  bool takes(Reader* newcomer) {
    const std::size_t before = notes.connected.size();
    const std::uint64_t refused = server.clientsRefused();
    EXPECT_TRUE(eventually([&] {
      server.poll(1, notes);
      newcomer->poll();
      return notes.connected.size() > before || server.clientsRefused() > refused;
    }));
    return notes.connected.size() > before;
  }

  TcpServer server{kLoopback, 0};
  Notes notes;
  std::vector<std::unique_ptr<Reader>> readers;
};

TEST(Tcp, ANewcomerGetsThePlaceOfTheOldestReaderWithHalfAMessage) {
  FullHouse house({1, 2});
  Reader first(house.server.port()), second(house.server.port()), third(house.server.port());
  EXPECT_TRUE(house.takes(&first));
  EXPECT_EQ(house.notes.disconnected, (std::vector<TcpServer::ClientId>{house.notes.connected[1]}));
  EXPECT_TRUE(house.takes(&second));
  EXPECT_EQ(house.notes.disconnected.back(), house.notes.connected[2]);
  EXPECT_FALSE(house.takes(&third)) << "the quiet ones are good readers";
  EXPECT_EQ(house.server.clientsEvicted(), 2U);
  EXPECT_EQ(house.server.clientCount(), TcpServer::kMaxClients);
}

TEST(Tcp, AReaderWhoseMessageIsWholeAgainKeepsItsPlace) {
  FullHouse house({1, 2});
  house.server.markPart(house.notes.connected[1], false);
  Reader first(house.server.port()), second(house.server.port());
  EXPECT_TRUE(house.takes(&first));
  EXPECT_EQ(house.notes.disconnected, (std::vector<TcpServer::ClientId>{house.notes.connected[2]}));
  EXPECT_FALSE(house.takes(&second));
}

/** Sends frames to a reader that takes none, until one is dropped. */
void overwhelm(TcpServer* server) {
  const std::uint64_t before = server->framesDropped();
  const Bytes frame = stateFrame(1);
  for (int i = 0; i < 100000 && server->framesDropped() == before; ++i)
    server->broadcast(frame.data(), frame.size());
  ASSERT_GT(server->framesDropped(), before);
}

TEST(Tcp, AReaderThatTakesSomethingNowAndThenIsNotStalled) {
  constexpr std::int64_t kHalfSecond = 500'000'000;
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader slow(server.port());
  ASSERT_TRUE(meet(&server, &notes, &slow));
  std::int64_t now_ns = monotonicNow();
  for (int second = 0; second < 3; ++second) {
    overwhelm(&server);
    for (const std::int64_t end = now_ns + 3 * kHalfSecond; now_ns < end; now_ns += kHalfSecond)
      server.poll(0, notes, now_ns);
    const std::uint64_t sent = server.totals().sent;
    ASSERT_TRUE(eventually([&] {  // its reading makes room while the test's clock does not move
      slow.poll();
      server.poll(0, notes, now_ns);
      return server.totals().sent > sent;
    }));
  }
  EXPECT_TRUE(notes.disconnected.empty()) << "each time it waited for less than kStallNs";
  overwhelm(&server);
  EXPECT_TRUE(eventually([&] {
    server.poll(0, notes, now_ns += TcpServer::kStallNs);
    return !notes.disconnected.empty();
  }));
}

TEST(Tcp, WhatAReaderLostStaysCountedWhenItIsGone) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  auto slow = std::make_unique<Reader>(server.port());
  ASSERT_TRUE(meet(&server, &notes, slow.get()));
  overwhelm(&server);
  const FrameTotals before = server.totals();
  slow.reset();
  ASSERT_TRUE(eventually([&] {
    server.poll(1, notes);
    return !notes.disconnected.empty();
  }));
  const FrameTotals after = server.totals();
  EXPECT_EQ(after.pushed, before.pushed);
  EXPECT_EQ(after.dropped, before.dropped);
  EXPECT_EQ(after.queued, 0U);
  EXPECT_GT(after.unsent, 0U);
  EXPECT_TRUE(after.addsUp());
}

TEST(Tcp, ANewcomerGetsThePlaceOfAReaderThatTakesNothing) {
  FullHouse house({});
  std::int64_t now_ns = monotonicNow();
  // WHEN three read and one does not
  std::uint32_t sequence = 0;
  const auto serve = [&] {
    const Bytes frame = stateFrame(++sequence);
    house.server.broadcast(frame.data(), frame.size());
    ASSERT_TRUE(eventually([&] {
      house.server.poll(0, house.notes, now_ns);
      for (const std::size_t i : {0, 1, 3})
        house.readers[i]->poll();
      return house.readers[0]->sequences.size() == sequence && house.readers[1]->sequences.size() == sequence &&
             house.readers[3]->sequences.size() == sequence;
    }));
  };
  // until the system's buffers are full, its own timers considered, and then for kYieldNs of our time
  const TcpServer::ClientId idler = house.notes.connected[2];
  std::uint64_t sent = 0;
  std::int64_t settled = monotonicNow();
  ASSERT_TRUE(eventually([&] {
    serve();
    if (house.server.reader(idler).frames.sent != sent) settled = monotonicNow();
    sent = house.server.reader(idler).frames.sent;
    return monotonicNow() - settled > 500'000'000;
  }));
  ASSERT_GT(house.server.framesDropped(), 0U);
  serve();
  now_ns += TcpServer::kYieldNs;
  serve();
  ASSERT_EQ(house.server.clientCount(), TcpServer::kMaxClients) << "nobody needed its place yet";
  Reader newcomer(house.server.port());
  ASSERT_TRUE(eventually([&] {
    house.server.poll(1, house.notes, now_ns);
    newcomer.poll();
    return !house.notes.disconnected.empty();
  }));
  EXPECT_EQ(house.notes.disconnected, (std::vector<TcpServer::ClientId>{idler}));
  EXPECT_EQ(house.server.clientsEvicted(), 1U);
  EXPECT_EQ(house.notes.connected.size(), TcpServer::kMaxClients + 1);
}

TEST(Tcp, TakesACrowdAtOnceAndAfterThatANewcomerEachInterval) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  const std::int64_t begin_ns = monotonicNow();
  const auto visit = [&](std::int64_t now_ns) {
    const std::size_t before = notes.connected.size() + server.clientsRefused();
    PlainSocket visitor;
    EXPECT_TRUE(visitor.connect(server.port()));
    EXPECT_TRUE(eventually([&] {
      server.poll(1, notes, now_ns);
      return notes.connected.size() + server.clientsRefused() > before;
    }));
    visitor.close(true);
    EXPECT_TRUE(eventually([&] {
      server.poll(1, notes, now_ns);
      return server.clientCount() == 0;
    }));
  };
  for (int i = 0; i < TcpServer::kAdmitBurst + 5; ++i)
    visit(begin_ns);
  EXPECT_EQ(notes.connected.size(), static_cast<std::size_t>(TcpServer::kAdmitBurst));
  EXPECT_EQ(server.clientsRefused(), 5U);
  for (int i = 1; i <= 10; ++i) {
    visit(begin_ns + i * TcpServer::kAdmitIntervalNs);
    visit(begin_ns + i * TcpServer::kAdmitIntervalNs);
  }
  EXPECT_EQ(notes.connected.size(), static_cast<std::size_t>(TcpServer::kAdmitBurst + 10));
  EXPECT_EQ(server.clientsRefused(), 15U);
}

TEST(Tcp, WhoeverLeftBeforeItWasTakenCostsNothing) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  for (int i = 0; i < 50; ++i) {
    PlainSocket visitor;
    ASSERT_TRUE(visitor.connect(server.port()));
    visitor.write(Bytes(100, 1));
    visitor.close(/*reset=*/false);
  }
  Reader reader(server.port());
  ASSERT_TRUE(meet(&server, &notes, &reader));
  EXPECT_EQ(notes.connected.size(), 1U);
  EXPECT_EQ(server.clientsRefused(), 0U);
}

TEST(Tcp, FiveHundredConnectionsBetweenTwoPollsWaitForTheirTurn) {
  const TcpServer server(kLoopback, 0);
  std::vector<std::unique_ptr<TcpClient>> crowd;
  for (int i = 0; i < 500; ++i) {
    crowd.push_back(std::make_unique<TcpClient>(kLoopback, server.port(), 0.1, 1.0));
    crowd.back()->poll(0, 20);
    ASSERT_FALSE(crowd.back()->isConnecting()) << i << ": the queue is full";
  }
}

TEST(TcpClient, PausesDoubleUpToTheLongest) {
  // GIVEN a port where nobody listens and a clock of our own
  TakenPort nobody;
  TcpClient client(kLoopback, nobody.port(), 0.1, 1.0);
  std::vector<std::int64_t> attempts_ms;
  for (std::int64_t now_ms = 0; now_ms <= 4000; now_ms += 10) {
    const std::uint64_t before = client.attempts();
    EXPECT_EQ(client.poll(now_ms * 1'000'000, 0), Event::kNone);
    if (client.attempts() != before) attempts_ms.push_back(now_ms);
    ASSERT_TRUE(eventually([&] {  // the refusal arrives, without our clock moving
      if (client.isConnecting()) client.poll(now_ms * 1'000'000, 10);
      return !client.isConnecting();
    }));
  }
  // THEN the pauses are 100, 200, 400, 800, 1000, 1000 ms
  EXPECT_EQ(attempts_ms, (std::vector<std::int64_t>{0, 100, 300, 700, 1500, 2500, 3500}));
}

TEST(TcpClient, StartsWithTheShortestPauseAgainAfterASuccess) {
  // GIVEN a client whose pause has grown to 0.8 s
  auto listener = std::make_unique<TakenPort>();
  TcpClient client(kLoopback, listener->port(), 0.1, 10.0);
  const auto pollAt = [&](std::int64_t ms) { return client.poll(ms * 1'000'000, 0); };
  for (const std::int64_t ms : {0, 100, 300}) {
    ASSERT_TRUE(eventually([&] {
      pollAt(ms);
      return !client.isConnecting();
    }));
  }
  ASSERT_EQ(client.attempts(), 3U);
  // WHEN the fourth attempt succeeds, something is received, and the connection is then lost
  ASSERT_TRUE(listener->listen(1));
  ASSERT_TRUE(eventually([&] { return pollAt(700) == Event::kConnected; }));
  std::uint8_t byte = 7;
  ASSERT_TRUE(listener->greet(byte));
  listener.reset();
  ASSERT_TRUE(eventually([&] {
    const Event event = pollAt(1000);
    if (event == Event::kReadable) client.receive(&byte, 1);
    return event == Event::kDisconnected;
  }));
  // THEN the next one comes after 0.1 s
  EXPECT_EQ(client.attempts(), 4U);
  pollAt(1099);
  EXPECT_EQ(client.attempts(), 4U);
  pollAt(1100);
  EXPECT_EQ(client.attempts(), 5U);
}

TEST(TcpClient, PausesGrowWhileAServerAcceptsAndCloses) {
  TakenPort full;
  ASSERT_TRUE(full.listen(8));
  TcpClient client(kLoopback, full.port(), 0.1, 10.0);
  std::uint8_t byte = 0;
  std::vector<std::int64_t> lost_ms;
  std::int64_t ms = 0;
  for (; lost_ms.size() < 3 && ms < 5000; ms += 10) {
    const std::int64_t now_ns = ms * 1'000'000;
    if (client.poll(now_ns, 0) == Event::kNone && !client.isConnecting()) continue;
    ASSERT_TRUE(eventually([&] { return client.isConnected() || client.poll(now_ns, 10) == Event::kConnected; }));
    ASSERT_TRUE(full.acceptAndClose());
    ASSERT_TRUE(eventually([&] {
      const Event event = client.poll(now_ns, 10);
      if (event == Event::kReadable) client.receive(&byte, 1);
      return event == Event::kDisconnected;
    }));
    lost_ms.push_back(ms);
  }
  EXPECT_EQ(lost_ms, (std::vector<std::int64_t>{0, 100, 300}));
}

TEST(TcpClient, GivesUpAnAttemptThatNobodyAnswers) {
  // GIVEN a listener that accepts nobody: once its queue is full, connection requests go unanswered
  TakenPort listener;
  ASSERT_TRUE(listener.listen(0));
  std::vector<std::unique_ptr<TcpClient>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<TcpClient>(kLoopback, listener.port(), 0.1, 1.0));
    clients.back()->poll(0, 20);
  }
  TcpClient& last = *clients.back();
  ASSERT_TRUE(last.isConnecting());
  last.poll(TcpClient::kConnectTimeoutNs - 1, 0);
  EXPECT_TRUE(last.isConnecting());
  last.poll(TcpClient::kConnectTimeoutNs, 0);
  EXPECT_FALSE(last.isConnecting());
}

TEST(TcpClient, EachAttemptHasItsWholeTime) {
  TakenPort listener;
  ASSERT_TRUE(listener.listen(0));
  std::vector<std::unique_ptr<TcpClient>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<TcpClient>(kLoopback, listener.port(), 0.1, 0.1));
    clients.back()->poll(0, 20);
  }
  TcpClient& last = *clients.back();
  constexpr std::int64_t kPause = 100'000'000, kTime = TcpClient::kConnectTimeoutNs;
  for (std::int64_t attempt = 0; attempt < 3; ++attempt) {
    const std::int64_t begin = attempt * (kTime + kPause);
    last.poll(begin, 0);
    EXPECT_EQ(last.attempts(), static_cast<std::uint64_t>(attempt + 1));
    last.poll(begin + kTime - 1, 0);
    EXPECT_TRUE(last.isConnecting()) << attempt;
    last.poll(begin + kTime, 0);
    EXPECT_FALSE(last.isConnecting()) << attempt;
  }
}

TEST(TcpClient, OnlyAConnectionThatWasUpIsLost) {
  TakenPort listener;
  TcpClient never(kLoopback, listener.port(), 0.1, 1.0);
  never.disconnect();
  EXPECT_NE(never.poll(0, 0), Event::kDisconnected);
  ASSERT_TRUE(listener.listen(1));
  TcpClient client(kLoopback, listener.port(), 0.1, 1.0);
  ASSERT_TRUE(eventually([&] { return client.poll(0, 10) == Event::kConnected; }));
  client.disconnect();
  EXPECT_EQ(client.poll(0, 0), Event::kDisconnected);
  EXPECT_EQ(client.poll(0, 0), Event::kNone) << "once";
}

TEST(TcpClient, AWriteThatFailsEndsTheConnection) {
  TakenPort listener;
  ASSERT_TRUE(listener.listen(1));
  TcpClient client(kLoopback, listener.port(), 0.1, 1.0);
  ASSERT_TRUE(eventually([&] { return client.poll(0, 10) == Event::kConnected; }));
  ASSERT_TRUE(listener.acceptAndClose());
  const std::uint8_t byte = 1;
  ASSERT_TRUE(eventually([&] { return !client.send(&byte, 1); }));  // the first one meets a reset
  EXPECT_FALSE(client.isConnected());
  EXPECT_FALSE(client.send(&byte, 1));
  EXPECT_EQ(client.poll(0, 0), Event::kDisconnected);
  EXPECT_EQ(client.poll(0, 0), Event::kNone);
}

TEST(TcpClient, SendsNothingUnlessConnected) {
  TakenPort nobody;
  TcpClient client(kLoopback, nobody.port(), 0.1, 1.0);
  const std::uint8_t byte = 1;
  EXPECT_FALSE(client.send(&byte, 1));
  client.poll(0, 0);
  EXPECT_FALSE(client.send(&byte, 1));
}

TEST(TcpClient, NeverSendsHalfAFrame) {
  TcpServer server(kLoopback, 0);
  Notes notes;
  Reader reader(server.port());
  ASSERT_TRUE(meet(&server, &notes, &reader));
  // WHEN the server does not read
  const Bytes block(4096, 7);
  std::size_t accepted = 0;
  bool failed = false;
  for (int i = 0; i < 100000 && !failed; ++i) {
    failed = !reader.client.send(block.data(), block.size());
    if (!failed) ++accepted;
  }
  ASSERT_TRUE(failed);
  // THEN the server gets all accepted bytes, and anything more is followed by the end of the connection
  const Bytes& got = notes.received[notes.connected[0]];
  EXPECT_TRUE(eventually([&] {
    server.poll(1, notes);
    reader.poll();
    return got.size() >= accepted * block.size() && (reader.client.isConnected() || !notes.disconnected.empty());
  }));
  EXPECT_TRUE(got.size() == accepted * block.size() || !notes.disconnected.empty());
}

TEST(TcpClient, RefusesImpossiblePauses) {
  EXPECT_THROW(TcpClient(kLoopback, 26100, 0.0, 1.0), NetworkException);
  EXPECT_THROW(TcpClient(kLoopback, 26100, 2.0, 1.0), NetworkException);
  EXPECT_THROW(TcpClient("", 26100, 0.1, 1.0), NetworkException);
}

}  // namespace
}  // namespace raven2_trainer::net
