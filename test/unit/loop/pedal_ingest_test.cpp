#include <gtest/gtest.h>

#include <array>

#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/wire/pedals.h"
#include "support/mode_driver.h"
#include "unit/wire/gate_bench.h"

// Tests packets of pedals that arrive next to ITP, from the packet to the mode.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::ModeDriver;

constexpr std::uint64_t kMaster = 1, kStranger = 2;  // the rig's ITP comes from 1

class PedalIngest : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    d = std::make_unique<ModeDriver>();
    ASSERT_TRUE(d->begin());
  }

  Reject send(std::uint32_t held, std::uint64_t source = kMaster) {
    const wire::PedalBytes bytes = wire::encodePedals({++sequence, held});
    return d->rig.ingest.receive({bytes.data(), bytes.size(), source, d->rig.model().time_ns});
  }

  /** Presses and releases a pedal. */
  void press(Pedal pedal) {
    EXPECT_EQ(send(bit(pedal)), Reject::kNone);
    d->rest(false, 1);
    EXPECT_EQ(send(0), Reject::kNone);
    d->rest(false, 1);
  }

  std::unique_ptr<ModeDriver> d;
  std::uint32_t sequence{0};
};

TEST_F(PedalIngest, APressReachesTheModeInTheSameTick) {
  press(Pedal::kSimulation);
  EXPECT_EQ(d->mode(), Mode::kSimulationHeld);
  press(Pedal::kSimulation);
  EXPECT_TRUE(d->waitFor(Mode::kPedalUp));
  press(Pedal::kTrial);
  EXPECT_EQ(d->mode(), Mode::kTrialHeld);
  press(Pedal::kTrial);
  EXPECT_EQ(d->mode(), Mode::kTrialReady);
  press(Pedal::kView);
  EXPECT_EQ(d->rig.model().view, 1);
  press(Pedal::kView);
  EXPECT_EQ(d->rig.model().view, 0);
  press(Pedal::kStop);
  EXPECT_EQ(d->mode(), Mode::kStopped);
  EXPECT_EQ(d->rig.ingest.pedalCounts().applied, 14U);
  EXPECT_TRUE(d->rig.ingest.pedalCounts().addsUp());
}

TEST_F(PedalIngest, TheCameraMovesWhileItsPedalIsHeldAndTheStopIsServedInATick) {
  send(bit(Pedal::kCamera));
  d->rest(false, 50);
  EXPECT_EQ(d->mode(), Mode::kCameraMoving);
  send(0);
  d->rest(false, 1);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  d->rest(true, 100);
  send(bit(Pedal::kStop));
  d->rest(true, 1);
  EXPECT_EQ(d->mode(), Mode::kStopped);
  EXPECT_EQ(d->rig.last_relay.command.pedal, 0);
}

TEST_F(PedalIngest, SilenceReleasesTheCamera) {
  send(bit(Pedal::kCamera));
  d->rest(false, 10);
  ASSERT_EQ(d->mode(), Mode::kCameraMoving);
  d->rig.ingest.idle(d->rig.model().time_ns + 100 * kTickNanoseconds);
  d->rest(false, 1);
  EXPECT_EQ(d->mode(), Mode::kCameraMoving);
  d->rig.ingest.idle(d->rig.model().time_ns + 400 * kTickNanoseconds);
  d->rest(false, 1);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
}

/** The surgeon still moves the camera, with both pedals down. Only the packets of one pedal are lost. */
TEST_F(PedalIngest, SilenceOfTheCamerasPedalDoesNotSetTheArmsMoving) {
  d->rest(true, 100);
  ASSERT_EQ(d->mode(), Mode::kTeleoperating);
  send(bit(Pedal::kCamera));
  d->rest(true, 10);
  ASSERT_EQ(d->mode(), Mode::kCameraMoving);
  const Vec3 before = d->modelTip();
  d->rig.ingest.idle(d->rig.model().time_ns + 400 * kTickNanoseconds);
  d->watch = [this] {
    EXPECT_EQ(d->mode(), Mode::kPedalUp);
    EXPECT_EQ(d->rig.last_relay.command.pedal, 0);
    EXPECT_EQ(d->rig.last_relay.command.dp_I, MasterCommand{}.dp_I);
  };
  d->stroke(200, 1.0);
  d->watch = nullptr;
  EXPECT_LT(raven2_trainer::testing::apart(d->modelTip(), before), 1e-3);
  d->rest(false, 2);
  d->rest(true, 50);
  EXPECT_EQ(d->mode(), Mode::kTeleoperating) << "a new press of the arms' pedal counts";
}

TEST_F(PedalIngest, WhoLiftsTheCamerasPedalGoesOnWithTheArms) {
  d->rest(true, 100);
  send(bit(Pedal::kCamera));
  d->rest(true, 10);
  send(0);
  d->rest(true, 1);
  EXPECT_EQ(d->mode(), Mode::kTeleoperating);
}

TEST_F(PedalIngest, TheLateAnswerToAPlanThatWasGivenUpIsNotTheNextOnes) {
  std::array<PlanRequest, 2> asked;
  for (PlanRequest& each : asked) {
    press(Pedal::kPlanning);
    ASSERT_EQ(d->mode(), Mode::kChoosing);
    press(Pedal::kPlanning);
    ASSERT_EQ(d->mode(), Mode::kPlanning);
    ASSERT_TRUE(d->rig.shared->plan_requests.tryPop(&each));
    if (&each == &asked[0]) press(Pedal::kPlanning);
  }
  EXPECT_NE(asked[0].id, 0U);
  EXPECT_NE(asked[1].id, asked[0].id);
  PlanResult late;
  late.id = asked[0].id;
  late.status = PlanStatus::kNoPath;
  ASSERT_TRUE(d->rig.shared->plan_results.tryPush(late));
  d->rest(false, 1);
  EXPECT_EQ(d->mode(), Mode::kPlanning) << "the second plan is still under way";
  EXPECT_EQ(d->rig.shared->last_plan.load().status, PlanStatus::kCancelled);
  late.id = asked[1].id;
  ASSERT_TRUE(d->rig.shared->plan_results.tryPush(late));
  d->rest(false, 1);
  EXPECT_NE(d->mode(), Mode::kPlanning);
}

TEST_F(PedalIngest, TheAnswerToAClientStaysWhateverPedalsAskFor) {
  ASSERT_EQ(d->ask(RequestKind::kSetView), PlanningAnswer::kAccepted);
  for (int i = 0; i < 3; ++i) {  // begin, record, give up
    press(Pedal::kPlanning);
    EXPECT_EQ(d->rig.model().planning.answered, d->last_id);
    EXPECT_EQ(d->rig.model().planning.answer, PlanningAnswer::kAccepted);
  }
}

TEST_F(PedalIngest, LateAndDoubledOnesAreCountedAsSuch) {
  sequence = 10;
  EXPECT_EQ(send(bit(Pedal::kView)), Reject::kNone);
  --sequence;
  EXPECT_EQ(send(bit(Pedal::kView)), Reject::kDuplicate);
  sequence = 5;
  EXPECT_EQ(send(0), Reject::kOutOfOrder);
  EXPECT_EQ(d->rig.ingest.pedalCounts().applied, 1U);
  EXPECT_EQ(d->rig.ingest.pedalCounts().rejectedTotal(), 2U);
}

TEST_F(PedalIngest, NobodyElseAndNothingBrokenIsHeard) {
  EXPECT_EQ(send(bit(Pedal::kStop), kStranger), Reject::kForeignSource);
  wire::PedalBytes bytes = wire::encodePedals({++sequence, bit(Pedal::kStop)});
  bytes[13] ^= 1;
  EXPECT_NE(d->rig.ingest.receive({bytes.data(), bytes.size(), kMaster, d->rig.model().time_ns}), Reject::kNone);
  d->rest(false, 5);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  EXPECT_EQ(d->rig.ingest.pedalCounts().rejectedTotal(), 2U);
  EXPECT_EQ(d->rig.shared->pedal_link.load().rejectedTotal(), 2U) << "the count is published";
  EXPECT_EQ(d->rig.ingest.counts().rejectedTotal(), 0U) << "pedal packets are not ITP";
}

TEST(PedalIngestSigned, WhereItpHasToBeSignedTheyAreRefused) {
  ItpRules rules;
  rules.auth = ItpAuth::kRequired;
  const auto shared = std::make_unique<SharedState>();
  MasterIngest ingest(rules, nullptr, shared.get());
  const wire::PedalBytes bytes = wire::encodePedals({1, bit(Pedal::kStop)});
  EXPECT_EQ(ingest.receive({bytes.data(), bytes.size(), kMaster, 0}), Reject::kUnsigned);
  EXPECT_EQ(shared->pedal_requests.counts().pushed, 0U);
}

/** Holds the arms' pedal down, and later the camera's too. */
class CameraHand : public console::MotionSource {
 public:
  console::Intent tick(const console::Senses&) override {
    console::Intent intent;
    intent.pedal = ++ticks_ > 10;
    intent.pedals = ticks_ > 500 ? bit(Pedal::kCamera) : 0;
    return intent;
  }

 private:
  int ticks_{0};
};

TEST(PedalLockstep, SilenceOfTheLinkReleasesTheCameraByTheSimulatedClock) {
  raven2_trainer::testing::useOde();
  lockstep::LockstepStack stack(ModeDriver::configuration(), std::make_unique<CameraHand>());
  const auto ticks = [&](int n) {
    for (int i = 0; i < n; ++i) {
      stack.tick();
      stack.discardRecords();
    }
  };
  for (int i = 0; i < 10000 && stack.view().model.mode != Mode::kCameraMoving; ++i)
    ticks(1);
  ASSERT_EQ(stack.view().model.mode, Mode::kCameraMoving);
  Impairment nothing_passes;
  nothing_passes.loss = 1.0;
  stack.impair(nothing_passes);
  ticks(150);
  EXPECT_EQ(stack.view().model.mode, Mode::kCameraMoving);
  ticks(150);
  EXPECT_EQ(stack.view().model.mode, Mode::kPedalUp);
}

/** A separate ingest, and a master that sends both kinds of ITP. */
class PedalIngestRules : public ::testing::Test {
 protected:
  static constexpr std::int64_t kStart = 1'000'000'000;  // [ns]

  static ItpRules rulesOf(bool hardened, ItpAuth auth) {
    ItpRules rules = raven2_trainer::testing::packagedConfig().network.itp;
    rules.hardened = hardened;
    rules.auth = auth;
    return rules;
  }

  void listen(bool hardened, ItpAuth auth) {
    ingest = std::make_unique<MasterIngest>(rulesOf(hardened, auth), &wire::benchKey(), shared.get());
  }

  Reject receive(const std::uint8_t* bytes, std::size_t size, std::uint64_t source) {
    return ingest->receive({bytes, size, source, now_ns});
  }

  Reject pedals(std::uint32_t held, std::uint64_t source = kMaster) {
    const wire::PedalBytes bytes = wire::encodePedals({++sequence, held});
    return receive(bytes.data(), bytes.size(), source);
  }

  /** An ITP packet with the pedal up. */
  static wire::ItpBytes itp(std::uint32_t number) {
    wire::ItpPacket packet;
    packet.sequence = number;
    packet.checksum = wire::itpChecksum(packet);
    return wire::encodeItp(packet);
  }

  void sign() {
    wire::SignedSender sender(&wire::benchKey(), wire::Audience::kDaemon);
    const wire::HandshakeBytes hello = sender.hello(wire::Nonce{1}, now_ns);
    wire::HandshakeBytes reply;
    ASSERT_EQ(ingest->answer({hello.data(), hello.size(), kMaster, now_ns}, wire::Nonce{2}, &reply), Reject::kNone);
    ASSERT_TRUE(sender.receive(reply.data(), reply.size(), now_ns));
    const wire::SignedItpBytes bytes = sender.sign(itp(2), false);
    ASSERT_EQ(receive(bytes.data(), bytes.size(), kMaster), Reject::kNone);
  }

  std::unique_ptr<SharedState> shared{std::make_unique<SharedState>()};
  std::unique_ptr<MasterIngest> ingest;
  std::int64_t now_ns{kStart};
  std::uint32_t sequence{0};
};

TEST_F(PedalIngestRules, OnlyTheAddressThatMaySpeakIsHeardOfAnyonesToo) {
  constexpr std::uint64_t kAllowed = 0x7F000001ULL << 16U, kOther = 0x7F000002ULL << 16U;
  listen(false, ItpAuth::kOff);
  ingest->allowOnly(kAllowed);
  EXPECT_EQ(pedals(bit(Pedal::kStop), kOther | 36000U), Reject::kForeignSource);
  EXPECT_EQ(shared->pedal_requests.counts().pushed, 0U);
  EXPECT_EQ(pedals(bit(Pedal::kStop), kAllowed | 36000U), Reject::kNone);
  EXPECT_EQ(shared->pedal_requests.counts().pushed, 1U);
}

TEST_F(PedalIngestRules, AFloodIsNotServed) {
  listen(false, ItpAuth::kOff);
  int heard = 0;
  for (int i = 0; i < 1000; ++i, now_ns += kTickNanoseconds)
    heard += pedals(i % 2 == 0 ? bit(Pedal::kToolChange) : 0) == Reject::kNone ? 1 : 0;
  EXPECT_GE(heard, 200);
  EXPECT_LE(heard, 250) << "the limit is 50 at once and 200 a second";
  const std::uint64_t refused = ingest->pedalCounts().rejected[static_cast<std::size_t>(Reject::kRateLimited)];
  EXPECT_EQ(refused, 1000U - static_cast<std::uint64_t>(heard));
}

TEST_F(PedalIngestRules, FromTheFirstSignedPacketOnNoneIsHeardWhereBothAreTaken) {
  listen(true, ItpAuth::kAcceptBoth);
  const wire::ItpBytes plain = itp(1);
  ASSERT_EQ(receive(plain.data(), plain.size(), kMaster), Reject::kNone);
  EXPECT_EQ(pedals(bit(Pedal::kView)), Reject::kNone);
  sign();
  EXPECT_EQ(pedals(bit(Pedal::kStop)), Reject::kUnsigned);
  EXPECT_EQ(shared->pedal_requests.counts().pushed, 1U);
}

/** After half a second of silence a master must send a packet of ITP before its pedals count again. */
TEST_F(PedalIngestRules, OfAMasterThatWasLetGoNoneIsHeardBeforeItIntroducesItselfAgain) {
  listen(true, ItpAuth::kOff);
  for (std::uint32_t number = 1; number <= 2; ++number) {
    const wire::ItpBytes plain = itp(number);
    ASSERT_EQ(receive(plain.data(), plain.size(), kMaster), Reject::kNone);
    EXPECT_EQ(pedals(bit(Pedal::kView)), Reject::kNone);
    EXPECT_EQ(pedals(0), Reject::kNone);
    now_ns += 600 * kTickNanoseconds;
    ingest->idle(now_ns);
    EXPECT_EQ(pedals(bit(Pedal::kToolChange)), Reject::kForeignSource);
    EXPECT_EQ(shared->pedal_requests.counts().pushed, number);
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
