#include "ros/raven/raven_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "ros/raven/raven_conversion.h"
#include "ros/raven/raven_state_reader.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kDegree = kPi / 180.0;

/** The home pose of raven2.md 2.3 on both arms, whose channels begin at 0 and 8. */
RavenReport home() {
  RavenReport report;
  report.runlevel = 2;
  report.last_sequence = 111;
  report.board = {49, 22};
  for (const std::size_t arm : {0U, 8U}) {
    report.jpos[arm] = 30.0 * kDegree;
    report.jpos[arm + 1] = 90.0 * kDegree;
    report.jpos[arm + 2] = 0.40;
    report.jpos[arm + 6] = report.jpos[arm + 7] = 45.0 * kDegree;
  }
  report.jpos_d = report.jpos;
  report.jpos_d[9] = 91.0 * kDegree;
  return report;
}

TEST(RavenStateMessage, HasTheSizesOfTheRealOnes) {
  // raven2.md 5.2, with an empty frame_id
  EXPECT_EQ(ros::serialization::serializationLength(raven_2::RavenState()), 980U);
  EXPECT_EQ(ros::serialization::serializationLength(raven_2::ForkRavenState()), 2008U);
  EXPECT_EQ(ros::serialization::serializationLength(raven_2::RavenAutomove()), 16U + 24U + 2 * 56U);
}

TEST(RavenStateMessage, FieldsStandWhereTheRealOneHasThem) {
  // offsets counted by hand along raven2.md 5.2
  raven_2::RavenState message;
  message.runlevel = 0x01020304;
  message.last_seq = 77;
  message.dac_val[15] = -5;
  message.jpos_d[0] = 1.5F;
  message.encoffsets[15] = 2.5F;
  message.jac_f[11] = 3.5F;
  std::vector<std::uint8_t> bytes(980);
  ros::serialization::OStream stream(bytes.data(), 980);
  ros::serialization::serialize(stream, message);
  const auto intAt = [&](std::size_t offset) {
    std::int32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, 4);
    return value;
  };
  const auto floatAt = [&](std::size_t offset) {
    float value = 0;
    std::memcpy(&value, bytes.data() + offset, 4);
    return value;
  };
  EXPECT_EQ(intAt(16), 0x01020304);
  EXPECT_EQ(intAt(24), 77);
  EXPECT_EQ(intAt(300 + 60), -5);
  EXPECT_EQ(floatAt(364 + 6 * 64), 1.5F);
  EXPECT_EQ(floatAt(820 + 60), 2.5F);
  EXPECT_EQ(floatAt(976), 3.5F);
}

TEST(RavenStateMessage, EverythingOfTheJointsIsTimes180OverPi) {
  raven_2::RavenState message;
  RavenReport report = home();
  report.mpos[2] = 1.0;
  report.mvel[8] = -2.0;
  report.tau[1] = 0.25;
  report.grasp_d = {kPi / 2, 0.5};
  report.dac[15] = -3800;
  fillRavenState(report, &message);
  EXPECT_FLOAT_EQ(message.jpos[0], 30.0F);
  EXPECT_FLOAT_EQ(message.jpos[1], 90.0F);
  EXPECT_NEAR(message.jpos[2], 22.918, 5e-4) << "metres too";
  EXPECT_NEAR(message.jpos[10], 22.918, 5e-4);
  EXPECT_FLOAT_EQ(message.jpos_d[9], 91.0F);
  EXPECT_NEAR(message.mpos[2], 57.29578, 1e-5);
  EXPECT_NEAR(message.mvel[8], -114.59156, 1e-5);
  EXPECT_FLOAT_EQ(message.tau[1], 0.25F) << "Nm";
  EXPECT_FLOAT_EQ(message.grasp_d[1], 0.5F) << "rad";
  EXPECT_EQ(message.dac_val[15], -3800);
  EXPECT_EQ(message.type[0], 49);
  EXPECT_EQ(message.last_seq, 111);
}

TEST(RavenJointStates, CarryMeasuredAndWantedWithTheRobotsOffsetsAndSigns) {
  RavenReport report = home();
  for (const std::size_t arm : {0U, 8U}) {
    report.jpos[arm + 4] = 0.1;
    report.jpos[arm + 5] = 0.2;
    report.jpos[arm + 7] = 0.3;
  }
  const sensor_msgs::JointState message = ravenJointState(report, -0.47, ros::Time(5.0));
  const std::vector<std::string> arm{"shoulder",    "elbow",           "insertion",      "tool_roll",
                                     "wrist_joint", "grasper_joint_1", "grasper_joint_2"};
  std::vector<std::string> names;
  for (const char* suffix : {"_L", "_R", "_L2", "_R2"}) {
    for (const std::string& joint : arm)
      names.push_back(joint + suffix);
  }
  EXPECT_EQ(message.name, names);
  ASSERT_EQ(message.position.size(), 28U);
  EXPECT_TRUE(message.velocity.empty());
  EXPECT_TRUE(message.effort.empty());
  // raven2.md 5.4
  EXPECT_NEAR(message.position[2], 0.40 - 0.47, 1e-12);
  EXPECT_NEAR(message.position[3], 0.1 - 45 * kDegree, 1e-12);
  EXPECT_NEAR(message.position[4], 0.2, 1e-12);
  EXPECT_NEAR(message.position[6], -0.3, 1e-12);
  EXPECT_NEAR(message.position[7 + 3], 0.1 + 45 * kDegree, 1e-12);
  EXPECT_NEAR(message.position[7 + 4], -0.2, 1e-12);
  EXPECT_NEAR(message.position[7 + 6], -0.3, 1e-12);
  EXPECT_NEAR(message.position[21 + 1], 91.0 * kDegree, 1e-12);
}

TEST(RavenAutomove, IsTruncatedToWholeMicrometresAndRefusedIfNotFinite) {
  raven_2::RavenAutomove message;
  message.tf_incr[0].translation.x = 12.9;
  message.tf_incr[1].translation.y = -12.9;
  message.tf_incr[1].translation.z = 1e30;
  message.tf_incr[0].rotation.w = 1.0;
  const auto move = toAutomove(message);
  ASSERT_TRUE(move);
  EXPECT_EQ(move->dp_um[0][0], 12);
  EXPECT_EQ(move->dp_um[1][1], -12);
  EXPECT_EQ(move->dp_um[1][2], std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(move->dq[0], kIdentityQuat);
  EXPECT_EQ(move->dq[1], (Quat{0, 0, 0, 0})) << "the robot must not take it for the identity";
  message.tf_incr[1].rotation.z = std::nan("");
  EXPECT_FALSE(toAutomove(message));
}

class RavenStateReaderTest : public ::testing::Test {
 protected:
  template <typename Message>
  static Message moving(int k, const std::array<double, 3>& rate) {
    // motor = A joint, numbers of raven2.md 3.3; rates in rad/s, rad/s, m/s from the home pose, k ms later
    const double A[3][3] = {{136.196255, 0, 0}, {17.675386, 121.522075, 0}, {16.831355, 17.435769, 2158.590308}};
    const double tool[3] = {5.786555, 5.994350, 742.115028};  // rows of all tool joints, before the sign
    const double q[3] = {30 * kDegree + rate[0] * k * 1e-3, 90 * kDegree + rate[1] * k * 1e-3,
                         0.4 + rate[2] * k * 1e-3};
    Message message;
    message.hdr.stamp.fromNSec(1000000000000ULL + static_cast<std::uint64_t>(k) * 1000000);  // without a number
    message.dt = ros::Duration(0.001);
    message.runlevel = 3;
    message.sublevel = 0;
    message.last_seq = 5000 + k;
    for (const std::size_t arm : {0U, 8U}) {
      for (std::size_t i = 0; i < 3; ++i) {
        message.jpos[arm + i] = static_cast<float>(q[i] / kDegree);
        message.mpos[arm + i] = static_cast<float>((A[i][0] * q[0] + A[i][1] * q[1] + A[i][2] * q[2]) / kDegree);
      }
      // The tool does not move: its motors only follow the three positioning joints. s is +1 for gold and -1 for green;
      // grasper 1 has the opposite sign.
      const double follow = (tool[0] * q[0] + tool[1] * q[1] + tool[2] * q[2]) / kDegree;
      const double s = arm == 0 ? 1.0 : -1.0;
      for (const std::size_t i : {4U, 5U, 7U})
        message.mpos[arm + i] = static_cast<float>(s * follow);
      message.mpos[arm + 6] = static_cast<float>(-s * follow);
    }
    return message;
  }

  TrainerConfig config{config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml")};
  RavenStateReader reader{config.virtual_raven};
  RobotState state;
};

TEST_F(RavenStateReaderTest, GivesSiUnitsAndAllVelocitiesFromTheMotors) {
  const std::array<double, 3> rate{0.2, -0.3, 0.05};
  for (int k = 0; k < 200; ++k) {
    auto message = moving<raven_2::RavenState>(k, rate);
    message.dac_val[2] = 1234;
    message.dac_val[15] = -4321;
    message.jpos[3] = 99.0F;  // this channel is not connected
    ASSERT_TRUE(reader.read(message, 1000 + k, &state));
  }
  EXPECT_EQ(state.cycle, 200U);
  EXPECT_EQ(state.time_ns, 1199);
  EXPECT_EQ(state.last_sequence, 5199U);
  EXPECT_EQ(state.runlevel, RunLevel::kPedalDown);
  EXPECT_EQ(state.homed, 1);
  EXPECT_EQ(state.is_virtual, 0);
  EXPECT_EQ(state.active_fault, 0U);
  EXPECT_EQ(state.arms[0].dac[kInsertion], 1234);
  EXPECT_EQ(state.arms[1].dac[kGrasp2], -4321);
  EXPECT_EQ(state.arms[0].jstate, kNoJointStates);
  for (const RobotArmState& arm : state.arms) {
    EXPECT_NEAR(arm.q[kShoulder], 30 * kDegree + 0.2 * 0.199, 1e-6);
    EXPECT_NEAR(arm.q[kInsertion], 0.4 + 0.05 * 0.199, 1e-7);
    // one float of a motor at 50,000 degrees is 0.004 degrees: 0.07 rad/s of the motor in 1 ms, filtered
    EXPECT_NEAR(arm.dq[kShoulder], 0.2, 2e-3);
    EXPECT_NEAR(arm.dq[kElbow], -0.3, 2e-3);
    EXPECT_NEAR(arm.dq[kInsertion], 0.05, 2e-4);
    for (const std::size_t j : {kToolRotation, kWrist, kGrasp1, kGrasp2})
      EXPECT_NEAR(arm.dq[j], 0.0, 0.03) << j;
  }
}

TEST_F(RavenStateReaderTest, ALostMessageIsACycleAndNoJumpOfVelocity) {
  const std::array<double, 3> rate{0.2, 0.0, 0.0};
  for (int k = 0; k < 300; k += (k % 7 == 0 ? 3 : 1)) {
    ASSERT_TRUE(reader.read(moving<raven_2::RavenState>(k, rate), k, &state));
    EXPECT_EQ(state.cycle, static_cast<std::uint64_t>(k) + 1);
    if (k > 100) {
      EXPECT_NEAR(state.arms[0].dq[kShoulder], 0.2, 3e-3);
    }
  }
}

TEST_F(RavenStateReaderTest, UnevenCyclesAreNotLostMessages) {
  // Every third message is stamped 0.7 ms late, and the robot's dt agrees.
  for (int k = 0; k < 300; ++k) {
    auto message = moving<raven_2::RavenState>(k, {0.2, 0.0, 0.0});
    const auto late = [](int i) { return ros::Duration(i % 3 == 1 ? 0.0007 : 0.0); };
    message.hdr.stamp += late(k);
    message.dt = ros::Duration(0.001) + late(k) - late(k - 1 + 300);
    ASSERT_TRUE(reader.read(message, k, &state));
    EXPECT_EQ(state.cycle, static_cast<std::uint64_t>(k) + 1);
  }
  EXPECT_NEAR(state.arms[0].dq[kShoulder], 0.2, 3e-3);
}

TEST_F(RavenStateReaderTest, ANewReferenceOfTheEncodersIsNoMotion) {
  for (int k = 0; k < 50; ++k) {
    auto message = moving<raven_2::RavenState>(k, {});
    message.runlevel = 1;
    if (k >= 25) message.mpos[0] += 500.0F;  // homing found the stop
    ASSERT_TRUE(reader.read(message, k, &state));
    EXPECT_EQ(state.arms[0].dq, JointArray{}) << k;
  }
}

TEST_F(RavenStateReaderTest, StaysHomedThroughAnEStop) {
  auto message = moving<raven_2::RavenState>(0, {});
  for (const std::int32_t level : {0, 1}) {
    message.runlevel = level;
    message.hdr.stamp += ros::Duration(0.001);
    ASSERT_TRUE(reader.read(message, 1, &state));
    EXPECT_EQ(state.homed, 0);
  }
  for (const std::int32_t level : {2, 3, 0, 1, 2}) {
    message.runlevel = level;
    message.hdr.stamp += ros::Duration(0.001);
    ASSERT_TRUE(reader.read(message, 1, &state));
    EXPECT_EQ(state.homed, 1) << level;
  }
}

TEST_F(RavenStateReaderTest, ARestartedSourceGoesOnCountingAndStartsWithoutVelocity) {
  for (int k = 0; k < 50; ++k)
    reader.read(moving<raven_2::RavenState>(k, {0.2, 0.0, 0.0}), k, &state);
  raven_2::RavenState anew;
  anew.hdr.stamp.fromNSec(1000000000000ULL + 80 * 1000000ULL);  // 31 ms later, the first message after a restart
  anew.runlevel = 1;
  ASSERT_TRUE(reader.read(anew, 60, &state));
  EXPECT_EQ(state.cycle, 51U);
  EXPECT_EQ(state.arms[0].dq, JointArray{});
  EXPECT_EQ(state.homed, 0);
}

TEST_F(RavenStateReaderTest, TheForksMessageGivesTheSame) {
  RavenStateReader other(config.virtual_raven);
  RobotState expected;
  for (int k = 0; k < 20; ++k) {
    auto fork = moving<raven_2::ForkRavenState>(k, {0.1, 0.1, 0.01});
    fork.current_cmd[4] = -77;
    auto stock = moving<raven_2::RavenState>(k, {0.1, 0.1, 0.01});
    stock.dac_val[4] = -77;
    ASSERT_TRUE(reader.read(fork, k, &state));
    ASSERT_TRUE(other.read(stock, k, &expected));
  }
  EXPECT_EQ(state.arms[0].dac[kToolRotation], -77);
  EXPECT_EQ(state.arms[1].q, expected.arms[1].q);
  EXPECT_EQ(state.arms[1].dq, expected.arms[1].dq);
  EXPECT_EQ(state.cycle, expected.cycle);
}

TEST_F(RavenStateReaderTest, RefusesUnknownRunLevelsAndNumbersThatAreNotFinite) {
  auto message = moving<raven_2::RavenState>(0, {});
  message.runlevel = 4;
  EXPECT_FALSE(reader.read(message, 1, &state));
  message.runlevel = -1;
  EXPECT_FALSE(reader.read(message, 1, &state));
  message.runlevel = 3;
  message.mpos[9] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(reader.read(message, 1, &state));
  message.mpos[9] = 0.0F;
  message.jpos[9] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(reader.read(message, 1, &state));
  EXPECT_EQ(state.cycle, 0U);
}

/** Fills an array with numbers that no other array has. */
template <typename Array>
void number(Array* values, int first) {
  std::iota(values->begin(), values->end(), static_cast<typename Array::value_type>(first));
}

template <typename To, typename From>
void expectScaled(const To& to, const From& from, double factor, const char* field) {
  ASSERT_EQ(to.size(), from.size()) << field;
  for (std::size_t i = 0; i < to.size(); ++i)
    EXPECT_FLOAT_EQ(static_cast<float>(to[i]), static_cast<float>(factor * static_cast<double>(from[i]))) << field << i;
}

/** raven2.md 5.2: each field has its own source and unit. */
TEST(RavenStateMessage, EveryFieldIsItsOwn) {
  RavenReport report;
  report.runlevel = 3;
  report.sublevel = 2;
  report.last_sequence = 1;
  number(&report.board, 40);
  number(&report.pos_um, 100);
  number(&report.pos_d_um, 200);
  number(&report.ori, 300);
  number(&report.ori_d, 400);
  number(&report.encoder, 500);
  number(&report.dac, 600);
  number(&report.tau, 700);
  number(&report.mpos, 800);
  number(&report.jpos, 900);
  number(&report.mvel, 1000);
  number(&report.jvel, 1100);
  number(&report.mpos_d, 1200);
  number(&report.jpos_d, 1300);
  number(&report.grasp_d, 1400);
  number(&report.encoder_offset, 1500);
  raven_2::RavenState message;
  fillRavenState(report, &message);
  EXPECT_EQ(message.runlevel, 3);
  EXPECT_EQ(message.sublevel, 2);
  EXPECT_EQ(message.last_seq, 1);
  const double degrees = 1.0 / kDegree;
  expectScaled(message.type, report.board, 1.0, "type");
  expectScaled(message.pos, report.pos_um, 1.0, "pos");
  expectScaled(message.pos_d, report.pos_d_um, 1.0, "pos_d");
  expectScaled(message.ori, report.ori, 1.0, "ori");
  expectScaled(message.ori_d, report.ori_d, 1.0, "ori_d");
  expectScaled(message.encVals, report.encoder, 1.0, "encVals");
  expectScaled(message.dac_val, report.dac, 1.0, "dac_val");
  expectScaled(message.tau, report.tau, 1.0, "tau");
  expectScaled(message.mpos, report.mpos, degrees, "mpos");
  expectScaled(message.jpos, report.jpos, degrees, "jpos");
  expectScaled(message.mvel, report.mvel, degrees, "mvel");
  expectScaled(message.jvel, report.jvel, degrees, "jvel");
  expectScaled(message.mpos_d, report.mpos_d, degrees, "mpos_d");
  expectScaled(message.jpos_d, report.jpos_d, degrees, "jpos_d");
  expectScaled(message.grasp_d, report.grasp_d, 1.0, "grasp_d");
  expectScaled(message.encoffsets, report.encoder_offset, 1.0, "encoffsets");
}

/** The arms move differently. Neither may get the other's positions, velocities or commands. */
TEST_F(RavenStateReaderTest, EachArmIsReadFromItsOwnChannels) {
  for (int k = 0; k < 200; ++k) {
    auto message = moving<raven_2::RavenState>(k, {0.2, 0.0, 0.0});
    const auto other = moving<raven_2::RavenState>(k, {-0.1, 0.0, 0.0});
    for (std::size_t i = 8; i < 16; ++i) {
      message.mpos[i] = other.mpos[i];
      message.jpos[i] = other.jpos[i];
    }
    message.dac_val[1] = 11;
    message.dac_val[9] = -22;
    ASSERT_TRUE(reader.read(message, k, &state));
  }
  EXPECT_NEAR(state.arms[0].dq[kShoulder], 0.2, 2e-3);
  EXPECT_NEAR(state.arms[1].dq[kShoulder], -0.1, 2e-3);
  EXPECT_NEAR(state.arms[0].q[kShoulder], 30 * kDegree + 0.2 * 0.199, 1e-6);
  EXPECT_NEAR(state.arms[1].q[kShoulder], 30 * kDegree - 0.1 * 0.199, 1e-6);
  EXPECT_EQ(state.arms[0].dac[kElbow], 11);
  EXPECT_EQ(state.arms[1].dac[kElbow], -22);
}

/** After any break of the stream the first message shows no velocity, on either arm. */
TEST_F(RavenStateReaderTest, AnyBreakOfTheStreamStartsBothArmsWithoutVelocity) {
  for (const double step : {0.2, -0.01}) {  // [s] a gap of over 100 ms, the clock set back
    RavenStateReader broken(config.virtual_raven);
    for (int k = 0; k < 50; ++k)
      ASSERT_TRUE(broken.read(moving<raven_2::RavenState>(k, {0.2, 0.1, 0.05}), k, &state));
    for (const RobotArmState& arm : state.arms)
      ASSERT_GT(arm.dq[kShoulder], 0.01);
    auto next = moving<raven_2::RavenState>(49, {0.2, 0.1, 0.05});
    next.hdr.stamp += ros::Duration(step);
    next.dt = ros::Duration(0.001);
    ASSERT_TRUE(broken.read(next, 50, &state));
    for (const RobotArmState& arm : state.arms)
      EXPECT_EQ(arm.dq, JointArray{}) << step;
    EXPECT_EQ(state.cycle, 51U) << step;
  }
}

TEST_F(RavenStateReaderTest, AClockThatIsYearsAheadIsABreakOfTheStream) {
  auto message = moving<raven_2::RavenState>(0, {});
  ASSERT_TRUE(reader.read(message, 1, &state));
  for (const std::uint32_t second : {4000000000U, 1000U}) {
    message.hdr.stamp = ros::Time(second, 0U);
    ASSERT_TRUE(reader.read(message, 2, &state));
    EXPECT_EQ(state.arms[0].dq, JointArray{}) << second;
  }
  EXPECT_EQ(state.cycle, 3U);
}

TEST_F(RavenStateReaderTest, ASubLevelBeyondAByteIsTheNearest) {
  auto message = moving<raven_2::RavenState>(0, {});
  for (const auto& [told, read] : {std::pair(7, 7), std::pair(300, 255), std::pair(-5, 0)}) {
    message.sublevel = told;
    message.hdr.stamp += ros::Duration(0.001);
    ASSERT_TRUE(reader.read(message, 1, &state));
    EXPECT_EQ(state.sublevel, read);
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
