#include "raven2_trainer/runtime/render_loop.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "render/frame_timeline.h"
#include "unit/render/plan_fixture.h"

namespace raven2_trainer::runtime {
namespace {

using Picture = std::vector<std::uint8_t>;

constexpr Tick kTick = 7000;

/** The render thread's body over a shared state that the test fills as the other threads would. */
class RenderLoopTest : public ::testing::Test {
 protected:
  RenderLoopTest()
      : config_(config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml")),
        raven_(model::loadRavenModel(config_)),
        scene_(model::loadSceneModel(config_)),
        shared_(std::make_unique<SharedState>()),
        loop_(config_, raven_, scene_, shared_.get(), [this](const LiveImage& image) {
          picture_ = image.rgb;
          is_view_ = image.is_view;
        }) {
    state_.tick = kTick;
    state_.session_tick = 0;
    for (ArmState& arm : state_.arms)
      arm.q = config_.arms.geometry.home;
    for (std::size_t i = 0; i < scene_.free_bodies.size(); ++i)
      state_.bodies[i] = toArray(scene_.X_WL[static_cast<std::size_t>(scene_.free_bodies[i])]);
  }

  Picture frame() {
    shared_->model.store(state_);
    loop_.frame();
    return picture_;
  }

  /** As the planner answers: the cell first, then the state of that tick. */
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
  RenderLoop loop_;
  ModelState state_;
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
  EXPECT_TRUE(is_view_) << "it is what is asked for";
  state_.view = 1;
  const Picture marked = frame();
  EXPECT_TRUE(is_view_) << "the camera was never heard";
  EXPECT_NE(marked, virtual_one);
  shared_->real_picture_ns.store(std::numeric_limits<std::int64_t>::max());  // heard until the end of time
  EXPECT_EQ(frame(), virtual_one);
  EXPECT_FALSE(is_view_) << "the camera's own are shown";
  state_.view = 0;
  frame();
  EXPECT_TRUE(is_view_);
}

TEST_F(RenderLoopTest, APictureHasTheTickAndTheTimeOfTheStateDrawn) {
  Tick tick = 0;
  std::int64_t time_ns = 0;
  RenderLoop loop(config_, raven_, scene_, shared_.get(), [&](const LiveImage& image) {
    tick = image.tick;
    time_ns = image.time_ns;
  });
  state_.time_ns = 123'456'789;
  shared_->model.store(state_);
  loop.frame();
  EXPECT_EQ(tick, kTick);
  EXPECT_EQ(time_ns, 123'456'789);
}

TEST_F(RenderLoopTest, FramesThatTakeTooLongMakeThePictureSmallerAndItsCameraWithIt) {
  TrainerConfig config = config_;
  config.render.live_fps = config.render.live_slowest = 120;
  std::vector<model::Camera> cameras;
  std::vector<std::size_t> sizes;
  RenderLoop loop(config, raven_, scene_, shared_.get(), [&](const LiveImage& image) {
    cameras.push_back(image.camera);
    sizes.push_back(image.rgb.size());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // longer than the 8 ms that there are
  });
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
  render::SceneBuilder builder(raven_, scene_, config_.haptics, &renderer);
  const model::Camera camera = model::makeCamera(findCamera(config_.render, config_.render.live_camera),
                                                 config_.render.live_width, config_.render.live_height);
  EXPECT_EQ(renderer.draw(builder.build(frames[0]), camera), live);
}

}  // namespace
}  // namespace raven2_trainer::runtime
