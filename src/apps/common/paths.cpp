#include "apps/common/paths.h"

#include "raven2_trainer/config/share_folder.h"

namespace raven2_trainer::apps {

std::string defaultConfigPath() {
  return config::shareFolder() + "/config/trainer.yaml";
}

std::string version() {
  return RAVEN2_TRAINER_VERSION;
}

}  // namespace raven2_trainer::apps
