#include "raven2_trainer/render/session_renderer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "plan_fixture.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::render {
namespace {

constexpr Tick kBefore = 100;  // ticks before the first pedal down
constexpr Tick kTicks = 400;   // of the session: 12 frames at 30 Hz

class SessionRendererTest : public ::testing::Test {
 protected:
  SessionRendererTest()
      : config_(config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml")),
        folder_(std::filesystem::temp_directory_path() / ("session_renderer_test_" + std::to_string(::getpid()))) {
    config_.render.video_width = 128;
    config_.render.video_height = 72;
    config_.render.video_fps = 30;
    std::filesystem::create_directories(folder_);
  }
  ~SessionRendererTest() override { std::filesystem::remove_all(folder_); }

  /** A log in which the arms move all the time. @param[in] picture of the ticks 100 to 300 of the session. */
  void record(bool with_pedal, bool with_plan = false, std::uint8_t picture = 0) {
    session::LogHeader header;
    header.robot_urdf_hash = session::fileHash(config_.robot_urdf);
    header.scene_urdf_hash = session::fileHash(config_.scene_urdf);
    header.d4 = config_.arms.geometry.d4;
    header.tolerance = config_.haptics.tolerance;
    session::LogWriter writer(path("session.rlog"), header);
    for (Tick t = 0; t < kBefore + kTicks; ++t) {
      TickRecord tick;
      tick.model.tick = t;
      tick.model.session_tick = with_pedal && t >= kBefore ? t - kBefore : -1;
      for (ArmState& arm : tick.model.arms) {
        arm.q = config_.arms.geometry.home;
        arm.q[kElbow] += 1e-3 * static_cast<double>(t);
      }
      if (t >= kBefore + 100 && t < kBefore + 300) tick.model.faults.picture = picture;
      if (with_plan && t == kBefore + 50) writer.write(PlanRecord{t, makePlan(config_.arms.geometry, Arm::kGold), 0});
      if (t >= kBefore + 50) tick.model.guide_plan = kPlan;
      writer.write(tick);
    }
    writer.finish(SessionCounts{});
  }

  std::string path(const std::string& file) const { return (folder_ / file).string(); }

  TrainerConfig config_;
  std::filesystem::path folder_;
};

std::string countFrames(const std::string& video) {
  const std::string command = "ffprobe -v error -count_frames -show_entries stream=nb_read_frames -of csv=p=0 " + video;
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 64> line{};
  const bool got = std::fgets(line.data(), line.size(), pipe) != nullptr;
  pclose(pipe);
  return got ? line.data() : "";
}

TEST_F(SessionRendererTest, AWholeSessionGivesItsFramesAndSaysSoInTheMetrics) {
  record(true);
  training::writeMetrics(path("metrics.json"), training::computeMetrics(path("session.rlog")));
  SessionRenderer renderer(config_, folder_.string());
  std::uint64_t calls = 0, all = 0;
  EXPECT_EQ(renderer.run({},
                         [&](std::uint64_t done, std::uint64_t total) {
                           EXPECT_EQ(done, ++calls);
                           all = total;
                         }),
            12U);
  EXPECT_EQ(calls, 12U);
  EXPECT_EQ(all, 12U);
  EXPECT_TRUE(renderer.warnings().empty());
  EXPECT_EQ(countFrames(path("video.mp4")), "12\n");
  std::ifstream file(path("metrics.json"));
  const std::string metrics((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_NE(metrics.find("\"frames\": 12"), std::string::npos) << metrics;
}

TEST_F(SessionRendererTest, APartOfASessionBecomesPicturesThatDiffer) {
  record(true);
  SessionRenderOptions options;
  options.from = 0.1;
  options.to = 0.2;
  options.camera = "top";
  options.inset = "none";
  options.output = path("pictures");
  EXPECT_EQ(SessionRenderer(config_, folder_.string()).run(options, nullptr), 3U);
  EXPECT_TRUE(std::filesystem::exists(path("pictures/frame_000002.png")));
  EXPECT_FALSE(std::filesystem::exists(path("pictures/frame_000003.png")));
  EXPECT_NE(session::fileHash(path("pictures/frame_000000.png")), session::fileHash(path("pictures/frame_000002.png")));
  EXPECT_FALSE(std::filesystem::exists(path("video.mp4")));
}

TEST_F(SessionRendererTest, RenderingAgainGivesTheSamePictures) {
  record(true);
  SessionRenderOptions options;
  options.to = 0.1;
  for (const char* folder : {"one", "two"}) {
    options.output = path(folder);
    EXPECT_EQ(SessionRenderer(config_, folder_.string()).run(options, nullptr), 3U);
  }
  for (const char* file : {"/frame_000000.png", "/frame_000002.png"}) {
    EXPECT_EQ(session::fileHash(path("one") + file), session::fileHash(path("two") + file));
  }
}

TEST_F(SessionRendererTest, APlanOfTheLogIsInThePicturesFromItsTickOn) {
  SessionRenderOptions options;
  options.to = 0.1;
  options.camera = "endoscope";
  for (const bool with_plan : {false, true}) {
    record(true, with_plan);
    options.output = path(with_plan ? "with" : "without");
    ASSERT_EQ(SessionRenderer(config_, folder_.string()).run(options, nullptr), 3U);
  }
  const auto hash = [&](const char* picture) { return session::fileHash(path(picture)); };
  EXPECT_EQ(hash("with/frame_000000.png"), hash("without/frame_000000.png"));
  EXPECT_EQ(hash("with/frame_000001.png"), hash("without/frame_000001.png"));
  EXPECT_NE(hash("with/frame_000002.png"), hash("without/frame_000002.png"));
}

TEST_F(SessionRendererTest, WithoutTheHazardsNameItShowsWhatTheTraineeSaw) {
  constexpr std::uint8_t kBlack = 1, kFrozen = 2;
  SessionRenderOptions options;
  options.inset = "none";
  options.overlays = OverlaySet();
  const auto pictures = [&](std::uint8_t picture, const std::string& folder) {
    record(true, false, picture);
    options.output = path(folder);
    EXPECT_EQ(SessionRenderer(config_, folder_.string()).run(options, nullptr), 12U);
    std::vector<std::string> hashes;
    for (int k = 0; k < 12; ++k) {
      std::array<char, 32> name{};
      std::snprintf(name.data(), name.size(), "/frame_%06d.png", k);
      hashes.push_back(session::fileHash(path(folder) + name.data()));
    }
    return hashes;
  };
  const auto plain = pictures(0, "plain"), frozen = pictures(kFrozen, "frozen"), black = pictures(kBlack, "black");
  for (std::size_t k = 0; k < 12; ++k) {
    const bool acts = k >= 3 && k < 9;  // frames at 100 ms up to 300 ms
    EXPECT_EQ(frozen[k], plain[acts ? 2 : k]) << k;
    EXPECT_EQ(black[k] == plain[k], !acts) << k;
    if (acts) {
      EXPECT_EQ(black[k], black[3]) << k;
    }
  }
  options.overlays->add(OverlayKind::kHazard);  // the log names no fault: no banner
  EXPECT_EQ(pictures(kFrozen, "told"), plain) << "what was there";
}

TEST_F(SessionRendererTest, SaysWhatCannotBeRendered) {
  EXPECT_THROW(SessionRenderer(config_, path("nowhere")), SessionException);
  record(false);
  SessionRenderer renderer(config_, folder_.string());
  EXPECT_THROW(renderer.run({}, nullptr), SessionException) << "the pedal was never down";
  record(true);
  SessionRenderOptions options;
  options.camera = "cellar";
  EXPECT_THROW(renderer.run(options, nullptr), ConfigException);
  options.camera = "top";
  options.from = 5.0;
  EXPECT_THROW(renderer.run(options, nullptr), SessionException);
}

TEST_F(SessionRendererTest, WarnsIfTheDescriptionsHaveChangedSince) {
  record(true);
  SessionRenderOptions options;
  options.to = 0.04;
  options.output = path("pictures");
  SessionRenderer(config_, folder_.string()).run(options, nullptr);
  config_.scene_urdf = config_.robot_urdf;
  SessionRenderer renderer(config_, folder_.string());
  EXPECT_ANY_THROW(renderer.run(options, nullptr));
  ASSERT_EQ(renderer.warnings().size(), 1U);
  EXPECT_NE(renderer.warnings()[0].find("scene"), std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer::render
