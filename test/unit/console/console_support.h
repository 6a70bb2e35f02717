#pragma once

#include <functional>
#include <memory>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::console {

/** Round figures, not those of config/: the tests state behaviour, not tuning. */
inline ConsoleConfig testConfig() {
  ConsoleConfig config;
  config.scale = 0.1;
  config.hand_mass = 0.3;
  config.hand_stiffness = 300.0;
  config.hand_damping = 17.0;
  config.tremor_amplitude = 0.0002;
  config.tremor_low = 8.0;
  config.tremor_high = 12.0;
  config.start_delay = 0.3;
  config.motion_time = 30.0;
  config.stroke_speed = 0.2;
  config.pause_min = 0.2;
  config.pause_max = 0.6;
  config.clutch_every = 7.0;
  config.clutch_time = 0.5;
  config.task_W_min = {-0.02, 0.01, 0.04};
  config.task_W_max = {0.03, 0.05, 0.07};
  config.recording_scale = 10.0;
  config.recording_lead_in = 2.0;
  return config;
}

/** Both arms at the home pose of raven2.md 2.4. */
inline ArmsConfig testArms() {
  ArmsConfig arms;
  arms.geometry.d4 = -0.47;
  arms.geometry.lw = 0.013;
  arms.geometry.home = {kPi / 6, kPi / 2, 0.40, 0.0, 0.0, kPi / 4, kPi / 4};
  arms.rcm_W = {Vec3{-0.03, 0.0643, 0.14}, Vec3{-0.03, -0.0643, 0.14}};
  return arms;
}

/** A motion given as a function of the tick. */
class FunctionSource : public MotionSource {
 public:
  explicit FunctionSource(std::function<Intent(Tick)> function) : function_(std::move(function)) {}
  Intent tick(const Senses&) override { return function_(now_++); }

 private:
  std::function<Intent(Tick)> function_;
  Tick now_{0};
};

inline Console readyConsole(const ConsoleConfig& config, std::function<Intent(Tick)> function) {
  ConsoleConfig at_once = config;
  at_once.start_delay = 0.0;
  return Console(at_once, std::make_unique<FunctionSource>(std::move(function)));
}

}  // namespace raven2_trainer::console
