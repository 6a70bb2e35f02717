#include "raven2_trainer/runtime/motion.h"

#include <ctime>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/runtime/build_identity.h"

namespace raven2_trainer::runtime {
namespace {

const std::string kRecording = "recording:";

}  // namespace

std::unique_ptr<console::MotionSource> makeMotion(const TrainerConfig& config, const std::string& motion) {
  if (motion == "scripted") return console::makeScripted(config.console, config.arms, config.seed);
  if (motion.compare(0, kRecording.size(), kRecording) == 0) {
    return console::makeRecorded(config.console, config.arms, console::loadRecording(motion.substr(kRecording.size())));
  }
  throw ConfigException("motion is \"" + motion + "\", expected scripted or recording:FILE");
}

session::SessionMeta startMeta(const std::string& program, const std::string& version, const std::string& motion) {
  session::SessionMeta meta;
  meta.program = program;
  meta.version = version;
  meta.motion = motion;
  meta.build = buildIdentity();
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  meta.start_time_utc = text;
  return meta;
}

}  // namespace raven2_trainer::runtime
