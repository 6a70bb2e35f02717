#include "raven2_trainer/recording/start_meta.h"

#include <ctime>

#include "raven2_trainer/recording/build_identity.h"

namespace raven2_trainer::recording {

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

}  // namespace raven2_trainer::recording
