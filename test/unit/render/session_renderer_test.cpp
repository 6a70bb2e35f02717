#include "raven2_trainer/render/session_renderer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include "plan_fixture.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/training/session_metrics.h"
#include "support/effort.h"

namespace raven2_trainer::render {
namespace {

constexpr Tick kBefore = 100;   // ticks before the first pedal down
constexpr Tick kTicks = 400;    // of a session: 12 frames at 30 Hz
constexpr Tick kLong = 10'000;  // of a session with parts: 8, 8 and 4 frames at 2 Hz

/** Options to draw with one process, independent of the number of cores. */
SessionRenderOptions drawnHere() {
  SessionRenderOptions options;
  options.processes = 1;
  return options;
}

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

  /** Records a log in which the arms always move. @param[in] picture fault of the session's ticks 100 to 300. */
  void record(bool with_pedal, bool with_plan = false, Tick ticks = kTicks, std::uint8_t picture = 0) {
    session::LogHeader header;
    header.scenarios = {"sudden_jump"};
    header.step_names = {{"lift", "hand_over"}};
    header.robot_urdf_hash = session::fileHash(config_.robot_urdf);
    header.scene_urdf_hash = session::fileHash(config_.scene_urdf);
    header.d4 = config_.arms.geometry.d4;
    header.tolerance = tolerance_ > 0.0 ? tolerance_ : config_.haptics.tolerance;
    session::LogWriter writer(path("session.rlog"), header);
    for (Tick t = 0; t < kBefore + ticks; ++t) {
      TickRecord tick;
      tick.model.tick = t;
      tick.model.session_tick = with_pedal && t >= kBefore ? t - kBefore : -1;
      for (const Arm arm : kArms) {
        ArmState& state = at(tick.model.arms, arm);
        state.q = config_.arms.geometry.home;
        state.q[kElbow] += 1e-3 * static_cast<double>(t % 500);
        state.p_BT = toArray(kinematics::forward(config_.arms.geometry, arm, state.q).p);
      }
      for (const Arm arm : kArms) {
        RobotArmState& state = at(tick.robot.arms, arm);
        state.q = at(tick.model.arms, arm).q;
        state.q[kShoulder] += robot_apart_;
        state.p_BT = toArray(kinematics::forward(config_.arms.geometry, arm, state.q).p);
      }
      if (robot_apart_ > 0.0) tick.robot.frame = 1;
      if (attempt_ > 0) {
        tick.model.exercise.attempt = attempt_;
        tick.model.exercise.status = ExerciseStatus::kDone;
      }
      tick.model.pedal = tick.model.session_tick >= 0 ? 1 : 0;
      if (t >= kBefore + 3000 && t < kBefore + 3300) tick.robot.active_fault = 1;
      if (t >= edge_first_ && t < edge_first_ + 100) {
        tick.model.mode = Mode::kTeleoperating;
        tick.model.arms[0].ik_status = static_cast<std::uint32_t>(kinematics::IkStatus::kClamped);
      }
      if (t == kBefore + 6000) {
        ExerciseEvent step;
        step.kind = ExerciseEventKind::kStepDone;
        step.track = 0;
        step.step = 1;
        writer.write(ExerciseRecord{t, step});
      }
      if (t >= kBefore + 100 && t < kBefore + 300) tick.model.faults.picture = picture;
      if (with_plan && t == kBefore + 50) writer.write(PlanRecord{t, makePlan(config_.arms.geometry, Arm::kGold), 0});
      if (t >= kBefore + 50) tick.model.guide_plan = kPlan;
      writer.write(tick);
    }
    writer.finish(SessionCounts{});
  }

  std::string path(const std::string& file) const { return (folder_ / file).string(); }

  /** Records a long session at two frames a second, as drawing takes most of these tests' time. */
  void recordLong(int fps = 2) {
    config_.render.video_fps = fps;
    record(true, false, kLong);
  }

  /** Draws until so many frames are done and then fails, like a render that was killed. */
  void drawUpTo(std::uint64_t frames, SessionRenderOptions options = drawnHere()) {
    SessionRenderer renderer(config_, folder_.string(), build_);
    EXPECT_THROW(renderer.run(options,
                              [&](std::uint64_t done, std::uint64_t) {
                                if (done >= frames) throw std::runtime_error("killed");
                              }),
                 std::runtime_error);
    EXPECT_FALSE(std::filesystem::exists(path("video.mp4"))) << "the video gets its name only when it is complete";
  }

  /** Draws the rest. @return frames that an earlier render had drawn. */
  std::uint64_t drawRest(const SessionRenderOptions& options = drawnHere()) {
    SessionRenderer renderer(config_, folder_.string(), build_);
    const auto frames = static_cast<std::uint64_t>(10 * config_.render.video_fps);
    std::uint64_t first = 0;
    EXPECT_EQ(renderer.run(options,
                           [&](std::uint64_t done, std::uint64_t all) {
                             if (first == 0) first = done;
                             EXPECT_EQ(all, frames);
                           }),
              frames);
    EXPECT_EQ(first, renderer.reused() > 0 ? renderer.reused() : 1U)
        << "the progress begins with the frames already drawn";
    EXPECT_FALSE(std::filesystem::exists(path("video.parts")));
    return renderer.reused();
  }

  /** Keeps a copy of a killed render's parts, which other renders use up. */
  void keepParts() { std::filesystem::rename(path("video.parts"), path("kept")); }
  void takeKeptParts() {
    std::filesystem::remove_all(path("video.parts"));
    std::filesystem::copy(path("kept"), path("video.parts"), std::filesystem::copy_options::recursive);
  }

  std::string hash() const { return session::fileHash(path("video.mp4")); }

  std::vector<std::filesystem::path> parts() const {
    std::vector<std::filesystem::path> out;
    for (const auto& entry : std::filesystem::directory_iterator(path("video.parts"))) {
      if (entry.path().extension() == ".mp4") out.push_back(entry.path());
    }
    std::sort(out.begin(), out.end());
    return out;
  }

  TrainerConfig config_;
  std::filesystem::path folder_;
  std::string build_{"a build"};
  double tolerance_{0.0};    // [m] of the session; 0: the configuration's
  double robot_apart_{0.0};  // [rad] of the robot's shoulders; 0: no robot
  std::int64_t attempt_{0};  // that is done; 0: none
  Tick edge_first_{-1000};   // first of 100 ticks in which a tool is at its edge; < 0: not in the session
};

std::string output(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 256> line{};
  std::string text;
  while (std::fgets(line.data(), line.size(), pipe) != nullptr)
    text += line.data();
  pclose(pipe);
  return text;
}

std::string countFrames(const std::string& video) {
  return output("ffprobe -v error -select_streams v -count_frames -show_entries stream=nb_read_frames -of csv=p=0 " +
                video);
}

/** Hashes and times of the decoded frames. */
std::string frameHashes(const std::string& video) {
  return output("ffmpeg -v error -i " + video + " -map 0:v -f framemd5 -");
}

TEST_F(SessionRendererTest, AWholeSessionGivesItsFramesAndSaysSoInTheMetrics) {
  record(true);
  training::writeMetrics(path("metrics.json"), training::computeMetrics(path("session.rlog")));
  SessionRenderer renderer(config_, folder_.string(), build_);
  std::uint64_t calls = 0, all = 0;
  EXPECT_EQ(renderer.run(drawnHere(),
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

TEST_F(SessionRendererTest, ARenderThatWasKilledGivesTheSameFileAndDrawsNothingTwice) {
  recordLong();
  EXPECT_EQ(drawRest(), 0U);
  const std::string whole = hash(), frames = frameHashes(path("video.mp4"));
  EXPECT_EQ(countFrames(path("video.mp4")), "20\n");
  struct Case {
    std::uint64_t killed, reused;
  };
  std::vector<Case> cases{{7, 0}, {9, 8}, {15, 8}, {17, 16}};  // just before and after the end of each part
  if (testing::isFull()) cases.insert(cases.end(), {{1, 0}, {19, 16}});
  for (const Case& c : cases) {
    std::filesystem::remove(path("video.mp4"));
    drawUpTo(c.killed);
    EXPECT_EQ(drawRest(), c.reused) << c.killed;
    EXPECT_EQ(hash(), whole) << c.killed;
  }
  EXPECT_EQ(frameHashes(path("video.mp4")), frames);
}

TEST_F(SessionRendererTest, ADamagedPartIsDrawnAgain) {
  recordLong();
  drawRest();
  const std::string whole = hash();
  std::filesystem::remove(path("video.mp4"));
  drawUpTo(19);
  keepParts();
  for (const bool is_cut : {false, true}) {
    std::filesystem::remove(path("video.mp4"));
    takeKeptParts();
    ASSERT_EQ(parts().size(), 2U);
    const auto size = std::filesystem::file_size(parts()[0]);
    if (is_cut) {
      std::filesystem::resize_file(parts()[0], size / 2);
    } else {
      std::fstream file(parts()[0], std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(static_cast<std::streamoff>(size / 2));
      const int byte = file.get();
      file.seekp(static_cast<std::streamoff>(size / 2));
      file.put(static_cast<char>(byte ^ 0x10));
    }
    EXPECT_EQ(drawRest(), 8U);
    EXPECT_EQ(hash(), whole);
  }
}

TEST_F(SessionRendererTest, PartsOfOtherSettingsAreDrawnAnew) {
  recordLong();
  drawUpTo(19);
  keepParts();
  const TrainerConfig config = config_;
  const std::string build = build_;
  // @return the frames that a render reuses after a change. The render is killed at its start.
  const auto change = [&](const std::function<void(SessionRenderOptions*)>& by) {
    takeKeptParts();
    SessionRenderOptions options = drawnHere();
    by(&options);
    SessionRenderer renderer(config_, folder_.string(), build_);
    std::uint64_t first = 0;
    EXPECT_THROW(renderer.run(options,
                              [&](std::uint64_t done, std::uint64_t) {
                                first = done;
                                throw std::runtime_error("killed");
                              }),
                 std::runtime_error);
    EXPECT_EQ(first, renderer.reused() > 0 ? renderer.reused() : 1U);
    config_ = config;
    build_ = build;
    return renderer.reused();
  };
  EXPECT_EQ(change([](SessionRenderOptions*) {}), 16U) << "nothing changed";
  EXPECT_EQ(change([](SessionRenderOptions* o) { o->camera = "top"; }), 0U);
  EXPECT_EQ(change([](SessionRenderOptions* o) { o->inset = "none"; }), 0U);
  EXPECT_EQ(change([&](SessionRenderOptions*) { build_ = "another"; }), 0U);
  EXPECT_EQ(change([](SessionRenderOptions* o) { o->overlays = OverlaySet(); }), 0U);
  EXPECT_EQ(change([&](SessionRenderOptions*) { config_.render.trails.duration += 1.0; }), 0U);
  EXPECT_EQ(change([&](SessionRenderOptions*) { config_.render.encoder_crf = 30; }), 0U);
  EXPECT_EQ(change([&](SessionRenderOptions*) { config_.render.video_width = 160; }), 0U);
  EXPECT_EQ(change([&](SessionRenderOptions*) { config_.render.cameras[0].eye_W[2] += 1e-9; }), 0U);
  EXPECT_EQ(change([&](SessionRenderOptions*) { edge_first_ = 400, recordLong(); }), 0U) << "another log";
}

TEST_F(SessionRendererTest, PartsOfAnEncoderThatLooksAheadAreJoinedAsWell) {
  recordLong(10);
  config_.render.encoder_preset = "veryfast";  // its frames refer to later ones
  drawRest();
  EXPECT_EQ(countFrames(path("video.mp4")), "100\n");
  const std::string times = output("ffprobe -v error -select_streams v -show_entries frame=pts_time -of csv=p=0 " +
                                   path("video.mp4") + " | tr -d ,");
  std::istringstream lines(times);
  double time = 0.0;
  int k = 0;
  for (; lines >> time; ++k)
    EXPECT_NEAR(time, 0.1 * k, 1e-4) << k;
  EXPECT_EQ(k, 100);
}

TEST_F(SessionRendererTest, AVideoHasChapters) {
  recordLong();
  drawRest();
  EXPECT_EQ(output("ffprobe -v error -show_chapters -show_entries chapter=start_time,end_time:chapter_tags=title -of "
                   "csv=p=0 " +
                   path("video.mp4")),
            "0.000000,3.000000,\"Beginning, Pedal down\"\n3.000000,3.300000,Hazard: sudden jump\n"
            "3.300000,6.000000,Hazard ends: sudden jump\n6.000000,10.000000,Step done: hand over\n");
}

TEST_F(SessionRendererTest, AToneSoundsWhereAToolIsAtItsEdgeAndAVideoWithoutHasNoSound) {
  const std::string streams = "ffprobe -v error -select_streams a -show_entries stream=codec_name -of csv=p=0 ";
  record(true);
  SessionRenderer(config_, folder_.string(), build_).run(drawnHere(), nullptr);
  EXPECT_EQ(output(streams + path("video.mp4")), "");
  edge_first_ = kBefore + 5000;
  recordLong();
  drawRest();
  EXPECT_EQ(output(streams + path("video.mp4")), "aac\n");
  EXPECT_EQ(countFrames(path("video.mp4")), "20\n");
  // [dB] loudest sample of a span: half a second around the tone, all before it, or all after it
  const auto loudest = [&](const std::string& span) {
    const std::string text = output("ffmpeg -nostdin " + span + " -i " + path("video.mp4") +
                                    " -map 0:a -af volumedetect -f null - 2>&1 | sed -n 's/.*max_volume: //p'");
    return std::stod(text);
  };
  EXPECT_GT(loudest("-ss 4.8 -t 0.5"), -15.0);
  EXPECT_LT(loudest("-ss 0 -t 4.8"), -50.0);
  EXPECT_LT(loudest("-ss 5.3 -t 4.5"), -50.0);
  const std::string first = hash();
  std::filesystem::remove(path("video.mp4"));
  drawUpTo(19);
  drawRest();
  EXPECT_EQ(hash(), first) << "the sound must repeat too";
}

TEST_F(SessionRendererTest, APartOfASessionBecomesPicturesThatDiffer) {
  record(true);
  SessionRenderOptions options = drawnHere();
  options.from = 0.1;
  options.to = 0.2;
  options.camera = "top";
  options.inset = "none";
  options.output = path("pictures");
  EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 3U);
  EXPECT_TRUE(std::filesystem::exists(path("pictures/frame_000002.png")));
  EXPECT_FALSE(std::filesystem::exists(path("pictures/frame_000003.png")));
  EXPECT_NE(session::fileHash(path("pictures/frame_000000.png")), session::fileHash(path("pictures/frame_000002.png")));
  EXPECT_FALSE(std::filesystem::exists(path("video.mp4")));
  EXPECT_FALSE(std::filesystem::exists(path("video.parts")));
}

TEST_F(SessionRendererTest, PicturesOfSeveralPartsAreNumberedThrough) {
  recordLong();
  SessionRenderOptions options = drawnHere();
  options.output = path("all");
  EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 20U);
  options.from = 4.5;
  options.to = 5.0;
  options.output = path("one");
  EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 1U);
  EXPECT_EQ(session::fileHash(path("all/frame_000009.png")), session::fileHash(path("one/frame_000000.png")));
  EXPECT_TRUE(std::filesystem::exists(path("all/frame_000019.png")));
  EXPECT_FALSE(std::filesystem::exists(path("all/frame_000020.png")));
}

TEST_F(SessionRendererTest, PicturesOfAnEarlierRenderAreRefusedOrReplaced) {
  record(true);
  SessionRenderOptions options = drawnHere();
  options.output = path("pictures");
  const auto draw = [&] { return SessionRenderer(config_, folder_.string(), build_).run(options, nullptr); };
  const auto isThere = [&](const std::string& file) { return std::filesystem::exists(path("pictures/" + file)); };
  EXPECT_EQ(draw(), 12U);
  for (const char* file : {"frame_one.png", "my_frame_000001.png", "notes.txt"})
    std::ofstream(path("pictures/") + file) << "somebody's own";
  std::ofstream(path("pictures/frame_000012.png.tmp")) << "half a pic";
  options.to = 0.1;
  EXPECT_THROW(draw(), RenderException);
  EXPECT_TRUE(isThere("frame_000011.png"));
  options.replace = true;
  options.camera = "cellar";
  EXPECT_THROW(draw(), ConfigException);
  EXPECT_TRUE(isThere("frame_000011.png")) << "a render that fails removes no picture";
  options.camera = "top";
  EXPECT_EQ(draw(), 3U);
  EXPECT_TRUE(isThere("frame_000002.png"));
  EXPECT_FALSE(isThere("frame_000003.png") || isThere("frame_000011.png") || isThere("frame_000012.png.tmp"));
  EXPECT_TRUE(isThere("frame_one.png") && isThere("my_frame_000001.png") && isThere("notes.txt"));
}

TEST_F(SessionRendererTest, APartShowsWhatTheWholeShowsThere) {
  const std::map<std::string, OverlayKind> cases{{"marks", OverlayKind::kTrails}, {"status", OverlayKind::kStatus}};
  constexpr auto kFrozen = static_cast<std::uint8_t>(PictureFault::kFrozen);
  record(true, false, kTicks, kFrozen);  // frozen from frame 3 to 8
  for (const auto& [name, overlay] : cases) {
    SessionRenderOptions options = drawnHere();
    options.inset = "none";
    options.camera = "gold_close";
    options.overlays = OverlaySet();
    options.overlays->add(overlay);
    options.output = path(name + "_whole");
    SessionRenderer(config_, folder_.string(), build_).run(options, nullptr);
    options.from = 0.2;
    options.output = path(name + "_part");
    EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 6U);
    for (const auto& [whole, part] : {std::pair{"6", "0"}, {"9", "3"}}) {
      EXPECT_EQ(session::fileHash(path(name + "_whole/frame_00000" + whole + ".png")),
                session::fileHash(path(name + "_part/frame_00000" + part + ".png")))
          << name << " " << whole;
    }
  }
  EXPECT_NE(session::fileHash(path("marks_whole/frame_000009.png")),
            session::fileHash(path("status_whole/frame_000009.png")));
}

TEST_F(SessionRendererTest, RenderingAgainGivesTheSamePictures) {
  record(true);
  SessionRenderOptions options = drawnHere();
  options.to = 0.1;
  for (const char* folder : {"one", "two"}) {
    options.output = path(folder);
    EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 3U);
  }
  for (const char* file : {"/frame_000000.png", "/frame_000002.png"}) {
    EXPECT_EQ(session::fileHash(path("one") + file), session::fileHash(path("two") + file));
  }
}

TEST_F(SessionRendererTest, APlanOfTheLogIsInThePicturesFromItsTickOn) {
  SessionRenderOptions options = drawnHere();
  options.to = 0.1;
  options.camera = "endoscope";
  for (const bool with_plan : {false, true}) {
    record(true, with_plan);
    options.output = path(with_plan ? "with" : "without");
    ASSERT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 3U);
  }
  const auto hash = [&](const char* picture) { return session::fileHash(path(picture)); };
  EXPECT_EQ(hash("with/frame_000000.png"), hash("without/frame_000000.png"));
  EXPECT_EQ(hash("with/frame_000001.png"), hash("without/frame_000001.png"));
  EXPECT_NE(hash("with/frame_000002.png"), hash("without/frame_000002.png"));
}

TEST_F(SessionRendererTest, ACornerViewIsThereIfItIsAskedForAndNotTheMainCamera) {
  record(true);
  const auto first = [&](const std::string& inset) {
    SessionRenderOptions options = drawnHere();
    options.to = 0.04;
    options.camera = "overview";
    options.inset = inset;
    options.replace = true;
    options.output = path("inset_" + inset);
    EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 1U);
    return session::fileHash(path("inset_" + inset + "/frame_000000.png"));
  };
  EXPECT_NE(first("endoscope"), first("none"));
  EXPECT_EQ(first("overview"), first("none"));
}

TEST_F(SessionRendererTest, TheResultOfItsAttemptIsInThePicture) {
  attempt_ = 2;
  config_.render.video_width = 640;  // smaller pictures have no room for it
  config_.render.video_height = 360;
  record(true);
  const auto first = [&](const std::string& name, const std::string& attempts) {
    std::ofstream(path("score.json")) << "{\"attempts\":[" << attempts << "]}";
    SessionRenderOptions options = drawnHere();
    options.to = 0.04;
    options.inset = "none";
    options.overlays = OverlaySet();
    options.overlays->add(OverlayKind::kTimer);
    options.output = path(name);
    EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 1U);
    return session::fileHash(path(name + "/frame_000000.png"));
  };
  const std::string none = first("none", "");
  EXPECT_NE(first("own", R"({"number":2,"passed":true,"composite":1.0})"), none);
  EXPECT_EQ(first("other", R"({"number":3,"passed":true,"composite":1.0})"), none);
}

TEST_F(SessionRendererTest, ItsGhostAppearsByTheToleranceOfTheSession) {
  robot_apart_ = 0.2;
  const auto first = [&](double tolerance, bool with_ghost) {
    tolerance_ = tolerance;
    record(true);
    SessionRenderOptions options = drawnHere();
    options.to = 0.04;
    options.inset = "none";
    options.replace = true;
    options.overlays = OverlaySet();
    if (with_ghost) options.overlays->add(OverlayKind::kGhost);
    options.output = path("ghost");
    EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 1U);
    return session::fileHash(path("ghost/frame_000000.png"));
  };
  EXPECT_NE(first(0.003, true), first(0.003, false));
  EXPECT_EQ(first(0.5, true), first(0.5, false));
}

TEST_F(SessionRendererTest, WithoutTheHazardsNameItShowsWhatTheTraineeSaw) {
  constexpr auto kBlack = static_cast<std::uint8_t>(PictureFault::kBlack);
  constexpr auto kFrozen = static_cast<std::uint8_t>(PictureFault::kFrozen);
  SessionRenderOptions options = drawnHere();
  options.inset = "none";
  options.overlays = OverlaySet();
  const auto pictures = [&](std::uint8_t picture, const std::string& folder) {
    record(true, false, kTicks, picture);
    options.output = path(folder);
    EXPECT_EQ(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), 12U);
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
  EXPECT_EQ(pictures(kFrozen, "told"), plain) << "with the hazard overlay the pictures show the real scene";
}

TEST_F(SessionRendererTest, SaysWhatCannotBeRendered) {
  EXPECT_THROW(SessionRenderer(config_, path("nowhere"), build_), SessionException);
  record(false);
  SessionRenderer renderer(config_, folder_.string(), build_);
  EXPECT_THROW(renderer.run(drawnHere(), nullptr), SessionException) << "a session without a pedal-down";
  record(true);
  SessionRenderOptions options = drawnHere();
  options.camera = "cellar";
  EXPECT_THROW(renderer.run(options, nullptr), ConfigException);
  options.camera = "top";
  options.from = 5.0;
  options.output = path("part.mp4");
  EXPECT_THROW(renderer.run(options, nullptr), SessionException);
  EXPECT_FALSE(std::filesystem::exists(path("part.mp4")));
}

TEST_F(SessionRendererTest, APartOfASessionIsNoVideoOfTheSession) {
  record(true);
  for (const auto& [from, to] : {std::pair{0.1, -1.0}, {0.0, 0.2}, {0.1, 0.2}}) {
    SessionRenderOptions options = drawnHere();
    options.from = from;
    options.to = to;
    EXPECT_THROW(checkOptions(options), ConfigException);
    EXPECT_THROW(SessionRenderer(config_, folder_.string(), build_).run(options, nullptr), ConfigException);
    EXPECT_FALSE(std::filesystem::exists(path("video.mp4")));
    options.output = path("part.mp4");
    EXPECT_NO_THROW(checkOptions(options));
  }
}

TEST_F(SessionRendererTest, AnOutputIsAVideoOrADirectory) {
  const auto refused = [&](const std::string& file) {
    SessionRenderOptions options;
    options.output = path(file);
    try {
      checkOptions(options);
    } catch (const ConfigException&) {
      return true;
    }
    return false;
  };
  std::filesystem::create_directories(path("tmp.4711"));
  std::filesystem::create_directories(path("folder.mp4"));
  for (const char* good :
       {"film.mp4", "pictures", "pictures/", "tmp.4711", "film.mkv/", "a.b/film.mp4", "a.b/pictures"})
    EXPECT_FALSE(refused(good)) << good;
  for (const char* bad : {"film.mkv", "film.mp4.bak", "frame.png", "film.MP4", "folder.mp4"})
    EXPECT_TRUE(refused(bad)) << bad;
}

TEST_F(SessionRendererTest, ASessionThatIsBeingRecordedIsRefused) {
  session::LogWriter writer(path("session.rlog"), session::LogHeader{});
  try {
    SessionRenderer(config_, folder_.string(), build_);
    FAIL() << "the log was accepted";
  } catch (const SessionException& e) {
    EXPECT_NE(std::string(e.what()).find("still being recorded"), std::string::npos) << e.what();
  }
  writer.finish(SessionCounts{});
  EXPECT_NO_THROW(SessionRenderer(config_, folder_.string(), build_)) << "the log is complete";
}

TEST_F(SessionRendererTest, AVideoSaysWhatItIs) {
  record(true);
  config_.render.video_camera = "overview";
  const auto tags = [](const std::string& video) {
    return output("ffprobe -v error -show_entries format_tags=title,description,comment -of default=nk=0:nw=1 " +
                  video);
  };
  SessionRenderer renderer(config_, folder_.string() + "/.", build_);
  renderer.run(drawnHere(), nullptr);
  const std::string told = tags(path("video.mp4"));
  EXPECT_NE(told.find("TAG:title=" + folder_.filename().string() + "\n"), std::string::npos) << told;
  EXPECT_NE(told.find("TAG:description=Camera overview, in the corner endoscope; 0.00 s to 0.40 s of the session\n"),
            std::string::npos)
      << told;
  EXPECT_NE(told.find("TAG:comment=raven2_trainer settings "), std::string::npos) << told;
  SessionRenderOptions options = drawnHere();
  options.camera = "top";
  options.inset = "none";
  options.from = 0.1;
  options.to = 0.2;
  options.output = path("part.mp4");
  renderer.run(options, nullptr);
  EXPECT_NE(tags(path("part.mp4")).find("TAG:description=Camera top; 0.10 s to 0.20 s of the session\n"),
            std::string::npos)
      << tags(path("part.mp4"));
}

TEST_F(SessionRendererTest, AVideoIsThereIfItIsOfTheseSettings) {
  record(true);
  const auto isThere = [&](const SessionRenderOptions& options = drawnHere()) {
    return SessionRenderer(config_, folder_.string(), build_).hasVideo(options);
  };
  EXPECT_FALSE(isThere());
  SessionRenderer(config_, folder_.string(), build_).run(drawnHere(), nullptr);
  EXPECT_TRUE(isThere());
  SessionRenderOptions options = drawnHere();
  options.processes = 2;
  EXPECT_TRUE(isThere(options)) << "the number of processes does not matter";
  options.camera = "overview";
  EXPECT_FALSE(isThere(options));
  options.camera = "cellar";
  EXPECT_THROW(isThere(options), ConfigException);
  options = drawnHere();
  options.output = path("another.mp4");
  EXPECT_FALSE(isThere(options)) << "the other file does not exist";
  build_ = "another";
  EXPECT_FALSE(isThere());
  build_ = "a build";
  EXPECT_TRUE(isThere());
  config_.render.video_width = 160;
  EXPECT_FALSE(isThere());
  config_.render.video_width = 128;
  std::filesystem::create_directories(path("video.parts"));
  EXPECT_FALSE(isThere()) << "parts in the folder mean that it must be drawn again";
  std::filesystem::remove(path("video.parts"));
  record(true, false, kTicks + 1);
  EXPECT_FALSE(isThere()) << "the video is of another log";
}

TEST_F(SessionRendererTest, WarnsIfTheDescriptionsHaveChangedSince) {
  record(true);
  SessionRenderOptions options = drawnHere();
  options.to = 0.04;
  options.output = path("pictures");
  SessionRenderer(config_, folder_.string(), build_).run(options, nullptr);
  config_.scene_urdf = config_.robot_urdf;
  options.replace = true;
  SessionRenderer renderer(config_, folder_.string(), build_);
  EXPECT_ANY_THROW(renderer.run(options, nullptr));
  ASSERT_EQ(renderer.warnings().size(), 1U);
  EXPECT_NE(renderer.warnings()[0].find("scene"), std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer::render
