#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "drill/drill.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/console/reactor.h"
#include "raven2_trainer/faults/arming.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/session_metrics.h"
#include "raven2_trainer/training/session_score.h"
#include "support/effort.h"

// Two simulated trainees meet the same drill. One releases the pedal 400 ms after the force or the ghost, the other
// does not. The score is compared with the first trainee's own record.

namespace raven2_trainer::testing {
namespace {

namespace fs = std::filesystem;

constexpr double kSeconds = 9.0;          // longest delay of these drills, plus 3 s for the response, plus a margin
constexpr double kAgreement = 5.0;        // [ms] between the measured reaction time and the truth
constexpr double kPicture = 1000.0 / 30;  // [ms] between two pictures: as exact as a ghost is seen (doc/scores.md)
constexpr double kReactionTime = 0.4;     // [s]

/** A recorded session of one trainee, with the trainee's own record. */
class Session {
 public:
  Session(const TrainerConfig& config, bool reacts) : config_(config) {
    physics::initialiseOde();
    physics::attachOdeToThread();
    static int count = 0;
    paths_ = session::createSessionDirectory(
        (fs::temp_directory_path() / ("raven2_drill_" + std::to_string(getpid()) + "_" + std::to_string(++count)))
            .string());
    auto source = console::makeMotion(config, "scripted");
    console::Reaction reaction;
    reaction.delay = kReactionTime;
    if (reacts) source = console::makeReacting(std::move(source), reaction, &truth_);
    lockstep::Lockstep lockstep(config, std::move(source), paths_, "scripted");
    ran_ = lockstep.run(kSeconds, {});
  }
  ~Session() { fs::remove_all(paths_.directory); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  bool ran() const { return ran_; }
  std::string log() const { return paths_.log(); }
  std::string directory() const { return paths_.directory; }

  training::SessionScore score() const {
    training::ScoreSettings settings;
    settings.motion.motion_scale = config_.console.scale;
    settings.motion.bodies = training::classifyBodies(session::readLogHeader(log()).body_names, {});
    settings.hand = config_.console;
    settings.response = training::ruleOf(config_.exercise.drill);
    return training::scoreSession(log(), settings);
  }

  /** [1 ms] session tick that used the packet of the trainee's first such action; -1 if there was no such action. */
  Tick tickOf(const std::string& what) const {
    for (const console::TruthEvent& event : truth_.events()) {
      if (event.what == what) return sessionTickOf(event.sequence);
    }
    return -1;
  }

 private:
  Tick sessionTickOf(std::uint32_t sequence) const {
    Tick used = -1, found = -1;
    session::LogVisitor visitor;
    visitor.command = [&](const CommandRecord& record) {
      if (record.command.sequence == sequence) used = record.tick;
    };
    visitor.tick = [&](const TickRecord& record) {
      if (record.model.tick == used) found = record.model.session_tick;
    };
    session::readLog(log(), visitor);
    return found;
  }

  const TrainerConfig config_;
  session::SessionPaths paths_;
  console::TruthLog truth_;
  bool ran_{false};
};

double milliseconds(Tick ticks) {
  return 1000.0 * kTickSeconds * static_cast<double>(ticks);
}

void expectTheTruth(const Session& session, const training::HazardScore& hazard) {
  const Tick felt = session.tickOf("felt"), up = session.tickOf("pedal_up");
  const Tick noticed = felt > 0 ? felt : session.tickOf("seen");
  const double agreement = felt > 0 ? kAgreement : kPicture;
  ASSERT_GT(noticed, 0);
  ASSERT_GT(up, 0);
  const training::HazardResponse& response = hazard.response;
  std::printf("  injection %lld, noticed %+lld, pedal up %+lld; truth: cue %+lld, %s %+lld, first %s %+lld\n",
              static_cast<long long>(hazard.injection), static_cast<long long>(noticed - hazard.injection),
              static_cast<long long>(up - hazard.injection), static_cast<long long>(response.cue_after),
              training::kResponseNames[static_cast<std::size_t>(response.reaction.response)],
              static_cast<long long>(response.reaction.after),
              training::kResponseNames[static_cast<std::size_t>(response.first.response)],
              static_cast<long long>(response.first.after));
  EXPECT_EQ(response.reaction.response, training::Response::kPedalUp);
  EXPECT_NEAR(milliseconds(hazard.injection + response.reaction.after), milliseconds(up), kAgreement);
  EXPECT_NEAR(milliseconds(response.reaction.after - response.cue_after), 1000.0 * kReactionTime, agreement);
  EXPECT_NEAR(milliseconds(hazard.injection + response.cue_after), milliseconds(noticed), agreement);
}

void compareTrainees(const std::string& exercise, const std::string& drill, std::uint64_t seed) {
  SCOPED_TRACE(exercise + ", " + drill + ", seed " + std::to_string(seed));
  const TrainerConfig config = drillConfig(exercise, drill, seed);
  const Session reacting(config, true), ignoring(config, false);
  ASSERT_TRUE(reacting.ran() && ignoring.ran());
  const training::SessionScore first = reacting.score(), second = ignoring.score();
  ASSERT_EQ(first.hazards.size(), 1U);
  ASSERT_EQ(second.hazards.size(), 1U);
  EXPECT_EQ(first.hazards[0].scenario, config.drill);
  EXPECT_EQ(first.hazards[0].injection, second.hazards[0].injection) << "the same seed gives the same drill";
  EXPECT_EQ(first.hazards[0].response.verdict, training::Verdict::kRight);
  const training::Verdict other = second.hazards[0].response.verdict;
  EXPECT_TRUE(other == training::Verdict::kWrong || other == training::Verdict::kNone)
      << training::kVerdictNames[static_cast<std::size_t>(other)];
  expectTheTruth(reacting, first.hazards[0]);
}

TEST(Trainees, WhoLetsGoIsRightAndWhoGoesOnIsNotAndTheReactionTimeIsTrue) {
  const std::uint64_t seeds = isFull() ? 20 : 1;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    compareTrainees("pick_hand_over_place", "own", seed);
    compareTrainees("retrieve_and_reach", "own", seed);
  }
}

TEST(Trainees, TheLogTellsTheDrillAndItsInjection) {
  const TrainerConfig config = drillConfig("pick_hand_over_place", "own", 3);
  const Session session(config, true);
  ASSERT_TRUE(session.ran());
  const session::LogHeader header = session::readLogHeader(session.log());
  EXPECT_EQ(header.exercise, "pick_hand_over_place");
  EXPECT_EQ(header.drill, "sudden_jump") << "the drill `own`, by the name of its scenario";
  EXPECT_EQ(header.hazard, "sudden_jump");
  EXPECT_EQ(header.trainee, "t01");
  const training::SessionMetrics metrics = training::computeMetrics(session.log());
  ASSERT_EQ(metrics.injections.size(), 1U);
  const training::Injection& injection = metrics.injections[0];
  EXPECT_EQ(injection.name, "sudden_jump");
  EXPECT_EQ(injection.fault.trigger, FaultTrigger::kStep);
  EXPECT_EQ(injection.fault.first_tick, faults::drillPlan(config, 1, 1).faults[0].first_tick);
  std::ostringstream text;
  text << std::ifstream(fs::path(session.directory()) / "faults.json").rdbuf();
  EXPECT_NE(text.str().find("\"sudden_jump\""), std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer::testing
