#include "loop/robot_tie.h"

#include <gtest/gtest.h>

#include <memory>

// Tests what the loop derives from the robot's states alone, without a world or another part of the loop.

namespace raven2_trainer::loop {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // [ns]
constexpr double kStaleAfter = 0.02;     // [s]

class RobotTieTest : public ::testing::Test {
 protected:
  /** A homed robot with its pedal up, whose first state was received at time 0. */
  RobotTieTest() {
    sent.connected = 1;
    sent.frame = 1;
    sent.cycle = 100;
    sent.homed = 1;
    sent.runlevel = RunLevel::kPedalUp;
  }

  /** One tick of the loop at `now` [ms], in its order. @return RobotTie::becomesReady(). */
  bool tick(std::int64_t now) {
    cell->store(sent);
    tie.hear(*cell, now * kMs);
    tie.forgetOld();
    const bool becomes_ready = tie.becomesReady();
    tie.listen();
    return becomes_ready;
  }

  /** The robot sends one more state, `cycles` of its cycles later. */
  void send(std::int64_t now, std::uint64_t cycles = 1) {
    ++sent.frame;
    sent.cycle += cycles;
    sent.received_ns = now * kMs;
  }

  /** Engages from a common pose. The robot hears us: its next state has the number of each packet. */
  void engage() {
    tick(0);
    for (int i = 1; i <= 3; ++i) {
      sent.last_sequence = static_cast<std::uint32_t>(i);
      send(i);
      tick(i);
    }
    tie.link(true);
    sent.runlevel = RunLevel::kPedalDown;
    send(4);
    tick(4);
    ASSERT_TRUE(tie.isLed());
    ASSERT_TRUE(tie.applies());
  }

  RobotState sent{};
  std::unique_ptr<StateCell<RobotState>> cell = std::make_unique<StateCell<RobotState>>();
  RobotTie tie{kStaleAfter};
};

TEST_F(RobotTieTest, NoRobotIsHeardBeforeItsFirstFrame) {
  sent = RobotState{};
  EXPECT_FALSE(tick(0));
  EXPECT_FALSE(tie.isHeard());
  EXPECT_FALSE(tie.wasHeard());
  EXPECT_TRUE(tie.isLost());
  EXPECT_FALSE(tie.isFresh());
}

TEST_F(RobotTieTest, AStateIsFreshForStaleAfterAndTheRobotLostAfterHalfASecond) {
  tick(20);
  EXPECT_TRUE(tie.isFresh());
  tick(21);
  EXPECT_FALSE(tie.isFresh());
  tick(500);
  EXPECT_FALSE(tie.isLost());
  tick(501);
  EXPECT_TRUE(tie.isLost());
  EXPECT_TRUE(tie.wasHeard());
}

TEST_F(RobotTieTest, BecomesReadyOnceItIsHomedAndDisengaged) {
  sent.homed = 0;
  EXPECT_FALSE(tick(0));
  EXPECT_TRUE(tie.isNotReady());
  sent.homed = 1;
  sent.runlevel = RunLevel::kPedalDown;
  EXPECT_FALSE(tick(0));
  sent.runlevel = RunLevel::kPedalUp;
  EXPECT_TRUE(tick(0));
  EXPECT_TRUE(tie.isThere());
  EXPECT_FALSE(tick(0)) << "it becomes ready only once";
}

TEST_F(RobotTieTest, ARobotThatStartsAgainIsAnotherRobot) {
  engage();
  sent.cycle = 0;
  sent.runlevel = RunLevel::kPedalUp;
  sent.homed = 0;
  send(5);
  tick(5);
  EXPECT_FALSE(tie.isLinked());
  EXPECT_FALSE(tie.isReady());
}

TEST_F(RobotTieTest, AnEmergencyStopUnlinks) {
  engage();
  sent.runlevel = RunLevel::kEStop;
  send(5);
  tick(5);
  EXPECT_TRUE(tie.isStopped());
  EXPECT_FALSE(tie.isLinked());
}

TEST_F(RobotTieTest, SilenceUnlinks) {
  engage();
  tick(504);
  EXPECT_TRUE(tie.isLinked());
  tick(505);
  EXPECT_FALSE(tie.isLinked());
}

TEST_F(RobotTieTest, IncrementsCountFromTheCycleThatReportsPedalDown) {
  tick(0);
  tie.link(true);
  EXPECT_FALSE(tie.applies());
  EXPECT_FALSE(tie.mayMoveOn());
  sent.runlevel = RunLevel::kPedalDown;
  send(1);
  tick(1);
  EXPECT_TRUE(tie.applies());
  EXPECT_TRUE(tie.mayMoveOn());
  tick(22);
  EXPECT_FALSE(tie.mayMoveOn()) << "the robot's state is stale";
}

TEST_F(RobotTieTest, AModelAloneAppliesEverything) {
  tick(0);
  tie.link(false);
  EXPECT_FALSE(tie.isLed());
  EXPECT_TRUE(tie.applies());
  EXPECT_TRUE(tie.mayMoveOn());
}

TEST_F(RobotTieTest, ARobotThatHearsNoPacketForASecondIsNotEngagedByALaterPacket) {
  engage();
  sent.runlevel = RunLevel::kPedalUp;
  send(5, 999);
  tick(5);
  EXPECT_FALSE(tie.isUnheard()) << "its last sequence has been the same for 1000 cycles, not for more";
  send(6);
  tick(6);
  EXPECT_TRUE(tie.isUnheard());
  EXPECT_FALSE(tie.isLed());
  EXPECT_FALSE(tie.applies());
  sent.last_sequence = 4;
  sent.runlevel = RunLevel::kPedalDown;
  send(7);
  tick(7);
  EXPECT_FALSE(tie.applies()) << "not before the next pedal-down";
  tie.link(true);
  EXPECT_TRUE(tie.applies());
}

TEST_F(RobotTieTest, APressAtADeafRobotIsUnheardUnlessTheModelMovesAlone) {
  engage();
  sent.last_sequence = 4;  // of a packet of this press
  send(5);
  tick(5);
  send(6, 1001);
  tick(6);
  EXPECT_FALSE(tie.isUnheard()) << "it heard the press that still lasts";
  tie.unlink();
  for (const RunLevel runlevel : {RunLevel::kPedalDown, RunLevel::kPedalUp}) {
    sent.runlevel = runlevel;
    send(7);
    tick(7);
    tie.link(true);
    EXPECT_TRUE(tie.isUnheard());
    EXPECT_FALSE(tie.applies());
    tie.link(false);
    EXPECT_FALSE(tie.isUnheard());
    EXPECT_TRUE(tie.applies());
  }
}

TEST_F(RobotTieTest, ARobotThatNeverReportsASequenceIsNotCalledDeaf) {
  tick(0);
  tie.link(true);
  send(1, 5000);
  tick(1);
  EXPECT_FALSE(tie.isUnheard());
}

TEST_F(RobotTieTest, ARobotThatStartsAgainMayBeOneThatReportsNoSequence) {
  engage();
  sent.cycle = 0;
  sent.last_sequence = 0;
  sent.runlevel = RunLevel::kPedalUp;
  send(5);
  tick(5);
  ASSERT_TRUE(tie.isThere());
  tie.link(true);
  send(6, 5000);
  tick(6);
  EXPECT_FALSE(tie.isUnheard()) << "only the robot before it reported one";
}

TEST_F(RobotTieTest, RemembersWhetherItWasThereInTheTickBefore) {
  tick(0);
  EXPECT_FALSE(tie.wasThere());
  tie.remember();
  EXPECT_TRUE(tie.wasThere());
  tick(501);
  EXPECT_TRUE(tie.wasThere());
  tie.remember();
  EXPECT_FALSE(tie.wasThere());
}

}  // namespace
}  // namespace raven2_trainer::loop
