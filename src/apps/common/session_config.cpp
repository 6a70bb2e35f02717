#include "apps/common/session_config.h"

#include <cstdio>

#include "apps/common/paths.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/recording/resimulation.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::apps {
namespace {

TrainerConfig loadFor(const session::SessionPaths& paths, const std::string& root) {
  config::TrainingNames training;
  training.exercise = session::readLogHeader(paths.log()).exercise;  // it brings its scene along
  return config::loadTrainerConfig(root, training);
}

}  // namespace

TrainerConfig viewingConfig(const session::SessionPaths& paths, const std::string& root) {
  if (!root.empty()) return loadFor(paths, root);
  try {
    TrainerConfig config = recording::sessionConfig(paths);
    config.render = config::loadTrainerConfig(defaultConfigPath()).render;
    return config;
  } catch (const Exception& e) {
    std::fprintf(stderr, "%s\nlooked at with the packaged configuration instead\n", e.what());
  }
  return loadFor(paths, defaultConfigPath());
}

}  // namespace raven2_trainer::apps
