#include "apps/common/resimulate_session.h"

#include <chrono>
#include <cstdio>

#include "apps/common/command_line.h"
#include "apps/common/paths.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/recording/build_identity.h"
#include "raven2_trainer/recording/resimulation.h"
#include "raven2_trainer/recording/start_meta.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::apps {
namespace {

/** The bits are promised for one build: say so if this is another, before they are compared. */
void warnOfOtherBuild(const session::SessionPaths& paths) {
  const auto then = session::readBuild(paths);
  if (then.empty())
    return (void)std::fprintf(stderr, "no meta.json: with which build the session was made is unknown\n");
  for (const auto& [name, now] : recording::buildIdentity()) {
    const auto entry = then.find(name);
    const std::string before = entry == then.end() ? "unknown" : entry->second;
    if (before == now) continue;
    std::fprintf(stderr, "warning: another %s (%s, now %s): the bits may differ\n", name.c_str(), before.c_str(),
                 now.c_str());
  }
}

std::string speed(std::uint64_t ticks, double wall) {
  const double seconds = static_cast<double>(ticks) * kTickSeconds;
  char text[96];
  std::snprintf(text, sizeof(text), "%.1f s in %.1f s (%.1f x real time)", seconds, wall, seconds / wall);
  return text;
}

/** @return the exit code. */
int report(const recording::ResimulationResult& result, double wall, ProgressBar* bar) {
  bar->done(speed(result.ticks, wall));
  if (result.difference) {
    std::printf("different: first at tick %lld: %s\n", static_cast<long long>(result.difference->tick),
                result.difference->field.c_str());
    return 1;
  }
  std::printf("equal: %llu ticks bit for bit; %llu forces, and %llu of which a robot state is not in the log\n",
              static_cast<unsigned long long>(result.ticks), static_cast<unsigned long long>(result.forces),
              static_cast<unsigned long long>(result.forces_unknown));
  return 0;
}

}  // namespace

int resimulateSession(const std::string& directory, const std::string& output) {
  const session::SessionPaths paths = session::openSessionDirectory(directory);
  const TrainerConfig config = recording::sessionConfig(paths);
  warnOfOtherBuild(paths);
  physics::initialiseOde();
  session::SessionMeta meta = recording::startMeta("resimulate", version(), session::readLogHeader(paths.log()).motion);
  recording::Resimulation resimulation(config, paths, output);
  const auto keep = [&](const char* realtime, double seconds) {
    meta.realtime = realtime;
    meta.wall_duration = seconds;
    if (!output.empty()) session::writeMeta(session::SessionPaths{output}, meta, config);
  };
  keep("unknown: not ended cleanly", 0.0);  // also of one that is killed
  ProgressBar bar("resimulate");
  const auto start = std::chrono::steady_clock::now();
  const recording::ResimulationResult result = resimulation.run([&](double share) { bar.update(share); });
  keep("re-simulated", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return report(result, meta.wall_duration, &bar);
}

}  // namespace raven2_trainer::apps
