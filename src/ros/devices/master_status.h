#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>

#include "raven2_trainer/console/master.h"

namespace raven2_trainer::ros_bridge {

/** State of one device, in addition to the report. */
struct DeviceTraffic {
  double pose_rate{};          ///< [1/s]
  std::uint32_t readers{};     ///< of its force
  bool is_driver_among{true};  ///< them; so it is while it is not known
  bool is_absolute_missing{};  ///< nobody reads force_absolute: forces stay zero
};

/** Status "master left" or "master right": ERROR if poses are missing or wrong, WARN if they do not change, or if
 * no force will be felt: nobody reads it, the publisher of the poses does not, or nobody reads force_absolute. */
diagnostic_msgs::DiagnosticStatus masterStatus(const MasterConfig& config,
                                               Arm arm,
                                               const MasterReport& report,
                                               const DeviceTraffic& traffic);

}  // namespace raven2_trainer::ros_bridge
