#include "render/render_settings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {
namespace {

namespace fs = std::filesystem;

/** A session and its configuration, as files of a few words. Only their bytes count. */
class RenderSettingsTest : public ::testing::Test {
 protected:
  RenderSettingsTest() : folder_(fs::temp_directory_path() / ("render_settings_test_" + std::to_string(::getpid()))) {
    for (const char* name : {"urdf", "meshes", "config/faults", "config/plants"})
      fs::create_directories(folder_ / name);
    write("session.rlog", "a log");
    write("score.json", "a score");
    write("config/haptics.yaml", "stiffness: 1.0");
    write("config/faults/jump.yaml", "a fault");
    write("config/plants/nominal.yaml", "a plant");
    write("urdf/arm.urdf", "<mesh filename='package://raven2_trainer/meshes/link.stl'/>");
    write("urdf/scene.urdf", "<mesh filename='../meshes/ring.stl'/>");
    write("meshes/link.stl", "a link");
    write("meshes/ring.stl", "a ring");
    config_.files = {path("config/haptics.yaml"), path("config/faults/jump.yaml"), path("config/plants/nominal.yaml")};
    config_.robot_urdf = path("urdf/arm.urdf");
    config_.scene_urdf = path("urdf/scene.urdf");
    CameraConfig camera;
    camera.name = "top";
    camera.vertical_fov = 0.8;
    config_.render.cameras = {camera};
    config_.render.video_width = 128;
    config_.render.video_height = 72;
    config_.render.video_fps = 30;
    config_.render.encoder_crf = 20;
    config_.render.encoder_preset = "veryfast";
    config_.render.trails = {2.0, 0.1};
  }
  ~RenderSettingsTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& file) const { return (folder_ / file).string(); }
  void write(const std::string& file, const std::string& text) const { std::ofstream(path(file)) << text; }

  std::string hash() const {
    return settingsHash(config_, options_, camera_, session::SessionPaths{folder_.string()}, build_);
  }

  using Change = std::function<void()>;

  fs::path folder_;
  TrainerConfig config_;
  SessionRenderOptions options_;
  std::string camera_{"top"}, build_{"a build"};
};

TEST_F(RenderSettingsTest, IsAnotherWhereAnythingThatDecidesOverTheVideoChanges) {
  const std::map<std::string, Change> changes{
      {"log", [&] { write("session.rlog", "another"); }},
      {"score", [&] { write("score.json", "another"); }},
      {"no score", [&] { fs::remove(path("score.json")); }},
      {"a value of YAML", [&] { write("config/haptics.yaml", "stiffness: 1.1"); }},
      {"a file of YAML more", [&] { config_.files.push_back(path("config/haptics.yaml")); }},
      {"the robot's description", [&] { write("urdf/arm.urdf", "<mesh filename='../meshes/link.stl'/>"); }},
      {"the robot's mesh", [&] { write("meshes/link.stl", "another"); }},
      {"the scene's description", [&] { write("urdf/scene.urdf", "<mesh filename='../meshes/ring.stl' />"); }},
      {"the scene's mesh", [&] { write("meshes/ring.stl", "another"); }},
      {"build", [&] { build_ = "another"; }},
      {"camera", [&] { camera_ = "overview"; }},
      {"inset", [&] { options_.inset = "none"; }},
      {"from", [&] { options_.from = 0.1; }},
      {"to", [&] { options_.to = 7.0; }},
      {"overlays of an option", [&] { options_.overlays = OverlaySet(); }},
      {"other overlays of an option", [&] { options_.overlays = OverlaySet::all(); }},
      {"overlays", [&] { config_.render.video_overlays.add(OverlayKind::kTimer); }},
      {"trails' duration", [&] { config_.render.trails.duration = 3.0; }},
      {"trails' step", [&] { config_.render.trails.step = 0.2; }},
      {"frames a second", [&] { config_.render.video_fps = 29; }},
      {"width", [&] { config_.render.video_width = 130; }},
      {"height", [&] { config_.render.video_height = 74; }},
      {"quality", [&] { config_.render.encoder_crf = 21; }},
      {"preset", [&] { config_.render.encoder_preset = "fast"; }},
      {"a camera's place", [&] { config_.render.cameras[0].eye_W[2] += 1e-12; }},
      {"a camera's angle", [&] { config_.render.cameras[0].vertical_fov = 0.9; }},
      {"a camera's offset", [&] { config_.render.cameras[0].aside = 0.002; }},
      {"what moves a camera", [&] { config_.render.cameras[0].moves = static_cast<CameraMoves>(1); }},
  };
  std::map<std::string, std::string> seen{{hash(), "nothing"}};
  const TrainerConfig config = config_;
  for (const auto& [name, change] : changes) {
    change();
    const auto [place, is_new] = seen.emplace(hash(), name);
    EXPECT_TRUE(is_new) << name << " and " << place->second;
    // Take the change back.
    write("session.rlog", "a log");
    write("score.json", "a score");
    write("config/haptics.yaml", "stiffness: 1.0");
    write("urdf/arm.urdf", "<mesh filename='package://raven2_trainer/meshes/link.stl'/>");
    write("urdf/scene.urdf", "<mesh filename='../meshes/ring.stl'/>");
    write("meshes/link.stl", "a link");
    write("meshes/ring.stl", "a ring");
    config_ = config;
    options_ = SessionRenderOptions();
    camera_ = "top";
    build_ = "a build";
  }
  EXPECT_EQ(seen[hash()], "nothing") << "a change was not taken back";
}

TEST_F(RenderSettingsTest, IsTheSameWhereOnlyWhatDecidesOverNoPictureChanges) {
  const std::string before = hash();
  options_.processes = 3;
  options_.output = "elsewhere.mp4";
  options_.replace = true;
  EXPECT_EQ(hash(), before);
  config_.render.live_fps = 7;
  config_.render.live_camera = "overview";
  config_.render.live_second = "top";
  EXPECT_EQ(hash(), before);
  write("config/faults/jump.yaml", "another");
  write("config/plants/nominal.yaml", "another");
  EXPECT_EQ(hash(), before) << "the log contains their effect";
  config_.files.pop_back();
  EXPECT_EQ(hash(), before) << "the program decides which files it reads";
}

TEST_F(RenderSettingsTest, IsTheSameInAnotherPlace) {
  const std::string before = hash();
  const fs::path moved = folder_.string() + "_moved";
  fs::copy(folder_, moved, fs::copy_options::recursive);
  for (std::string& file : config_.files)
    file = (moved / fs::relative(file, folder_)).string();
  config_.robot_urdf = (moved / "urdf/arm.urdf").string();
  config_.scene_urdf = (moved / "urdf/scene.urdf").string();
  EXPECT_EQ(hash(), before);
  fs::remove_all(moved);
  EXPECT_THROW(hash(), SessionException) << "a missing file is an error";
}

}  // namespace
}  // namespace raven2_trainer::render
