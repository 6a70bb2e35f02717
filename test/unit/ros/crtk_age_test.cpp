#include "ros/crtk/crtk_age.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

namespace raven2_trainer::ros_bridge {
namespace {

/** A connection's header, as roscpp attaches it to each message of the connection. */
ros::M_stringPtr connectionOf(const std::string& publisher, const char* latching = "1") {
  const auto header = boost::make_shared<ros::M_string>();
  (*header)["callerid"] = publisher;
  (*header)["latching"] = latching;
  return header;
}

/** A message without a stamp. */
CrtkStorage storage(CrtkStored* stored, const ros::M_stringPtr& connection) {
  return stored->storageOf(connection, {});
}

TEST(CrtkStored, WhoPublishedBeforeMayHaveStoredItsFirstMessage) {
  CrtkStored stored(std::set<std::string>{"/old"});
  const auto old = connectionOf("/old"), fresh = connectionOf("/fresh");
  EXPECT_EQ(storage(&stored, old), CrtkStorage::kUnknown);
  EXPECT_EQ(storage(&stored, old), CrtkStorage::kNew) << "later messages of a connection are new";
  EXPECT_EQ(storage(&stored, fresh), CrtkStorage::kNew) << "this publisher connected while we listened";
  EXPECT_EQ(storage(&stored, fresh), CrtkStorage::kNew);
}

TEST(CrtkStored, WhoConnectsAgainGivesAgainWhatItHadGiven) {
  CrtkStored stored(std::set<std::string>{});
  auto first = connectionOf("/client");
  EXPECT_EQ(storage(&stored, first), CrtkStorage::kNew);
  first.reset();  // the connection breaks, as its only holder releases it
  const auto second = connectionOf("/client");
  EXPECT_EQ(storage(&stored, second), CrtkStorage::kUnknown);
  EXPECT_EQ(storage(&stored, second), CrtkStorage::kNew);
  EXPECT_EQ(storage(&stored, connectionOf("/client")), CrtkStorage::kUnknown) << "a third, while the second exists";
  EXPECT_EQ(storage(&stored, connectionOf("/other")), CrtkStorage::kNew);
}

TEST(CrtkStored, TheStampOfAMessageThatCameBeforeSaysThatItWasStored) {
  CrtkStored stored(std::set<std::string>{});
  const auto first = connectionOf("/client");
  EXPECT_EQ(stored.storageOf(first, ros::Time(10.0)), CrtkStorage::kNew);
  EXPECT_EQ(stored.storageOf(first, ros::Time(10.2)), CrtkStorage::kNew);
  const auto second = connectionOf("/client");
  EXPECT_EQ(stored.storageOf(second, ros::Time(10.2)), CrtkStorage::kStored) << "it would be executed twice";
  EXPECT_EQ(stored.storageOf(second, ros::Time(10.3)), CrtkStorage::kNew);
  EXPECT_EQ(stored.storageOf(connectionOf("/client"), ros::Time(10.4)), CrtkStorage::kUnknown);
}

TEST(CrtkStored, WhoDoesNotLatchStoresNothing) {
  CrtkStored stored(std::set<std::string>{"/old"});
  EXPECT_EQ(storage(&stored, connectionOf("/old", "0")), CrtkStorage::kNew);
  EXPECT_EQ(storage(&stored, connectionOf("/old", "0")), CrtkStorage::kNew);
  EXPECT_EQ(storage(&stored, boost::make_shared<ros::M_string>()), CrtkStorage::kNew);
  EXPECT_EQ(storage(&stored, {}), CrtkStorage::kNew);
}

TEST(CrtkStored, WithoutTheMastersAnswerAnybodyMayHaveBeenThere) {
  CrtkStored stored(std::nullopt);
  const auto client = connectionOf("/client");
  EXPECT_EQ(storage(&stored, client), CrtkStorage::kUnknown);
  EXPECT_EQ(storage(&stored, client), CrtkStorage::kNew);
}

TEST(CrtkPublishers, AreThoseOfTheMastersAnswer) {
  XmlRpc::XmlRpcValue state;
  state[0][0][0] = "/arm1/servo_cp";
  state[0][0][1][0] = "/a";
  state[0][0][1][1] = "/b";
  state[0][1][0] = "/arm2/servo_cp";
  state[0][1][1][0] = "/b";
  state[1][0][0] = "/arm1/hold";
  state[1][0][1][0] = "/raven2_simulator";
  state[2].setSize(0);
  const auto publishers = publishersIn(state);
  ASSERT_TRUE(publishers);
  const CrtkPublishers expected{{"/arm1/servo_cp", {"/a", "/b"}}, {"/arm2/servo_cp", {"/b"}}};
  EXPECT_EQ(*publishers, expected);
  XmlRpc::XmlRpcValue nobody;
  for (int i = 0; i < 3; ++i)
    nobody[i].setSize(0);
  ASSERT_TRUE(publishersIn(nobody));
  EXPECT_TRUE(publishersIn(nobody)->empty());
  EXPECT_FALSE(publishersIn(XmlRpc::XmlRpcValue("no")));
  EXPECT_FALSE(publishersIn(XmlRpc::XmlRpcValue()));
}

CrtkAsked of(ServoKind kind) {
  return readPlain(Arm::kGold, kind);
}

TEST(CrtkAge, WhatMayBeStoredIsRefusedUnlessItMakesTheArmsSafer) {
  const CrtkOrigin stored{"/circle", CrtkStorage::kUnknown, {}, ros::Time(100.0)};
  const CrtkAsked asked = unlessOld(readState(Arm::kGold, "enable"), stored);
  EXPECT_FALSE(asked.command);
  EXPECT_EQ(asked.refusal, "state_command: /circle latches its topic, so the message may be old; send it again");
  for (const ServoKind kind : {ServoKind::kServoPose, ServoKind::kServoJawBy, ServoKind::kMoveJoints})
    EXPECT_FALSE(unlessOld(of(kind), stored).command);
  for (const std::string word : {"resume", "home"})
    EXPECT_FALSE(unlessOld(readState(Arm::kGold, word), stored).command) << word;
  for (const std::string word : {"pause", "disable"})
    EXPECT_TRUE(unlessOld(readState(Arm::kGold, word), stored).command) << word;
  for (const ServoKind kind : {ServoKind::kHold, ServoKind::kFree})
    EXPECT_TRUE(unlessOld(of(kind), stored).command);
}

TEST(CrtkAge, AStampIsNotOlderThanHalfASecondOrThereIsNone) {
  const ros::Time now(100.0);
  const auto is_taken = [&](ServoKind kind, double stamp) {
    return unlessOld(of(kind), {"/c", CrtkStorage::kNew, ros::Time(stamp), now}).command.has_value();
  };
  EXPECT_TRUE(is_taken(ServoKind::kServoJoints, 99.6));
  EXPECT_FALSE(is_taken(ServoKind::kServoJoints, 99.4));
  EXPECT_FALSE(is_taken(ServoKind::kMovePose, 1.0));
  EXPECT_TRUE(is_taken(ServoKind::kServoJoints, 0.0)) << "the command has no stamp";
  EXPECT_TRUE(is_taken(ServoKind::kServoJoints, 103.0)) << "another host's clock, not an old command";
  EXPECT_TRUE(is_taken(ServoKind::kHold, 1.0));
  const CrtkStorage fresh = CrtkStorage::kNew;
  const auto pause = unlessOld(readState(Arm::kGold, "pause"), {"/c", fresh, ros::Time(1.0), now});
  EXPECT_TRUE(pause.command);
  const auto resume = unlessOld(readState(Arm::kGold, "resume"), {"/c", fresh, ros::Time(98.0), now});
  EXPECT_EQ(resume.refusal, "state_command: stamped 2 s ago, at most 0.5 s; clocks must agree, or leave the stamp out");
}

/** crtk_python_client latches state_command and stamps it: a client that is older than the daemon can enable it. */
TEST(CrtkAge, AFreshStampSaysThatALatchedMessageIsNew) {
  const ros::Time now(100.0);
  const auto isTaken = [&](CrtkStorage storage, double stamp) {
    const CrtkOrigin origin{"/client", storage, ros::Time(stamp), now};
    const CrtkAsked enable = unlessOld(readState(Arm::kGreen, "enable"), origin);
    EXPECT_EQ(enable.command.has_value(), unlessOld(of(ServoKind::kMoveJointsBy), origin).command.has_value());
    EXPECT_TRUE(enable.command || enable.refusal.find("/client latches") != std::string::npos) << enable.refusal;
    return enable.command.has_value();
  };
  for (const double fresh : {99.501, 99.9, 100.0, 100.499})
    EXPECT_TRUE(isTaken(CrtkStorage::kUnknown, fresh)) << fresh;
  for (const double old : {0.0, 1.0, 99.499})
    EXPECT_FALSE(isTaken(CrtkStorage::kUnknown, old)) << old;
  EXPECT_FALSE(isTaken(CrtkStorage::kUnknown, 103.0)) << "by a clock that is wrong nothing is known to be new";
  EXPECT_FALSE(isTaken(CrtkStorage::kStored, 99.9)) << "it was received before";
}

TEST(CrtkAge, AStampMayBeAnyNumberOfYearsAway) {
  const ros::Time last(4294967295U, 999999999U), now(1700000000U, 0U);  // ros::TIME_MAX, for one
  const auto is_taken = [](CrtkStorage storage, const ros::Time& stamp, const ros::Time& at) {
    return unlessOld(of(ServoKind::kServoPose), {"/c", storage, stamp, at}).command.has_value();
  };
  EXPECT_TRUE(is_taken(CrtkStorage::kNew, last, now)) << "another host's clock, not an old command";
  EXPECT_FALSE(is_taken(CrtkStorage::kUnknown, last, now));
  EXPECT_FALSE(is_taken(CrtkStorage::kNew, ros::Time(1U, 0U), last));
}

TEST(CrtkAge, WhatIsNoCommandAnywayKeepsItsReason) {
  const CrtkOrigin old{"/c", CrtkStorage::kUnknown, ros::Time(1.0), ros::Time(100.0)};
  const CrtkAsked asked = unlessOld(readState(Arm::kGold, "go"), old);
  EXPECT_NE(asked.refusal.find("\"go\""), std::string::npos) << asked.refusal;
}

TEST(CrtkAge, JawsOfTheSameMessageAreAsOld) {
  CrtkAsked asked = of(ServoKind::kServoJoints);
  asked.jaw = of(ServoKind::kServoJaw).command;
  EXPECT_FALSE(unlessOld(asked, {"/c", CrtkStorage::kUnknown, {}, {}}).jaw);
  EXPECT_TRUE(unlessOld(asked, {"/c", CrtkStorage::kNew, {}, {}}).jaw);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
