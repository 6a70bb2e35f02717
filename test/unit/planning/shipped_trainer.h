#pragma once

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/model/raven_model.h"

// The robot, scene and configuration as they are shipped, and joints drawn at random.

namespace raven2_trainer::planning::test {

struct Trainer {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  model::RavenModel raven = model::loadRavenModel(config);
  model::SceneModel scene = model::loadSceneModel(config);
};

inline const Trainer& trainer() {
  static const Trainer loaded;
  return loaded;
}

inline JointArray randomJoints(const ArmGeometry& g, Random* random) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = random->uniform(g.q_min[j], g.q_max[j]);
  return q;
}

/** Random joints near `q`, each off by up to `share` of its range, within the limits. */
inline JointArray randomJointsNear(const ArmGeometry& g, const JointArray& q, double share, Random* random) {
  JointArray out{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double reach = share * (g.q_max[j] - g.q_min[j]);
    out[j] = std::min(std::max(q[j] + random->uniform(-reach, reach), g.q_min[j]), g.q_max[j]);
  }
  return out;
}

}  // namespace raven2_trainer::planning::test
