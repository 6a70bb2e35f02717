#include "raven2_trainer/robot/state_server.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/tcp_client.h"
#include "support/effort.h"
#include "unit/net/net_support.h"

namespace raven2_trainer::robot {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

/** A reader on a real socket; time is the test's. */
class TestReader {
 public:
  explicit TestReader(std::uint16_t port, double again_after = 0.01)
      : client_("127.0.0.1", port, again_after, 10.0 * again_after) {}

  void poll() {
    const auto event = client_.poll(net::monotonicNow(), 0);
    if (event == net::TcpClient::Event::kDisconnected) left_ = true;
    if (event == net::TcpClient::Event::kReadable) read();
  }

  bool began{false};  ///< the test's

  bool isUp() const { return client_.isConnected(); }
  bool left() const { return left_; }
  bool greeted() const { return greeted_; }
  bool isVirtual() const { return is_virtual_; }
  const std::vector<RobotState>& states() const { return states_; }
  bool send(const std::uint8_t* bytes, std::size_t size) { return client_.send(bytes, size); }

  const std::vector<bool>& answers() const { return answers_; }
  const std::vector<FaultChange>& changes() const { return changes_; }

  void sendSignals(double distance) {
    const std::size_t size = wire::encodeFaultSignals(1, {distance, distance, 3, 0}, bytes_.data());
    ASSERT_TRUE(client_.send(bytes_.data(), size));
  }

  void sendPlan(std::uint32_t fault_id, std::uint32_t session = 0) {
    FaultPlan plan;
    plan.generation = 1;
    plan.session = session;
    plan.count = 1;
    plan.faults[0].id = fault_id;
    plan.faults[0].site = FaultSite::kPutUsbPacket;
    plan.faults[0].variable = FaultVariable::kDac;
    plan.faults[0].kind = FaultKind::kStuckAt;
    const std::size_t size = wire::encodeFaultPlan(1, plan, bytes_.data());
    ASSERT_TRUE(client_.send(bytes_.data(), size));
  }

 private:
  void read() {
    while (const std::size_t size = client_.receive(bytes_.data(), bytes_.size())) {
      parser_.feed(bytes_.data(), size);
      wire::Frame frame;
      while (parser_.next(&frame) == wire::FrameParser::Result::kFrame)
        take(frame);
    }
  }

  void take(const wire::Frame& frame) {
    RobotState state;
    if (frame.type == wire::FrameType::kHello) {
      greeted_ = states_.empty();
      is_virtual_ = wire::saysVirtual(frame);
    } else if (FaultChange change; wire::decodeFaultChange(frame, &change)) {
      changes_.push_back(change);
    } else if (bool is_armed = false; wire::decodePlanAnswer(frame, &is_armed)) {
      answers_.push_back(is_armed);
    } else if (wire::decodeState(frame, &state) == Reject::kNone) {
      states_.push_back(state);
    }
  }

  net::TcpClient client_;
  wire::FrameParser parser_;
  std::array<std::uint8_t, wire::kMaxFrame> bytes_{};
  std::vector<RobotState> states_;
  std::vector<FaultChange> changes_;
  std::vector<bool> answers_;
  bool greeted_{false}, is_virtual_{false}, left_{false};
};

class StateServerTest : public ::testing::Test {
 protected:
  /** Serves and polls until `done`; the server's clock stops unless the test advances it. */
  template <typename Done>
  bool until(Done done) {
    const std::int64_t end = net::monotonicNow() + 10 * kSecond;
    while (net::monotonicNow() < end) {
      server->serve(now_ns);
      for (auto& reader : readers)
        if (reader) reader->poll();
      if (done()) return true;
    }
    return false;
  }

  TestReader* join() {
    readers.push_back(std::make_unique<TestReader>(server->port()));
    TestReader* reader = readers.back().get();
    EXPECT_TRUE(until([&] { return reader->greeted(); }));
    return reader;
  }

  std::uint32_t armed() const {
    const FaultPlan plan = server->faults().load();
    return plan.count == 0 ? 0 : plan.faults[0].id;
  }

  void push(std::uint64_t cycle) {
    RobotState state;
    state.cycle = cycle;
    server->push(state);
  }

  std::int64_t now_ns{kSecond};
  std::unique_ptr<StateServer> server{std::make_unique<StateServer>("127.0.0.1", 0, true)};
  std::vector<std::unique_ptr<TestReader>> readers;
};

TEST_F(StateServerTest, FourReadersGetTheHelloAndThenEveryCycle) {
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(join()->isVirtual());
  for (std::uint64_t cycle = 1; cycle <= 500; ++cycle) {
    push(cycle);
    ASSERT_TRUE(until([&] {
      for (const auto& reader : readers)
        if (reader->states().size() != cycle) return false;
      return true;
    })) << cycle;
  }
  for (const auto& reader : readers) {
    for (std::size_t i = 0; i < 500; ++i)
      ASSERT_EQ(reader->states()[i].cycle, i + 1);
  }
  EXPECT_EQ(server->framesDropped(), 0U);
  EXPECT_EQ(server->frames().pushed, 2004U);  // four hellos
  EXPECT_EQ(server->frames().sent, 2004U);
  EXPECT_EQ(server->readers(), 4U);
}

TEST_F(StateServerTest, TheFirstReaderWithAPlanOwnsItUntilItLeaves) {
  TestReader* first = join();
  TestReader* second = join();
  second->sendPlan(22);
  ASSERT_TRUE(until([&] { return armed() == 22; }));
  first->sendPlan(11);
  ASSERT_TRUE(until([&] { return server->plansRefused() == 1; }));
  EXPECT_EQ(armed(), 22U);
  second->sendPlan(23);  // the owner may change it
  ASSERT_TRUE(until([&] { return armed() == 23; }));
  const std::uint64_t generation = server->faults().load().generation;

  readers[1].reset();  // the owner leaves, another reader stays
  ASSERT_TRUE(until([&] { return server->readers() == 1; }));
  EXPECT_EQ(armed(), 0U) << "nobody is left who could clear it";
  EXPECT_GT(server->faults().load().generation, generation);

  first->sendPlan(12);
  ASSERT_TRUE(until([&] { return armed() == 12; }));
  EXPECT_EQ(server->plansRefused(), 1U);
}

TEST_F(StateServerTest, EveryPlanIsAnsweredToItsSender) {
  TestReader* owner = join();
  TestReader* other = join();
  owner->sendPlan(5);
  ASSERT_TRUE(until([&] { return owner->answers().size() == 1; }));
  other->sendPlan(6);
  ASSERT_TRUE(until([&] { return other->answers().size() == 1; }));
  EXPECT_EQ(owner->answers(), (std::vector<bool>{true}));
  EXPECT_EQ(other->answers(), (std::vector<bool>{false}));
}

TEST_F(StateServerTest, APlanThatCannotBeMadeIsRefusedAndTheArmedOneStays) {
  TestReader* owner = join();
  owner->sendPlan(5);
  ASSERT_TRUE(until([&] { return armed() == 5; }));
  std::array<std::uint8_t, wire::kMaxFrame> bytes{};
  FaultPlan wrong;
  wrong.count = 1;  // a row of nothing
  ASSERT_TRUE(owner->send(bytes.data(), wire::encodeFaultPlan(2, wrong, bytes.data())));
  ASSERT_TRUE(until([&] { return owner->answers().size() == 2; }));
  EXPECT_EQ(owner->answers(), (std::vector<bool>{true, false}));
  EXPECT_EQ(armed(), 5U);
}

TEST_F(StateServerTest, SignalsCountFromThePlanOfTheirSenderOnAndOfNobodyElse) {
  TestReader* owner = join();
  TestReader* other = join();
  owner->sendSignals(0.25);
  other->sendSignals(0.5);
  owner->sendPlan(5);
  ASSERT_TRUE(until([&] { return armed() == 5; }));
  EXPECT_EQ(server->signals().load().tissue_distance, 0.25) << "with the plan, not after it";
  owner->sendSignals(0.125);
  ASSERT_TRUE(until([&] { return server->signals().load().tissue_distance == 0.125; })) << "they go on";
  other->sendSignals(0.75);
  other->sendPlan(6);
  ASSERT_TRUE(until([&] { return server->plansRefused() == 1; }));
  EXPECT_EQ(server->signals().load().tissue_distance, 0.125);
  readers[0].reset();
  ASSERT_TRUE(until([&] { return armed() == 0; }));
  other->sendPlan(7);
  ASSERT_TRUE(until([&] { return armed() == 7; }));
  EXPECT_EQ(server->signals().load().tissue_distance, 0.75) << "its own, not the last owner's";
}

TEST_F(StateServerTest, AnOwnerThatLeavesSuspendsItsSessionsFaults) {
  TestReader* owner = join();
  owner->sendPlan(5, 77);
  ASSERT_TRUE(until([&] { return armed() == 5; }));
  EXPECT_EQ(server->faults().load().session, 77U);
  EXPECT_EQ(server->faults().load().is_suspended, 0);
  readers[0].reset();
  ASSERT_TRUE(until([&] { return armed() == 0; }));
  EXPECT_EQ(server->faults().load().session, 77U);
  EXPECT_EQ(server->faults().load().is_suspended, 1);
}

TEST_F(StateServerTest, ChangesOfFaultsComeToEveryReaderAheadOfTheirState) {
  for (int i = 0; i < 2; ++i)
    join();
  for (std::uint64_t cycle = 1; cycle <= 100; ++cycle) {
    FaultChange change;
    change.number = cycle;
    change.cycle = cycle;
    server->push(change);
    push(cycle);
    ASSERT_TRUE(until([&] {
      for (const auto& reader : readers) {
        if (reader->states().size() > reader->changes().size()) return true;  // wrong: seen below
        if (reader->states().size() != cycle) return false;
      }
      return true;
    }));
    for (const auto& reader : readers)
      ASSERT_EQ(reader->changes().size(), cycle);
  }
}

TEST_F(StateServerTest, TheRestOfTheReadersLeavingDoesNotDisarm) {
  TestReader* owner = join();
  join();
  owner->sendPlan(5);
  ASSERT_TRUE(until([&] { return armed() == 5; }));
  readers[1].reset();
  ASSERT_TRUE(until([&] { return server->readers() == 1; }));
  EXPECT_EQ(armed(), 5U);
}

TEST_F(StateServerTest, ThePlanSentAgainByItsOwnerChangesNothingAndIsTakenOnceAnotherOwnerLeft) {
  TestReader* dead = join();
  TestReader* daemon = join();
  dead->sendPlan(7);
  ASSERT_TRUE(until([&] { return armed() == 7; }));
  const std::uint64_t generation = server->faults().load().generation;
  dead->sendPlan(7);
  daemon->sendPlan(8);  // refused, and by then the owner's second one has been read
  ASSERT_TRUE(until([&] { return server->plansRefused() == 1; }));
  EXPECT_EQ(server->faults().load().generation, generation);
  readers[0].reset();
  ASSERT_TRUE(until([&] { return armed() == 0; }));
  daemon->sendPlan(8);  // as every second
  EXPECT_TRUE(until([&] { return armed() == 8; }));
}

TEST_F(StateServerTest, ThePlanOfAnOwnerThatCameBackIsArmedAgain) {
  join()->sendPlan(5, 77);
  ASSERT_TRUE(until([&] { return armed() == 5; }));
  const std::uint64_t generation = server->faults().load().generation;
  readers[0].reset();
  ASSERT_TRUE(until([&] { return armed() == 0; }));
  join()->sendPlan(5, 77);
  EXPECT_TRUE(until([&] { return armed() == 5; }));
  EXPECT_GT(server->faults().load().generation, generation) << "as another plan";
}

TEST_F(StateServerTest, SixtyFourDribblersNeverKeepAGoodReaderOut) {
  TestReader* good = join();
  std::array<std::uint8_t, wire::kMaxFrame> plan{};
  wire::encodeFaultPlan(1, FaultPlan{}, plan.data());
  std::vector<std::unique_ptr<TestReader>> crowd;
  for (int i = 0; i < 64; ++i)
    crowd.push_back(std::make_unique<TestReader>(server->port(), /*again_after=*/60.0));
  const auto dribble = [&] {
    for (auto& each : crowd) {
      each->poll();
      if (each->isUp() && each->greeted() && !each->began) each->began = each->send(plan.data(), 1);
    }
  };
  ASSERT_TRUE(until([&] {
    dribble();
    return server->partsWaiting() == 3;
  }));
  // WHEN another good one comes, it has its place at once, and both get what is sent
  TestReader* late = join();
  push(1);
  EXPECT_TRUE(until([&] { return good->states().size() == 1 && late->states().size() == 1; }));
  EXPECT_GE(server->readersEvicted(), 1U);
  // THEN the crowd is gone half a second later
  now_ns += StateServer::kFrameDeadlineNs;
  EXPECT_TRUE(until([&] { return server->partsWaiting() == 0 && server->readers() == 2; }));
  EXPECT_TRUE(good->isUp());
  EXPECT_TRUE(late->isUp());
  EXPECT_TRUE(server->frames().addsUp());
}

TEST_F(StateServerTest, AStormOfReadersThatWriteDisturbsNeitherThreadsNorCounters) {
  const std::int64_t storms = raven2_trainer::testing::effort(200, 1000);
  const int before = net::openDescriptors();
  Random random(8);
  server->start();  // the thread sends and accepts from here on
  for (std::int64_t i = 0; i < storms; ++i) {
    net::PlainSocket visitor;
    ASSERT_TRUE(visitor.connect(server->port()));
    visitor.write(std::vector<std::uint8_t>(random.next() % 700, 7));
    push(static_cast<std::uint64_t>(i));
    visitor.close(/*reset=*/random.next() % 2 == 0);
  }
  EXPECT_TRUE(net::eventually([&] { return net::openDescriptors() == before && server->readers() == 0; }));
  server->stop();
  EXPECT_TRUE(server->frames().addsUp());
  EXPECT_EQ(server->frames().queued, 0U);
  EXPECT_EQ(armed(), 0U);
}

TEST_F(StateServerTest, ARealRobotRefusesEveryPlan) {
  server = std::make_unique<StateServer>("127.0.0.1", 0, /*is_virtual=*/false);
  TestReader* reader = join();
  EXPECT_FALSE(reader->isVirtual());
  reader->sendPlan(1);
  reader->sendPlan(2);
  ASSERT_TRUE(until([&] { return server->plansRefused() == 2; }));
  EXPECT_EQ(armed(), 0U);
  EXPECT_TRUE(reader->isUp());
}

TEST_F(StateServerTest, ADribblingReaderIsClosedAfterHalfASecondAndAQuietOneIsNot) {
  TestReader* quiet = join();
  TestReader* dribbler = join();
  std::array<std::uint8_t, wire::kMaxFrame> plan{};
  wire::encodeFaultPlan(1, FaultPlan{}, plan.data());
  // WHEN a byte comes now and then, never a whole frame
  std::size_t sent = 0;
  ASSERT_TRUE(dribbler->send(plan.data() + sent++, 1));
  ASSERT_TRUE(until([&] { return server->partsWaiting() == 1; }));
  now_ns += StateServer::kFrameDeadlineNs - 1;
  ASSERT_TRUE(dribbler->send(plan.data() + sent++, 1));
  server->serve(now_ns);
  EXPECT_EQ(server->partsWaiting(), 1U);
  now_ns += 1;
  EXPECT_TRUE(until([&] { return dribbler->left(); }));
  EXPECT_EQ(server->plansRefused(), 0U);
  EXPECT_TRUE(quiet->isUp()) << "a reader need not say anything";
}

TEST_F(StateServerTest, AReaderWhoseFramesComeInPiecesIsKept) {
  TestReader* reader = join();
  std::array<std::uint8_t, wire::kMaxFrame> plan{};
  const std::size_t size = wire::encodeFaultPlan(1, FaultPlan{}, plan.data());
  ASSERT_TRUE(reader->send(plan.data(), 1));
  for (int frame = 0; frame < 5; ++frame) {  // the rest of it, and the first byte of the next
    ASSERT_TRUE(until([&] { return server->partsWaiting() == 1; }));
    now_ns += StateServer::kFrameDeadlineNs * 6 / 10;
    ASSERT_TRUE(reader->send(plan.data() + 1, size - 1));
    ASSERT_TRUE(reader->send(plan.data(), 1));
    const auto answered = static_cast<std::size_t>(frame + 1);
    ASSERT_TRUE(until([&] { return reader->answers().size() == answered || reader->left(); }));
    ASSERT_FALSE(reader->left()) << frame;
  }
}

TEST_F(StateServerTest, AStalledReaderIsClosedAfterTwoSecondsAndDelaysNobody) {
  TestReader* good = join();
  auto stalled = std::make_unique<TestReader>(server->port());
  ASSERT_TRUE(until([&] {
    if (!stalled->greeted()) stalled->poll();
    return stalled->greeted();
  }));
  // WHEN it no longer reads
  std::uint64_t cycle = 0;
  const auto next = [&] {
    push(++cycle);
    now_ns += kTickNanoseconds;
    return until([&] { return good->states().size() == cycle; });
  };
  while (server->framesDropped() == 0 && cycle < 5000)
    ASSERT_TRUE(next());
  ASSERT_GT(server->framesDropped(), 0U);
  // The system's buffers keep filling for as long as the system's timers take. The server's clock stops meanwhile.
  std::uint64_t sent = 0;
  std::int64_t settled = net::monotonicNow();
  ASSERT_TRUE(until([&] {
    push(++cycle);
    const std::uint64_t sent_before = sent;
    sent = server->frames().pushed - server->frames().dropped - cycle;  // changes while the stalled one takes
    if (sent != sent_before) settled = net::monotonicNow();
    return net::monotonicNow() - settled > kSecond / 2;
  }));
  ASSERT_TRUE(until([&] { return good->states().size() == cycle; }));
  EXPECT_EQ(server->readers(), 2U);
  const std::uint64_t full = cycle;
  while (server->readers() == 2 && cycle < full + 3000)
    ASSERT_TRUE(next());
  EXPECT_EQ(server->readers(), 1U);
  EXPECT_LE(cycle - full, 2001U);
  EXPECT_GT(cycle - full, 1900U) << "two seconds without a byte, not less";
}

TEST_F(StateServerTest, AReaderOfAnotherVersionIsClosed) {
  TestReader* reader = join();
  std::array<std::uint8_t, wire::kMaxFrame> plan{};
  const std::size_t size = wire::encodeFaultPlan(1, FaultPlan{}, plan.data());
  plan[5] = 9;
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(reader->send(plan.data(), size));
  EXPECT_TRUE(until([&] { return reader->left(); }));
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("9.0"), std::string::npos) << said;
  EXPECT_NE(said.find("4.0"), std::string::npos) << said;
}

}  // namespace
}  // namespace raven2_trainer::robot
