#include <algorithm>

#include "motion.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::console {
namespace {

/** Lead-in from home, then one row of the recording a tick, pedal down throughout; the jaws stay as at home. */
class RecordedSource : public MotionSource {
 public:
  RecordedSource(const ConsoleConfig& config, const ArmsConfig& arms, Recording recording)
      : scale_(config.recording_scale),
        lead_in_(std::max<Tick>(1, toTicks(config.recording_lead_in))),
        jaws_(kinematics::jawOpening(arms.geometry.home)),
        recording_(std::move(recording)) {
    for (const Arm arm : kArms)
      at(home_B_, arm) = homeTip(arms, arm);
  }

  Intent tick(const Senses&) override {
    const Tick now = now_++;
    const Tick rows = static_cast<Tick>(recording_.tips.size());
    const Tick row = std::clamp<Tick>(now - lead_in_, 0, rows - 1);
    const double approached = minimumJerk(static_cast<double>(now) / static_cast<double>(lead_in_));
    Intent intent;
    intent.finished = now >= lead_in_ + rows;
    intent.pedal = !intent.finished;
    for (const Arm arm : kArms) {
      at(intent.hand_I, arm) = toArray(approached * hand(arm, static_cast<std::size_t>(row)));
      at(intent.grasp, arm) = jaws_;
    }
    return intent;
  }

 private:
  Vector3 hand(Arm arm, std::size_t row) const {
    const Vector3 from_home_B = toEigen(at(recording_.tips[row], arm)) - at(home_B_, arm);
    return scale_ * (control::itpToBase(arm).transpose() * from_home_B);
  }

  double scale_;
  Tick lead_in_;
  double jaws_;
  Recording recording_;
  PerArm<Vector3> home_B_;
  Tick now_{0};
};

}  // namespace

std::unique_ptr<MotionSource> makeRecorded(const ConsoleConfig& config, const ArmsConfig& arms, Recording recording) {
  if (recording.tips.empty()) throw ConfigException("recording: 0 rows, expected at least 1");
  return std::make_unique<RecordedSource>(config, arms, std::move(recording));
}

}  // namespace raven2_trainer::console
