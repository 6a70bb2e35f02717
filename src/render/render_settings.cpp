#include "render/render_settings.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <vector>

#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/session/session_directory.h"
#include "render/ffmpeg_process.h"

namespace raven2_trainer::render {

namespace {

namespace fs = std::filesystem;

/** Folders of config/ whose files decide over what happens, and over no picture of what happened. Programs
 * read different ones of them: the same video would have two hashes. */
constexpr std::array<const char*, 5> kNotOfPictures{"bands", "curricula", "faults", "impairments", "plants"};

bool isOfPictures(const std::string& file) {
  const std::string folder = fs::path(file).parent_path().filename().string();
  return std::find(kNotOfPictures.begin(), kNotOfPictures.end(), folder) == kNotOfPictures.end();
}

void addFiles(const PictureConfig& config, std::ostringstream* out) {
  std::vector<std::string> files;
  std::copy_if(config.files.begin(), config.files.end(), std::back_inserter(files), isOfPictures);
  for (const std::string& urdf : {config.source.robot_urdf, config.source.scene_urdf}) {
    files.push_back(urdf);
    for (const std::string& mesh : model::meshFiles(urdf))
      files.push_back(mesh);
  }
  for (const std::string& file : files)
    *out << fs::path(file).filename().string() << ' ' << session::fileHash(file) << '\n';
}

void add(const CameraConfig& camera, std::ostringstream* out) {
  *out << camera.name << ' ' << camera.vertical_fov << ' ' << static_cast<int>(camera.moves) << ' ' << camera.aside;
  for (const Vec3* place : {&camera.eye_W, &camera.target_W, &camera.up_W}) {
    for (const double x : *place)
      *out << ' ' << x;
  }
  *out << '\n';
}

void add(OverlaySet overlays, std::ostringstream* out) {
  for (std::size_t kind = 0; kind < kOverlayCount; ++kind)
    *out << (overlays.has(static_cast<OverlayKind>(kind)) ? '1' : '0');
  *out << '\n';
}

/** As it is in memory, where options may have changed it. Taken apart, so that a field that is new has to be added
 * here: without it the parts of two settings would be taken for those of one. */
void add(const RenderConfig& config, std::ostringstream* out) {
  const auto& [cameras, stereo, video_overlays, live_overlays, trails, video_camera, live_camera, live_second, width,
               height, fps, live_width, live_height, live_fps, live_slowest, live_smallest, live_settle,
               live_jpeg_quality, crf, preset, real_topic, real_stale_after] = config;
  for (const CameraConfig& camera : cameras)  // the stereo pair among them
    add(camera, out);
  add(video_overlays, out);
  *out << trails.duration << ' ' << trails.step << '\n';
  *out << width << ' ' << height << ' ' << fps << ' ' << crf << ' ' << preset << '\n';
}

}  // namespace

std::string settingsHash(const PictureConfig& config,
                         const SessionRenderOptions& options,
                         const std::string& camera,
                         const session::SessionPaths& paths,
                         const std::string& build) {
  std::ostringstream out;
  out.precision(17);
  out << session::fileHash(paths.log()) << '\n';
  if (fs::exists(paths.score())) out << session::fileHash(paths.score()) << '\n';  // the timer's verdict
  out << build << '\n' << ffmpegVersion() << '\n';
  out << camera << ' ' << options.inset << ' ' << options.from << ' ' << options.to << ' '
      << SessionRenderer::kPartSeconds << '\n';
  if (options.overlays) add(*options.overlays, &out);
  add(config.render, &out);
  addFiles(config, &out);
  return session::textHash(out.str());
}

}  // namespace raven2_trainer::render
