#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/detector/identify.h"
#include "raven2_trainer/raven/drives.h"
#include "raven2_trainer/recording/format.h"
#include "raven2_trainer/studies/detector_study.h"

namespace raven2_trainer::studies {
namespace {

using Stretch = std::vector<detector::AxisSample>;

/** Percentiles of the three quantities of one axis. */
struct AxisTails {
  detector::TailPercentile acceleration, motor_velocity, joint_velocity;
  AxisTails(double percentile, std::size_t most)
      : acceleration(percentile, most), motor_velocity(percentile, most), joint_velocity(percentile, most) {}
  DetectorThresholds value() const { return {acceleration.value(), motor_velocity.value(), joint_velocity.value()}; }
};

/** All values of one rule's predictions in fault-free runs. */
class ThresholdLearner {
 public:
  ThresholdLearner(DetectorConfig config,
                   DetectorRule rule,
                   const detector::Drives& drives,
                   double percentile,
                   std::size_t most)
      : config_(withRule(std::move(config), rule)),
        drives_(drives),
        tails_(kArmCount * kDetectorAxes, AxisTails(percentile, most)) {}

  void add(const std::vector<TrialTick>& run) {
    detector::AnomalyDetector fresh(config_, drives_);
    for (const TrialTick& tick : run) {
      const detector::Observation now = observationOf(tick);
      fresh.step(now);
      if (now.engaged) addTick(fresh);
    }
  }

  DetectorThresholds value(Arm arm, std::size_t axis) const {
    return tails_[index(arm) * kDetectorAxes + axis].value();
  }

 private:
  static DetectorConfig withRule(DetectorConfig config, DetectorRule rule) {
    config.rule = rule;
    config.suspicion = std::numeric_limits<double>::infinity();  // asks for the thresholds that are learnt here
    return config;
  }

  void addTick(const detector::AnomalyDetector& stepped) {
    for (const Arm arm : kArms) {
      for (std::size_t i = 0; i < kDetectorAxes; ++i) {
        const detector::Prediction& p = stepped.prediction(arm, i);
        AxisTails& tails = tails_[index(arm) * kDetectorAxes + i];
        tails.acceleration.add(std::abs(p.acceleration));
        tails.motor_velocity.add(std::abs(p.motor_velocity));
        tails.joint_velocity.add(std::abs(p.joint_velocity));
      }
    }
  }

  DetectorConfig config_;
  detector::Drives drives_;
  std::vector<AxisTails> tails_;
};

/** The uninterrupted stretches of a run with the brakes off. */
std::vector<Stretch> stretchesOf(const std::vector<TrialTick>& run,
                                 Arm arm,
                                 std::size_t axis,
                                 double torque_per_count) {
  std::vector<Stretch> stretches(1);
  for (const TrialTick& tick : run) {
    if (tick.level == RunLevel::kPedalDown) {
      stretches.back().push_back(
          {at(tick.motor, arm)[axis], torque_per_count * at(tick.dac, arm)[axis], at(tick.q, arm)});
    } else if (!stretches.back().empty()) {
      stretches.emplace_back();
    }
  }
  return stretches;
}

void identify(const std::vector<std::vector<TrialTick>>& runs, const detector::Drives& drives, Learned* learned) {
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < kDetectorAxes; ++i) {
      detector::AxisFit fit;
      for (const auto& run : runs) {
        for (const Stretch& stretch : stretchesOf(run, arm, i, at(drives.torque_per_count, arm)[i]))
          fit.add(stretch);
      }
      at(learned->detector.axes, arm)[i] = fit.solve();
      at(learned->explained, arm)[i] = fit.explained(at(learned->detector.axes, arm)[i]);
    }
  }
}

std::string thresholdsYaml(const DetectorThresholds& t) {
  return recording::format("{acceleration: %.5g, motor_velocity: %.5g, joint_velocity: %.5g}", t.acceleration,
                           t.motor_velocity, t.joint_velocity);
}

std::string axisYaml(const char* joint, const DetectorAxis& axis, double explained) {
  return recording::format("  %s:  # the model explains %.1f %% of the acceleration's variance\n", joint,
                           100.0 * explained) +
         recording::format(
             "    {inertia: %.5g, viscous: %.5g, coulomb: %.5g, offset: %.5g, gravity: [%.5g, %.5g, %.5g],\n",
             axis.inertia, axis.viscous, axis.coulomb, axis.offset, axis.gravity[0], axis.gravity[1], axis.gravity[2]) +
         "     published: " + thresholdsYaml(axis.published) + ",\n     departure: " + thresholdsYaml(axis.departure) +
         "}\n";
}

std::string settingsYaml(const DetectorConfig& c) {
  std::string text = recording::format(
      "mitigate: %-13s # off | hold: write the last safe command while the alarm lasts | stop: software E-stop\n",
      kMitigationNames[static_cast<std::size_t>(c.mitigate)]);
  text += recording::format(
      "rule: %-17s # published: DSN 2016, one step ahead | departure: the motor's and tip's predicted "
      "departure\n",
      kDetectorRuleNames[static_cast<std::size_t>(c.rule)]);
  text += recording::format("factor: %-15g # [-] [0.01, 100] on all thresholds\n", c.factor);
  text += recording::format(
      "memory: %-15g # [s] [0.002, 10] for the mean velocity, which counts as the surgeon's; tuned, "
      "doc/detector.md\n",
      c.memory);
  text += recording::format("braking_time: %-9g # [s] [0.001, 1] assumed duration of the gained velocity; tuned\n",
                            c.braking_time);
  text += recording::format(
      "asked: %-16g # [-] [0, 1] weight of the position error implied by a command within the clip; tuned\n", c.asked);
  text += recording::format(
      "persistence: %-10g # [s] [0, 1] assumed duration of a command beyond the robot's clip; tuned\n", c.persistence);
  text += recording::format(
      "suspicion: %-12g # [-] [0.01, 100] size (alarm: 1) above which motion is not the surgeon's; tuned\n",
      c.suspicion);
  text += recording::format("suspicion_time: %-7g # [s] [0, 1] longest suspicion; tuned\n", c.suspicion_time);
  text += recording::format(
      "excursion: %-12g # [m] [0, 0.1] least predicted departure of the tip: the unsafe jump of DSN 2016; 0 = any.\n",
      c.excursion);
  return text;
}

}  // namespace

TrainerConfig studyConfig(const TrainerConfig& config, std::uint64_t seed) {
  TrainerConfig study = config;
  study.seed = seed;
  study.virtual_raven.full_homing = false;
  study.virtual_raven.homing_time = 0.5;
  study.console.motion_time = 0.0;
  return study;
}

Learned learnDetector(const TrainerConfig& config, const LearnOptions& options, const StudyProgress& progress) {
  const detector::Drives drives = raven::drivesOf(config.arms, config.virtual_raven);
  Learned learned;
  learned.detector = config.detector;
  std::vector<std::vector<TrialTick>> kept;
  std::vector<ThresholdLearner> learners;  // of both rules, once there is a model
  const auto most = static_cast<std::size_t>(options.runs * options.ticks);
  for (std::int64_t run = 0; run < options.runs; ++run) {
    const DetectorTrial trial(studyConfig(config, options.seed + static_cast<std::uint64_t>(run)), options.ticks);
    learned.samples += static_cast<std::int64_t>(trial.past().size());
    kept.push_back(trial.past());
    if (learners.empty() && run + 1 == std::min(options.runs, options.fit_runs)) {
      identify(kept, drives, &learned);
      for (const DetectorRule rule : {DetectorRule::kPublished, DetectorRule::kDeparture})
        learners.emplace_back(learned.detector, rule, drives, options.percentile, most);
    }
    for (ThresholdLearner& learner : learners) {
      for (const auto& past : kept)
        learner.add(past);
    }
    if (!learners.empty()) kept.clear();
    progress(static_cast<double>(run + 1) / static_cast<double>(options.runs));
  }
  learned.runs = options.runs;
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < kDetectorAxes; ++i) {
      at(learned.detector.axes, arm)[i].published = learners[0].value(arm, i);
      at(learned.detector.axes, arm)[i].departure = learners[1].value(arm, i);
    }
  }
  return learned;
}

std::string detectorYaml(const Learned& learned, const std::string& source) {
  const DetectorConfig& c = learned.detector;
  std::string text =
      "# Detector of unsafe motor commands (doc/detector.md). learn_detector wrote it from commands and encoders of "
      "fault-free\n"
      "# runs only:\n# " +
      source + "\n" + settingsYaml(c) +
      "# Axes: inertia [kg m2] [1e-7, 1], viscous [Nms/rad] [0, 10], coulomb [Nm] [0, 10], offset [Nm] [-10, 10]: "
      "capstan\n"
      "# torque per motor shaft angle, links included. gravity [Nm/rad, Nm/rad, Nm/m] [-100, 100]: change of the "
      "offset\n"
      "# with the three joints. Thresholds of both rules: acceleration [rad/s2] and motor_velocity [rad/s] of the "
      "motor,\n"
      "# joint_velocity [rad/s; m/s], all [0, 1e6].\n";
  for (const Arm arm : kArms) {
    text += std::string(name(arm)) + ":\n";
    for (std::size_t i = 0; i < kDetectorAxes; ++i)
      text += axisYaml(kJointNames[i], at(c.axes, arm)[i], at(learned.explained, arm)[i]);
  }
  return text;
}

}  // namespace raven2_trainer::studies
