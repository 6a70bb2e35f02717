#pragma once

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/haptics/hand_config.h"

namespace raven2_trainer {

/** config/console.yaml: the simulated surgeon. */
struct ConsoleConfig : HandConfig {
  double scale{};                      ///< [-] motion scale of the master
  double tremor_amplitude{};           ///< [m] of the hand, peak
  double tremor_low{}, tremor_high{};  ///< [Hz]
  double start_delay{};                ///< [s] pedal stays up this long after the robot is ready
  double motion_time{};                ///< [s] from first pedal down to the final release; 0 = for ever
  double stroke_speed{};               ///< [m/s] mean hand speed of a stroke
  double pause_min{}, pause_max{};     ///< [s] between strokes
  double clutch_every{};               ///< [s] mean time between clutchings; 0 = never
  double clutch_time{};                ///< [s] pedal up while clutching
  Vec3 task_W_min{},
      task_W_max{};            ///< [m] [@frame W] box of the strokes' targets for the gold arm, mirrored in y for green
  double ready_timeout{};      ///< [s] a scripted surgeon begins without a ready robot after this time; 0 = never
  double recording_scale{};    ///< [-] hand motion = recording x this
  double recording_lead_in{};  ///< [s] minimum-jerk move from home to the recording's first position
};

}  // namespace raven2_trainer
