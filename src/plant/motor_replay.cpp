#include "raven2_trainer/plant/motor_replay.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "plant/arm_plant.h"
#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::plant {

struct MotorReplay::Impl {
  Impl(const model::RavenModel& raven, const VirtualRavenConfig& configuration, MotorRecording&& recorded)
      : config(configuration),
        recording(std::move(recorded)),
        coupling(Arm::kGold, configuration),
        home(Eigen::Map<const Vector7>(raven.arms.geometry.home.data())),
        arm(raven, Arm::kGold, configuration) {
    start();
  }

  /** All motors of the arm for the recorded three; the tool joints at `tool`. */
  Vector7 complete(const MotorReplay::Motors& motors, const Vector7& tool) const {
    const Eigen::Matrix3d A = coupling.matrix().topLeftCorner<3, 3>();
    Vector7 q = tool;
    q.head<3>() = A.inverse() * Eigen::Map<const Vector3>(motors.data());
    return coupling.matrix() * q;
  }

  /** Proportional part of the control law, to where a tool motor belongs at the insertion motor's position. */
  std::int16_t holdTool(const ArmPlant& plant, std::size_t j) const {
    const auto k = static_cast<Eigen::Index>(j);
    const MotorAxis& axis = config.axes[j];
    Vector7 q = coupling.inverse() * plant.motorPositions();
    q.tail<4>() = home.tail<4>();
    const double error = coupling.matrix().row(k).dot(q) - plant.motorPositions()[k];
    const double counts = axis.kp * error / axis.torque_per_amp * axis.counts_per_amp;
    const double limit = axis.dac_clip;
    return static_cast<std::int16_t>(raven::torqueSign(Arm::kGold, j) * std::clamp(counts, -limit, limit));
  }

  void drive(ArmPlant* plant, std::size_t at_row) const {
    std::array<std::int16_t, raven::kChannels> dac{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      dac[raven::channelOf(j)] = j < 3 ? recording.rows[at_row].dac[j] : holdTool(*plant, j);
    plant->step(dac, /*brakes_on=*/false);
  }

  void start() {
    const MotorRecording::Row& first = recording.rows.front();
    arm.setMotors(complete(first.position, home), complete(first.rate, Vector7::Zero()));
    row = 0;
  }

  void lead() {
    drive(&arm, row);
    const MotorRecording::Row& next = recording.rows[++row];
    arm.leadMotors(complete(next.position, home), complete(next.rate, Vector7::Zero()));
  }

  VirtualRavenConfig config;
  MotorRecording recording;
  raven::CableCoupling coupling;
  Vector7 home;
  ArmPlant arm;
  std::size_t row{0};
};

MotorReplay::MotorReplay(const model::RavenModel& raven, const VirtualRavenConfig& config, MotorRecording recording)
    : impl_(std::make_unique<Impl>(raven, config, std::move(recording))) {}

MotorReplay::~MotorReplay() = default;

const MotorRecording& MotorReplay::recording() const noexcept {
  return impl_->recording;
}

void MotorReplay::leadTo(std::size_t row) {
  if (row < impl_->row) impl_->start();
  while (impl_->row < row)
    impl_->lead();
}

std::vector<MotorReplay::Motors> MotorReplay::predict(std::size_t horizon) const {
  ArmPlant arm = impl_->arm;
  std::vector<Motors> path;
  for (std::size_t k = 0; k < horizon; ++k) {
    impl_->drive(&arm, impl_->row + k);
    const Vector7& motor = arm.motorPositions();
    path.push_back({motor[0], motor[1], motor[2]});
  }
  return path;
}

ReplayError replayError(MotorReplay* replay,
                        std::size_t first,
                        std::size_t last,
                        std::size_t stride,
                        std::size_t horizon) {
  const std::vector<MotorRecording::Row>& rows = replay->recording().rows;
  ReplayError sum;
  std::size_t count = 0;
  for (std::size_t row = first; row < last && row + horizon < rows.size(); row += stride, ++count) {
    replay->leadTo(row);
    const MotorReplay::Motors predicted = replay->predict(horizon).back();
    for (std::size_t i = 0; i < 3; ++i) {
      const double truth = rows[row + horizon].position[i];
      const double straight = rows[row].position[i] + rows[row].rate[i] * static_cast<double>(horizon) * kTickSeconds;
      sum.plant[i] += std::pow(predicted[i] - truth, 2);
      sum.constant_velocity[i] += std::pow(straight - truth, 2);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    sum.plant[i] = std::sqrt(sum.plant[i] / static_cast<double>(count));
    sum.constant_velocity[i] = std::sqrt(sum.constant_velocity[i] / static_cast<double>(count));
  }
  return sum;
}

}  // namespace raven2_trainer::plant
