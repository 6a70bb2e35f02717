// Recordings of a real arm's motors: reading, and how well the identified plant predicts one.

#include "raven2_trainer/plant/motor_recording.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/plant/motor_replay.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "unit/plant/closed_loop.h"

namespace raven2_trainer::plant {
namespace {

using test::dhRaven;
using test::trainerConfig;

/** A separate CSV file for each test, removed at its end. */
class RecordingFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::temp_directory_path() / ("raven2_motors_" + std::to_string(getpid()));
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string write(const std::string& header, const std::string& row, int rows) {
    std::ofstream file(path_);
    file << header << '\n';
    for (int k = 0; k < rows; ++k)
      file << row << '\n';
    return path_.string();
  }

  std::string refusal(const std::string& header, const std::string& row, int rows = 300) {
    try {
      loadMotorRecording(write(header, row, rows));
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  std::filesystem::path path_;
};

constexpr const char* kHeader = "mpos1_deg,mpos2_deg,mpos3_deg,mvel1_deg_s,dac1,dac2,dac3";

TEST_F(RecordingFile, IsReadInRadiansByColumnNames) {
  const MotorRecording recording = loadMotorRecording(write(kHeader, "180,360,-90,5,-20,2,7", 200));
  ASSERT_EQ(recording.rows.size(), 200u);
  EXPECT_DOUBLE_EQ(recording.rows[5].position[2], -kPi / 2);
  EXPECT_EQ(recording.rows[5].dac[0], -20);
  EXPECT_EQ(recording.rows[5].rate[1], 0.0);
}

TEST_F(RecordingFile, BadOnesAreRefusedWithTheirLine) {
  EXPECT_NE(refusal("a,b,c", "1,2,3").find(":1: column mpos1_deg is missing"), std::string::npos);
  EXPECT_NE(refusal(kHeader, "1,2,3,4,5,6").find(":2: 6 cells"), std::string::npos);
  EXPECT_NE(refusal(kHeader, "1,nan,3,4,5,6,7").find(":2: \"nan\""), std::string::npos);
  EXPECT_NE(refusal(kHeader, "1,2,3,4,40000,6,7").find(":2: \"40000\""), std::string::npos);
  EXPECT_NE(refusal(kHeader, "1,2,3,4,5,6,7", 10).find("10 rows"), std::string::npos);
  EXPECT_THROW(loadMotorRecording("/nowhere/motors.csv"), ConfigException);
}

/** The gold shoulder under a square wave of 250 counts, from the plant itself. */
MotorRecording recordOfPlant(const VirtualRavenConfig& config) {
  MotorRecording seed;
  MotorRecording::Row start;
  const JointArray motors = raven::CableCoupling(Arm::kGold, config).toMotor(trainerConfig().arms.geometry.home);
  start.position = {motors[0], motors[1], motors[2]};
  for (int k = 0; k < 601; ++k) {
    start.dac = {static_cast<std::int16_t>(k % 200 < 100 ? -250 : 250), 0, 0};
    seed.rows.push_back(start);
  }
  MotorReplay replay(dhRaven(trainerConfig().arms), config, seed);
  const auto path = replay.predict(600);
  for (std::size_t k = 0; k < path.size(); ++k) {
    seed.rows[k + 1].position = path[k];
    for (std::size_t i = 0; i < 3; ++i)
      seed.rows[k + 1].rate[i] = (path[k][i] - seed.rows[k].position[i]) / kTickSeconds;
  }
  return seed;
}

TEST(MotorReplay, KnowsItsOwnPlantFromAnotherOne) {
  const VirtualRavenConfig config = trainerConfig().virtual_raven;
  VirtualRavenConfig heavier = config;
  heavier.plant.axes[kShoulder].inertia *= 1.5;
  const MotorRecording recording = recordOfPlant(config);
  MotorReplay same(dhRaven(trainerConfig().arms), config, recording);
  MotorReplay other(dhRaven(trainerConfig().arms), heavier, recording);
  const double right = replayError(&same, 100, 500, 10, 100).plant[0];
  const double wrong = replayError(&other, 100, 500, 10, 100).plant[0];
  EXPECT_LT(right, 0.2 * wrong);
}

TEST_F(RecordingFile, RatesAreDifferencesToTheRowBefore) {
  std::ofstream file(path_);
  file << kHeader << '\n';
  for (int k = 0; k < 200; ++k)
    file << 0.36 * k << ',' << -0.72 * k << ",5,0,-32767,32767," << -k << '\n';
  file.close();
  const MotorRecording recording = loadMotorRecording(path_.string());
  const double degree = kPi / 180.0;
  for (std::size_t k = 1; k < 200; ++k) {
    EXPECT_NEAR(recording.rows[k].rate[0], 360 * degree, 1e-9);
    EXPECT_NEAR(recording.rows[k].rate[1], -720 * degree, 1e-9);
    EXPECT_NEAR(recording.rows[k].rate[2], 0.0, 1e-12);
  }
  EXPECT_EQ(recording.rows[199].dac, (std::array<std::int16_t, 3>{-32767, 32767, -199}));
}

TEST_F(RecordingFile, NumbersAreBoundedOnBothSides) {
  for (const char* sign : {"", "-"}) {
    const std::string angle = std::string(sign) + "1000001", dac = std::string(sign) + "32768";
    EXPECT_NE(refusal(kHeader, angle + ",2,3,4,5,6,7").find(":2: \"" + angle), std::string::npos);
    EXPECT_NE(refusal(kHeader, "1,2,3,4,5,6," + dac).find(":2: \"" + dac), std::string::npos);
  }
}

TEST(MotorReplay, ErrorsAreRootMeanSquaresAgainstTheRecording) {
  // Motor 2 recorded with an acceleration a: going on with the last difference lacks a (n T)^2 / 2 + a n T^2 / 2.
  const VirtualRavenConfig config = trainerConfig().virtual_raven;
  MotorRecording recording = recordOfPlant(config);
  constexpr double kAcceleration = 3.0;  // [rad/s2]
  const double start = recording.rows[0].position[1];
  for (std::size_t k = 0; k < recording.rows.size(); ++k) {
    const double t = static_cast<double>(k) * kTickSeconds;
    recording.rows[k].position[1] = start + 0.5 * kAcceleration * t * t;
    if (k > 0)
      recording.rows[k].rate[1] =
          (recording.rows[k].position[1] - recording.rows[k - 1].position[1]) / kTickSeconds;
  }
  MotorReplay replay(dhRaven(trainerConfig().arms), config, recording);
  constexpr std::size_t kHorizon = 50;
  const ReplayError error = replayError(&replay, 100, 300, 40, kHorizon);
  const double n = static_cast<double>(kHorizon);
  EXPECT_NEAR(error.constant_velocity[1], 0.5 * kAcceleration * (n * n + n) * kTickSeconds * kTickSeconds, 1e-9);
  // the same starts, by hand, and the last first: a replay can go back
  double sum = 0.0;
  for (std::size_t row : {260, 220, 180, 140, 100}) {
    replay.leadTo(row);
    sum += std::pow(replay.predict(kHorizon).back()[1] - recording.rows[row + kHorizon].position[1], 2);
  }
  EXPECT_NEAR(error.plant[1], std::sqrt(sum / 5), 1e-12);
  EXPECT_GT(error.plant[1], 1e-3);
}

TEST(MotorReplay, PredictsTheRecordedArmBetterThanItsVelocity) {
  // The last third of the recording was not used to fit config/plants/identified.yaml.
  const char* folder = std::getenv("RAVEN2_TRAINER_DATA");
  if (folder == nullptr) GTEST_SKIP() << "RAVEN2_TRAINER_DATA does not name the folder of the recordings";
  MotorRecording recording = loadMotorRecording(std::string(folder) + "/gold_arm_dac_motor_a.csv");
  const std::size_t rows = recording.rows.size();
  const TrainerConfig& config = trainerConfig();
  MotorReplay replay(model::loadRavenModel(config), config.virtual_raven, std::move(recording));
  const ReplayError error = replayError(&replay, 2 * rows / 3, rows, 5, 100);
  const double degree = kPi / 180.0;
  EXPECT_NEAR(error.constant_velocity[0], 13.7 * degree, 0.1 * degree);  // the recording has one baseline
  EXPECT_NEAR(error.constant_velocity[1], 23.0 * degree, 0.1 * degree);
  EXPECT_NEAR(error.constant_velocity[2], 10.1 * degree, 0.1 * degree);
  EXPECT_LT(error.plant[0], 0.8 * error.constant_velocity[0]);
  EXPECT_LT(error.plant[1], 0.8 * error.constant_velocity[1]);
  EXPECT_LT(error.plant[2], 1.0 * error.constant_velocity[2]);
}

TEST(MotorReplay, EachPredictionBeginsWhereTheRecordingIs) {
  // GIVEN motors with an acceleration that the recorded commands do not explain
  const VirtualRavenConfig config = trainerConfig().virtual_raven;
  MotorRecording recording = recordOfPlant(config);
  const std::array<double, 3> start = recording.rows[0].position;
  for (std::size_t k = 0; k < recording.rows.size(); ++k) {
    const double t = static_cast<double>(k) * kTickSeconds;
    for (std::size_t i = 0; i < 3; ++i) {
      recording.rows[k].position[i] = start[i] + 0.5 * 3.0 * t * t;
      if (k > 0)
        recording.rows[k].rate[i] = (recording.rows[k].position[i] - recording.rows[k - 1].position[i]) / kTickSeconds;
    }
  }
  MotorReplay replay(dhRaven(trainerConfig().arms), config, recording);
  for (const std::size_t row : {200, 400}) {  // 0.06 and 0.24 rad from the start
    replay.leadTo(row);
    const MotorReplay::Motors next = replay.predict(1).back();
    // a millisecond of gravity and friction turns a motor by less than 5 mrad
    for (std::size_t i = 0; i < 3; ++i) {
      const double straight = recording.rows[row].position[i] + recording.rows[row].rate[i] * kTickSeconds;
      EXPECT_NEAR(next[i], straight, 0.005) << row << kJointNames[i];
    }
  }
}

TEST(MotorReplay, EachRecordedCommandDrivesItsOwnMotor) {
  const VirtualRavenConfig config = trainerConfig().virtual_raven;
  MotorRecording quiet = recordOfPlant(config);
  for (MotorRecording::Row& row : quiet.rows)
    row.dac = {};
  MotorReplay still(dhRaven(trainerConfig().arms), config, quiet);
  const MotorReplay::Motors undriven = still.predict(50).back();
  for (std::size_t i = 0; i < 3; ++i) {
    MotorRecording driven = quiet;
    for (MotorRecording::Row& row : driven.rows)
      row.dac[i] = -2000;  // gold: a negative command turns a positioning motor forward (raven2.md 3.4)
    MotorReplay moving(dhRaven(trainerConfig().arms), config, driven);
    const MotorReplay::Motors there = moving.predict(50).back();
    EXPECT_GT(there[i] - undriven[i], 0.1) << kJointNames[i];
    for (std::size_t k = 0; k < 3; ++k) {
      if (k == i) continue;
      EXPECT_LT(std::abs(there[k] - undriven[k]), 0.5 * (there[i] - undriven[i])) << kJointNames[i] << " " << k;
    }
  }
}

TEST_F(RecordingFile, LinesMayEndAsWindowsEndsThem) {
  const std::string header = std::string(kHeader) + "\r";
  const MotorRecording recording = loadMotorRecording(write(header, "180,360,-90,5,-20,2,7\r", 200));
  ASSERT_EQ(recording.rows.size(), 200u);
  EXPECT_EQ(recording.rows[5].dac, (std::array<std::int16_t, 3>{-20, 2, 7}));
}

TEST_F(RecordingFile, CellsThatAreEmptyOrMoreThanANumberAreRefused) {
  for (const std::string cell : {"", " ", "3x", "3 4", "0.5.1"}) {
    EXPECT_NE(refusal(kHeader, "1," + cell + ",3,4,5,6,7").find(":2: \"" + cell + "\""), std::string::npos) << cell;
    EXPECT_NE(refusal(kHeader, "1,2,3,4,5,6," + cell).find(":2: \"" + cell + "\""), std::string::npos) << cell;
  }
}

TEST_F(RecordingFile, ColumnsMayComeInAnyOrder) {
  const MotorRecording recording = loadMotorRecording(
      write("dac3,mpos2_deg,dac1,mpos3_deg,note,dac2,mpos1_deg", "7,360,-20,-90,any words,2,180", 200));
  const MotorRecording::Row& row = recording.rows[5];
  EXPECT_DOUBLE_EQ(row.position[0], kPi);
  EXPECT_DOUBLE_EQ(row.position[1], 2 * kPi);
  EXPECT_DOUBLE_EQ(row.position[2], -kPi / 2);
  EXPECT_EQ(row.dac, (std::array<std::int16_t, 3>{-20, 2, 7}));
}

}  // namespace
}  // namespace raven2_trainer::plant
