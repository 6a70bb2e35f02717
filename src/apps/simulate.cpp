// Runs console, daemon and virtual Raven in one process in lockstep: no sockets, no ROS, faster than real time, the
// same bytes from the same seed.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/impairment_options.h"
#include "apps/common/motion_options.h"
#include "apps/common/paths.h"
#include "apps/common/resimulate_session.h"
#include "apps/common/study_bar.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/recording/build_identity.h"
#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/recording/start_meta.h"
#include "raven2_trainer/render/session_renderer.h"

namespace raven2_trainer {
namespace {

struct Options {
  apps::CommonOptions common;
  apps::MotionOptions motion;
  double seconds{0.0};  ///< [s] of session time; 0: as long as it takes
  std::string output;
  std::string homing;        ///< the configuration's if empty
  double motion_scale{0.0};  ///< [-] the configuration's if 0
  std::string impairment{"none"};
  std::string replay;    ///< session that is shown first; empty: none
  std::string from_log;  ///< session that is simulated again; empty: none
  bool video{false};
};

void renderVideo(const TrainerConfig& config, const std::string& directory) {
  apps::StudyBar bar("video");
  render::SessionRenderer renderer(config, directory, recording::pictureIdentity());
  const std::uint64_t frames = renderer.run({}, [&](std::uint64_t done, std::uint64_t all) {
    bar.update(static_cast<double>(done) / static_cast<double>(all));
  });
  bar.done(std::to_string(frames) + " frames");
  for (const std::string& warning : renderer.warnings())
    std::fprintf(stderr, "simulate: %s\n", warning.c_str());
}

/** The recorded surgeon worked in another scene: by default the model's arms pass through ours. */
apps::CommonOptions common(const Options& options) {
  apps::CommonOptions result = options.common;
  if (result.arm_contacts.empty() && options.motion.motion.rfind("recording:", 0) == 0) result.arm_contacts = "off";
  return result;
}

/** As in the Python session that the commands are from. */
void prepareForCommands(const Options& options, TrainerConfig* config) {
  if (options.homing == "full" || !options.replay.empty())
    throw ConfigException(options.motion.motion + " begins with the first tick: without --homing full and --replay");
  config->virtual_raven.full_homing = false;
  config->runtime.plan_at = -1.0;  // the model moves as commanded alone
}

constexpr double kUsualSeconds = 30.0;
constexpr double kBeyondLimit = 60.0;  ///< [s] not counted by an exercise's timer: the time before the first touch, and pauses

lockstep::Lockstep::End endOf(const std::string& motion) {
  using End = lockstep::Lockstep::End;
  if (console::isCommanded(motion)) return End::kAtOnce;
  return console::doesExercise(motion) ? End::kFinished : End::kTime;
}

/** [s] Longest session. Commands, an expert or a clumsy surgeon end it sooner; beyond the time limit the attempt has
 * failed. */
double secondsOf(const Options& options, const TrainerConfig& config) {
  if (options.seconds > 0.0) return options.seconds;
  if (console::isCommanded(options.motion.motion)) return console::commandedSeconds(options.motion.motion);
  return console::doesExercise(options.motion.motion) ? config.exercise.time_limit + kBeyondLimit : kUsualSeconds;
}

/** A session that is killed has a start time, too. */
session::SessionMeta beginMeta(const session::SessionPaths& paths,
                               const std::string& motion,
                               const TrainerConfig& config) {
  session::SessionMeta meta = recording::startMeta("simulate", apps::version(), motion);
  meta.realtime = "unknown: not ended cleanly";
  session::writeMeta(paths, meta, config);
  return meta;
}

int simulate(const Options& options) {
  TrainerConfig config = common(options).load();
  if (!options.homing.empty()) config.virtual_raven.full_homing = options.homing == "full";
  if (options.motion_scale > 0.0) config.console.scale = options.motion_scale;
  if (console::isCommanded(options.motion.motion)) prepareForCommands(options, &config);
  const Impairment impairment = apps::impairmentByName(options.impairment, options.common.config);
  const double seconds = secondsOf(options, config);
  apps::TruthFile truth(options.motion.truth);
  auto surgeon = console::makeMotion(config, options.motion.choice(), truth.log());
  physics::initialiseOde();
  physics::attachOdeToThread();
  const session::SessionPaths paths = session::createSessionDirectory(options.output);
  const auto start = std::chrono::steady_clock::now();
  const std::string over = options.impairment == "none" ? "" : " over " + impairment.name;
  const std::string label = console::motionLabel(options.motion.motion) + over;
  lockstep::Lockstep lockstep(config, std::move(surgeon), paths, label);
  session::SessionMeta meta = beginMeta(paths, options.motion.motion + over, config);
  if (options.impairment != "none") lockstep.impair(impairment);
  if (!options.replay.empty()) lockstep.showFirst(options.replay);
  apps::ProgressBar bar("simulate");
  const bool complete = lockstep.run(
      seconds, [&](double share) { bar.update(share); }, endOf(options.motion.motion));
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  meta.wall_duration = wall.count();
  meta.realtime = "lockstep";
  session::writeMeta(paths, meta, config);
  truth.write();
  if (!complete) {
    bar.done("no pedal-down before the start time-out");
    return 1;
  }
  char text[160];
  const double simulated = static_cast<double>(lockstep.view().model.session_tick + 1) * kTickSeconds;
  std::snprintf(text, sizeof(text), "%.1f s in %.1f s (%.1f x real time), %s", simulated, wall.count(),
                simulated / wall.count(), paths.directory.c_str());
  bar.done(text);
  const bool scored = recording::finishSession(paths);
  if (options.video) renderVideo(config, paths.directory);
  return scored ? 0 : 1;
}

/** The log has all other settings: refuses options other than --output. */
void addFromLog(CLI::App* app, std::string* directory) {
  CLI::Option* from_log = app->add_option(
      "--from-log", *directory,
      "Simulate this session again and compare each tick bit for bit, as resimulate does (exit status 1: different); "
      "takes no other option but --output, which writes a session");
  for (CLI::Option* other : app->get_options()) {
    const std::string name = other->get_name();
    if (other != from_log && name != "--output" && name != "--help") from_log->excludes(other);
  }
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Runs a training session in one process, faster than real time, with the same result each time."};
  options.common.add(&app, /*with_ports=*/false);
  app.add_option("--seconds", options.seconds,
                 "Session time from the first pedal-down [s] (default: 30; with commands, expert and clumsy until they "
                 "have finished)")
      ->check(CLI::Range(0.001, 86400.0));
  options.motion.add(&app);
  app.add_option("--motion-scale", options.motion_scale,
                 "Motion scale of the master (default: the configuration's)")
      ->check(CLI::Range(0.001, 1.0));
  app.add_option("--output", options.output, "Session directory (default: sessions/<UTC stamp>)")->type_name("DIR");
  app.add_option("--homing", options.homing, "full: search the hard stops; quick: start with known joints (default: the configuration's)")
      ->check(CLI::IsMember({"full", "quick"}));
  app.add_option("--impair", options.impairment,
                 "Bad link between console and daemon: a name of config/impairments or FILE.yaml")
      ->capture_default_str();
  app.add_option("--replay", options.replay, "Replay this session first: its directory or its log")->type_name("DIR");
  app.add_flag("--video", options.video, "Render video.mp4 afterwards");
  addFromLog(&app, &options.from_log);
  return apps::runProgram(&app, argc, argv, [&] {
    return options.from_log.empty() ? simulate(options) : apps::resimulateSession(options.from_log, options.output);
  });
}
