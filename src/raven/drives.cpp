#include "raven2_trainer/raven/drives.h"

#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/cable_coupling.h"

namespace raven2_trainer::raven {

detector::Drives drivesOf(const ArmsConfig& arms, const VirtualRavenConfig& config) {
  detector::Drives drives;
  drives.geometry = arms.geometry;
  // The positioning joints depend on their own motors alone, the same in both arms.
  const CableCoupling coupling(Arm::kGold, config);
  for (std::size_t j = 0; j < detector::kAxes; ++j) {
    const MotorAxis& axis = config.axes[j];
    for (const Arm arm : kArms)
      at(drives.torque_per_count, arm)[j] = torqueSign(arm, j) * axis.torque_per_amp / axis.counts_per_amp;
    for (std::size_t k = 0; k < detector::kAxes; ++k)
      drives.joint_per_motor[j][k] = coupling.inverse()(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k));
    drives.position_gain[j] = axis.kp;
    drives.clip[j] = axis.dac_clip;
  }
  return drives;
}

}  // namespace raven2_trainer::raven
