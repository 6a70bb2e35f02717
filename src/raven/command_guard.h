#pragma once

#include "raven/motor_controller.h"
#include "raven2_trainer/detector/anomaly_detector.h"
#include "raven2_trainer/detector/detector_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/raven/usb_packets.h"
#include "raven2_trainer/raven/virtual_raven_config.h"

namespace raven2_trainer::raven {

/** Between put_USB_packet, its faults included, and the boards: the detector, and what an alarm does
 *  (config/detector.yaml, `mitigate`). Real-time safe. */
class CommandGuard {
 public:
  /** @throw ConfigException as drivesOf(). */
  CommandGuard(const ArmsConfig& arms, const VirtualRavenConfig& config, const DetectorConfig& detector);

  struct ArmCommand {
    const JointArray* motor;  ///< [rad] measured
    const JointArray* q;      ///< [rad; m] measured
    DacArray* dac;            ///< [counts] about to be written; replaced by what is
    UsbOutBytes* packet;      ///< that carries it; the same
  };

  /** One cycle. @param[in] soft_estopped a stop that the guard asked for holds the boards at zero until this ends: the
   *  fault that caused it may still write.
   *  @return true: the robot must stop (mode stop); the commands are then zero. */
  bool check(const PerArm<ArmCommand>& commands, bool engaged, bool soft_estopped) noexcept;

  const DetectorReport& report() const noexcept { return report_; }

 private:
  static void replace(const ArmCommand& command, const DacArray& dac) noexcept;

  bool isSafe(const DacArray& dac, const detector::Verdict& verdict) const noexcept;

  Mitigation mitigate_;
  double safe_size_;  // [-]
  Vec3 clip_;         // [counts]
  detector::AnomalyDetector detector_;
  PerArm<DacArray> safe_{};  // [counts] last commands that are worth holding
  bool stopped_{false};      // by this guard
  DetectorReport report_{};
};

}  // namespace raven2_trainer::raven
