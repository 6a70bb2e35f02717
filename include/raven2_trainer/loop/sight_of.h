#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/sight.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::loop {

constexpr Tick kPicturePeriod = 33;  ///< [1 ms] 30 views a second

/**
 * The simulated surgeon's view of model and robot. Real-time safe.
 * @param[in] free_bodies Number of free bodies: the first ones of ModelState::bodies.
 * @param[in] sequence Number of the view.
 */
Sight sightOf(const ModelState& model,
              const RobotState& robot,
              const ArmsConfig& arms,
              std::size_t free_bodies,
              std::uint32_t sequence) noexcept;

}  // namespace raven2_trainer::loop
