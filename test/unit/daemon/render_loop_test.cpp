#include "raven2_trainer/daemon/render_loop.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "render/frame_timeline.h"
#include "unit/render/plan_fixture.h"

namespace raven2_trainer::daemon {
namespace {

using Picture = std::vector<std::uint8_t>;

constexpr Tick kTick = 7000;

/** The render thread's body over a shared state that the test fills as the other threads would. */
class RenderLoopTest : public ::testing::Test {
 protected:
  RenderLoopTest()
      : config_(smallPictures()),
        raven_(model::loadRavenModel(config_)),
        scene_(model::loadSceneModel(config_)),
        shared_(std::make_unique<SharedState>()),
        loop_(
            config_,
            raven_,
            scene_,
            {},
            shared_.get(),
            [this](const LiveImage& image) { take(image); },
            [this] { return now_ns_; }) {
    watched_.live = 1;
    shared_->pictures_watched.store(watched_);
    state_.tick = kTick;
    state_.session_tick = 0;
    for (ArmState& arm : state_.arms)
      arm.q = config_.arms.geometry.home;
    for (std::size_t i = 0; i < scene_.free_bodies.size(); ++i)
      state_.bodies[i] = toArray(scene_.X_WL[static_cast<std::size_t>(scene_.free_bodies[i])]);
  }

  static TrainerConfig smallPictures() {
    static const TrainerConfig packaged = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
    TrainerConfig config = packaged;
    config.render.live_width /= 2;
    config.render.live_height /= 2;
    return config;
  }

  struct EyePicture {
    Viewpoint viewpoint;
    Picture rgb;
    model::Camera camera;
  };

  void take(const LiveImage& image) {
    ++drawn_;
    now_ns_ += takes_ns_;
    if (image.viewpoint != Viewpoint::kLive) return eyes_.push_back({image.viewpoint, image.rgb, image.camera});
    picture_ = image.rgb;
    is_view_ = image.is_view;
    camera_ = image.camera;
    tick_ = image.tick;
    time_ns_ = image.time_ns;
  }

  Picture frame() {
    eyes_.clear();
    shared_->model.store(state_);
    haptic_.tick = state_.tick;  // or the loop waits for it
    shared_->haptic.store(haptic_);
    shared_->pictures_watched.store(watched_);
    loop_.frame();
    return picture_;
  }

  void setPicture(PictureFault fault) { state_.faults.picture = static_cast<std::uint8_t>(fault); }

  /** Answers as the planner does: first the plan cell, then the state of that tick. */
  void answer(const PlanResult& plan, PlanningStatus status) {
    shared_->last_plan.store(plan);
    state_.planning.status = status;
    state_.planning.plan = plan.id;
    state_.planning.arm = plan.arm;
  }

  TrainerConfig config_;
  model::RavenModel raven_;
  model::SceneModel scene_;
  std::unique_ptr<SharedState> shared_;
  Picture picture_;
  bool is_view_{false};
  model::Camera camera_;
  Tick tick_{-1};
  std::int64_t time_ns_{-1};
  std::vector<EyePicture> eyes_;
  int drawn_{0};                            // pictures, those of the eyes included
  std::int64_t now_ns_{1'000'000'000'000};  // the loop's clock
  std::int64_t takes_ns_{0};                // each picture
  RenderLoop loop_;
  ModelState state_;
  HapticState haptic_;
  WatchedPictures watched_;
};

TEST_F(RenderLoopTest, APlanIsInTheLivePictureUntilItIsForgotten) {
  const Picture before = frame();
  EXPECT_EQ(frame(), before);
  answer(render::makePlan(config_.arms.geometry, Arm::kGreen), PlanningStatus::kReady);
  const Picture planned = frame();
  EXPECT_NE(planned, before);
  PlanResult refusal;
  refusal.id = render::kPlan + 1;
  refusal.status = PlanStatus::kCancelled;
  shared_->last_plan.store(refusal);
  EXPECT_EQ(frame(), planned) << "a refused request leaves the plan where it is";
  state_.planning = {};
  EXPECT_NE(frame(), planned);
}

TEST_F(RenderLoopTest, TheSameIdWithAnotherPathIsDrawnAnew) {
  PlanResult plan = render::makePlan(config_.arms.geometry, Arm::kGreen);
  answer(plan, PlanningStatus::kReady);
  const Picture first = frame();
  plan.waypoints[2][kInsertion] -= 0.04;
  answer(plan, PlanningStatus::kReady);
  EXPECT_NE(frame(), first);
}

TEST_F(RenderLoopTest, TheVirtualPictureStandsInForTheCamerasWhileThatIsSilentAndSaysSo) {
  const Picture virtual_one = frame();
  EXPECT_TRUE(is_view_) << "the virtual view is selected";
  state_.view = 1;
  const Picture marked = frame();
  EXPECT_TRUE(is_view_) << "no image has come from the camera";
  EXPECT_NE(marked, virtual_one);
  shared_->real_picture_ns.store(std::numeric_limits<std::int64_t>::max());  // never silent
  EXPECT_EQ(frame(), virtual_one);
  EXPECT_FALSE(is_view_) << "the camera's images are shown";
  state_.view = 0;
  frame();
  EXPECT_TRUE(is_view_);
}

TEST_F(RenderLoopTest, ThePictureAndItsCameraGoWithTheClutch) {
  ASSERT_EQ(config_.render.live_camera, "endoscope");
  const Picture before = frame();
  const Vector3 configured = camera_.X_WC.p;
  state_.camera = {{-0.1, -0.15, 0.2}, {0.0, 0.0, 0.035}, {0.0, 0.0, 1.0}};
  EXPECT_NE(frame(), before);
  EXPECT_LT((camera_.X_WC.p - Vector3(-0.1, -0.15, 0.2)).norm(), 1e-12);
  state_.camera = {};
  EXPECT_EQ(frame(), before);
  EXPECT_EQ((camera_.X_WC.p - configured).norm(), 0.0);
}

TEST_F(RenderLoopTest, BothEyesAreDrawnWhileSomebodyLooks) {
  frame();
  EXPECT_TRUE(eyes_.empty());
  watched_.stereo = 1;
  const Picture middle = frame();
  ASSERT_EQ(eyes_.size(), 2U);
  EXPECT_EQ(eyes_[0].viewpoint, Viewpoint::kLeftEye);
  EXPECT_EQ(eyes_[1].viewpoint, Viewpoint::kRightEye);
  const Vector3 apart_C = camera_.X_WC.R.transpose() * (eyes_[1].camera.X_WC.p - eyes_[0].camera.X_WC.p);
  EXPECT_LT((apart_C - Vector3(config_.render.stereo.baseline, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_NE(eyes_[0].rgb, eyes_[1].rgb);
  EXPECT_NE(eyes_[0].rgb, middle);
  watched_.stereo = 0;
  frame();
  EXPECT_TRUE(eyes_.empty());
}

TEST_F(RenderLoopTest, TheSecondCamerasPictureIsDrawnAtAThirdOfTheRateWhileSomebodyLooks) {
  ASSERT_EQ(config_.render.live_second, "overview");
  frame();
  watched_.second = 1;
  int drawn = 0;
  for (int i = 0; i < 9; ++i) {
    const Picture live = frame();
    drawn += static_cast<int>(eyes_.size());
    for (const EyePicture& picture : eyes_) {
      EXPECT_EQ(picture.viewpoint, Viewpoint::kSecond);
      EXPECT_NE(picture.rgb, live);
      const CameraConfig& overview = model::requireCamera(config_.render.cameras, "overview");
      EXPECT_EQ((picture.camera.X_WC.p - toEigen(overview.eye_W)).norm(), 0.0);
    }
  }
  EXPECT_EQ(drawn, 4) << "the first at once";
  watched_.second = 0;
  for (int i = 0; i < 3; ++i) {
    frame();
    EXPECT_TRUE(eyes_.empty());
  }
}

TEST_F(RenderLoopTest, TheSecondPictureMakesTheLiveOneNoSmaller) {
  watched_.second = 1;
  takes_ns_ = 20'000'000;  // two of them take longer than the period, 33 ms
  std::size_t drawn = 0;
  const std::int64_t begin = now_ns_;
  for (int i = 0; i < 300; ++i) {
    frame();
    drawn += eyes_.size();
  }
  EXPECT_EQ(shared_->live_picture.load().level, 0U);
  EXPECT_NEAR(static_cast<double>(drawn), static_cast<double>(now_ns_ - begin) * 1e-9, 1.0) << "one a second";
  watched_.stereo = 1;
  for (int i = 0; i < 300; ++i)
    frame();
  EXPECT_GT(shared_->live_picture.load().level, 0U);
}

TEST_F(RenderLoopTest, AViewerOfTheSecondCameraAloneCounts) {
  watched_ = {0, 0, 1};
  frame();
  EXPECT_EQ(shared_->live_picture.load().watched, 1);
  now_ns_ += 40'000'000;
  frame();
  EXPECT_EQ(shared_->live_picture.load().frames, 2U) << "more than one a second";
}

TEST_F(RenderLoopTest, AFrozenPictureGoesOnWithItsOldTickAndTime) {
  state_.time_ns = 5'000'000'000;
  const Picture last = frame();
  state_.tick += 33;
  state_.time_ns += 33'000'000;
  state_.arms[0].q[kElbow] += 0.2;
  setPicture(PictureFault::kFrozen);
  EXPECT_EQ(frame(), last);
  EXPECT_EQ(tick_, kTick);
  EXPECT_EQ(time_ns_, 5'000'000'000);
  setPicture(PictureFault::kNone);
  EXPECT_NE(frame(), last);
  EXPECT_EQ(tick_, kTick + 33);
  EXPECT_EQ(time_ns_, 5'033'000'000);
}

TEST_F(RenderLoopTest, WhichPictureIsTheViewGoesByNowThoughTheLastOneIsFrozen) {
  state_.view = 1;
  shared_->real_picture_ns.store(std::numeric_limits<std::int64_t>::max());  // never silent
  const Picture last = frame();
  EXPECT_FALSE(is_view_);
  state_.tick += 33;
  setPicture(PictureFault::kFrozen);
  state_.view = 0;
  EXPECT_EQ(frame(), last);
  EXPECT_TRUE(is_view_) << "it is selected, although it is old";
  EXPECT_EQ(tick_, kTick);
  state_.view = 1;
  frame();
  EXPECT_FALSE(is_view_) << "the camera's images are shown";
  shared_->real_picture_ns.store(0);
  EXPECT_NE(frame(), last) << "a frozen picture is also marked as not the selected one";
  EXPECT_TRUE(is_view_);
  EXPECT_EQ(tick_, kTick);
}

TEST_F(RenderLoopTest, WhichPictureIsTheViewGoesByNowThoughPicturesAreLate) {
  state_.view = 1;
  shared_->real_picture_ns.store(std::numeric_limits<std::int64_t>::max());
  frame();
  state_.tick += 33;
  state_.faults.picture_delay_ms = 2000;
  state_.view = 0;
  frame();
  EXPECT_TRUE(is_view_);
  EXPECT_EQ(tick_, kTick) << "the picture is late";
}

TEST_F(RenderLoopTest, ABlackPictureIsBlackForBothEyesAndTheViewToo) {
  const Picture seen = frame();
  setPicture(PictureFault::kBlack);
  watched_.stereo = 1;
  const Picture black = frame();
  EXPECT_EQ(black, Picture(seen.size(), 0));
  EXPECT_TRUE(is_view_);
  ASSERT_EQ(eyes_.size(), 2U);
  EXPECT_EQ(eyes_[0].rgb, black);
  setPicture(PictureFault::kNone);
  EXPECT_EQ(frame(), seen);
}

TEST_F(RenderLoopTest, EyesThatAreChangedOverKeepTheirNamesAndCameras) {
  watched_.stereo = 1;
  const Picture middle = frame();
  const std::vector<EyePicture> right_way = eyes_;
  setPicture(PictureFault::kEyesSwapped);
  EXPECT_EQ(frame(), middle);
  ASSERT_EQ(eyes_.size(), 2U);
  EXPECT_EQ(eyes_[0].rgb, right_way[1].rgb);
  EXPECT_EQ(eyes_[1].rgb, right_way[0].rgb);
  EXPECT_EQ((eyes_[0].camera.X_WC.p - right_way[0].camera.X_WC.p).norm(), 0.0);
}

TEST_F(RenderLoopTest, TheNameOfAFaultIsNotInTheTraineesPicture) {
  const Picture quiet = frame();
  state_.faults.active = 1;
  ASSERT_FALSE(config_.scenarios.empty());
  EXPECT_EQ(frame(), quiet);
}

TEST_F(RenderLoopTest, APictureHasTheTickAndTheTimeOfTheStateDrawn) {
  Tick tick = 0;
  std::int64_t time_ns = 0;
  RenderLoop loop(config_, raven_, scene_, {}, shared_.get(), [&](const LiveImage& image) {
    tick = image.tick;
    time_ns = image.time_ns;
  });
  state_.time_ns = 123'456'789;
  shared_->model.store(state_);
  loop.frame();
  EXPECT_EQ(tick, kTick);
  EXPECT_EQ(time_ns, 123'456'789);
}

TEST_F(RenderLoopTest, WhileNobodyLooksOneASecondIsDrawn) {
  watched_.live = 0;
  const auto run = [this](int frames) {
    for (int i = 0; i < frames; ++i) {
      frame();
      now_ns_ += 40'000'000;
    }
  };
  run(1);
  EXPECT_EQ(drawn_, 1) << "the first at once";
  run(249);
  EXPECT_EQ(drawn_, 10) << "one a second";
  EXPECT_EQ(shared_->live_picture.load().frames, 10U);
  EXPECT_EQ(shared_->frames.value(), 10U);
  EXPECT_EQ(shared_->live_picture.load().watched, 0);
  run(1);
  EXPECT_EQ(drawn_, 11);
  watched_.live = 1;
  run(1);
  EXPECT_EQ(drawn_, 12) << "the first for a new viewer, at once";
  run(25);
  EXPECT_EQ(drawn_, 37);
  EXPECT_EQ(shared_->live_picture.load().watched, 1);
  watched_.live = 0;
  run(1);
  EXPECT_EQ(drawn_, 37);
  watched_.stereo = 1;
  run(1);
  EXPECT_EQ(drawn_, 40) << "a viewer of both eyes counts";
}

/** The picture must not depend on earlier viewers. */
TEST_F(RenderLoopTest, WhatNobodyLookedAtIsKnownAllTheSame) {
  frame();
  watched_.live = 0;
  state_.tick += 400;
  state_.arms[0].q[kElbow] += 0.1;
  frame();
  ASSERT_EQ(drawn_, 1);
  state_.tick += 33;
  setPicture(PictureFault::kFrozen);
  watched_.live = 1;
  frame();
  EXPECT_EQ(tick_, kTick + 400) << "when it froze";
}

TEST_F(RenderLoopTest, PicturesThatNobodyLooksAtSayNothingOfTheirPace) {
  takes_ns_ = 200'000'000;
  watched_.live = 0;
  for (int i = 0; i < 100; ++i) {
    frame();
    now_ns_ += 1'000'000'000;
  }
  EXPECT_EQ(drawn_, 100);
  EXPECT_EQ(shared_->live_picture.load().level, 0U);
  watched_.live = 1;
  for (int i = 0; i < 5; ++i)
    frame();
  EXPECT_EQ(shared_->live_picture.load().level, 1U) << "the same load with a viewer";
}

TEST_F(RenderLoopTest, FramesThatTakeTooLongMakeThePictureSmallerAndItsCameraWithIt) {
  TrainerConfig config = config_;
  config.render.live_fps = config.render.live_slowest = 120;
  std::vector<model::Camera> cameras;
  std::vector<std::size_t> sizes;
  const auto show = [&](const LiveImage& image) {
    cameras.push_back(image.camera);
    sizes.push_back(image.rgb.size());
    now_ns_ += 20'000'000;  // longer than the 8 ms of a period
  };
  RenderLoop loop(config, raven_, scene_, {}, shared_.get(), show, [this] { return now_ns_; });
  shared_->model.store(state_);
  while (cameras.size() < 500 && shared_->live_picture.load().level < 2)
    loop.frame();
  loop.frame();
  const LivePicture told = shared_->live_picture.load();
  EXPECT_EQ(told.level, 2U);
  EXPECT_EQ(told.changes, 2U);
  EXPECT_EQ(told.frames, cameras.size());
  EXPECT_EQ(told.width, config.render.live_width / 2);
  EXPECT_EQ(told.height, config.render.live_height / 2);
  EXPECT_DOUBLE_EQ(loop.period(), 1.0 / 120.0);
  EXPECT_EQ(cameras.front().width, config.render.live_width);
  EXPECT_EQ(cameras.back().width, told.width);
  EXPECT_EQ(cameras.back().height, told.height);
  EXPECT_EQ(sizes.back(), static_cast<std::size_t>(told.width) * static_cast<std::size_t>(told.height) * 3);
  EXPECT_NEAR(cameras.back().fx, cameras.front().fx / 2, 1e-9) << "the same field of view";
  EXPECT_DOUBLE_EQ(cameras.back().cx, (told.width - 1) / 2.0);
}

/** Black pictures take no time. If they counted, the size would rise, and fall again with the next scene picture. */
TEST_F(RenderLoopTest, BlackPicturesSayNothingOfTheirPace) {
  takes_ns_ = 200'000'000;
  while (drawn_ < 100 && shared_->live_picture.load().level < 5)
    frame();
  ASSERT_EQ(shared_->live_picture.load().level, 5U);
  takes_ns_ = 0;
  setPicture(PictureFault::kBlack);
  constexpr int kFrames = 50;  // 5 s at 10 Hz; it goes up after 3
  for (int i = 0; i < kFrames; ++i)
    frame();
  EXPECT_EQ(shared_->live_picture.load().level, 5U);
  setPicture(PictureFault::kNone);
  for (int i = 0; i < kFrames; ++i)
    frame();
  EXPECT_LT(shared_->live_picture.load().level, 5U) << "the same load with visible pictures";
}

/** Drawing both eyes takes longer than the period. The live camera's picture takes far less. */
TEST_F(RenderLoopTest, TheEyesOfAPairAreCountedAndOfTheSameSize) {
  TrainerConfig config = config_;
  config.render.live_fps = config.render.live_slowest = 10;
  std::vector<model::Camera> cameras;
  const auto show = [&](const LiveImage& image) {
    if (image.viewpoint == Viewpoint::kLive) return;
    cameras.push_back(image.camera);
    now_ns_ += 60'000'000;
  };
  RenderLoop loop(config, raven_, scene_, {}, shared_.get(), show, [this] { return now_ns_; });
  watched_.stereo = 1;
  shared_->pictures_watched.store(watched_);
  shared_->model.store(state_);
  while (cameras.size() < 100 && shared_->live_picture.load().level < 1)
    loop.frame();
  loop.frame();
  const LivePicture told = shared_->live_picture.load();
  EXPECT_EQ(told.level, 1U);
  EXPECT_EQ(told.frames, cameras.size() / 2) << "both eyes count as one frame";
  ASSERT_GE(cameras.size(), 4U);
  for (const model::Camera& camera : {cameras[cameras.size() - 2], cameras.back()}) {
    EXPECT_EQ(camera.width, told.width);
    EXPECT_EQ(camera.height, told.height);
  }
  EXPECT_LT(told.width, config.render.live_width);
}

/** The renderer runs on a thread of the daemon: an exception that leaves it would end the process. */
TEST_F(RenderLoopTest, AnyExceptionEndsThePicturesAloneAndIsTold) {
  const std::vector<std::function<void()>> failures{
      [] { throw std::bad_alloc(); }, [] { throw std::runtime_error("of the subscriber to the pictures"); },
      [] { throw RenderException("ours"); }};
  for (const auto& fail : failures) {
    shared_->live_picture.store({});
    std::uint64_t shown = 0;
    const auto make = [&] {
      return std::make_unique<RenderLoop>(config_, raven_, scene_, std::vector<std::string>{}, shared_.get(),
                                          [&](const LiveImage&) {
                                            if (++shown > 2) fail();
                                          });
    };
    shared_->model.store(state_);
    int waits = 0;
    keepDrawing(
        make, [&](double) { return ++waits > 100; }, shared_.get());
    EXPECT_EQ(shown, 3U);
    EXPECT_EQ(shared_->live_picture.load().failed, 1);
    EXPECT_EQ(shared_->live_picture.load().frames, 2U) << "the earlier frames are still reported";
  }
}

TEST_F(RenderLoopTest, PicturesThatCannotBeBegunAreTold) {
  const auto make = []() -> std::unique_ptr<RenderLoop> { throw std::runtime_error("no OpenGL"); };
  keepDrawing(
      make, [](double) { return false; }, shared_.get());
  EXPECT_EQ(shared_->live_picture.load().failed, 1);
  EXPECT_EQ(shared_->live_picture.load().fps, 0);
}

TEST_F(RenderLoopTest, AnEndThatWasAskedForIsNoFailure) {
  std::uint64_t shown = 0;
  const auto make = [&] {
    return std::make_unique<RenderLoop>(config_, raven_, scene_, std::vector<std::string>{}, shared_.get(),
                                        [&](const LiveImage&) { ++shown; });
  };
  shared_->model.store(state_);
  std::vector<double> waits;
  const auto wait = [&](double seconds) {
    waits.push_back(seconds);
    return waits.size() > 2;
  };
  keepDrawing(make, wait, shared_.get());
  EXPECT_EQ(shown, 2U);
  EXPECT_EQ(shared_->live_picture.load().failed, 0);
  ASSERT_EQ(waits.size(), 3U);
  EXPECT_EQ(waits[0], 0.0) << "the first at once";
  for (const double seconds : waits) {
    EXPECT_GE(seconds, 0.0);
    EXPECT_LE(seconds, 1.0 / config_.render.live_fps);
  }
}

TEST_F(RenderLoopTest, TheRecordedPictureIsTheLiveOne) {
  const PlanResult plan = render::makePlan(config_.arms.geometry, Arm::kGold);
  const ExecutionReport report = render::makeReport(ExecutionEnd::kReleased, 0.4);
  answer(plan, PlanningStatus::kExecuting);
  state_.mode = Mode::kExecuting;
  state_.planning.progress = 0.6;
  state_.arms[0].q_d = plan.waypoints[1];
  shared_->last_execution.store(report);
  const Picture live = frame();

  render::FrameTimeline timeline(1000, 0.0, -1.0);
  timeline.add(PlanRecord{kTick, plan, 0});
  timeline.add(ExecutionRecord{kTick, report});
  timeline.add(TickRecord{state_, RobotState{}, 0});
  const std::vector<render::Snapshot> frames = timeline.frames({});
  ASSERT_EQ(frames.size(), 1U);
  render::Renderer renderer(config_.render.live_width, config_.render.live_height);
  render::SceneBuilder builder(raven_, scene_, render::SceneOptions(config_, config_.render.live_overlays), &renderer);
  const model::Camera camera =
      model::makeCamera(model::requireCamera(config_.render.cameras, config_.render.live_camera),
                        config_.render.live_width, config_.render.live_height);
  EXPECT_EQ(renderer.draw(builder.build(frames[0]), camera), live);
}

TEST_F(RenderLoopTest, TheCameraIsSilentOnceItsNewestPictureIsOlderThanConfigured) {
  state_.view = 1;
  for (const double share : {0.9, 1.1}) {
    const double age_ns = share * config_.render.real_stale_after * 1e9;
    shared_->real_picture_ns.store(now_ns_ - static_cast<std::int64_t>(age_ns));
    frame();
    EXPECT_EQ(is_view_, share > 1.0) << share;
  }
}

}  // namespace
}  // namespace raven2_trainer::daemon
