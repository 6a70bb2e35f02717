#pragma once

#include <cstdint>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::training {

/**
 * Whether any arm can take something that lies at a place: some attitude of the tool, from straight down to nearly
 * level, in which the jaws are there and every joint is inside its limits. One attitude of one arm a call: a
 * microsecond or two. Obstacles are not asked for. Real-time safe but for the constructor.
 */
class ReachSearch {
 public:
  enum class Answer : std::uint8_t { kNotYet, kReachable, kOutOfReach };

  ReachSearch(const ArmGeometry& geometry, const PerArm<Pose>& X_WB) : geometry_(geometry), X_WB_(X_WB) {}

  void begin(const Vector3& p_W) noexcept;
  void stop() noexcept { busy_ = false; }
  bool isBusy() const noexcept { return busy_; }
  /** One try. kNotYet also where nothing was begun. */
  Answer step() noexcept;

  static constexpr std::uint32_t kLeans = 5, kAzimuths = 12, kRolls = 12;
  static constexpr std::uint32_t kTries = kArmCount * kLeans * kAzimuths * kRolls;

 private:
  bool isReached(std::uint32_t attempt) const noexcept;

  ArmGeometry geometry_;
  PerArm<Pose> X_WB_;
  Vector3 p_W_{Vector3::Zero()};
  std::uint32_t next_{0};
  bool busy_{false};
};

}  // namespace raven2_trainer::training
