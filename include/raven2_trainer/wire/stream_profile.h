#pragma once

#include "raven2_trainer/core/axis_map.h"

namespace raven2_trainer {

/** How a console speaks ITP in its own way (config/streams, doc/streams.md). */
struct StreamProfile {
  bool is_on{};  ///< false: packets are taken as they come, and nothing below counts
  AxisMap axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  double um_per_count{1.0};    ///< [um]
  bool turns_in_counts{};      ///< Qx, Qy, Qz are whole numbers, Qw is not looked at
  double turn_per_count{};     ///< [-] of a quaternion's vector part
  bool has_absolute_grasp{};   ///< grasp says where the jaws are, not how far they go
  double mrad_per_count{1.0};  ///< [mrad]
  bool waits_for_press{};      ///< a pedal that is down at the start counts as up until it was up
};

}  // namespace raven2_trainer
