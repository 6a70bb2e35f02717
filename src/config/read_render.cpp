#include "config/readers.h"

#include <algorithm>
#include <utility>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

CameraConfig readCamera(Section& camera) {
  CameraConfig c;
  c.name = camera.text("name");
  c.eye_W = camera.vec3("eye_W", -10, 10);
  c.target_W = camera.vec3("target_W", -10, 10);
  c.up_W = camera.vec3("up_W", -1, 1);
  c.vertical_fov = camera.number("vertical_fov", 0.1, 2);
  c.moves = static_cast<CameraMoves>(camera.choice("moves", kCameraMovesNames));
  camera.finish();
  return c;
}

/** Puts both cameras of the pair behind those of the file. */
void readStereo(Section stereo, std::vector<std::string>* names, RenderConfig* c) {
  c->stereo.camera = stereo.text("camera", *names);
  c->stereo.baseline = stereo.number("baseline", 0.0005, 0.2);
  stereo.finish();
  const auto middle =
      static_cast<std::size_t>(std::find(names->begin(), names->end(), c->stereo.camera) - names->begin());
  for (const double side : {-0.5, 0.5}) {
    CameraConfig eye = c->cameras[middle];
    eye.name += side < 0.0 ? "_left" : "_right";
    if (std::find(names->begin(), names->end(), eye.name) != names->end())
      throw ConfigException(stereo.where("camera") + ": there is another camera called " + eye.name);
    eye.aside = side * c->stereo.baseline;
    names->push_back(eye.name);
    c->cameras.push_back(std::move(eye));
  }
}

OverlaySet readOverlays(Section* overlays, const std::string& key) {
  try {
    return overlaysOf(overlays->texts(key));
  } catch (const ConfigException& e) {
    throw ConfigException(overlays->where(key) + ": " + e.what());
  }
}

void readTrails(Section trails, RenderConfig* c) {
  c->trails.duration = trails.number("duration", 0.1, 60);
  c->trails.step = trails.number("step", c->trails.duration / 400.0, 10);
  trails.finish();
}

void readVideo(Section video, const std::vector<std::string>& names, RenderConfig* c) {
  c->video_camera = video.text("camera", names);
  c->video_width = static_cast<int>(video.integer("width", 64, 4096)) & ~1;
  c->video_height = static_cast<int>(video.integer("height", 64, 4096)) & ~1;
  c->video_fps = static_cast<int>(video.integer("fps", 1, 120));
  c->encoder_crf = static_cast<int>(video.integer("crf", 0, 51));
  c->encoder_preset = video.text("preset", {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"});
  video.finish();
}

void readLive(Section live, const std::vector<std::string>& names, RenderConfig* c) {
  c->live_camera = live.text("camera", names);
  // Earlier configurations, also those that sessions keep, do not name one.
  c->live_second = live.has("second") ? live.text("second", names) : c->live_camera;
  c->live_width = static_cast<int>(live.integer("width", 64, 4096));
  c->live_height = static_cast<int>(live.integer("height", 64, 4096));
  c->live_fps = static_cast<int>(live.integer("fps", 1, 120));
  c->live_slowest = static_cast<int>(live.integer("slowest", 1, 120));
  if (c->live_slowest > c->live_fps)
    throw ConfigException(live.where("slowest") + " is " + std::to_string(c->live_slowest) + ", above fps, " +
                          std::to_string(c->live_fps));
  c->live_smallest = live.number("smallest", 0.5, 1);
  c->live_settle = live.number("settle", 0.5, 60);
  c->live_jpeg_quality = static_cast<int>(live.integer("jpeg_quality", 1, 100));
  live.finish();
}

void readRealCamera(Section real, RenderConfig* c) {
  c->real_camera_topic = real.text("topic");
  if (c->real_camera_topic == "view/image_raw" || c->real_camera_topic == "/view/image_raw")
    throw ConfigException(real.where("topic") + " is " + c->real_camera_topic + ", where the view itself is shown");
  c->real_stale_after = real.number("stale_after", 0.05, 10);
  real.finish();
}

}  // namespace

void readRender(Section& root, RenderConfig* c) {
  std::vector<std::string> names;
  for (Section& camera : root.list("cameras")) {
    c->cameras.push_back(readCamera(camera));
    names.push_back(c->cameras.back().name);
  }
  if (names.empty()) throw ConfigException(root.where("cameras") + " is empty");
  readStereo(root.section("stereo"), &names, c);
  Section overlays = root.section("overlays");
  c->video_overlays = readOverlays(&overlays, "video");
  c->live_overlays = readOverlays(&overlays, "live");
  overlays.finish();
  readTrails(root.section("trails"), c);
  readVideo(root.section("video"), names, c);
  readLive(root.section("live"), names, c);
  readRealCamera(root.section("real_camera"), c);
}

}  // namespace raven2_trainer::config
