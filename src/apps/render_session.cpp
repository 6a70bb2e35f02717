// render_session DIR...: recorded sessions as videos.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/session_config.h"
#include "apps/common/study_bar.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/recording/build_identity.h"
#include "raven2_trainer/render/session_renderer.h"
#include "raven2_trainer/render/video_file.h"
#include "raven2_trainer/session/session_directory.h"

namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> directories, overlays;
  std::string config, size, build;
  int fps{0};
  bool again{false};
  raven2_trainer::render::SessionRenderOptions render;
};

/** @return what is wrong with a size; empty if nothing is. */
std::string checkSize(const std::string& text) {
  int w = 0, h = 0, used = 0;
  const int read = std::sscanf(text.c_str(), "%4dx%4d%n", &w, &h, &used);
  const bool ok = read == 2 && used == static_cast<int>(text.size()) && w >= 64 && w <= 4096 && h >= 64 && h <= 4096 &&
                  w % 2 == 0 && h % 2 == 0;
  return ok ? "" : "must be WIDTHxHEIGHT, each even and in 64..4096";
}

void addOptions(CLI::App* app, Options* o) {
  app->add_option("DIR", o->directories, "Session directories, each with session.rlog")->required();
  app->add_option("--camera", o->render.camera, "Camera of config/render.yaml (default: its video camera)");
  app->add_option(
      "--inset", o->render.inset,
      "Camera of the small picture in the corner, or none (default: overview; endoscope in the overview's picture)");
  app->add_option(
         "--overlay", o->overlays,
         "Overlays, A,B,...: ghost, force_arrows, force_bars, hazard, plan, trails, workspace, timer, status, latency; "
         "or all, or none (default: config/render.yaml). Without the overlay hazard the picture is what the "
         "trainee saw: black, frozen or late")
      ->delimiter(',');
  app->add_option("--size", o->size,
                  "Size of the picture: WIDTHxHEIGHT, each even and 64 to 4096 (default: config/render.yaml)")
      ->type_name("WxH")
      ->check(CLI::Validator(checkSize, ""));
  app->add_option("--fps", o->fps, "Frames per second (default: config/render.yaml)")->check(CLI::Range(1, 120));
  app->add_option("--from", o->render.from, "Session time of the first frame [s]; needs --output")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--to", o->render.to, "Session time of the end [s] (default: the session's end); needs --output")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--output", o->render.output,
                  "FILE.mp4, or a directory for PNG pictures; for one session (default: DIR/video.mp4)")
      ->type_name("FILE");
  app->add_flag("--again", o->again,
                "Render existing videos again; delete the pictures of an earlier render in --output");
  app->add_option("--config", o->config,
                  "Root configuration file (default: the session's own copy, and the packaged config/render.yaml)")
      ->type_name("FILE");
  constexpr int kMost = raven2_trainer::render::SessionRenderer::kMaxProcesses;
  app->add_option(
         "--processes", o->render.processes,
         "Processes that draw at the same time; 0: one for each processor, at most " +
             std::to_string(kMost))
      ->check(CLI::Range(0, kMost))
      ->capture_default_str();
}

raven2_trainer::TrainerConfig load(const Options& o, const std::string& directory) {
  const auto paths = raven2_trainer::session::openSessionDirectory(directory);
  auto config = raven2_trainer::apps::viewingConfig(paths, o.config);
  auto& render = config.render;
  if (!o.size.empty()) std::sscanf(o.size.c_str(), "%dx%d", &render.video_width, &render.video_height);
  if (o.fps > 0) render.video_fps = o.fps;
  return config;
}

/** Progress over the sessions that are drawn, by the size of their logs: how long each lasts is known only once it was
 * read. */
class Progress {
 public:
  explicit Progress(const std::vector<std::string>& directories) : bar_("render") {
    std::error_code error;
    for (const std::string& directory : directories) {
      const auto size = fs::file_size(raven2_trainer::session::SessionPaths{directory}.log(), error);
      sizes_.push_back(error ? 1.0 : 1.0 + static_cast<double>(size));  // never nothing: it is divided by
      all_ += sizes_.back();
    }
  }

  /** Of session `i`: shares done, and done without being drawn. */
  void update(std::size_t i, double share, double reused) {
    bar_.update((before_ + share * sizes_[i]) / all_, (found_ + reused * sizes_[i]) / all_);
  }

  /** Session `i` is over: `reused`, the share of it that was not drawn. */
  void end(std::size_t i, double reused, const std::string& what) {
    before_ += sizes_[i];
    found_ += reused * sizes_[i];
    bar_.done(what);
  }

 private:
  raven2_trainer::apps::StudyBar bar_;
  std::vector<double> sizes_;                   // [bytes]
  double all_{0.0}, before_{0.0}, found_{0.0};  // of all sessions; of those that are over; of that what took no time
};

/** Sessions that failed, each with the reason. */
using Failures = std::vector<std::string>;
using raven2_trainer::render::SessionRenderer;

std::string thereAlready(const SessionRenderer& renderer, const Options& o) {
  return renderer.outputOf(o.render) + " exists; --again draws it again";
}

void renderOne(const Options& o, const std::string& directory, std::size_t i, Progress* progress) {
  const auto config = load(o, directory);
  SessionRenderer renderer(config, directory, o.build);
  // Another process may have drawn it meanwhile.
  if (!o.again && renderer.hasVideo(o.render)) return progress->end(i, 1.0, thereAlready(renderer, o));
  double reused = 0.0;
  const std::uint64_t frames = renderer.run(o.render, [&](std::uint64_t done, std::uint64_t all) {
    const auto total = static_cast<double>(all);
    reused = static_cast<double>(renderer.reused()) / total;
    progress->update(i, static_cast<double>(done) / total, reused);
  });
  progress->end(i, reused,
                std::to_string(frames) + " frames in " + renderer.outputOf(o.render) +
                    (renderer.reused() > 0 ? ", " + std::to_string(renderer.reused()) + " of them drawn before" : ""));
  for (const std::string& warning : renderer.warnings())
    std::fprintf(stderr, "render_session: %s\n", warning.c_str());
}

/** Whether there is a video to be drawn of a session. */
bool isToBeDrawn(const Options& o, const std::string& directory) {
  const auto config = load(o, directory);
  const SessionRenderer renderer(config, directory, o.build);
  if (o.again) {
    raven2_trainer::render::markUnfinished(renderer.outputOf(o.render));  // a run without --again goes on with it
    return true;
  }
  if (!renderer.hasVideo(o.render)) return true;
  std::fprintf(stderr, "render: %s\n", thereAlready(renderer, o).c_str());
  return false;
}

/** Looks at the sessions first, so that the time left counts only videos to draw, and marks those that --again
 * replaces. */
std::vector<std::string> toBeDrawn(const Options& o, const std::vector<std::string>& directories, Failures* failures) {
  std::vector<std::string> out;
  for (const std::string& directory : directories) {
    try {
      if (isToBeDrawn(o, directory)) out.push_back(directory);
    } catch (const std::exception& e) {
      failures->push_back(directory + ": " + e.what());
    }
  }
  return out;
}

void drawAll(const Options& o, const std::vector<std::string>& directories, Failures* failures) {
  Progress progress(directories);
  for (std::size_t i = 0; i < directories.size(); ++i) {
    try {
      renderOne(o, directories[i], i, &progress);
    } catch (const std::exception& e) {
      progress.end(i, 1.0, directories[i] + " failed");
      failures->push_back(directories[i] + ": " + e.what());
    }
  }
}

/** Without plain files: a shell's `sessions/`* also matches sessions/index.json. */
std::vector<std::string> withoutFiles(const std::vector<std::string>& names) {
  std::vector<std::string> out;
  std::error_code error;
  for (const std::string& name : names) {
    if (names.size() == 1 || !fs::is_regular_file(name, error)) out.push_back(name);
  }
  return out;
}

int renderSessions(Options o) {
  o.build = raven2_trainer::recording::pictureIdentity();
  o.render.replace = o.again;
  if (!o.overlays.empty()) o.render.overlays = raven2_trainer::config::overlaysOf(o.overlays);
  raven2_trainer::render::checkOptions(o.render);
  const std::vector<std::string> directories = withoutFiles(o.directories);
  if (directories.size() > 1 && !o.render.output.empty())
    throw raven2_trainer::ConfigException("--output: takes one session; several have their video.mp4 each");
  if (directories.empty()) throw raven2_trainer::SessionException("no session directory among the arguments");
  Failures failures;
  drawAll(o, toBeDrawn(o, directories, &failures), &failures);
  for (const std::string& failure : failures)
    std::fprintf(stderr, "%s\n", failure.c_str());
  if (directories.size() > 1 && !failures.empty())
    std::fprintf(stderr, "render_session: %zu of %zu sessions failed\n", failures.size(), directories.size());
  return failures.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes a video of each recorded session, from the first pedal-down to the end.", "render_session"};
  app.footer(
      "A whole session gives round(duration x fps) frames; frame k shows the newest record at time k / fps.\n"
      "An existing video is kept if it is complete and of the same log, options, configuration and build. A killed\n"
      "render continues when it is started again, with or without --again; its parts are in video.parts.\n"
      "Refuses a session that is still being recorded. Needs ffmpeg, no display and no graphics card.\n"
      "Exit status: 0 all written, else failed; after a session that fails the others are rendered.");
  Options options;
  addOptions(&app, &options);
  return raven2_trainer::apps::runProgram(&app, argc, argv, [&] { return renderSessions(options); });
}
