#include <geometry_msgs/PoseStamped.h>
#include <gtest/gtest.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>
#include <std_msgs/String.h>

#include <cstring>
#include <string>
#include <tuple>
#include <vector>

#include "raven2_trainer/config/load_master.h"
#include "ros/crtk/crtk_messages.h"
#include "ros/devices/force_messages.h"
#include "ros/devices/force_readers.h"
#include "ros/devices/fresh_force.h"
#include "ros/devices/master_device_messages.h"
#include "ros/devices/master_device_reader.h"
#include "ros/devices/master_status.h"
#include "ros/devices/operator_lines.h"
#include "ros/devices/pedal_hold.h"
#include "ros/devices/rest_watch.h"

namespace raven2_trainer::ros_bridge {
namespace {

template <typename Message>
std::vector<std::uint8_t> bytesOf(const Message& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

/** A message with these bytes, as it comes on a topic of that type. */
topic_tools::ShapeShifter received(const char* type, const char* md5, std::vector<std::uint8_t> bytes) {
  topic_tools::ShapeShifter message;
  message.morph(md5, type, "", "");
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  message.read(stream);
  return message;
}

template <typename Message>
topic_tools::ShapeShifter receivedAs(const char* type, const Message& message) {
  return received(type, Message::md5(), bytesOf(message));
}

template <typename Message>
topic_tools::ShapeShifter received(const Message& message) {
  return received(ros::message_traits::DataType<Message>::value(), ros::message_traits::MD5Sum<Message>::value(),
                  bytesOf(message));
}

double doubleAt(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  double value = 0.0;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

MasterConfig shipped(const char* name) {
  return config::findMaster(RAVEN2_TRAINER_SOURCE_DIR "/config/masters", name);
}

sensor_msgs::Joy joyOf(const std::vector<int>& buttons, const std::vector<float>& axes = {}) {
  sensor_msgs::Joy joy;
  joy.buttons = buttons;
  joy.axes = axes;
  return joy;
}

TEST(DeviceMessages, HaveTheCheckSumsOfTheDriversPackages) {
  // Check sums by genmsg from the texts of omni_msgs, geomagic_control and crtk_msgs. The generated code of those
  // packages has the same first, second and fourth one.
  EXPECT_STREQ(devices::OmniState::md5(), "89c2a741de66e9e904f59a02b171dd6e");
  EXPECT_STREQ(devices::ButtonEvent::md5(), "fb77877e6b639935c3360838062f05f0");
  EXPECT_STREQ(devices::OmniFeedback::md5(), "e9083ac4fd95494e94fbb0c0f90b6c00");
  EXPECT_STREQ(devices::DeviceFeedback::md5(), "94755b031db27fe99c2c235c0da9b072");
  EXPECT_STREQ(crtk::OperatingState::md5(), "b1bd4021639d9d9c5fbfff78d6ff3158");
}

TEST(DeviceMessages, FieldsStandWhereTheDriversHaveThem) {
  // offsets counted by hand along the .msg texts, frame_id empty
  devices::OmniState state;
  state.locked = 1;
  state.close_gripper = 2;
  state.pose.position.z = 1.5;
  state.pose.orientation.w = 0.25;
  state.current.y = 7.0;
  state.velocity.z = -3.5;
  const std::vector<std::uint8_t> bytes = bytesOf(state);
  ASSERT_EQ(bytes.size(), 16U + 2U + 56U + 24U + 24U);
  EXPECT_EQ(bytes[16], 1);
  EXPECT_EQ(bytes[17], 2);
  EXPECT_EQ(doubleAt(bytes, 18 + 16), 1.5);
  EXPECT_EQ(doubleAt(bytes, 18 + 48), 0.25);
  EXPECT_EQ(doubleAt(bytes, 74 + 8), 7.0);
  EXPECT_EQ(doubleAt(bytes, 98 + 16), -3.5);

  devices::DeviceFeedback feedback;
  feedback.force.y = 2.5;
  feedback.position.x = 4.5;
  feedback.lock = {0, 1, 0};
  const std::vector<std::uint8_t> told = bytesOf(feedback);
  ASSERT_EQ(told.size(), 24U + 24U + 4U + 3U);
  EXPECT_EQ(doubleAt(told, 8), 2.5);
  EXPECT_EQ(doubleAt(told, 24), 4.5);
  EXPECT_EQ(told[48], 3);
  EXPECT_EQ(told[53], 1);
  EXPECT_EQ(bytesOf(devices::OmniFeedback()).size(), 48U);
  EXPECT_EQ(bytesOf(devices::ButtonEvent()).size(), 8U);
}

TEST(DeviceMessages, APublishersHeaderCarriesTheWholeText) {
  const std::string text = ros::message_traits::Definition<devices::DeviceFeedback>::value();
  EXPECT_EQ(text.find("geometry_msgs/Vector3  force\n"), 0U);
  EXPECT_NE(text.find("\nMSG: geometry_msgs/Vector3\n"), std::string::npos);
  EXPECT_NE(text.find("float64 z"), std::string::npos);
}

/** The console has turned them to the device's axes and the driver's units (toDevice). A device that is locked stays
 *  where it is. */
TEST(DeviceMessages, ForcesAndPlacesGoOutAsTheyAre) {
  ros::Time::init();
  const Vec3 force{0.5, -1.25, 3.0}, position{-12.0, 34.0, 56.5};
  const DeviceForce out{force, position, /*is_placed=*/1, /*has_begun=*/1};
  const auto of = [](const geometry_msgs::Vector3& v) { return Vec3{v.x, v.y, v.z}; };
  devices::OmniFeedback omni;
  devices::fill(out, "base", &omni);
  EXPECT_EQ(of(omni.force), force);
  EXPECT_EQ(of(omni.position), position);
  devices::DeviceFeedback geomagic;
  devices::fill(out, "base", &geomagic);
  EXPECT_EQ(of(geomagic.force), force);
  EXPECT_EQ(of(geomagic.position), position);
  EXPECT_EQ(geomagic.lock, (std::vector<std::uint8_t>{0, 0, 0}));
  geometry_msgs::WrenchStamped crtk;
  devices::fill(out, "base", &crtk);
  EXPECT_EQ(of(crtk.wrench.force), force);
  EXPECT_EQ(of(crtk.wrench.torque), (Vec3{0.0, 0.0, 0.0}));
  EXPECT_EQ(crtk.header.frame_id, "base");
  EXPECT_FALSE(crtk.header.stamp.isZero());
}

TEST(DeviceReader, ReadsAnOmnisStateAndButtonsUnderAnyPackagesName) {
  const MasterConfig config = shipped("omni");
  MasterDeviceReader reader(config, config.devices[0]);
  devices::OmniState state;
  state.pose.position.x = -12.5;
  state.pose.orientation.w = 1.0;
  state.locked = 1;
  state.header.frame_id = "/map";
  ASSERT_TRUE(reader.pose(receivedAs("omni_msgs/OmniState", state)));
  EXPECT_EQ(reader.sample().poses, 1U);
  EXPECT_EQ(reader.sample().position, (Vec3{-12.5, 0.0, 0.0}));
  EXPECT_EQ(reader.sample().is_locked, 1);
  EXPECT_EQ(reader.frame(), "/map");
  devices::ButtonEvent event;
  event.white_button = 1;
  for (const char* type : {"omni_msgs/OmniButtonEvent", "geomagic_control/DeviceButtonEvent"}) {
    ASSERT_TRUE(reader.buttons(receivedAs(type, event), 0));
    EXPECT_EQ(reader.sample().buttons, 2U);
  }
  event.grey_button = 2;  // a click that has ended
  ASSERT_TRUE(reader.buttons(receivedAs("omni_msgs/OmniButtonEvent", event), 0));
  EXPECT_EQ(reader.sample().buttons, 2U);
  event = {};
  event.grey_button = 1;
  ASSERT_TRUE(reader.buttons(receivedAs("phantom_omni/PhantomButtonEvent", event), 0));
  EXPECT_EQ(reader.sample().buttons, 1U);
}

TEST(DeviceReader, ReadsCrtkPosesWithATimeAndButtonsOfSeveralTopics) {
  const MasterConfig config = shipped("crtk_pair");
  MasterDeviceReader reader(config, config.devices[1]);
  geometry_msgs::PoseStamped pose;
  pose.pose.position.y = 0.03;
  pose.pose.orientation.z = 1.0;
  ASSERT_TRUE(reader.pose(received(pose)));
  EXPECT_EQ(reader.sample().poses, 0U) << "a pose without a stamp is invalid";
  pose.header.stamp = ros::Time(5.0);
  ASSERT_TRUE(reader.pose(received(pose)));
  EXPECT_EQ(reader.sample().poses, 1U);
  EXPECT_EQ(reader.sample().position, (Vec3{0.0, 0.03, 0.0}));
  EXPECT_EQ(reader.sample().orientation, (Quat{0.0, 0.0, 1.0, 0.0}));
  ASSERT_TRUE(reader.buttons(received(joyOf({1})), 1));
  EXPECT_EQ(reader.sample().buttons, 2U);
  ASSERT_TRUE(reader.buttons(received(joyOf({1})), 0));
  EXPECT_EQ(reader.sample().buttons, 3U);
  ASSERT_TRUE(reader.buttons(received(joyOf({2})), 1));  // a click that has ended
  EXPECT_EQ(reader.sample().buttons, 1U);
}

TEST(DeviceReader, KnowsWhetherACrtkDeviceIsEnabledAndHomed) {
  const MasterConfig config = shipped("mtm");
  MasterDeviceReader reader(config, config.devices[0]);
  EXPECT_EQ(reader.sample().is_ready, 0) << "the device has not reported its state";
  EXPECT_EQ(reader.sample().is_stateless, 1);
  crtk::OperatingState state;
  for (const auto& [name, homed, ready] : {std::tuple("ENABLED", 1, 1), std::tuple("ENABLED", 0, 0),
                                           std::tuple("DISABLED", 1, 0), std::tuple("FAULT", 1, 0)}) {
    state.state = name;
    state.is_homed = static_cast<std::uint8_t>(homed);
    ASSERT_TRUE(reader.operatingState(receivedAs("crtk_msgs/OperatingState", state)));
    EXPECT_EQ(reader.sample().is_ready, ready) << name << homed;
    EXPECT_EQ(reader.sample().is_stateless, 0);
  }
  const MasterConfig omni = shipped("omni");
  EXPECT_EQ(MasterDeviceReader(omni, omni.devices[0]).sample().is_ready, 1) << "an Omni has no operating state";
  sensor_msgs::JointState joints;
  ASSERT_TRUE(reader.gripper(received(joints)));
  EXPECT_EQ(reader.sample().has_gripper, 0);
  joints.position = {0.4, 9.0};
  ASSERT_TRUE(reader.gripper(received(joints)));
  EXPECT_EQ(reader.sample().has_gripper, 1);
  EXPECT_EQ(reader.sample().gripper, 0.4);
}

TEST(DeviceReader, ReadsAGamepad) {
  const MasterConfig config = shipped("gamepad");
  MasterDeviceReader reader(config, config.devices[0]);
  ASSERT_TRUE(reader.pose(received(joyOf({0, 0, 0, 0, 0, 1}, {0.5F, -1.0F}))));
  EXPECT_EQ(reader.sample().buttons, 32U);
  EXPECT_EQ(reader.sample().axis_count, 2U);
  EXPECT_EQ(reader.sample().axes[1], -1.0);
  ASSERT_TRUE(reader.pose(received(joyOf({2, 1}))));  // 2: a click that has ended
  EXPECT_EQ(reader.sample().buttons, 2U);
  ASSERT_TRUE(reader.pose(received(joyOf({}, std::vector<float>(20, 0.25F)))));
  EXPECT_EQ(reader.sample().buttons, 0U);
  EXPECT_EQ(reader.sample().axis_count, 8U);
}

TEST(DeviceReader, RefusesOtherTypesByNameAndOnce) {
  const MasterConfig config = shipped("omni");
  MasterDeviceReader reader(config, config.devices[0]);
  const auto wrong = received(std_msgs::String());
  EXPECT_FALSE(reader.pose(wrong));
  const std::string line = reader.refusal();
  EXPECT_NE(line.find("/phantom/state is of type std_msgs/String"), std::string::npos) << line;
  EXPECT_NE(line.find("omni_msgs/OmniState"), std::string::npos) << line;
  EXPECT_FALSE(reader.pose(wrong));
  EXPECT_EQ(reader.refusal(), "");
  EXPECT_FALSE(reader.buttons(wrong, 0));
  EXPECT_NE(reader.refusal().find("/phantom/button"), std::string::npos);
  EXPECT_EQ(reader.sample().poses, 0U);
}

TEST(DeviceReader, TakesNothingOfAMessageThatIsCutShort) {
  const MasterConfig config = shipped("omni");
  MasterDeviceReader reader(config, config.devices[0]);
  std::vector<std::uint8_t> bytes = bytesOf(devices::OmniState());
  bytes.resize(bytes.size() - 60);
  EXPECT_FALSE(reader.pose(received("omni_msgs/OmniState", devices::OmniState::md5(), bytes)));
  EXPECT_EQ(reader.sample().poses, 0U);
}

TEST(PedalTopic, IsAButtonOfAJoy) {
  bool held = false;
  EXPECT_TRUE(readJoyButton(received(joyOf({0, 1})), 1, &held));
  EXPECT_TRUE(held);
  EXPECT_TRUE(readJoyButton(received(joyOf({1, 0})), 1, &held));
  EXPECT_FALSE(held);
  EXPECT_TRUE(readJoyButton(received(joyOf({0, 1})), 1, &held));
  EXPECT_TRUE(readJoyButton(received(joyOf({0, 2})), 1, &held));
  EXPECT_FALSE(held) << "2 is a click that has ended";
  EXPECT_FALSE(readJoyButton(received(joyOf({1, 0})), 2, &held));
  EXPECT_FALSE(readJoyButton(received(std_msgs::String()), 0, &held));
}

TEST(OperatorLinesTest, ComeOutInOrderAndSayHowManyDidNot) {
  OperatorLines lines;
  std::string line;
  EXPECT_FALSE(lines.next(&line));
  lines.say("");
  EXPECT_FALSE(lines.next(&line));
  for (int i = 0; i < 40; ++i)
    lines.say("line " + std::to_string(i));
  for (int i = 0; i < 32; ++i) {
    ASSERT_TRUE(lines.next(&line));
    EXPECT_EQ(line, "line " + std::to_string(i));
  }
  ASSERT_TRUE(lines.next(&line));
  EXPECT_EQ(line, "8 lines more, which were not kept");
  EXPECT_FALSE(lines.next(&line));
  lines.say(std::string(2000, 'x'));
  ASSERT_TRUE(lines.next(&line));
  EXPECT_EQ(line, std::string(504, 'x'));
}

TEST(FreshForceTest, WhatTheConsoleDoesNotRenewIsNoForce) {
  StateCell<DeviceForce> cell;
  FreshForce force(cell);
  const Vec3 pressed{1.0, 0.0, 0.0}, place{2.0, 3.0, 4.0}, none{};
  for (const double start : {10.0, 20.0}) {
    cell.store({pressed, place, 1, 1});
    for (const double age : {0.0, 0.049, 0.051, 1.0}) {
      const DeviceForce out = force.take(start + age);
      EXPECT_EQ(out.force, age < 0.05 ? pressed : none) << age;
      EXPECT_EQ(out.position, place) << "its driver holds a device that is locked there";
    }
  }
}

TEST(RestWatchTest, ADeviceRestsThatHasNotMovedForAMoment) {
  RestWatch watch;
  // 20 mm/s, a pose every 10 ms, checked every 5 ms
  double time = 0.0;
  for (int i = 0; i < 40; ++i, time += 0.005)
    EXPECT_FALSE(watch.look({4e-4 * (i / 2), 0.0, 0.05}, time)) << i;
  const Vector3 end(4e-4 * 19, 0.0, 0.05);
  EXPECT_FALSE(watch.look(end, 0.2));
  EXPECT_TRUE(watch.look(end, 0.211));
  EXPECT_TRUE(watch.look(end + Vector3(1e-4, 0.0, 0.0), 0.22)) << "trembling counts as rest";
  EXPECT_FALSE(watch.look(end + Vector3(0.0, 3e-4, 0.0), 0.225));
}

TEST(PedalHoldTest, OneThatRepeatsItselfIsUpOnceItIsSilent) {
  PedalHold pedal("/foot", 0.5);
  std::string news;
  EXPECT_FALSE(pedal.look(true, 0.0, &news));
  pedal.hear(true, 1.0);
  EXPECT_TRUE(pedal.look(true, 1.4, &news));
  pedal.hear(true, 1.4);
  EXPECT_TRUE(pedal.look(true, 1.8, &news));
  EXPECT_EQ(news, "");
  // The publisher's process is killed, but the ROS master still counts it.
  EXPECT_FALSE(pedal.look(true, 2.0, &news));
  EXPECT_EQ(news, "pedal: nothing came on /foot for 600 ms while it was held: it counts as up");
  news.clear();
  EXPECT_FALSE(pedal.look(true, 9.0, &news));
  EXPECT_EQ(news, "") << "the silence is reported once";
  // A publisher that comes back with the pedal down counts as up until a release.
  pedal.hear(true, 10.0);
  EXPECT_FALSE(pedal.look(true, 10.1, &news));
  pedal.hear(false, 10.2);
  pedal.hear(true, 10.3);
  EXPECT_TRUE(pedal.look(true, 10.4, &news));
  // Silence with the pedal up is not reported.
  pedal.hear(false, 10.5);
  EXPECT_FALSE(pedal.look(true, 20.0, &news));
  EXPECT_EQ(news, "");
  // A message comes after a silence that no look() has noticed.
  pedal.hear(true, 20.1);
  pedal.hear(true, 21.0);
  EXPECT_FALSE(pedal.look(true, 21.0, &news));
}

TEST(PedalHoldTest, OneThatTellsChangesIsUpOnceNobodyPublishes) {
  PedalHold pedal("/foot", 0.0);
  std::string news;
  pedal.hear(true, 1.0);
  EXPECT_TRUE(pedal.look(true, 100.0, &news));
  EXPECT_FALSE(pedal.look(false, 101.0, &news));
  EXPECT_EQ(news, "pedal: nobody publishes /foot: it counts as up");
  news.clear();
  EXPECT_FALSE(pedal.look(true, 102.0, &news)) << "another publisher, which has sent nothing yet";
  pedal.hear(true, 103.0);
  EXPECT_TRUE(pedal.look(true, 104.0, &news));
  EXPECT_EQ(news, "");
}

TEST(PedalHoldTest, OneThatWasNeverThereIsToldOnceAfterTheStart) {
  PedalHold pedal("/foot", 0.0);
  std::string news;
  pedal.look(false, 1.9, &news);
  EXPECT_EQ(news, "");
  pedal.look(false, 2.1, &news);
  EXPECT_NE(news.find("nobody publishes /foot"), std::string::npos);
  news.clear();
  pedal.look(false, 3.0, &news);
  EXPECT_EQ(news, "");
}

TEST(ForceReadersTest, AreToldByNameOnceAndWhenTheyChange) {
  ForceReaders readers("left", "/left/servo_cf", "/left/measured_cp", 2.0);
  EXPECT_EQ(readers.look({}, "", 0.5), "");
  EXPECT_EQ(readers.look({"/saw"}, "", 0.6), "left: force on /left/servo_cf, read by 1: /saw");
  EXPECT_EQ(readers.look({"/saw"}, "/saw", 5.0), "") << "the publisher of the poses is a reader";
  EXPECT_NE(readers.look({}, "/saw", 6.0).find("NOBODY any more"), std::string::npos);
  EXPECT_EQ(readers.look({}, "/saw", 7.0), "");
  EXPECT_EQ(readers.look({"/saw", "/bag"}, "/saw", 8.0), "left: force on /left/servo_cf, read by 2: /saw /bag");
  EXPECT_EQ(
      readers.look({"/bag"}, "/saw", 9.0),
      "left: force on /left/servo_cf, read by 1: /bag, but not by /saw, which publishes /left/measured_cp: no force "
      "may be felt");
  EXPECT_EQ(readers.look({"/bag"}, "/saw", 10.0), "");
  ForceReaders nobody("right", "/f", "/p", 2.0);
  EXPECT_EQ(nobody.look({}, "/saw", 1.9), "");
  EXPECT_EQ(nobody.look({}, "/saw", 2.1), "right: force on /f, read by NOBODY: no force will be felt");
}

TEST(ForceReadersTest, WithoutATopicThereIsNoForce) {
  ForceReaders readers("left", "", "/p", 2.0);
  EXPECT_EQ(readers.look({}, "", 1.0), "");
  EXPECT_NE(readers.look({}, "", 2.0).find("left: no force"), std::string::npos);
  EXPECT_EQ(readers.look({}, "/saw", 3.0), "");
}

TEST(AbsoluteListenerTest, IsToldWhereItIsMissing) {
  AbsoluteListener listener("left", "/left/absolute", 2.0);
  EXPECT_EQ(listener.look(false, 1.0), "");
  EXPECT_NE(listener.look(false, 2.0).find("left: nobody reads /left/absolute: forces stay zero"), std::string::npos);
  EXPECT_EQ(listener.look(false, 3.0), "");
  EXPECT_EQ(listener.look(true, 4.0), "left: /left/absolute is read now: forces go out");
  EXPECT_EQ(listener.look(true, 5.0), "");
  EXPECT_NE(listener.look(false, 6.0).find("nobody reads"), std::string::npos);
  AbsoluteListener there("left", "/left/absolute", 2.0);
  EXPECT_EQ(there.look(true, 0.5), "");
  EXPECT_EQ(there.look(true, 2.5), "") << "no report while all is in order";
  EXPECT_NE(there.look(false, 2.6).find("nobody reads"), std::string::npos);
  AbsoluteListener early("left", "/left/absolute", 2.0);
  EXPECT_EQ(early.look(true, 0.5), "");
  EXPECT_NE(early.look(false, 1.0).find("nobody reads"), std::string::npos)
      << "the listener had been there: no need to wait";
}

TEST(MasterStatus, SaysWhatIsWrong) {
  const MasterConfig config = shipped("omni_pair");
  MasterReport report;
  diagnostic_msgs::DiagnosticStatus status = masterStatus(config, Arm::kGreen, report, {998.0, 1});
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::OK);
  EXPECT_EQ(status.name, "raven2_trainer: master right");
  EXPECT_EQ(status.values[0].value, "998");
  status = masterStatus(config, Arm::kGreen, report, {998.0, 0});
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_NE(status.message.find("/right/force_feedback"), std::string::npos);
  status = masterStatus(config, Arm::kGreen, report, {998.0, 1, false, false});
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "/right/force_feedback is read, but not by the publisher of /right/state");
  status = masterStatus(shipped("mtm"), Arm::kGreen, report, {998.0, 1, true, true});
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "nobody reads /MTMR/body/set_cf_orientation_absolute: forces stay zero");
  status = masterStatus(shipped("gamepad"), Arm::kGreen, report, {50.0, 0});
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::OK);
  EXPECT_EQ(status.message, "pedal up; no force");
  report.now[1] = {DeviceTrouble::kSilent, 0.4};
  status = masterStatus(config, Arm::kGreen, report, {0.0, 0});
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "right: nothing came on /right/state for 400 ms");
  EXPECT_EQ(masterStatus(config, Arm::kGold, report, {998.0, 1}).level, diagnostic_msgs::DiagnosticStatus::OK);
}

/** Only CRTK says that a pose without a stamp is invalid; other drivers send none. */
TEST(DeviceReader, TakesAPoseWithoutATimeWhereTheDriverSendsNone) {
  const MasterConfig config = shipped("touch_geomagic");
  MasterDeviceReader reader(config, config.devices[0]);
  ASSERT_TRUE(reader.pose(received(geometry_msgs::PoseStamped())));
  EXPECT_EQ(reader.sample().poses, 1U);
}

TEST(DeviceReader, ADeviceThatIsDisabledLaterIsNotReadyAnyMore) {
  const MasterConfig config = shipped("mtm");
  for (std::size_t i = 0; i < kArmCount; ++i) {
    MasterDeviceReader reader(config, config.devices[i]);
    crtk::OperatingState state;
    state.is_homed = 1;
    for (const auto& [word, ready] : {std::pair("ENABLED", 1), std::pair("PAUSED", 0), std::pair("ENABLED", 1)}) {
      state.state = word;
      ASSERT_TRUE(reader.operatingState(receivedAs("crtk_msgs/OperatingState", state)));
      EXPECT_EQ(reader.sample().is_ready, ready) << word;
    }
  }
}

/** Motion starts the wait again, however long the device has been watched. */
TEST(RestWatchTest, OneThatStopsLateRestsLate) {
  RestWatch watch;
  watch.look({0.0, 0.0, 0.0}, 0.0);
  EXPECT_TRUE(watch.look({0.0, 0.0, 0.0}, 5.0));
  EXPECT_FALSE(watch.look({0.01, 0.0, 0.0}, 5.01));
  EXPECT_FALSE(watch.look({0.01, 0.0, 0.0}, 5.02)) << "at rest for only 10 ms";
  EXPECT_TRUE(watch.look({0.01, 0.0, 0.0}, 5.04));
}

TEST(PedalHoldTest, OneThatRepeatsItselfIsUpOnceNobodyPublishes) {
  PedalHold pedal("/foot", 60.0);
  std::string news;
  pedal.hear(true, 1.0);
  EXPECT_TRUE(pedal.look(true, 1.1, &news));
  EXPECT_FALSE(pedal.look(false, 1.2, &news));
  EXPECT_FALSE(pedal.look(true, 1.3, &news));
}

TEST(PedalHoldTest, OneThatIsStartedAgainWithThePedalDownIsUpUntilARelease) {
  PedalHold pedal("/foot", 60.0);
  std::string news;
  pedal.hear(true, 1.0);
  EXPECT_TRUE(pedal.look(true, 1.1, &news));
  EXPECT_FALSE(pedal.look(false, 1.2, &news));
  pedal.hear(true, 1.3);
  EXPECT_FALSE(pedal.look(true, 1.4, &news)) << "nobody pressed the pedal again";
  pedal.hear(false, 1.5);
  pedal.hear(true, 1.6);
  EXPECT_TRUE(pedal.look(true, 1.7, &news));
}

TEST(PedalHoldTest, TheFirstPressOfOneThatComesLaterCounts) {
  PedalHold pedal("/foot", 60.0);
  std::string news;
  EXPECT_FALSE(pedal.look(false, 1.0, &news));
  pedal.hear(true, 1.1);
  EXPECT_TRUE(pedal.look(true, 1.2, &news));
}

std::string valueOf(const diagnostic_msgs::DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values) {
    if (pair.key == key) return pair.value;
  }
  return "none";
}

TEST(MasterStatus, ShowsEachHandsOwnFigures) {
  const MasterConfig config = shipped("omni_pair");
  MasterReport report;
  report.pedal = 1;
  report.engaged = 0;
  report.hand_force = {1.5, 2.5};
  report.found = {3, 4};
  const auto left = masterStatus(config, Arm::kGold, report, {998.0, 2}),
             right = masterStatus(config, Arm::kGreen, report, {997.0, 0});
  EXPECT_EQ(valueOf(left, "force"), "1.5");
  EXPECT_EQ(valueOf(right, "force"), "2.5");
  EXPECT_EQ(valueOf(left, "troubles"), "3");
  EXPECT_EQ(valueOf(right, "troubles"), "4");
  EXPECT_EQ(valueOf(left, "pedal"), "1");
  EXPECT_EQ(valueOf(left, "engaged"), "0");
  EXPECT_EQ(valueOf(left, "force_readers"), "2");
  EXPECT_EQ(valueOf(left, "driver_reads_force"), "1");
  EXPECT_EQ(valueOf(right, "driver_reads_force"), "0") << "no driver reads the force";
}

/** Only a trouble that lifts the pedal is an error. A locked or frozen device is a warning. */
TEST(MasterStatus, OnlyATroubleThatLiftsThePedalIsAnError) {
  const MasterConfig config = shipped("omni_pair");
  for (const DeviceTrouble trouble : {DeviceTrouble::kLocked, DeviceTrouble::kFrozen, DeviceTrouble::kSilent}) {
    for (const Arm arm : kArms) {
      MasterReport report;
      at(report.now, arm) = {trouble, 0.4};
      const int level = masterStatus(config, arm, report, {998.0, 1}).level;
      EXPECT_EQ(level, trouble == DeviceTrouble::kSilent ? diagnostic_msgs::DiagnosticStatus::ERROR
                                                         : diagnostic_msgs::DiagnosticStatus::WARN);
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
