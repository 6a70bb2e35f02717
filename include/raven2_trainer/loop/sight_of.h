#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/sight.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::loop {

constexpr Tick kPicturePeriod = 33;  ///< [1 ms] 30 pictures a second

/**
 * A surgeon's view of the model and news of the robot.
 * @param[in] free_bodies Bodies of ModelState::bodies ahead of those that can break off.
 * @param[in] sequence Number of the picture. Real-time safe.
 */
Sight sightOf(const ModelState& model,
              const RobotState& robot,
              const ArmsConfig& arms,
              std::size_t free_bodies,
              std::uint32_t sequence) noexcept;

}  // namespace raven2_trainer::loop
