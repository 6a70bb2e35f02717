#include "ros/crtk/crtk_words.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "ros/crtk/crtk_device.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;

ServoRefused refusalOf(ServoKind kind, ServoRefusal reason) {
  ServoRefused refused;
  refused.kind = kind;
  refused.reason = reason;
  return refused;
}

TEST(CrtkWords, TooFarSaysValueLimitUnitAndWhatIsLikelyWrong) {
  ServoRefused refused = refusalOf(ServoKind::kServoPose, ServoRefusal::kTooFar);
  refused.value = 83.0;
  refused.limit = 0.02;
  EXPECT_EQ(sentence(refused), "servo_cp: 83 m from the set point, at most 0.02 m; CRTK is in metres");
  refused.value = 0.0312;
  EXPECT_EQ(sentence(refused), "servo_cp: 0.0312 m from the set point, at most 0.02 m; move_* goes farther");
  refused.is_turn = 1;
  refused.value = 45.0;
  refused.limit = 0.4;
  EXPECT_EQ(sentence(refused), "servo_cp: 45 rad from the set point, at most 0.4 rad; CRTK is in radians");
}

TEST(CrtkWords, OutOfRangeNamesTheJointAndTheBoundItIsBeyond) {
  ServoRefused refused = refusalOf(ServoKind::kMoveJoints, ServoRefusal::kOutOfRange);
  refused.joint = 1;
  refused.value = 90.0;
  refused.limit = 2.356;
  EXPECT_EQ(sentence(refused), "move_jp: elbow at 90 rad, at most 2.356 rad; CRTK is in radians");
  refused.value = 2.3561;
  EXPECT_EQ(sentence(refused), "move_jp: elbow at 2.3561 rad, at most 2.356 rad") << "the two do not look the same";
  refused.joint = 2;
  refused.value = 0.1;
  refused.limit = 0.23;
  EXPECT_EQ(sentence(refused), "move_jp: insertion at 0.1 m, at least 0.23 m");
  refused = refusalOf(ServoKind::kServoJaw, ServoRefusal::kOutOfRange);
  refused.joint = 6;
  refused.value = 1.7;
  refused.limit = 1.57;
  EXPECT_EQ(sentence(refused), "jaw/servo_jp: jaw at 1.7 rad, at most 1.57 rad");
}

TEST(CrtkWords, WhatIsRefusedBecauseOfTheStateSaysTheWayOut) {
  ServoRefused refused = refusalOf(ServoKind::kServoJoints, ServoRefusal::kNotEnabled);
  refused.in = OperatingState::kPaused;
  EXPECT_NE(sentence(refused).find("PAUSED"), std::string::npos);
  EXPECT_NE(sentence(refused).find("resume"), std::string::npos);
  refused.in = OperatingState::kDisabled;
  EXPECT_NE(sentence(refused).find("\"enable\""), std::string::npos);
  refused = refusalOf(ServoKind::kState, ServoRefusal::kInvalid);
  refused.state = StateCommand::kPause;
  refused.in = OperatingState::kDisabled;
  EXPECT_EQ(sentence(refused), "state_command: pause has no effect in DISABLED; enable has");
}

TEST(CrtkWords, InAFaultNobodyIsAskedToEnable) {
  ServoRefused refused = refusalOf(ServoKind::kServoTwist, ServoRefusal::kNotEnabled);
  refused.in = OperatingState::kFault;
  EXPECT_EQ(sentence(refused), "servo_cv: the arms are in FAULT: end the E-STOP at the robot");
}

TEST(CrtkWords, FreeThatFindsNothingToLetGoOfNamesNoOtherCommand) {
  ServoRefused refused = refusalOf(ServoKind::kFree, ServoRefusal::kInvalid);
  refused.in = OperatingState::kDisabled;
  for (std::size_t i = 0; i < kStateCommandCount; ++i) {
    refused.state = static_cast<StateCommand>(i);  // `free` is not a StateCommand
    EXPECT_EQ(sentence(refused), "free: the arms are DISABLED: only the brakes hold them");
  }
}

TEST(CrtkWords, EveryReasonHasASentenceOfItsOwn) {
  std::set<std::string> sentences;
  for (std::size_t i = 0; i < kServoRefusalCount; ++i) {
    const std::string text = sentence(refusalOf(ServoKind::kMovePose, static_cast<ServoRefusal>(i)));
    EXPECT_EQ(text.rfind("move_cp: ", 0), 0U) << text;
    sentences.insert(text);
  }
  EXPECT_EQ(sentences.size(), kServoRefusalCount);
  EXPECT_EQ(sentences.count("move_cp: unknown"), 0U);
}

TEST(CrtkWords, OnlyWhatAPersonMustEndIsAnError) {
  EXPECT_EQ(level(refusalOf(ServoKind::kState, ServoRefusal::kRobotStop)), CrtkLevel::kError);
  EXPECT_EQ(level(refusalOf(ServoKind::kServoPose, ServoRefusal::kTooFar)), CrtkLevel::kWarning);
  EXPECT_EQ(level(OperatingState::kFault), CrtkLevel::kError);
  EXPECT_EQ(level(OperatingState::kPaused), CrtkLevel::kInfo);
  for (std::size_t i = 0; i < kOperatingStateCount; ++i)
    EXPECT_EQ(sentence(static_cast<OperatingState>(i)).rfind(kOperatingStateNames[i], 0), 0U);
}

TEST(CrtkPatience, AStreamIsSaidOnceASecondWithHowManyWereLeftOut) {
  constexpr std::int64_t kMillisecond = 1000000;
  CrtkPatience patience;
  int said = 0;
  for (int ms = 0; ms < 1000; ms += 5)
    said += patience.pass("a", "no", ms * kMillisecond) ? 1 : 0;
  EXPECT_EQ(said, 1);
  EXPECT_EQ(patience.pass("b", "never", 3 * kMillisecond), "never") << "a message of another kind is not held back";
  EXPECT_EQ(patience.pass("a", "no", 1000 * kMillisecond), "no (and 199 more like it)");
  EXPECT_EQ(patience.pass("a", "no", 1001 * kMillisecond), std::nullopt);
  EXPECT_EQ(patience.pass("a", "no", 60000 * kMillisecond), "no (and 1 more like it)");
  EXPECT_EQ(patience.pass("a", "no", 62000 * kMillisecond), "no");
}

/** After a first refusal a person corrects the command, and within the second it is refused for something else. */
TEST(CrtkPatience, AnotherReasonIsSaidAtOnceButNotOtherNumbers) {
  CrtkPatience patience;
  const std::string far = "servo_cp: 83 m from the set point, at most 0.02 m; CRTK is in metres";
  const std::string near = "servo_cp: 1.2e-05 m from the set point, at most 0.02 m; CRTK is in metres";
  EXPECT_TRUE(patience.pass("arm1/servo_cp", far, 0));
  EXPECT_FALSE(patience.pass("arm1/servo_cp", near, 1000)) << "the same, with another number";
  EXPECT_TRUE(patience.pass("arm1/servo_cp", "servo_cp: in frame \"arm\"; it is world or no frame_id", 2000));
  EXPECT_EQ(patience.pass("arm1/servo_cp", near, 2'000'000'000), near + " (and 1 more like it)");
}

TEST(CrtkPatience, AClientWithWordsOfItsOwnIsBounded) {
  CrtkPatience patience;
  std::size_t said = 0;
  for (int i = 0; i < 5000; ++i)
    said += patience.pass("state_command", std::string(static_cast<std::size_t>(i), 'x') + " is unknown", i * 200'000)
                ? 1
                : 0;
  EXPECT_EQ(said, CrtkPatience::kSentences) << "in a second";
  EXPECT_TRUE(patience.pass("hold", "too many commands at once", 999'000'000)) << "another topic has its own";
  EXPECT_TRUE(patience.pass("state_command", "\"go\" is unknown", 2'100'000'000));
}

TEST(CrtkWords, StateCommandsAndStatesAreTheirOwnSubjects) {
  ServoRefused enable = refusalOf(ServoKind::kState, ServoRefusal::kOperatorStop), resume = enable, later = enable;
  enable.state = StateCommand::kEnable;
  resume.state = StateCommand::kResume;
  later.in = OperatingState::kPaused;
  const std::set<std::string> abouts{aboutOf(enable), aboutOf(resume), aboutOf(later)};
  EXPECT_EQ(abouts.size(), 3U);
  ServoRefused motion = refusalOf(ServoKind::kServoJoints, ServoRefusal::kTooFar), other = motion;
  other.state = StateCommand::kResume;
  EXPECT_EQ(aboutOf(motion), aboutOf(other));
  other.reason = ServoRefusal::kUnreachable;
  EXPECT_NE(aboutOf(motion), aboutOf(other));
}

class CrtkInboxTest : public ::testing::Test {
 protected:
  std::unique_ptr<SharedState> state{std::make_unique<SharedState>()};  // 11 MiB
  CrtkInbox inbox{state.get()};
};

TEST_F(CrtkInboxTest, CommandsGoToTheLoopInOrderEachWithANumberOfItsOwn) {
  EXPECT_EQ(inbox.take(readPlain(Arm::kGold, ServoKind::kHold)), "");
  EXPECT_EQ(inbox.take(readState(Arm::kGreen, "enable")), "");
  EXPECT_NE(inbox.take(readState(Arm::kGreen, "fly")), "") << "an unknown word never reaches the loop";
  ServoOrder first, second, none;
  ASSERT_TRUE(state->servo_commands.popOrder(&first));
  ASSERT_TRUE(state->servo_commands.popOrder(&second));
  EXPECT_FALSE(state->servo_commands.popOrder(&none));
  EXPECT_EQ(first.command.kind, ServoKind::kHold);
  EXPECT_EQ(second.command.kind, ServoKind::kState);
  EXPECT_NE(first.command.id, second.command.id);
  EXPECT_EQ(inbox.counts().passed_on, 2U);
  EXPECT_EQ(inbox.counts().unread, 1U);
  EXPECT_EQ(inbox.counts().lost, 0U);
}

TEST_F(CrtkInboxTest, AMessageOfArmAndJawsIsTwoCommands) {
  CrtkAsked asked = readPlain(Arm::kGold, ServoKind::kServoJoints);
  asked.jaw = readPlain(Arm::kGold, ServoKind::kServoJaw).command;
  EXPECT_EQ(inbox.take(asked), "");
  ServoCommand first, second;
  ASSERT_TRUE(state->servo_commands.popMotion(&first));
  ASSERT_TRUE(state->servo_commands.popMotion(&second));
  EXPECT_EQ(first.kind, ServoKind::kServoJoints);
  EXPECT_EQ(second.kind, ServoKind::kServoJaw);
  EXPECT_NE(first.id, second.id);
}

TEST_F(CrtkInboxTest, WhatFindsNoRoomIsSaidAndCounted) {
  while (inbox.counts().lost == 0 && inbox.counts().passed_on < 10000)
    inbox.take(readPlain(Arm::kGold, ServoKind::kHold));
  EXPECT_NE(inbox.take(readPlain(Arm::kGold, ServoKind::kHold)).find("hold: too many"), std::string::npos);
  EXPECT_EQ(inbox.counts().lost, 2U);
}

std::string valueOf(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values) {
    if (pair.key == key) return pair.value;
  }
  return "none";
}

TEST(CrtkStatus, WhatWasReceivedWasAppliedRefusedNotReadOrLost) {
  ServoState servo;
  servo.state = OperatingState::kEnabled;
  servo.is_homed = 1;
  servo.received = 10;
  servo.applied = 7;
  servo.refused = 3;
  const CrtkCounts heard{10, 2, 0};
  const DiagnosticStatus good = crtkStatus(servo, heard);
  EXPECT_EQ(good.name, "raven2_trainer: crtk");
  EXPECT_EQ(good.level, DiagnosticStatus::OK);
  EXPECT_EQ(good.message, "ENABLED");
  EXPECT_EQ(valueOf(good, "received"), "12");
  EXPECT_EQ(valueOf(good, "applied"), "7");
  EXPECT_EQ(valueOf(good, "refused"), "3");
  EXPECT_EQ(valueOf(good, "unread"), "2");
  EXPECT_EQ(crtkStatus(servo, CrtkCounts{10, 0, 1}).level, DiagnosticStatus::WARN) << "a lost command is a warning";
  EXPECT_EQ(crtkStatus(servo, CrtkCounts{9, 0, 0}).level, DiagnosticStatus::ERROR)
      << "more commands were handled than passed on";
  servo.refused = 2;
  EXPECT_EQ(crtkStatus(servo, heard).level, DiagnosticStatus::ERROR);
  servo.refused = 3;
  servo.state = OperatingState::kFault;
  EXPECT_EQ(crtkStatus(servo, heard).level, DiagnosticStatus::WARN);
}

/** The sign of a joint's command says nothing about its unit. */
TEST(CrtkWords, WhatIsLikelyWrongIsSaidOfBothSigns) {
  for (const double sign : {1.0, -1.0}) {
    ServoRefused refused = refusalOf(ServoKind::kMoveJoints, ServoRefusal::kOutOfRange);
    refused.joint = 1;
    refused.value = 90.0 * sign;
    EXPECT_NE(sentence(refused).find("CRTK is in radians"), std::string::npos) << sentence(refused);
    refused.value = 6.2 * sign;
    EXPECT_EQ(sentence(refused).find("CRTK is in"), std::string::npos) << "less than a full rotation";
    refused.joint = 2;
    refused.value = 400.0 * sign;
    EXPECT_NE(sentence(refused).find("CRTK is in metres"), std::string::npos) << sentence(refused);
  }
}

TEST(CrtkWords, TooFastSaysSpeedsInTheirUnits) {
  ServoRefused refused = refusalOf(ServoKind::kServoTwist, ServoRefusal::kTooFast);
  refused.value = 0.25;
  refused.limit = 0.1;
  EXPECT_EQ(sentence(refused), "servo_cv: 0.25 m/s, at most 0.1 m/s");
  refused.is_turn = 1;
  EXPECT_EQ(sentence(refused), "servo_cv: 0.25 rad/s, at most 0.1 rad/s");
}

TEST(CrtkWords, OnlyABrokenModelNeedsARestart) {
  ServoRefused refused = refusalOf(ServoKind::kServoJoints, ServoRefusal::kMode);
  for (std::size_t i = 0; i < kOperatingStateCount; ++i) {
    refused.in = static_cast<OperatingState>(i);
    const bool says_restart = sentence(refused).find("restart the daemon") != std::string::npos;
    EXPECT_EQ(says_restart, refused.in == OperatingState::kFault) << kOperatingStateNames[i];
  }
}

/** If an arm's command is refused, its jaws must not move. */
TEST_F(CrtkInboxTest, JawsDoNotGoWithoutTheirArm) {
  while (inbox.counts().lost == 0 && inbox.counts().passed_on < 10000)
    inbox.take(readPlain(Arm::kGold, ServoKind::kServoJoints));
  const std::uint64_t lost = inbox.counts().lost;
  CrtkAsked asked = readPlain(Arm::kGold, ServoKind::kServoJoints);
  asked.jaw = readPlain(Arm::kGold, ServoKind::kServoJaw).command;
  EXPECT_NE(inbox.take(asked).find("servo_jp: too many"), std::string::npos);
  EXPECT_EQ(inbox.counts().lost, lost + 1);
}

TEST(CrtkStatus, SaysWhatKeepsTheArmsAndWhoMovesThem) {
  ServoState servo;
  servo.state = OperatingState::kEnabled;
  EXPECT_EQ(crtkStatus(servo, {}).message, "ENABLED, not homed");
  servo.is_homed = 1;
  servo.holds_pedal = 1;
  EXPECT_EQ(crtkStatus(servo, {}).message, "ENABLED, a client moves the arms");
  const CrtkCounts heard{5, 2, 3};
  EXPECT_EQ(valueOf(crtkStatus(servo, heard), "received"), "10") << "lost commands were received too";
  EXPECT_EQ(valueOf(crtkStatus(servo, heard), "lost"), "3");
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
