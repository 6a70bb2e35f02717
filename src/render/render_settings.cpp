#include "render/render_settings.h"

#include <sstream>

#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/session/session_directory.h"
#include "render/ffmpeg_process.h"

namespace raven2_trainer::render {

namespace {

void addFiles(const TrainerConfig& config, std::ostringstream* out) {
  std::vector<std::string> files = config.files;
  for (const std::string& urdf : {config.robot_urdf, config.scene_urdf}) {
    files.push_back(urdf);
    for (const std::string& mesh : model::meshFiles(urdf))
      files.push_back(mesh);
  }
  for (const std::string& file : files)
    *out << file << ' ' << session::fileHash(file) << '\n';
}

void add(const CameraConfig& camera, std::ostringstream* out) {
  *out << camera.name << ' ' << camera.vertical_fov;
  for (const Vec3* place : {&camera.eye_W, &camera.target_W, &camera.up_W}) {
    for (const double x : *place)
      *out << ' ' << x;
  }
  *out << '\n';
}

/** As it is in memory, where options may have changed it. Taken apart, so that a field that is new has to be added
 * here: without it the parts of two settings would be taken for those of one. */
void add(const RenderConfig& config, std::ostringstream* out) {
  const auto& [cameras, video_camera, live_camera, width, height, fps, live_width, live_height, live_fps, crf, preset,
               real_topic, real_stale_after] = config;
  for (const CameraConfig& camera : cameras)
    add(camera, out);
  *out << width << ' ' << height << ' ' << fps << ' ' << crf << ' ' << preset << '\n';
}

}  // namespace

std::string settingsHash(const TrainerConfig& config,
                         const SessionRenderOptions& options,
                         const std::string& camera,
                         const std::string& log,
                         std::size_t part_frames) {
  std::ostringstream out;
  out.precision(17);
  out << session::fileHash(log) << '\n' << options.build << '\n' << ffmpegVersion() << '\n';
  out << camera << ' ' << options.inset << ' ' << options.from << ' ' << options.to << ' ' << part_frames << '\n';
  add(config.render, &out);
  addFiles(config, &out);
  return session::textHash(out.str());
}

}  // namespace raven2_trainer::render
