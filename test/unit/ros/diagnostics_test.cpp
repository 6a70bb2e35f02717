#include <gtest/gtest.h>

#include <cerrno>
#include <memory>
#include <string>
#include <utility>

#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;

DiagnosticStatus statusOf(const std::string& name, const SessionCounts& counts, const SharedState& shared) {
  const auto array = diagnostics(counts, shared, RobotState{}, 0, "real-time", ros::Time(1, 0));
  for (const DiagnosticStatus& status : array.status) {
    if (status.name == "raven2_trainer: " + name) return status;
  }
  ADD_FAILURE() << "no status of " << name;
  return {};
}

DiagnosticStatus queues(const SharedState& shared) {
  return statusOf("queues", SessionCounts{}, shared);
}

std::string valueOf(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values) {
    if (pair.key == key) return pair.value;
  }
  return "none";
}

TEST(Diagnostics, TellsWhatScriptedHandsAreSent) {
  const auto shared = std::make_unique<SharedState>();
  shared->sight_sent.add(30);
  shared->sight_failed.add(2);
  EXPECT_EQ(queues(*shared).level, DiagnosticStatus::OK) << "a listener is optional";
  EXPECT_EQ(valueOf(queues(*shared), "sight_sent"), "30");
  EXPECT_EQ(valueOf(queues(*shared), "sight_failed"), "2");
}

TEST(Diagnostics, TellWhatWasSentToConsoleAndRobot) {
  const auto shared = std::make_unique<SharedState>();
  SessionCounts counts;
  counts.force_sent = 1000;
  counts.force_failed = 3;
  counts.force_silent = 40;
  counts.relay_sent = 900;
  const DiagnosticStatus forces = statusOf("forces to console", counts, *shared);
  EXPECT_EQ(valueOf(forces, "sent"), "1000");
  EXPECT_EQ(valueOf(forces, "failed"), "3");
  EXPECT_EQ(valueOf(forces, "silent"), "40");
  EXPECT_EQ(valueOf(statusOf("daemon to robot link", counts, *shared), "sent"), "900");
}

TEST(Diagnostics, ARealCameraThatIsAskedForAndSilentIsAWarning) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  RenderConfig render;
  EXPECT_EQ(realCameraStatus(render, 0, true, 9 * kSecond).message, "none configured");
  render.real_camera_topic = "real_camera/image_raw";
  render.real_stale_after = 0.5;
  EXPECT_EQ(realCameraStatus(render, 0, false, 9 * kSecond).level, DiagnosticStatus::OK);
  EXPECT_EQ(realCameraStatus(render, 0, true, 9 * kSecond).level, DiagnosticStatus::WARN);
  EXPECT_EQ(valueOf(realCameraStatus(render, 0, true, 9 * kSecond), "age_ms"), "none") << "no image has come yet";
  EXPECT_EQ(realCameraStatus(render, 8 * kSecond, true, 9 * kSecond).level, DiagnosticStatus::WARN);
  const DiagnosticStatus heard = realCameraStatus(render, 9 * kSecond - kSecond / 4, true, 9 * kSecond);
  EXPECT_EQ(heard.level, DiagnosticStatus::OK);
  EXPECT_EQ(heard.message, "heard");
  EXPECT_EQ(valueOf(heard, "age_ms"), "250");
}

TEST(Diagnostics, AStreamThatIsMostlyRefusedIsNamedWhileItLasts) {
  const auto shared = std::make_unique<SharedState>();
  StreamFinding finding{1, 1000, 900, Reject::kOutOfRange, 1};
  shared->master_stream.store(finding);
  const DiagnosticStatus refused = statusOf("master to daemon link", SessionCounts{}, *shared);
  EXPECT_EQ(refused.level, DiagnosticStatus::WARN);
  EXPECT_NE(refused.message.find("900 of 1000 packets were refused"), std::string::npos) << refused.message;
  finding.lasts = 0;
  shared->master_stream.store(finding);
  EXPECT_EQ(statusOf("master to daemon link", SessionCounts{}, *shared).level, DiagnosticStatus::OK);
}

TEST(Diagnostics, ALinkWhoseCountersDoNotAddUpIsAnError) {
  LinkCounts counts;
  counts.count(Reject::kNone);
  counts.count(Reject::kOutOfOrder);
  EXPECT_EQ(linkStatus("x", counts).level, DiagnosticStatus::OK);
  EXPECT_EQ(valueOf(linkStatus("x", counts), "rejected_out_of_order"), "1") << "a single rejection is reported";
  EXPECT_EQ(valueOf(linkStatus("x", counts), "rejected_duplicate"), "none");
  ++counts.received;
  EXPECT_EQ(linkStatus("x", counts).level, DiagnosticStatus::ERROR);
}

/** Both loops: a warning below 95 % on time, as in libfranka; an error for a time slip. Figures are in microseconds. */
TEST(Diagnostics, ALoopThatIsLateIsAWarningAndLostTimeAnError) {
  const auto shared = std::make_unique<SharedState>();
  for (std::size_t i = 0; i < kLoopCount; ++i) {
    SessionCounts counts;
    LoopTiming& timing = counts.loops[i];
    const std::string loop = std::string(kLoopNames[i]) + " loop";
    timing.ticks = 1000;
    timing.on_time = 951;
    EXPECT_EQ(statusOf(loop, counts, *shared).level, DiagnosticStatus::OK);
    timing.on_time = 949;
    EXPECT_EQ(statusOf(loop, counts, *shared).level, DiagnosticStatus::WARN);
    timing.time_slips = 1;
    timing.slips = 51;
    timing.max_late_ns = 7'000'000;
    timing.max_run_ns = 600'000;
    timing.last_run_late_ns = 2'000'000;
    const DiagnosticStatus slipped = statusOf(loop, counts, *shared);
    EXPECT_EQ(slipped.level, DiagnosticStatus::ERROR);
    EXPECT_EQ(valueOf(slipped, "ticks"), "1000");
    EXPECT_EQ(valueOf(slipped, "slips"), "51");
    EXPECT_EQ(valueOf(slipped, "time_slips"), "1");
    EXPECT_EQ(valueOf(slipped, "max_late_us"), "7000");
    EXPECT_EQ(valueOf(slipped, "max_run_us"), "600");
    EXPECT_EQ(valueOf(slipped, "last_run_late_us"), "2000");
  }
}

/** 985 times 10 us, 10 times 100 us, 5 times 1 ms; a bucket is at most 12.5 % too large. */
TEST(Diagnostics, QuantilesOfALoopAreWhatTheyAreCalled) {
  const auto shared = std::make_unique<SharedState>();
  SessionCounts counts;
  for (int i = 0; i < 1000; ++i) {
    counts.loops[0].wake_up.add(i < 985 ? 10'000 : i < 995 ? 100'000 : 1'000'000);
    counts.loops[0].run.add(i < 985 ? 20'000 : i < 995 ? 200'000 : 2'000'000);
  }
  const DiagnosticStatus status = statusOf(std::string(kLoopNames[0]) + " loop", counts, *shared);
  for (const auto& [key, microseconds] :
       {std::pair("wake_up_p99_us", 100.0), std::pair("wake_up_p999_us", 1000.0), std::pair("run_p99_us", 200.0),
        std::pair("run_p999_us", 2000.0)}) {
    EXPECT_GE(std::stod(valueOf(status, key)), microseconds - 1.0) << key;
    EXPECT_LE(std::stod(valueOf(status, key)), 1.125 * microseconds + 1.0) << key;
  }
}

DiagnosticStatus robotStatusOf(const RobotState& robot, const SharedState& shared, std::int64_t now_ns = 0) {
  for (const DiagnosticStatus& status : diagnostics({}, shared, robot, now_ns, "real-time", ros::Time(1, 0)).status) {
    if (status.name == "raven2_trainer: robot") return status;
  }
  return {};
}

TEST(Diagnostics, ARobotThatIsNotThereIsAnErrorAndItsStateHasAnAge) {
  const auto shared = std::make_unique<SharedState>();
  RobotState robot;
  robot.frame = 10;
  robot.runlevel = RunLevel::kPedalUp;
  EXPECT_EQ(robotStatusOf(robot, *shared).level, DiagnosticStatus::ERROR) << "the robot has left";
  robot.connected = 1;
  robot.is_virtual = 1;
  robot.cycle = 77;
  robot.active_fault = 5;
  robot.received_ns = 1'000'000'000;
  const DiagnosticStatus there = robotStatusOf(robot, *shared, 1'250'000'000);
  EXPECT_EQ(there.level, DiagnosticStatus::OK);
  EXPECT_EQ(there.message, kRunLevelNames[static_cast<std::size_t>(RunLevel::kPedalUp)]);
  EXPECT_EQ(valueOf(there, "age_ms"), "250");
  EXPECT_EQ(valueOf(there, "virtual"), "1");
  EXPECT_EQ(valueOf(there, "homed"), "0");
  EXPECT_EQ(valueOf(there, "cycle"), "77");
  EXPECT_EQ(valueOf(there, "active_fault"), "5");
  robot.frame = 0;
  EXPECT_EQ(robotStatusOf(robot, *shared).level, DiagnosticStatus::ERROR) << "the robot has sent nothing yet";
}

TEST(Diagnostics, ARobotThatRefusesSaysSo) {
  const auto shared = std::make_unique<SharedState>();
  RobotState robot;
  shared->robot_version_refused.store(2);
  EXPECT_NE(robotStatusOf(robot, *shared).message.find("version"), std::string::npos);
  robot.connected = 1;
  robot.frame = 1;
  EXPECT_EQ(robotStatusOf(robot, *shared).level, DiagnosticStatus::OK) << "the refusal concerned the robot before";
  shared->plan_refused.store(1);
  EXPECT_EQ(robotStatusOf(robot, *shared).level, DiagnosticStatus::WARN);
  EXPECT_NE(robotStatusOf(robot, *shared).message.find("fault plan"), std::string::npos);
}

TEST(Diagnostics, RecordsThatAreLostOrCannotBeWrittenAreErrors) {
  const auto shared = std::make_unique<SharedState>();
  SessionCounts counts;
  EXPECT_EQ(statusOf("recorder", counts, *shared).level, DiagnosticStatus::OK);
  counts.records_dropped = 3;
  EXPECT_EQ(statusOf("recorder", counts, *shared).level, DiagnosticStatus::ERROR);
  EXPECT_EQ(statusOf("recorder", counts, *shared).message, "3 records dropped");
  counts.records_dropped = 0;
  RecorderStatus recorder;
  recorder.failing = 1;
  recorder.error = ENOSPC;
  shared->recorder.store(recorder);
  EXPECT_EQ(statusOf("recorder", counts, *shared).level, DiagnosticStatus::ERROR);
  EXPECT_NE(statusOf("recorder", counts, *shared).message.find("No space left"), std::string::npos);
}

TEST(Diagnostics, WhateverAQueueDropsIsAWarning) {
  const auto shared = std::make_unique<SharedState>();
  SessionCounts counts;
  counts.contacts_dropped = 2;
  EXPECT_EQ(statusOf("queues", counts, *shared).level, DiagnosticStatus::WARN);
  EXPECT_EQ(statusOf("queues", counts, *shared).message, "2 dropped");
  for (std::size_t i = 0; i < kRingCount; ++i) {
    counts = {};
    counts.rings[i].dropped = 1;
    const DiagnosticStatus status = statusOf("queues", counts, *shared);
    EXPECT_EQ(status.level, DiagnosticStatus::WARN) << kRingNames[i];
    EXPECT_EQ(valueOf(status, std::string(kRingNames[i]) + "_dropped"), "1");
  }
}

/** Fills a ring of answers, and offers one more. */
template <typename T, std::size_t Capacity>
void overfill(SpscRing<T, Capacity>* ring) {
  while (ring->tryPush(T{})) {
  }
}

TEST(Diagnostics, AnAnswerThatAFullQueueDropsIsAWarning) {
  const auto shared = std::make_unique<SharedState>();
  EXPECT_EQ(queues(*shared).message, "0 dropped");
  overfill(&shared->answers);
  overfill(&shared->plan_answers);
  overfill(&shared->execution_answers);
  const DiagnosticStatus status = queues(*shared);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "3 dropped");
  for (const char* ring : {"answers", "plan_answers", "execution_answers"})
    EXPECT_EQ(valueOf(status, std::string(ring) + "_dropped"), "1") << ring;
}

TEST(Diagnostics, PacketsThatTheSystemDidNotTakeAreToldByTheirLink) {
  const auto shared = std::make_unique<SharedState>();
  SessionCounts counts;
  counts.relay_failed = 4;
  counts.force_failed = 6;
  EXPECT_EQ(valueOf(statusOf("daemon to robot link", counts, *shared), "failed"), "4");
  EXPECT_EQ(valueOf(statusOf("forces to console", counts, *shared), "failed"), "6");
  EXPECT_EQ(valueOf(statusOf("queues", counts, *shared), "relay_failed"), "4");
  EXPECT_EQ(valueOf(statusOf("queues", counts, *shared), "force_failed"), "6");
}

TEST(Diagnostics, DegradedRealTimeIsAWarning) {
  const auto shared = std::make_unique<SharedState>();
  for (const auto& [words, level] : {std::pair("SCHED_FIFO, memory locked", DiagnosticStatus::OK),
                                     std::pair("DEGRADED_RT: no SCHED_FIFO", DiagnosticStatus::WARN)}) {
    for (const auto& status : diagnostics({}, *shared, {}, 0, words, ros::Time(1, 0)).status) {
      if (status.name != "raven2_trainer: real time") continue;
      EXPECT_EQ(status.level, level) << words;
      EXPECT_EQ(status.message, words);
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
