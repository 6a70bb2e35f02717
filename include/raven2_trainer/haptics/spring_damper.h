#pragma once

#include <Eigen/Core>

#include "raven2_trainer/haptics/haptics_config.h"

namespace raven2_trainer::haptics {

/**
 * Force rendered on the master, eqs. (5) and (6) of Li et al. 2017.
 *
 * Reading of the paper: the "0.05" printed in eq. (5) is `min_force`, the least force [N] once the tolerance is passed.
 * Deviation from the paper: saturated at `max_force`; the paper states saturation but no value. A state that is not
 * finite gives no force.
 * Real-time safe.
 *
 * @param[in] p_model, p_robot Tool tips [m] in frame B of the same arm.
 * @param[in] v_model, v_robot Tool-tip velocities [m/s] in frame B.
 * @return Force [N] in frame B; zero within `gains.tolerance`.
 */
Eigen::Vector3d springDamper(const HapticGains& gains,
                             const Eigen::Vector3d& p_model,
                             const Eigen::Vector3d& p_robot,
                             const Eigen::Vector3d& v_model,
                             const Eigen::Vector3d& v_robot) noexcept;

}  // namespace raven2_trainer::haptics
