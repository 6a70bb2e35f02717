#include "raven2_trainer/training/session_score.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "gtest/gtest.h"
#include "motion_support.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/pedals.h"

namespace raven2_trainer::training {
namespace {

namespace fs = std::filesystem;
constexpr double kScale = 0.1;

session::LogHeader makeHeader() {
  session::LogHeader header;
  header.scenarios = {"sudden_jump"};
  header.tolerance = 0.003;
  header.body_names = {"grasper1_L", "tower_far_left"};
  header.exercise = "peg_transfer";
  header.step_names = {{"lift", "place"}};
  return header;
}

ScoreSettings makeSettings() {
  ScoreSettings settings;
  settings.motion.motion_scale = kScale;
  settings.motion.bodies = classifyBodies(makeHeader().body_names, {});
  settings.hand.hand_mass = 0.3;
  settings.hand.hand_stiffness = 300.0;
  settings.hand.hand_damping = 17.0;
  return settings;
}

/** A log that a test writes and scores. */
class SessionScoreTest : public ::testing::Test {
 protected:
  SessionScoreTest() { fs::create_directories(folder_); }
  ~SessionScoreTest() override { fs::remove_all(folder_); }
  SessionScoreTest(const SessionScoreTest&) = delete;
  SessionScoreTest& operator=(const SessionScoreTest&) = delete;

  std::string log() const { return (folder_ / "session.rlog").string(); }
  void begin(const session::LogHeader& header = makeHeader()) {
    writer_ = std::make_unique<session::LogWriter>(log(), header);
  }
  SessionScore finish(const ScoreSettings& settings = makeSettings()) {
    writer_->finish({});
    writer_.reset();
    return scoreSession(log(), settings);
  }
  std::string write(const SessionScore& score, const ScoreSettings& settings) const {
    const std::string path = (folder_ / "score.json").string();
    writeScore(path, score, settings);
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  fs::path folder_{fs::temp_directory_path() / ("score_test_" + std::to_string(::getpid()))};
  std::unique_ptr<session::LogWriter> writer_;
};

TEST_F(SessionScoreTest, WithoutAnExerciseTheWholeSessionIsOneAttemptWithoutAVerdict) {
  begin();
  for (Tick k = -500; k < 3000; ++k) {
    TickRecord record = makeRecord(k, {1e-5 * static_cast<double>(k), 0.0, 0.0});
    if (k < 0) record.model.session_tick = -1;
    if (k >= 1000 && k < 1500) record.model.mode = Mode::kPaused;
    writer_->write(record);
  }
  const SessionScore score = finish();
  ASSERT_EQ(score.attempts.size(), 1u);
  EXPECT_EQ(score.attempts[0].motion.ticks, 2500);
  EXPECT_EQ(score.attempts[0].outcome.status, ExerciseStatus::kNone);
  EXPECT_EQ(score.attempts[0].outcome.first, 0);
  EXPECT_EQ(score.attempts[0].outcome.last, 2999);
  EXPECT_FALSE(score.attempts[0].passed);
  EXPECT_NEAR(at(score.attempts[0].motion.hands, Arm::kGold).path, 0.01 + 0.015, 3e-4);
  EXPECT_TRUE(score.hazards.empty());
}

TEST_F(SessionScoreTest, VerdictsAreReadAsTheyWereWritten) {
  SessionScore score;
  score.attempts.resize(3);
  score.histories.resize(3);
  for (std::size_t i = 0; i < 3; ++i)
    score.attempts[i].outcome.number = static_cast<std::int64_t>(i) + 1;
  score.attempts[0].passed = false;
  score.attempts[0].composite = 0.25;
  score.attempts[2].passed = true;
  score.attempts[2].composite = 1.0;
  write(score, makeSettings());
  const std::string path = (folder_ / "score.json").string();
  const auto verdicts = readVerdicts(path);
  ASSERT_EQ(verdicts.size(), 3u);
  EXPECT_EQ(verdicts.at(1).passed, std::optional<bool>(false));
  EXPECT_EQ(verdicts.at(1).composite, std::optional<double>(0.25));
  EXPECT_FALSE(verdicts.at(2).passed || verdicts.at(2).composite) << "without a band";
  EXPECT_EQ(verdicts.at(3).passed, std::optional<bool>(true));
  std::ofstream(path) << R"({"attempts": [{"number": "one"}]})";
  EXPECT_THROW(readVerdicts(path), SessionException);
  EXPECT_THROW(readVerdicts(path + ".none"), SessionException);
}

TickRecord makeExerciseTick(Tick k, std::uint8_t attempt, ExerciseStatus status) {
  TickRecord record = makeRecord(k);
  record.model.exercise.attempt = attempt;
  record.model.exercise.status = status;
  record.model.exercise.step = 1;
  return record;
}

/** [first, last) of an attempt. */
void writeTicks(session::LogWriter* writer, Tick first, Tick last, std::uint8_t attempt, ExerciseStatus status) {
  for (Tick k = first; k < last; ++k)
    writer->write(makeExerciseTick(k, attempt, status));
}

/** [first, last) of the first attempt, which broke something off, with one mistake. */
void writeFailedTicks(session::LogWriter* writer, Tick first, Tick last, Mistake mistake) {
  for (Tick k = first; k < last; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kFailed);
    record.model.exercise.failure = ExerciseFailure::kBrokeOff;
    record.model.exercise.mistakes[static_cast<std::size_t>(mistake)] = 1;
    writer->write(record);
  }
}

ExerciseRecord makeEvent(Tick k, ExerciseEventKind kind) {
  ExerciseRecord record;
  record.tick = kFirstTick + k;
  record.event.kind = kind;
  return record;
}

TEST_F(SessionScoreTest, ScoresEachAttemptAtAnExercise) {
  begin();
  for (Tick k = 0; k < 100; ++k)
    writer_->write(makeRecord(k));  // before the first attempt
  writeTicks(writer_.get(), 100, 300, 1, ExerciseStatus::kWaiting);
  for (Tick k = 300; k < 1300; ++k) {
    if (k == 800) writer_->write(makeEvent(k, ExerciseEventKind::kMistake));
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.model.exercise.mistakes[static_cast<std::size_t>(Mistake::kWireTouch)] = k >= 800 ? 1 : 0;
    writer_->write(record);
  }
  writeFailedTicks(writer_.get(), 1300, 1400, Mistake::kWireTouch);
  writeTicks(writer_.get(), 1400, 3400, 2, ExerciseStatus::kRunning);
  ExerciseRecord step = makeEvent(3400, ExerciseEventKind::kStepDone);
  step.event.track = 0;
  step.event.step = 1;
  writer_->write(step);
  TickRecord done = makeExerciseTick(3400, 2, ExerciseStatus::kDone);
  done.model.exercise.step = 3;
  writer_->write(done);
  const SessionScore score = finish();
  ASSERT_EQ(score.attempts.size(), 2u);
  const AttemptOutcome& first = score.attempts[0].outcome;
  EXPECT_EQ(first.number, 1);
  EXPECT_EQ(first.status, ExerciseStatus::kFailed);
  EXPECT_EQ(first.failure, ExerciseFailure::kBrokeOff);
  EXPECT_EQ(first.first, 300);
  EXPECT_EQ(first.last, 1299);
  EXPECT_EQ(score.attempts[0].motion.ticks, 1000);
  EXPECT_EQ(first.mistakes[static_cast<std::size_t>(Mistake::kWireTouch)], 1u);
  ASSERT_EQ(score.histories[0].mistakes.size(), 1u);
  EXPECT_EQ(score.histories[0].mistakes[0].name, "wire_touch");
  EXPECT_NEAR(score.histories[0].mistakes[0].at, 0.5, 1e-9);
  EXPECT_EQ(score.attempts[1].outcome.status, ExerciseStatus::kDone);
  EXPECT_EQ(score.attempts[1].outcome.steps, 2u);
  EXPECT_NEAR(score.attempts[1].motion.duration, 2.0, 1e-12);
  ASSERT_EQ(score.histories[1].steps.size(), 1u);
  EXPECT_EQ(score.histories[1].steps[0].name, "place");
  EXPECT_NEAR(score.histories[1].steps[0].at, 2.0, 1e-9);
}

TEST_F(SessionScoreTest, AStepHasItsNameInItsOwnTrack) {
  session::LogHeader header = makeHeader();
  header.step_names = {{"lift", "place"}, {"press"}};
  begin(header);
  writeTicks(writer_.get(), 0, 500, 1, ExerciseStatus::kRunning);
  ExerciseRecord step = makeEvent(500, ExerciseEventKind::kStepDone);
  step.event.track = 1;
  step.event.step = 0;
  writer_->write(step);
  writeTicks(writer_.get(), 500, 1000, 1, ExerciseStatus::kRunning);
  const SessionScore score = finish();
  ASSERT_EQ(score.histories.at(0).steps.size(), 1U);
  EXPECT_EQ(score.histories[0].steps[0].name, "press");
}

TEST_F(SessionScoreTest, AnAttemptThatFailsBeforeItsTimerStartsIsOne) {
  begin();
  writeTicks(writer_.get(), 0, 300, 1, ExerciseStatus::kWaiting);
  ExerciseRecord torn = makeEvent(300, ExerciseEventKind::kMistake);
  torn.event.mistake = Mistake::kBreakOff;
  writer_->write(torn);
  writeFailedTicks(writer_.get(), 300, 400, Mistake::kBreakOff);
  writeTicks(writer_.get(), 400, 1400, 2, ExerciseStatus::kRunning);
  ScoreSettings settings = makeSettings();
  Band band;
  band.metrics = {{"time", 45.0, 6.0, Better::kLower, 0.0}};
  settings.standard.band = &band;
  const SessionScore score = finish(settings);
  ASSERT_EQ(score.attempts.size(), 2u);
  const AttemptScore& torn_off = score.attempts[0];
  EXPECT_EQ(torn_off.outcome.number, 1);
  EXPECT_EQ(torn_off.outcome.failure, ExerciseFailure::kBrokeOff);
  EXPECT_EQ(torn_off.outcome.first, -1);
  EXPECT_EQ(torn_off.outcome.last, -1);
  EXPECT_EQ(torn_off.passed, std::optional<bool>(false));
  EXPECT_FALSE(torn_off.composite) << "a time of 0 s would be the best of all";
  for (const MetricScore& metric : torn_off.metrics)
    EXPECT_FALSE(metric.metric.value) << metric.metric.name;
  ASSERT_EQ(score.histories[0].mistakes.size(), 1u);
  EXPECT_EQ(score.attempts[1].outcome.first, 400);
  const nlohmann::json json = nlohmann::json::parse(write(score, settings));
  EXPECT_TRUE(json["attempts"][0]["first_tick"].is_null());
  EXPECT_EQ(json["attempts"][0]["mistakes"]["break_off"], 1);
}

/** A part that breaks off while an attempt waits is reported once, with that attempt. */
TEST_F(SessionScoreTest, AMistakeBeforeTheTimerStartsIsOfTheAttemptThatWaits) {
  begin();
  for (const std::uint8_t attempt : {1, 2, 3}) {
    const Tick start = 1000 * (attempt - 1);
    writer_->write(makeEvent(start, ExerciseEventKind::kStarted));
    for (Tick k = start; k < start + 1000; ++k) {
      const bool waits = k < start + 500 || attempt == 2;  // the second attempt ends before its timer starts
      ExerciseRecord torn = makeEvent(k, ExerciseEventKind::kMistake);
      torn.event.mistake = attempt == 2 ? Mistake::kDrop : Mistake::kBreakOff;
      if (k == start + 200 && attempt != 3) writer_->write(torn);
      writer_->write(makeExerciseTick(k, attempt, waits ? ExerciseStatus::kWaiting : ExerciseStatus::kRunning));
    }
  }
  const SessionScore score = finish();
  ASSERT_EQ(score.attempts.size(), 2U);
  EXPECT_EQ(score.attempts[1].outcome.number, 3);
  ASSERT_EQ(score.histories[0].mistakes.size(), 1U);
  EXPECT_EQ(score.histories[0].mistakes[0].name, "break_off");
  EXPECT_EQ(score.histories[0].mistakes[0].at, 0.0);
  EXPECT_TRUE(score.histories[1].mistakes.empty());
}

TEST_F(SessionScoreTest, ComparesWhatWasCarriedWithItsPlannedWay) {
  begin();
  for (Tick k = 0; k < 2000; ++k) {
    ExerciseRecord event = makeEvent(k, k == 500 ? ExerciseEventKind::kHeld : ExerciseEventKind::kReleased);
    event.event.arm = Hand::kGold;
    if (k == 500 || k == 1500) writer_->write(event);
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    const double t = kTickSeconds * static_cast<double>(k - 500);
    at(record.model.arms, Arm::kGold).p_BT = {0.05 * std::cos(kPi * t), 0.05 * std::sin(kPi * t), 0.0};
    writer_->write(record);
  }
  ScoreSettings settings = makeSettings();
  settings.plan = [](const Transit& t) { return std::vector<Vec3>{t.way_W.front(), t.way_W.back()}; };
  const SessionScore score = finish(settings);
  // A half circle of 50 mm less 15 mm of chord at both ends: an arc of pi - 4 asin(0.15) and its chord.
  const double arc = kPi - 4.0 * std::asin(0.15);
  EXPECT_EQ(score.attempts[0].economy.transits, 1u);
  EXPECT_NEAR(score.attempts[0].economy.ratio.value(), 2.0 * std::sin(arc / 2.0) / arc,
              0.012);  // both ends wait for a sample: 0.06 rad less at most
}

TEST_F(SessionScoreTest, WhatIsHeldAsTheTimerStartsIsCarriedFromThereOn) {
  begin();
  for (Tick k = 0; k < 2000; ++k) {
    ExerciseRecord event = makeEvent(k, k == 200 ? ExerciseEventKind::kHeld : ExerciseEventKind::kReleased);
    event.event.arm = Hand::kGreen;
    if (k == 200 || k == 1500) writer_->write(event);
    TickRecord record = makeExerciseTick(k, 1, k < 500 ? ExerciseStatus::kWaiting : ExerciseStatus::kRunning);
    record.model.exercise.bodies[3] = k >= 200 && k < 1500 ? kHeldByGreen : 0;
    at(record.model.arms, Arm::kGreen).p_BT = {1e-4 * static_cast<double>(k), 0.0, 0.0};
    writer_->write(record);
  }
  ScoreSettings settings = makeSettings();
  settings.plan = [](const Transit& t) { return std::vector<Vec3>{t.way_W.front(), t.way_W.back()}; };
  const SessionScore score = finish(settings);
  EXPECT_EQ(score.attempts[0].economy.transits, 1u);
  EXPECT_NEAR(score.attempts[0].economy.ratio.value_or(0.0), 1.0, 1e-9);
}

TEST_F(SessionScoreTest, TakesRecordsOfOtherThreadsBeforeAndBehindTheirTick) {
  begin();
  const auto write_others = [&](Tick k) {
    HapticRecord haptic;
    haptic.haptic.tick = kFirstTick + k;
    at(haptic.haptic.force_I, Arm::kGold) = {1.0, 0.0, 0.0};
    writer_->write(haptic);
    ContactRecord contact;
    contact.tick = kFirstTick + k;
    contact.b = 1;
    contact.f_W = {0.0, 2.0, 0.0};
    writer_->write(contact);
  };
  for (Tick k = 0; k < 1000; ++k) {
    if (k < 500) write_others(k);  // before
    writer_->write(makeRecord(k));
    if (k >= 700) write_others(k - 200);  // behind
  }
  for (Tick k = 800; k < 1000; ++k)
    write_others(k);
  const SessionScore score = finish();
  EXPECT_EQ(score.attempts[0].motion.haptic_force.with_force, 1000);
  EXPECT_EQ(score.attempts[0].motion.contact_force.with_force, 1000);
  EXPECT_EQ(score.attempts[0].motion.touches[static_cast<std::size_t>(Partner::kTower)].count, 1u);
}

constexpr Tick kInjection = 2000;  // session tick

struct MadeFault {
  Tick clutch{};      ///< [1 ms] that a clutch took before it
  Tick every{1};      ///< [1 ms] from one computed force to the next
  double gap{0.010};  ///< [m] of the robot's tip from the model's
};

/** The robot's tip is astray for 400 ms; the pedal goes up 350 ms behind that, for 2.1 s. */
void writeFault(session::LogWriter* writer, const MadeFault& made = {}) {
  for (Tick k = 0; k < 20'000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, k < 8000 ? ExerciseStatus::kRunning : ExerciseStatus::kDone);
    record.robot.connected = 1;
    record.robot.cycle = 50000 + static_cast<std::uint64_t>(k);
    const bool acts = k >= kInjection && k < kInjection + 400;
    if (acts) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, made.gap, 0.0};
    const bool is_clutching = k >= 200 && k < 200 + made.clutch;
    const bool is_up = (k >= kInjection + 350 && k < kInjection + 2450) || is_clutching;
    record.model.pedal = is_up ? 0 : 1;
    if (k == kInjection || k == kInjection + 400) {
      FaultChangeRecord change;
      change.tick = record.model.tick;
      change.change.cycle = record.robot.cycle;
      change.change.id = 1;
      change.change.acts = acts ? 1 : 0;
      writer->write(change);
    }
    writer->write(record);
    HapticRecord haptic;
    haptic.haptic.tick = record.model.tick;
    if (k >= kInjection + 5 && k < kInjection + 350) at(haptic.haptic.force_I, Arm::kGold) = {0.0, 0.0, 1.5};
    if (k % made.every == 0) writer->write(haptic);
    ContactRecord contact;
    contact.tick = record.model.tick;
    contact.b = 1;
    contact.f_W = {0.0, 2.0, 0.0};
    if (k == kInjection + 100 || k == kInjection - 200) writer->write(contact);
  }
}

TEST_F(SessionScoreTest, JudgesWhatWasDoneAboutAHazard) {
  begin();
  writeFault(writer_.get());
  const SessionScore score = finish();
  ASSERT_EQ(score.hazards.size(), 1u);
  const HazardScore& hazard = score.hazards[0];
  EXPECT_EQ(hazard.scenario, "sudden_jump");
  EXPECT_EQ(hazard.injection, kInjection);
  EXPECT_EQ(hazard.response.first.response, Response::kPedalUp);
  EXPECT_EQ(hazard.response.first.after, 350);
  EXPECT_EQ(hazard.response.verdict, Verdict::kRight);
  EXPECT_EQ(hazard.response.force_after, 5);
  EXPECT_NEAR(hazard.response.excursion, 0.01, 1e-12);
  EXPECT_NEAR(hazard.response.impulse, 0.345 * 1.5, 1e-9);
  EXPECT_EQ(hazard.response.touches[static_cast<std::size_t>(Partner::kTower)].count, 1u);
  EXPECT_TRUE(hazard.response.recovered);
  EXPECT_EQ(hazard.response.duration, 900);  // 400 astray, 500 calm
  ASSERT_EQ(score.attempts.size(), 1u);
  EXPECT_EQ(score.attempts[0].hazards.size(), 1u);
}

/** From the cue 5 ms behind the injection to the press 2450 ms behind it; the clutch of 300 ms before it is charged. */
TEST_F(SessionScoreTest, ARightAnswerCostsNeitherTimeNorAClutch) {
  for (const bool is_right : {true, false}) {
    begin();
    writeFault(writer_.get(), {300, 1, 0.010});
    ScoreSettings settings = makeSettings();
    if (!is_right) settings.response.right = {Response::kStop};
    const SessionScore score = finish(settings);
    ASSERT_EQ(score.attempts.size(), 1u);
    const MotionMetrics& motion = score.attempts[0].motion;
    EXPECT_EQ(score.hazards.at(0).response.verdict, is_right ? Verdict::kRight : Verdict::kNone);
    EXPECT_EQ(motion.ticks, is_right ? 8000 - 2445 : 8000);
    EXPECT_EQ(motion.clutches, is_right ? 1u : 2u);
    EXPECT_NEAR(motion.clutch_time, is_right ? 0.3 : 2.4, 1e-9);
    EXPECT_NEAR(motion.engaged, is_right ? 1.0 - 0.3 / 5.555 : 1.0 - 2.4 / 8.0, 1e-9);
    EXPECT_EQ(score.attempts[0].outcome.last, 7999);
  }
}

TEST_F(SessionScoreTest, WhoseClutchesAreLongLetsGoForLonger) {
  ScoreSettings settings = makeSettings();
  settings.response.right = {Response::kPedalUp};
  for (const Tick clutch : {1000, 1100}) {
    begin();
    writeFault(writer_.get(), {clutch, 1, 0.010});
    const HazardResponse response = finish(settings).hazards.at(0).response;
    EXPECT_EQ(response.verdict, clutch == 1000 ? Verdict::kRight : Verdict::kNone) << "2.1 s";
  }
}

/** A tick of two attempts of 15 s: a fault, and 600 ms later the pedal goes up for 2.1 s. Between the attempts it is up
 * for 3 s. */
TickRecord writeAnswered(session::LogWriter* writer, Tick k) {
  const Tick own = k % 15'000;
  TickRecord record = makeExerciseTick(k, k < 15'000 ? 1 : 2, ExerciseStatus::kRunning);
  record.robot.connected = 1;
  if (own >= kInjection && own < kInjection + 400) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, 0.01, 0.0};
  const bool answers = own >= kInjection + 600 && own < kInjection + 2700;
  record.model.pedal = answers || own < 500 || own >= 12'500 ? 0 : 1;
  if (own == kInjection || own == kInjection + 400) {
    FaultChangeRecord change;
    change.tick = record.model.tick;
    change.change.id = 1;
    change.change.acts = own == kInjection ? 1 : 0;
    writer->write(change);
  }
  return record;
}

TEST_F(SessionScoreTest, NeitherAnAnswerNorTheTimeBetweenAttemptsIsAClutch) {
  ScoreSettings settings = makeSettings();
  settings.response.right = {Response::kPedalUp};
  begin();
  for (Tick k = 0; k < 30'000; ++k)
    writer_->write(writeAnswered(writer_.get(), k));
  const SessionScore score = finish(settings);
  ASSERT_EQ(score.hazards.size(), 2u);
  for (const HazardScore& hazard : score.hazards) {
    EXPECT_EQ(hazard.response.deciding.after, 600);
    EXPECT_EQ(hazard.response.verdict, Verdict::kRight) << "at " << hazard.injection;
  }
}

TEST_F(SessionScoreTest, AForceThatIsComputedEveryOtherTickIsFeltAllTheSame) {
  for (const Tick every : {1, 2}) {
    begin();
    writeFault(writer_.get(), {0, every, 0.002});
    const HazardResponse response = finish().hazards.at(0).response;
    EXPECT_EQ(response.sense, Sense::kForce);
    EXPECT_NEAR(static_cast<double>(response.cue_after), 5.0, 1.0);
  }
}

TEST_F(SessionScoreTest, WhereNothingIsFeltTheRobotIsSeenToPart) {
  for (const double gap : {0.0029, 0.0031}) {
    begin();
    writeFault(writer_.get(), {0, 100'000, gap});
    const HazardResponse response = finish().hazards.at(0).response;
    EXPECT_EQ(response.verdict, gap > 0.003 ? Verdict::kRight : Verdict::kNotJudged);
    EXPECT_EQ(response.cue_after, gap > 0.003 ? kNoticed : -1);
  }
}

/** A change of the first scenario in this tick. */
FaultChangeRecord makeChange(const TickRecord& record, FaultHost host, bool acts) {
  FaultChangeRecord change;
  change.tick = record.model.tick;
  change.change.cycle = record.robot.cycle;
  change.change.id = 1;
  change.change.host = host;
  change.change.acts = acts ? 1 : 0;
  return change;
}

/** Forces on one hand; guidance and edge act from 1 s before the fault on. */
struct MadeForces {
  Vec3 cue_B{}, guidance_B{}, edge_B{}, offset_B{};
  double gain{1.0}, force_gain{1.0};
  Tick fixtures_end{3000};
  bool acts{true};  ///< forces may act
};

/** A fault of the console acts for 400 ms. The hand gets 1.5 N before, during and after it. */
void writeForces(session::LogWriter* writer, Arm arm, const MadeForces& made) {
  for (Tick k = 0; k < 3000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    const bool acts = k >= kInjection && k < kInjection + 400;
    if (acts) record.model.faults.console = 1;
    if (acts) at(record.model.faults.force_gain, arm) = made.force_gain;
    if (acts) at(record.model.faults.force_offset_B, arm) = made.offset_B;
    if (k == kInjection || k == kInjection + 400) writer->write(makeChange(record, FaultHost::kConsole, acts));
    writer->write(record);
    HapticRecord haptic;
    haptic.haptic.tick = record.model.tick;
    haptic.haptic.active = made.acts ? 1 : 0;
    at(haptic.haptic.force_I, arm) = {1.5, 0.0, 0.0};
    at(haptic.haptic.gain, arm) = made.gain;
    if (acts) at(haptic.haptic.cue_B, arm) = made.cue_B;
    if (k >= kInjection - 1000 && k < made.fixtures_end) {
      at(haptic.haptic.guidance_B, arm) = made.guidance_B;
      at(haptic.haptic.edge_B, arm) = made.edge_B;
    }
    writer->write(haptic);
  }
}

/** Each case has guidance on one arm, and edge force on the other. */
TEST_F(SessionScoreTest, GuidanceAndEdgeAreNoCueForAHazard) {
  struct Case {
    Vec3 cue_B, offset_B;
    double gain, force_gain;
    Tick cue_after;
  };
  const Case cases[] = {{{}, {}, 1.0, 1.0, -1},
                        {{0.0, 0.3, 0.4}, {}, 1.0, 1.0, 0},
                        {{0.0, 1.0, 0.0}, {}, 0.4, 1.0, -1},
                        {{0.0, 1.0, 0.0}, {}, 0.6, 1.0, 0},
                        {{0.0, 0.3, 0.0}, {}, 1.0, -2.0, 0},
                        {{}, {0.0, 0.0, 0.4}, 1.0, 1.0, -1},
                        {{}, {0.0, 0.0, -0.6}, 1.0, 1.0, 0},
                        {{0.0, 0.4, 0.0}, {0.0, -0.3, 0.0}, 1.0, 1.0, -1}};
  for (const Arm arm : kArms) {
    for (const Case& c : cases) {
      const bool is_guided = (&c - cases) % 2 == static_cast<int>(arm);
      const Vec3 fixture{1.5, 0.0, 0.0}, guidance = is_guided ? fixture : Vec3{}, edge = is_guided ? Vec3{} : fixture;
      begin();
      writeForces(writer_.get(), arm, {c.cue_B, guidance, edge, c.offset_B, c.gain, c.force_gain});
      const HazardResponse response = finish().hazards.at(0).response;
      EXPECT_EQ(response.cue_after, c.cue_after) << is_guided << " " << &c - cases;
      EXPECT_EQ(response.peak_force, 1.5) << "of the whole force";
    }
  }
}

/** With the pedal up, neither the force cue nor the console's fault reaches the hand. */
TEST_F(SessionScoreTest, AForceThatMayNotActIsNoCue) {
  for (const Arm arm : kArms) {
    for (const bool acts : {false, true}) {
      begin();
      MadeForces made;
      made.cue_B = made.offset_B = {0.0, 0.3, 0.4};
      made.guidance_B = {1.5, 0.0, 0.0};
      made.acts = acts;
      writeForces(writer_.get(), arm, made);
      EXPECT_EQ(finish().hazards.at(0).response.cue_after, acts ? 0 : -1);
    }
  }
}

/** The largest force has fallen to zero 40 ms after its end: the rest is the force cue. */
TEST_F(SessionScoreTest, TheWholeForceIsACueOnceGuidanceIsOver) {
  for (const Arm arm : kArms) {
    begin();
    MadeForces made;
    made.guidance_B = {1.5, 0.0, 0.0};
    made.fixtures_end = kInjection;
    writeForces(writer_.get(), arm, made);
    EXPECT_EQ(finish().hazards.at(0).response.cue_after, 39);
  }
}

/** The robot's state shows the first cycle with the fault 40 ms before the daemon receives the change. */
TEST_F(SessionScoreTest, AHazardBeginsWithTheCycleThatTheRobotReports) {
  begin();
  for (Tick k = 0; k < 6000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    record.robot.cycle = 50'000 + static_cast<std::uint64_t>(k);
    FaultChangeRecord change = makeChange(record, FaultHost::kRobot, true);
    change.change.cycle -= 40;
    if (k == kInjection) writer_->write(change);
    writer_->write(record);
  }
  EXPECT_EQ(finish().hazards.at(0).injection, kInjection - 40);
}

/** The library counts its cycles from 1, the bridge to a real robot its own. */
TEST_F(SessionScoreTest, AMergedHazardBeginsWithItsTick) {
  for (const Tick cycle : {Tick{1}, 50'000 + kInjection - 40, Tick{900'000}}) {
    begin();
    for (Tick k = 0; k < 6000; ++k) {
      TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
      record.robot.connected = 1;
      record.robot.cycle = 50'000 + static_cast<std::uint64_t>(k);
      writer_->write(record);
    }
    const nlohmann::json injection{{"name", "sudden_jump"},
                                   {"host", "robot"},
                                   {"row", 0},
                                   {"site", "put_usb_packet"},
                                   {"variable", "dac"},
                                   {"arm", "gold"},
                                   {"channel", 1},
                                   {"kind", "stuck_at"},
                                   {"value", 8000},
                                   {"inject", {{"cycle", cycle}, {"tick", kFirstTick + kInjection}}},
                                   {"clear", nullptr}};
    std::ofstream(folder_ / "usb_truth.json") << nlohmann::json{{"id", 1}, {"injections", {injection}}};
    EXPECT_EQ(finish().hazards.at(0).injection, kInjection) << cycle;
  }
}

/** The robot's tip is 10 mm astray for 400 ms, and the hands rest. @param[in] up when the pedal goes up. */
void writeFaultAnsweredLate(session::LogWriter* writer, Tick up, Tick end = 20'000) {
  for (Tick k = 0; k < end; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    if (k >= kInjection && k < kInjection + 400) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, 0.01, 0.0};
    record.model.pedal = k >= up ? 0 : 1;
    if (k == kInjection || k == kInjection + 400) {
      FaultChangeRecord change;
      change.tick = record.model.tick;
      change.change.id = 1;
      change.change.acts = k == kInjection ? 1 : 0;
      writer->write(change);
    }
    writer->write(record);
  }
}

/** The pedal goes up 900 ms after the fault, and the trainee ends the session. */
TEST_F(SessionScoreTest, ASessionThatEndsWithTheAnswerIsNotJudged) {
  for (const Tick length : {1000, 1999, 2000}) {
    begin();
    writeFaultAnsweredLate(writer_.get(), kInjection + 900, kInjection + 900 + length);
    const SessionScore score = finish();
    EXPECT_EQ(score.hazards.at(0).response.verdict, length < 2000 ? Verdict::kNotJudged : Verdict::kRight);
    EXPECT_EQ(score.hazards.at(0).response.deciding.after, length < 2000 ? -1 : 900);
  }
}

TEST_F(SessionScoreTest, AnswersAreLookedForAsLongAsTheyMayTake) {
  ScoreSettings settings = makeSettings();
  settings.response.right = {Response::kPedalUp};
  for (const double within : {2.0, 5.0, 8.0}) {
    settings.response.within = within;
    begin();
    writeFaultAnsweredLate(writer_.get(), kInjection + 7000);
    const HazardResponse response = finish(settings).hazards.at(0).response;
    EXPECT_EQ(response.verdict, within > 7.0   ? Verdict::kRight
                                : within > 3.5 ? Verdict::kLate
                                               : Verdict::kNone)
        << within;
  }
}

TEST_F(SessionScoreTest, WritesTheSameBytesTwice) {
  begin();
  writeFault(writer_.get());
  Band band;
  band.origin = "a test";
  band.sessions = 3;
  band.metrics = {{"time", 9.0, 1.0, Better::kLower, 0.0}, {"ldlj", -9.0, 1.0, Better::kHigher, 0.0}};
  ScoreSettings settings = makeSettings();
  settings.standard.band = &band;
  const std::string text = write(finish(settings), settings);
  EXPECT_EQ(write(scoreSession(log(), settings), settings), text);
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["exercise"], "peg_transfer");
  EXPECT_TRUE(json["drill"].is_null());
  EXPECT_EQ(json["band"]["origin"], "a test");
  const auto& attempt = json["attempts"][0];
  EXPECT_EQ(attempt["status"], "done");
  EXPECT_EQ(attempt["passed"], true);
  EXPECT_EQ(attempt["metrics"]["time"]["value"], 5.555) << "without the answer to the hazard";
  EXPECT_EQ(attempt["metrics"]["time"]["limit"], 10.0);
  EXPECT_EQ(attempt["metrics"]["time"]["unit"], "s");
  EXPECT_TRUE(attempt["metrics"]["path"]["passed"].is_null());
  EXPECT_TRUE(attempt["metrics"]["ldlj"]["value"].is_null());  // nothing moved
  EXPECT_EQ(attempt["not_judged"], nlohmann::json::array({"ldlj"}));
  EXPECT_EQ(attempt["hazards"][0]["reaction"]["response"], "pedal_up");
  EXPECT_EQ(attempt["hazards"][0]["reaction"]["after_ms"], 350);
  EXPECT_EQ(attempt["touches"]["tower"]["count"], 1) << "one came with the hazard";
  EXPECT_EQ(attempt["hazards"][0]["touches"]["tower"]["count"], 1);
}

TEST_F(SessionScoreTest, GivesUpWhenItsCallbackThrows) {
  begin();
  for (Tick k = 0; k < 100; ++k)
    writer_->write(makeRecord(k));
  ScoreSettings settings = makeSettings();
  int ticks = 0;
  settings.on_tick = [&] {
    if (++ticks == 150) throw std::runtime_error("enough");  // in the second reading
  };
  EXPECT_THROW(finish(settings), std::runtime_error);
  EXPECT_EQ(ticks, 150);
}

TEST_F(SessionScoreTest, OfALogWithoutASessionHasNoAttempts) {
  begin();
  TickRecord record = makeRecord(0);
  record.model.session_tick = -1;
  writer_->write(record);
  EXPECT_TRUE(finish().attempts.empty());
}

RequestRecord makeStop(Tick k) {
  RequestRecord stop;
  stop.tick = kFirstTick + k;
  stop.request.kind = RequestKind::kEmergencyStop;
  return stop;
}

/** As writeFault() without the pedal: the trainee stops by request, by pedal, or not. */
void writeStoppedFault(session::LogWriter* writer, bool by_request, bool by_pedal) {
  for (Tick k = 0; k < 6000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    if (k >= kInjection && k < kInjection + 400) at(record.robot.arms, Arm::kGold).p_BT = {0.0, 0.01, 0.0};
    if (by_pedal && k >= kInjection + 600) record.model.pedals = bit(Pedal::kStop);
    for (const Tick after : {600, 800})  // a part of the log has all of its requests before its ticks
      if (by_request && k == kInjection + 600) writer->write(makeStop(kInjection + after));
    if (k == kInjection || k == kInjection + 400) {
      FaultChangeRecord change;
      change.tick = record.model.tick;
      change.change.id = 1;
      change.change.acts = k == kInjection ? 1 : 0;
      writer->write(change);
    }
    writer->write(record);
  }
}

TEST_F(SessionScoreTest, AnEmergencyStopIsAnAnswerByRequestAndByPedal) {
  for (const auto& [by_request, by_pedal] : {std::pair{true, false}, {false, true}, {false, false}}) {
    ScoreSettings settings = makeSettings();
    settings.response.right = {Response::kStop};
    begin();
    writeStoppedFault(writer_.get(), by_request, by_pedal);
    const HazardResponse response = finish(settings).hazards.at(0).response;
    EXPECT_EQ(response.deciding.response, by_request || by_pedal ? Response::kStop : Response::kNone);
    EXPECT_EQ(response.deciding.after, by_request || by_pedal ? 600 : -1);
  }
}

/** Two faults of 100 ms, 4 s apart, each with its own touches; while `is_lost`, the robot's pose is invalid. */
void writeTwoFaults(session::LogWriter* writer, Arm arm, Mode mode = Mode::kTeleoperating, bool is_linked = true) {
  for (Tick k = 0; k < 9000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    const Tick phase = k % 4000;
    const bool is_lost = phase >= 2050 && phase < 2060;
    record.robot.connected = is_lost ? 0 : 1;
    record.model.mode = mode;
    record.model.linked = is_lost || !is_linked ? 0 : 1;
    if (is_lost) at(record.robot.arms, arm).p_BT = {3.0, 0.0, 0.0};
    if (phase >= 2000 && phase < 2050) at(record.robot.arms, arm).p_BT = {0.0, 0.0, k < 4000 ? 0.01 : 0.02};
    if (phase == 2000 || phase == 2100) {
      FaultChangeRecord change;
      change.tick = record.model.tick;
      change.change.id = 1;
      change.change.acts = phase == 2000 ? 1 : 0;
      writer->write(change);
    }
    writer->write(record);
    ContactRecord contact;
    contact.tick = record.model.tick;
    contact.b = 1;
    contact.f_W = {0.0, 2.0, 0.0};
    const bool is_touch = phase == 2010 || (k > 4000 && phase == 2300) || phase == 3500;  // the last is behind both
    if (is_touch) writer->write(contact);
  }
}

TEST_F(SessionScoreTest, EachHazardHasItsOwnTouchesAndDistancesOfEitherArm) {
  for (const Arm arm : kArms) {
    begin();
    writeTwoFaults(writer_.get(), arm);
    const std::vector<HazardScore> hazards = finish().hazards;
    ASSERT_EQ(hazards.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const HazardResponse& response = hazards[i].response;
      EXPECT_EQ(hazards[i].injection, 2000 + 4000 * static_cast<Tick>(i));
      EXPECT_NEAR(response.excursion, i == 0 ? 0.01 : 0.02, 1e-12) << "a lost robot has no excursion";
      EXPECT_NEAR(response.error, i == 0 ? 0.01 : 0.02, 1e-12);
      EXPECT_EQ(response.touches[static_cast<std::size_t>(Partner::kTower)].count, i + 1);
      EXPECT_EQ(response.touches[static_cast<std::size_t>(Partner::kTower)].ticks, static_cast<Tick>(i) + 1);
    }
  }
}

TEST_F(SessionScoreTest, AModelThatExecutesAPlanAloneHasNoDistanceToTheRobot) {
  for (const bool is_linked : {true, false}) {
    begin();
    writeTwoFaults(writer_.get(), Arm::kGold, Mode::kExecuting, is_linked);
    const std::vector<HazardScore> hazards = finish().hazards;
    ASSERT_FALSE(hazards.empty());
    EXPECT_NEAR(hazards[0].response.excursion, 0.01, 1e-12) << is_linked;
    EXPECT_NEAR(hazards[0].response.error, is_linked ? 0.01 : 0.0, 1e-12) << is_linked;
  }
}

/** Three faults: in the first attempt, while the second one waits for its timer, and in the second. */
TEST_F(SessionScoreTest, AHazardIsOfTheAttemptInWhichItStruck) {
  begin();
  for (Tick k = 0; k < 13'000; ++k) {
    const bool is_first = k < 4000, waits = k >= 4000 && k < 8000;
    TickRecord record =
        makeExerciseTick(k, is_first ? 1 : 2, waits ? ExerciseStatus::kWaiting : ExerciseStatus::kRunning);
    record.robot.connected = 1;
    if (k % 4000 == 2000 || k % 4000 == 2100) {
      FaultChangeRecord change;
      change.tick = record.model.tick;
      change.change.id = 1;
      change.change.acts = k % 4000 == 2000 ? 1 : 0;
      writer_->write(change);
    }
    writer_->write(record);
  }
  const SessionScore score = finish();
  ASSERT_EQ(score.hazards.size(), 3U);
  ASSERT_EQ(score.attempts.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(score.attempts[i].hazards.size(), 1U) << i;
    EXPECT_EQ(score.attempts[i].hazards[0].injection, i == 0 ? 2000 : 10'000);
  }
}

/** The hands of a client of CRTK are not the surgeon's: with its pedal, the surgeon's is up. */
TEST_F(SessionScoreTest, ThePedalThatAnswersIsTheSurgeons) {
  ScoreSettings settings = makeSettings();
  settings.response.right = {Response::kPedalUp};
  begin();
  for (Tick k = 0; k < 6000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    if (k >= kInjection && k < kInjection + 400) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, 0.01, 0.0};
    record.model.pedal = k < kInjection + 600 ? kSurgeonsPedal : kClientsPedal;
    if (k == kInjection || k == kInjection + 400) {
      FaultChangeRecord change;
      change.tick = record.model.tick;
      change.change.id = 1;
      change.change.acts = k == kInjection ? 1 : 0;
      writer_->write(change);
    }
    writer_->write(record);
  }
  const HazardResponse response = finish(settings).hazards.at(0).response;
  EXPECT_EQ(response.deciding.response, Response::kPedalUp);
  EXPECT_EQ(response.deciding.after, 600);
}

TEST_F(SessionScoreTest, NeitherPausesNorReplaysCount) {
  begin();
  for (Tick k = 0; k < 3000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    if (k >= 500 && k < 700) record.model.mode = Mode::kPaused;
    if (k >= 1000 && k < 1300) record.model.mode = Mode::kReplaying;
    writer_->write(record);
  }
  EXPECT_EQ(finish().attempts.at(0).motion.ticks, 2500);
}

/** Gold or green holds something as the timer starts. */
TEST_F(SessionScoreTest, WhatEitherArmHoldsAsTheTimerStartsIsCarried) {
  for (const Arm arm : kArms) {
    begin();
    for (Tick k = 0; k < 2000; ++k) {
      TickRecord record = makeExerciseTick(k, 1, k < 500 ? ExerciseStatus::kWaiting : ExerciseStatus::kRunning);
      record.model.exercise.bodies[2] = arm == Arm::kGold ? kHeldByGold : kHeldByGreen;
      at(record.model.arms, arm).p_BT = {1e-4 * static_cast<double>(k), 0.0, 0.0};
      if (k == 1500) {
        ExerciseRecord released = makeEvent(k, ExerciseEventKind::kReleased);
        released.event.arm = arm == Arm::kGold ? Hand::kGold : Hand::kGreen;
        writer_->write(released);
      }
      writer_->write(record);
    }
    EXPECT_EQ(finish().attempts.at(0).economy.transits, 1u);
  }
}

FaultChangeRecord changeOf(const TickRecord& record, std::uint32_t id, bool acts) {
  FaultChangeRecord change;
  change.tick = record.model.tick;
  change.change.id = id;
  change.change.acts = acts ? 1 : 0;
  return change;
}

/** friction acts from 500 to `first_end`, sudden_jump from kInjection on for 400 ms. A gap is seen from `gap` on. */
void writeTwo(session::LogWriter* writer, Tick first_end, Tick gap, bool has_rows) {
  for (Tick k = 0; k < 9000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    if (k >= gap && k < gap + 400) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, 0.01, 0.0};
    record.model.pedal = k >= gap + 350 && k < gap + 2450 ? 0 : 1;
    if (k == 500 || k == first_end) writer->write(changeOf(record, 1, k == 500));
    if (k == kInjection || k == kInjection + (has_rows ? 100 : 400))
      writer->write(changeOf(record, 2, k == kInjection));
    if (has_rows && (k == kInjection + 200 || k == kInjection + 1500)) {
      FaultChangeRecord change = changeOf(record, 2, k == kInjection + 200);
      change.change.row = 1;
      writer->write(change);
    }
    writer->write(record);
  }
}

TEST_F(SessionScoreTest, AHazardInTheMidstOfAnotherIsJudgedToo) {
  session::LogHeader header = makeHeader();
  header.scenarios = {"friction", "sudden_jump"};
  for (const Tick first_end : {Tick{20'000}, kInjection + 200}) {  // or it outlasts the other one
    begin(header);
    writeTwo(writer_.get(), first_end, kInjection, /*has_rows=*/false);
    const std::vector<HazardScore> hazards = finish().hazards;
    ASSERT_EQ(hazards.size(), 2U) << first_end;
    EXPECT_EQ(hazards[1].scenario, "sudden_jump");
    EXPECT_EQ(hazards[1].injection, kInjection);
    EXPECT_EQ(hazards[1].response.verdict, Verdict::kRight);
  }
}

TEST_F(SessionScoreTest, TheRowsOfAHazardInTheMidstOfAnotherAreOneHazard) {
  session::LogHeader header = makeHeader();
  header.scenarios = {"friction", "sudden_jump"};
  begin(header);
  writeTwo(writer_.get(), 20'000, kInjection + 800, /*has_rows=*/true);
  const std::vector<HazardScore> hazards = finish().hazards;
  ASSERT_EQ(hazards.size(), 2U);
  EXPECT_EQ(hazards[1].response.cue_after, 800 + kNoticed);
  EXPECT_EQ(hazards[1].response.verdict, Verdict::kRight);
}

/** Of one row of a scenario. */
struct Acting {
  std::uint32_t id;
  FaultHost host;
  std::uint8_t row;
  Tick begin, end;
};

class OverlappingFaults : public SessionScoreTest {
 protected:
  /** [session ticks] Begins of the hazards that are judged. */
  std::vector<Tick> begins(const std::vector<Acting>& all) {
    session::LogHeader header = makeHeader();
    header.scenarios = {"friction", "sudden_jump", "grasper_runaway"};
    begin(header);
    for (Tick k = 0; k < 9000; ++k) {
      TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
      record.robot.connected = 1;
      record.robot.cycle = static_cast<std::uint64_t>(k + 1);
      for (const Acting& fault : all) {
        if (k != fault.begin && k != fault.end) continue;
        FaultChangeRecord change = changeOf(record, fault.id, k == fault.begin);
        change.change.host = fault.host;
        change.change.row = fault.row;
        change.change.cycle = record.robot.cycle;
        writer_->write(change);
      }
      writer_->write(record);
    }
    std::vector<Tick> found;
    for (const HazardScore& hazard : finish().hazards)
      found.push_back(hazard.injection);
    return found;
  }
};

TEST_F(OverlappingFaults, AreOneHazardEach) {
  const auto robot = FaultHost::kRobot, relay = FaultHost::kRelay, console = FaultHost::kConsole;
  // two rows at a time, which outlast the other fault
  EXPECT_EQ(begins({{1, robot, 0, 500, 2200}, {2, relay, 0, 2000, 4000}, {2, relay, 1, 2000, 4000}}),
            (std::vector<Tick>{500, 2000}));
  EXPECT_EQ(begins({{1, robot, 0, 500, 2200}, {2, relay, 0, 2000, 4000}, {2, relay, 1, 2050, 4000}}),
            (std::vector<Tick>{500, 2000}));
  // the second pulse outlasts it
  EXPECT_EQ(begins({{1, robot, 0, 500, 2300}, {2, relay, 0, 2000, 2100}, {2, relay, 0, 2250, 4000}}),
            (std::vector<Tick>{500, 2000}));
  // it has an event soon after its beginning
  EXPECT_EQ(begins({{1, robot, 0, 500, 2080}, {2, relay, 0, 2000, 4000}}), (std::vector<Tick>{500, 2000}));
  // three that begin within a tenth of a second
  EXPECT_EQ(begins({{1, console, 0, 2000, 4000}, {2, relay, 0, 2020, 4000}, {3, robot, 0, 2050, 4000}}),
            (std::vector<Tick>{2000, 2020, 2050}));
  // it comes again, under another one that it outlasts
  EXPECT_EQ(begins({{2, relay, 0, 500, 600}, {1, robot, 0, 4000, 6000}, {2, relay, 0, 5000, 7000}}),
            (std::vector<Tick>{500, 4000, 5000}));
  // its second row begins once another one has the events, which ends sooner or later
  for (const Tick end : {4000, 6000})
    EXPECT_EQ(begins({{2, relay, 0, 500, 5000}, {1, robot, 0, 800, end}, {2, relay, 1, 900, 5000}}),
              (std::vector<Tick>{500, 800}))
        << end;
  // one that is interrupted twice
  EXPECT_EQ(begins({{1, relay, 0, 500, 7000}, {2, robot, 0, 2000, 2300}, {2, robot, 0, 5000, 5300}}),
            (std::vector<Tick>{500, 2000, 5000}));
}

TEST_F(SessionScoreTest, FaultsBeyondThoseThatAreJudgedAreCountedOnce) {
  session::LogHeader header = makeHeader();
  header.scenarios = {"friction", "sudden_jump"};
  begin(header);
  for (Tick k = 0; k < 1005 * 10; ++k) {  // one after the other, 10 ms each
    const TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    const std::uint32_t id = 1 + static_cast<std::uint32_t>(k / 10) % 2;
    if (k % 10 == 0 && k > 0) writer_->write(changeOf(record, 3 - id, false));
    if (k % 10 == 0) writer_->write(changeOf(record, id, true));
    writer_->write(record);
  }
  const SessionScore score = finish();
  EXPECT_EQ(score.hazards.size(), kMaxHazards);
  EXPECT_EQ(score.hazards_beyond, 5U);
}

TEST_F(SessionScoreTest, WhatIsDoneInAPauseIsUnknown) {
  begin();
  for (Tick k = 0; k < 12'000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    const bool is_paused = k >= kInjection + 300 && k < kInjection + 3300;
    if (is_paused) record.model.mode = Mode::kPaused;
    if (k >= kInjection + 300) record.model.session_tick = is_paused ? kInjection + 299 : k - 3000;
    record.model.pedal = k >= kInjection + 500 && k < kInjection + 3300 ? 0 : 1;
    at(record.model.master_I, Arm::kGold) = {8e-6 * static_cast<double>(k), 0.0, 0.0};
    if (k >= kInjection && k < kInjection + 300) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, 0.01, 0.0};
    if (k == kInjection || k == kInjection + 300) writer_->write(changeOf(record, 1, k == kInjection));
    writer_->write(record);
  }
  const HazardResponse response = finish().hazards.at(0).response;
  EXPECT_EQ(response.cue_after, kNoticed);
  EXPECT_EQ(response.verdict, Verdict::kNotJudged);
}

TEST_F(SessionScoreTest, EachHazardHasItsForceThoughTheOneBeforeIsStillWatched) {
  begin();
  for (Tick k = 0; k < 9000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    const bool acts = k % 4000 >= 2000 && k % 4000 < 2400;
    if (k % 4000 == 2000 || k % 4000 == 2400) writer_->write(changeOf(record, 1, acts));
    writer_->write(record);
    HapticRecord haptic;
    haptic.haptic.tick = record.model.tick;
    if (acts) at(haptic.haptic.force_I, Arm::kGreen) = {0.0, 0.0, 1.5};
    writer_->write(haptic);
  }
  const auto hazards = finish().hazards;
  ASSERT_EQ(hazards.size(), 2U);
  for (const HazardScore& hazard : hazards) {
    EXPECT_EQ(hazard.response.cue_after, 0);
    EXPECT_EQ(hazard.response.peak_force, 1.5);
  }
}

TEST_F(SessionScoreTest, ADrillWhoseHazardNeverCameIsNotPassed) {
  Band band;
  band.metrics = {{"time", 9.0, 1.0, Better::kLower, 0.0}};
  ScoreSettings settings = makeSettings();
  settings.standard.band = &band;
  for (const std::string drill : {"none", "sudden_jump"}) {
    session::LogHeader header = makeHeader();
    header.drill = drill;
    begin(header);
    writeTicks(writer_.get(), 0, 2000, 1, ExerciseStatus::kRunning);
    writer_->write(makeExerciseTick(2000, 1, ExerciseStatus::kDone));
    const std::optional<bool> passed = drill == "none" ? std::optional<bool>(true) : std::nullopt;
    EXPECT_EQ(finish(settings).attempts.at(0).passed, passed) << drill;
  }
}

/** A jump of the robot's green arm during a hazard. @param[in] is_up, is_lost by tick. */
template <typename Up, typename Lost>
void writeJump(session::LogWriter* writer, const Up& is_up, const Lost& is_lost) {
  for (Tick k = 0; k < 9000; ++k) {
    TickRecord record = makeExerciseTick(k, 1, ExerciseStatus::kRunning);
    record.robot.connected = 1;
    const bool acts = k >= kInjection && k < kInjection + 400;
    if (acts) at(record.robot.arms, Arm::kGreen).p_BT = {0.0, 0.01, 0.0};
    record.model.pedal = is_up(k) ? 0 : 1;
    if (k == kInjection || k == kInjection + 400) writer->write(changeOf(record, 1, acts));
    if (!is_lost(k)) writer->write(record);
  }
}

TEST_F(SessionScoreTest, RecordsThatWereLostShortenNoReaction) {
  begin();
  writeJump(
      writer_.get(), [](Tick k) { return k >= kInjection + 900; },
      [](Tick k) { return k >= kInjection + 450 && k < kInjection + 650; });
  EXPECT_EQ(finish().hazards.at(0).response.deciding.after, 900);
}

TEST_F(SessionScoreTest, OneLongClutchIsNoHabit) {
  begin();
  const auto is_up = [](Tick k) {
    const bool clutches = (k >= 100 && k < 200) || (k >= 300 && k < 400) || (k >= 500 && k < 1800);
    return clutches || (k >= kInjection + 350 && k < kInjection + 2450);
  };
  writeJump(writer_.get(), is_up, [](Tick) { return false; });
  ScoreSettings settings = makeSettings();
  settings.response.right = {Response::kPedalUp};
  EXPECT_EQ(finish(settings).hazards.at(0).response.verdict, Verdict::kRight);
}

}  // namespace
}  // namespace raven2_trainer::training
