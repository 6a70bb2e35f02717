#include "raven/state_estimator.h"

#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::raven {

void StateEstimator::update(const std::array<std::int32_t, kChannels>& encoder) noexcept {
  JointArray raw;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    count_[j] = static_cast<double>(encoderSign(arm_, j)) * encoder[channelOf(j)];
    raw[j] = kMotorRadPerCount * (count_[j] - offset_[j]);
  }
  if (!started_) {
    filter_.reset(raw);
    mpos_ = raw;
    started_ = true;
  }
  const JointArray next = low_pass_ ? filter_.update(raw) : raw;
  for (std::size_t j = 0; j < kJointCount; ++j)
    mvel_[j] = (next[j] - mpos_[j]) / kTickSeconds;
  mpos_ = next;
}

void StateEstimator::setMotor(const JointArray& mpos) noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j)
    offset_[j] = count_[j] - mpos[j] / kMotorRadPerCount;
  filter_.reset(mpos);
  mpos_ = mpos;
  mvel_ = JointArray{};
}

}  // namespace raven2_trainer::raven
