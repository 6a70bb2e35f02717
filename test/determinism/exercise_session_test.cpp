#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "raven2_trainer/recording/resimulation.h"
#include "raven2_trainer/session/session_log.h"
#include "support/rig.h"

// Simulated surgeons do an exercise in lockstep. They see the scene and hold pedals through the bytes of the sockets.

namespace raven2_trainer::lockstep {
namespace {

/** Holds the pedal for so many ticks, then is finished. */
struct ShortHands : console::MotionSource {
  explicit ShortHands(int how_long) : left(how_long) {}
  console::Intent tick(const console::Senses&) override {
    console::Intent intent;
    intent.pedal = left-- > 0;
    intent.finished = !intent.pedal;
    return intent;
  }
  int left;
};

class ExerciseSession : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    folder_ = std::filesystem::temp_directory_path() / ("raven2_exercise_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static TrainerConfig configOf(const std::string& exercise, std::uint64_t seed = 1) {
    config::TrainingNames names;
    names.exercise = exercise;
    TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml", names);
    config.virtual_raven.full_homing = false;
    config.virtual_raven.homing_time = 0.3;
    config.hazard = "none";
    config.seed = seed;
    return config;
  }

  session::SessionPaths run(const std::string& name,
                            const TrainerConfig& config,
                            const console::MotionChoice& choice,
                            double seconds,
                            console::TruthLog* truth = nullptr) {
    const session::SessionPaths paths = session::createSessionDirectory((folder_ / name).string());
    Lockstep lockstep(config, console::makeMotion(config, choice, truth), paths, choice.motion);
    EXPECT_TRUE(lockstep.run(seconds, {}, Lockstep::End::kFinished));
    return paths;
  }

  static bool isSameAgain(const session::SessionPaths& paths) {
    const recording::ResimulationResult result =
        recording::Resimulation(recording::sessionConfig(paths), paths, "").run({});
    if (result.difference) ADD_FAILURE() << "tick " << result.difference->tick << ": " << result.difference->field;
    return result.ticks > 0 && !result.difference;
  }

  std::filesystem::path folder_;
};

TEST_F(ExerciseSession, AnExpertsIsTheSameFromTheSameSeedAndSimulatesAgain) {
  const TrainerConfig config = configOf("pick_hand_over_place");
  console::TruthLog truth, again;
  const session::SessionPaths paths = run("a", config, {"expert", {}}, 8.0, &truth);
  const std::string first = session::fileHash(paths.log());
  EXPECT_EQ(session::fileHash(run("b", config, {"expert", {}}, 8.0, &again).log()), first);
  EXPECT_NE(session::fileHash(run("c", configOf("pick_hand_over_place", 2), {"expert", {}}, 8.0).log()), first);
  EXPECT_TRUE(isSameAgain(paths));
  const session::LogHeader header = session::readLogHeader(paths.log());
  EXPECT_EQ(header.motion, "expert");
  EXPECT_EQ(header.exercise, "pick_hand_over_place");
  EXPECT_EQ(header.motion_scale, config.console.scale);
  ASSERT_GE(truth.events().size(), 2U) << "without sight the surgeon would not get beyond the first verb";
  ASSERT_EQ(truth.events().size(), again.events().size());
  EXPECT_EQ(truth.events().back().sequence, again.events().back().sequence);
}

TEST_F(ExerciseSession, PedalsOfScriptedHandsActAndAreRecorded) {
  const session::SessionPaths paths = run("camera", configOf("camera_clutch"), {"expert", {}}, 5.0);
  std::set<Mode> modes;
  std::vector<std::uint8_t> pressed;
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& r) { modes.insert(r.model.mode); };
  visitor.request = [&](const RequestRecord& r) {
    if (r.request.kind == RequestKind::kSetCameraPedal) pressed.push_back(r.request.enabled);
  };
  session::readLog(paths.log(), visitor);
  EXPECT_EQ(modes.count(Mode::kCameraMoving), 1U);
  ASSERT_GE(pressed.size(), 2U);
  EXPECT_EQ(pressed[0], 1);
  EXPECT_EQ(pressed[1], 0);
  EXPECT_TRUE(isSameAgain(paths));
}

TEST_F(ExerciseSession, EndsASecondAfterTheHandsAreFinishedIfThatIsAskedFor) {
  const TrainerConfig config = configOf("none");
  const auto length = [&](const std::string& name, Lockstep::End end) {
    const session::SessionPaths paths = session::createSessionDirectory((folder_ / name).string());
    Lockstep lockstep(config, std::make_unique<ShortHands>(500), paths, "short");
    EXPECT_TRUE(lockstep.run(2.5, {}, end));
    return lockstep.view().model.session_tick + 1;
  };
  EXPECT_EQ(length("time", Lockstep::End::kTime), 2500);
  EXPECT_NEAR(static_cast<double>(length("finished", Lockstep::End::kFinished)), 1500.0, 3.0);
}

TEST_F(ExerciseSession, AReactionStandsInTheTruthAndInTheLogAtTheSamePacket) {
  TrainerConfig config = configOf("none");
  config.hazard = "sudden_jump";
  raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump").first_tick = 1500;
  console::TruthLog truth;
  const session::SessionPaths paths = run("reaction", config, {"scripted", 0.4}, 5.0, &truth);
  const auto of = [&](const char* what) {
    const auto& events = truth.events();
    const auto event = std::find_if(events.begin(), events.end(), [what](const auto& e) { return e.what == what; });
    return event == events.end() ? 0U : event->sequence;
  };
  ASSERT_GT(of("felt"), 0U);
  ASSERT_EQ(of("pedal_up") - of("felt"), 400U);
  std::uint8_t before = 2, then = 2;
  session::LogVisitor visitor;
  visitor.command = [&](const CommandRecord& r) {
    if (r.command.sequence == of("pedal_up") - 1) before = r.command.pedal;
    if (r.command.sequence == of("pedal_up")) then = r.command.pedal;
  };
  session::readLog(paths.log(), visitor);
  EXPECT_EQ(before, 1);
  EXPECT_EQ(then, 0);
}

}  // namespace
}  // namespace raven2_trainer::lockstep
