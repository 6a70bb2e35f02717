// render_session DIR: a recorded session as a video.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/paths.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/render/session_renderer.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace {

constexpr double kEstimateAfter = 2.0;  // [s] the first frames compile shaders and say nothing of the rest

struct Options {
  std::string directory, config, size;
  std::vector<std::string> overlays;
  int fps{0};
  raven2_trainer::render::SessionRenderOptions render;
};

void addOptions(CLI::App* app, Options* o) {
  app->add_option("DIR", o->directory, "Session directory: the one that holds session.rlog")->required();
  app->add_option("--camera", o->render.camera, "Camera of config/render.yaml (default: its video camera)");
  app->add_option("--inset", o->render.inset, "Camera of the small picture in the corner, or none")
      ->capture_default_str();
  app->add_option(
         "--overlay", o->overlays,
         "What is drawn over the scene, A,B,...: ghost, force_arrows, force_bars, hazard, plan, trails, workspace, "
         "timer, status, latency; or all, or none (default: config/render.yaml). Without hazard the video shows "
         "what the trainee saw while the picture was black, frozen or late")
      ->delimiter(',');
  app->add_option("--size", o->size, "Size of the picture, even numbers (default: config/render.yaml)")
      ->check(CLI::Validator(
          [](std::string& text) {
            int w = 0, h = 0, used = 0;
            const int read = std::sscanf(text.c_str(), "%4dx%4d%n", &w, &h, &used);
            const bool ok = read == 2 && used == static_cast<int>(text.size()) && w >= 64 && w <= 4096 && h >= 64 &&
                            h <= 4096 && w % 2 == 0 && h % 2 == 0;
            return ok ? std::string() : "must be WIDTHxHEIGHT, each even and in 64..4096";
          },
          "WxH"));
  app->add_option("--fps", o->fps, "Frames a second (default: config/render.yaml)")->check(CLI::Range(1, 120));
  app->add_option("--from", o->render.from, "Session time of the first frame [s]")->check(CLI::Range(0.0, 1e6));
  app->add_option("--to", o->render.to, "Session time of the end [s] (default: all)")->check(CLI::Range(0.0, 1e6));
  app->add_option("--output", o->render.output, "FILE.mp4, or a directory for PNG pictures (default: DIR/video.mp4)");
  app->add_option("--config", o->config, "Root configuration file (default: the packaged config/trainer.yaml)");
  app->add_option("--processes", o->render.processes, "Processes that draw side by side; 0 = one a core")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
}

raven2_trainer::TrainerConfig load(const Options& o) {
  namespace apps = raven2_trainer::apps;
  const std::string log = raven2_trainer::session::openSessionDirectory(o.directory).log();
  raven2_trainer::config::TrainingNames training;
  training.exercise = raven2_trainer::session::readLogHeader(log).exercise;  // it brings its scene along
  auto config =
      raven2_trainer::config::loadTrainerConfig(o.config.empty() ? apps::defaultConfigPath() : o.config, training);
  auto& render = config.render;
  if (!o.size.empty()) std::sscanf(o.size.c_str(), "%dx%d", &render.video_width, &render.video_height);
  if (o.fps > 0) render.video_fps = o.fps;
  return config;
}

int renderSession(const Options& o) {
  using Clock = std::chrono::steady_clock;
  raven2_trainer::render::SessionRenderOptions options = o.render;
  if (!o.overlays.empty()) options.overlays = raven2_trainer::config::overlaysOf(o.overlays);
  raven2_trainer::render::SessionRenderer renderer(load(o), o.directory);
  raven2_trainer::apps::ProgressBar bar("render");
  const Clock::time_point start = Clock::now();
  const auto progress = [&](std::uint64_t done, std::uint64_t all) {
    const double spent = std::chrono::duration<double>(Clock::now() - start).count();
    const double left = spent * static_cast<double>(all - done) / static_cast<double>(done);
    bar.update(static_cast<double>(done) / static_cast<double>(all),
               spent > kEstimateAfter ? std::to_string(static_cast<int>(left)) + " s left" : "");
  };
  const std::uint64_t frames = renderer.run(options, progress);
  bar.done(std::to_string(frames) + " frames in " +
           (o.render.output.empty() ? o.directory + "/video.mp4" : o.render.output));
  for (const std::string& warning : renderer.warnings())
    std::fprintf(stderr, "render_session: %s\n", warning.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Renders a recorded session into a video, from the first pedal down to the end.", "render_session"};
  app.footer(
      "A whole session gives round(duration x fps) frames; frame k shows the newest record at time k / fps.\n"
      "Needs no display and no graphics card; needs the program ffmpeg.\n"
      "Exit status: 0 written, 1 otherwise.");
  Options options;
  addOptions(&app, &options);
  return raven2_trainer::apps::runProgram(&app, argc, argv, [&] { return renderSession(options); });
}
