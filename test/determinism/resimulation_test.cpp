#include "raven2_trainer/recording/resimulation.h"

#include <gtest/gtest.h>
#include <ode/ode.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "drill/drill.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/console/commands_file.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "raven2_trainer/loop/planner_worker.h"
#include "raven2_trainer/recording/recorder.h"
#include "support/eventful_session.h"
#include "support/made_up_session.h"

namespace raven2_trainer::lockstep {
namespace {

class ResimulationTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    raven2_trainer::testing::useOde();
    folder = std::filesystem::temp_directory_path() / ("raven2_resimulation_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder);
    EventfulSession session((folder / "eventful").string());
    session.run();
    paths = session.paths;
    config = session.config;
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder); }

  static recording::ResimulationResult resimulate(const session::SessionPaths& session,
                                                  const std::string& output = "") {
    return recording::Resimulation(config, session, output).run({});
  }

  /** Result for the eventful session, without a copy; computed once. */
  static const recording::ResimulationResult& whole() {
    static const recording::ResimulationResult result = resimulate(paths);
    return result;
  }

  /** Writes the log again and passes each record to `change`. If `change` returns false, the record is left out. */
  template <typename Record>
  static session::SessionPaths rewritten(
      const std::string& name,
      const std::function<bool(Record&)>& change,
      const std::function<void(Tick, session::LogWriter&)>& before = [](Tick, session::LogWriter&) {}) {
    const session::SessionPaths copy = session::createSessionDirectory((folder / name).string());
    session::LogWriter log(copy.log(), session::readLogHeader(paths.log()));
    session::LogVisitor visitor;
    const auto pass = [&](const auto& record) {
      auto changed = record;
      using Given = std::decay_t<decltype(record)>;
      if constexpr (std::is_same_v<Given, Record>) {
        if (!change(changed)) return;
      }
      if constexpr (std::is_same_v<Given, TickRecord>) before(record.model.tick, log);
      log.write(changed);
    };
    visitor.tick = pass;
    visitor.haptic = pass;
    visitor.command = pass;
    visitor.request = pass;
    visitor.plan = pass;
    visitor.faults = pass;
    visitor.execution = pass;
    visitor.exercise = pass;
    visitor.contact = pass;
    visitor.counts = [&](const SessionCounts& counts) { log.finish(counts); };
    session::readLog(paths.log(), visitor);
    return copy;
  }

  /** A tick in the midst of a stroke, whose command moved the model. */
  static Tick strokeTick() {
    std::vector<Tick> used;
    session::LogVisitor visitor;
    visitor.tick = [&](const TickRecord& r) {
      if (r.model.commands_used > 0) used.push_back(r.model.tick);
    };
    session::readLog(paths.log(), visitor);
    return used.at(100);
  }

  static inline std::filesystem::path folder;
  static inline session::SessionPaths paths;
  static inline TrainerConfig config;
};

TEST_F(ResimulationTest, TheSessionHeldEverythingThatPhysicsCanBeGiven) {
  std::set<Mode> modes;
  std::set<RequestKind> requests;
  std::uint64_t slips = 0, lost = 0, contacts = 0, faulty = 0, armed = 0, refused = 0, answered = 0;
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& r) {
    modes.insert(r.model.mode);
    slips += r.slipped;
    lost += r.model.robot_fresh == 0 && r.robot.frame > 0 ? 1 : 0;
    faulty += r.robot.active_fault != 0 ? 1 : 0;
  };
  visitor.request = [&](const RequestRecord& r) { requests.insert(r.request.kind); };
  visitor.plan = [&](const PlanRecord& r) { ++(r.refused != 0 ? refused : answered); };
  visitor.faults = [&](const FaultRecord& r) { armed += r.plan.count; };
  visitor.contact = [&](const ContactRecord&) { ++contacts; };
  std::vector<ExecutionEnd> ends;
  visitor.execution = [&](const ExecutionRecord& r) { ends.push_back(r.report.end); };
  std::uint64_t guided = 0, at_edge = 0, watched = 0;
  visitor.haptic = [&](const HapticRecord& r) {
    guided += toEigen(r.haptic.guidance_B[0]).norm() > 0.01 ? 1 : 0;
    at_edge += toEigen(r.haptic.edge_B[0]).norm() > 0.01 ? 1 : 0;
    watched += r.haptic.energy[0] != 0.0 ? 1 : 0;
  };
  session::readLog(paths.log(), visitor);
  EXPECT_GT(guided, 0U);
  EXPECT_GT(at_edge, 0U);
  EXPECT_GT(watched, 0U);
  EXPECT_EQ(modes,
            (std::set<Mode>{Mode::kWaiting, Mode::kPedalUp, Mode::kTeleoperating, Mode::kPlanning, Mode::kTracking,
                            Mode::kPaused, Mode::kChoosing, Mode::kArmed, Mode::kExecuting, Mode::kStopped,
                            Mode::kSimulating, Mode::kSimulationHeld, Mode::kTrial, Mode::kTrialHeld, Mode::kTrialReady,
                            Mode::kReturning, Mode::kCameraMoving, Mode::kReplaying}));
  EXPECT_EQ(requests.size(), 23U);
  EXPECT_EQ(ends, (std::vector<ExecutionEnd>{ExecutionEnd::kFinished, ExecutionEnd::kReleased, ExecutionEnd::kFinished,
                                             ExecutionEnd::kReleased}));
  EXPECT_EQ(slips, 1U);
  EXPECT_GT(lost, 0U);
  EXPECT_GT(contacts, 1000U);
  EXPECT_GT(faulty, 0U);
  EXPECT_EQ(armed, 1U);
  EXPECT_EQ(refused, 3U) << "one with the pedal down, and two beyond the four that may be under way";
  EXPECT_EQ(answered, 6U);
}

TEST_F(ResimulationTest, GivesTheSameBitsInEveryTickContactAndForce) {
  const recording::ResimulationResult& result = whole();
  EXPECT_FALSE(result.difference) << result.difference->tick << ": " << result.difference->field;
  EXPECT_GT(result.ticks, 6000U);
  EXPECT_GE(result.forces, result.ticks - 1) << "every haptic tick except the one before the first model state";
}

TEST_F(ResimulationTest, GivesTheSameBitsInAProcessThatRanAnotherSession) {
  TrainerConfig other = packagedConfig();
  other.seed = 99;
  {
    Lockstep lockstep(other, console::makeMotion(other, "scripted"),
                      session::createSessionDirectory((folder / "other").string()), "scripted");
    ASSERT_TRUE(lockstep.run(1.0, {}));
  }
  dRandSetSeed(12345);
  EXPECT_FALSE(resimulate(paths).difference);
  // The world seeds ODE's random numbers but draws none. Other users of them change nothing.
  const unsigned long seed = dRandGetSeed();
  Rig rig(packagedConfig());
  const unsigned long seeded = dRandGetSeed();
  ASSERT_TRUE(rig.home());
  EXPECT_EQ(dRandGetSeed(), seeded);
  EXPECT_EQ(seed, seeded);
}

TEST_F(ResimulationTest, RecordsASessionOfTheSameTicks) {
  const std::string output = (folder / "again").string();
  ASSERT_FALSE(resimulate(paths, output).difference);
  const auto ticksOf = [](const session::SessionPaths& session) {
    std::uint64_t ticks = 0;
    session::LogVisitor visitor;
    visitor.tick = [&](const TickRecord&) { ++ticks; };
    EXPECT_TRUE(session::readLog(session.log(), visitor).clean);
    return ticks;
  };
  EXPECT_EQ(ticksOf(session::SessionPaths{output}), ticksOf(paths));
  EXPECT_FALSE(resimulate(session::SessionPaths{output}).difference) << "the copy cannot be simulated again";
}

/** Faults of every host, one of them on a signal. */
TrainerConfig allHosts() {
  TrainerConfig faulty = packagedConfig();
  faulty.hazard = "sudden_jump";
  faulty.runtime.plan_at = -1.0;
  std::vector<Fault>& rows = faulty.scenarios[config::faultId(faulty, "sudden_jump") - 1].faults;
  rows[0].first_tick = 1500;
  const auto add = [&](FaultHost host, FaultVariable variable, FaultKind kind, std::int64_t first, double value) {
    Fault row;
    row.id = rows[0].id;
    row.row = static_cast<std::uint8_t>(rows.size());
    row.host = host;
    row.site = infoOf(variable).site;
    row.variable = variable;
    row.kind = kind;
    row.first_tick = first;
    row.duration_ticks = 200;
    row.value = row.low = row.high = value;
    rows.push_back(row);
  };
  add(FaultHost::kMaster, FaultVariable::kPacket, FaultKind::kDelay, 300, 20);
  add(FaultHost::kMaster, FaultVariable::kIncrement, FaultKind::kRandom, 700, 30);
  rows.back().low = -30;
  add(FaultHost::kRelay, FaultVariable::kPacket, FaultKind::kDrop, 1000, 0.2);
  add(FaultHost::kConsole, FaultVariable::kForceOffset, FaultKind::kAdd, 500, 0.5);
  rows.back().trigger = FaultTrigger::kTissueDistance;
  rows.back().threshold = 0.005;
  return faulty;
}

std::vector<std::array<std::uint64_t, 6>> changesIn(const session::SessionPaths& session) {
  std::vector<std::array<std::uint64_t, 6>> changes;
  session::LogVisitor visitor;
  visitor.fault_change = [&](const FaultChangeRecord& r) {
    changes.push_back({static_cast<std::uint64_t>(r.tick), r.change.number, r.change.cycle,
                       static_cast<std::uint64_t>(r.change.host), r.change.row, r.change.acts});
  };
  session::readLog(session.log(), visitor);
  return changes;
}

TEST_F(ResimulationTest, GivesFaultsOfEveryHostAgainAndWhatTheirTriggersLookAt) {
  const TrainerConfig faulty = allHosts();
  const session::SessionPaths first = session::createSessionDirectory((folder / "all_hosts").string());
  {
    Lockstep lockstep(faulty, console::makeMotion(faulty, "scripted"), first, "scripted");
    FaultSignals signals;
    while (lockstep.view().model.session_tick < 2500) {
      signals.tissue_distance = 0.02 - 1e-5 * static_cast<double>(lockstep.view().model.session_tick);
      lockstep.setSignals(signals);
      lockstep.tick();
    }
    lockstep.finish();
  }
  const session::SessionPaths again{(folder / "all_hosts_again").string()};
  const recording::ResimulationResult result = recording::Resimulation(faulty, first, again.directory).run({});
  ASSERT_FALSE(result.difference) << result.difference->tick << ": " << result.difference->field;
  const auto changes = changesIn(first);
  EXPECT_EQ(changes, changesIn(again));
  std::set<std::uint64_t> hosts, rows;
  for (const auto& change : changes) {
    hosts.insert(change[3]);
    rows.insert(change[4]);
  }
  EXPECT_EQ(hosts.size(), 4U);
  EXPECT_EQ(rows.size(), 5U);
}

TEST_F(ResimulationTest, GivesADrillAgainFromWhatTheJudgeSees) {
  const TrainerConfig drilled = raven2_trainer::testing::drillConfig("pick_hand_over_place", "own", 1);
  const session::SessionPaths first = session::createSessionDirectory((folder / "drill").string());
  Lockstep lockstep(drilled, console::makeMotion(drilled, "scripted"), first, "scripted");
  ASSERT_TRUE(lockstep.run(4.0, {}));
  const session::SessionPaths again{(folder / "drill_again").string()};
  const recording::ResimulationResult result = recording::Resimulation(drilled, first, again.directory).run({});
  ASSERT_FALSE(result.difference) << result.difference->tick << ": " << result.difference->field;
  EXPECT_EQ(changesIn(first), changesIn(again));
  ASSERT_EQ(changesIn(first).size(), 2U) << "one change for the fault's begin and one for its end";
}

TEST_F(ResimulationTest, TheSameSeedGivesTheSameDrill) {
  const auto bytes = [](const char* name) {
    const TrainerConfig drilled = raven2_trainer::testing::drillConfig("pick_hand_over_place", "own", 2);
    const session::SessionPaths session = session::createSessionDirectory((folder / name).string());
    Lockstep lockstep(drilled, console::makeMotion(drilled, "scripted"), session, "scripted");
    EXPECT_TRUE(lockstep.run(2.5, {}));
    std::ostringstream text;
    text << std::ifstream(session.log(), std::ios::binary).rdbuf();
    return text.str();
  };
  const std::string one = bytes("one");
  EXPECT_GT(one.size(), 1'000'000U);
  EXPECT_TRUE(one == bytes("two"));
}

TEST_F(ResimulationTest, NamesTheTickOfOneFlippedBitInOneCommand) {
  const Tick flipped = strokeTick();
  const auto other = rewritten<CommandRecord>("flipped", [&](CommandRecord& record) {
    if (record.tick != flipped) return true;
    std::uint64_t bits = 0;
    std::memcpy(&bits, &record.command.dp_I[0][0], sizeof(bits));
    bits ^= std::uint64_t{1} << 51U;  // some micrometres; increments are whole micrometres
    std::memcpy(&record.command.dp_I[0][0], &bits, sizeof(bits));
    return true;
  });
  const recording::ResimulationResult result = resimulate(other);
  ASSERT_TRUE(result.difference);
  EXPECT_EQ(result.difference->tick, flipped);
  EXPECT_EQ(result.difference->field.rfind("model.master_I[0][0]", 0), 0U) << result.difference->field;
}

TEST_F(ResimulationTest, NamesAReportThatIsNotThatOfItsExecution) {
  Tick changed = -1;
  const auto other = rewritten<ExecutionRecord>("report", [&](ExecutionRecord& record) {
    changed = record.tick;
    record.report.robot.mean = std::nextafter(record.report.robot.mean, 1.0);
    return true;
  });
  ASSERT_GE(changed, 0);
  const recording::ResimulationResult result = resimulate(other);
  ASSERT_TRUE(result.difference);
  EXPECT_EQ(result.difference->field.rfind("execution.report.robot.mean", 0), 0U) << result.difference->field;
  const auto without = rewritten<ExecutionRecord>("no_report", [](ExecutionRecord&) { return false; });
  EXPECT_TRUE(resimulate(without).difference);
}

TEST_F(ResimulationTest, NamesAContactThatIsNotThatOfItsTick) {
  Tick changed = -1;
  for (const bool is_there : {true, false}) {
    changed = -1;
    const auto other = rewritten<ContactRecord>(is_there ? "contact" : "no_contact", [&](ContactRecord& record) {
      if (changed >= 0) return true;
      changed = record.tick;
      record.f_W[2] = std::nextafter(record.f_W[2], 1e9);
      return is_there;
    });
    ASSERT_GE(changed, 0);
    const recording::ResimulationResult result = resimulate(other);
    ASSERT_TRUE(result.difference);
    EXPECT_EQ(result.difference->tick, changed);
    EXPECT_EQ(result.difference->field.rfind(is_there ? "contact.f_W[2]" : "contact.", 0), 0U)
        << result.difference->field;
  }
}

TEST_F(ResimulationTest, NamesAnEventOfAnExerciseThatDoesNotHappenAgain) {
  const auto keep = [](ExerciseRecord&) { return true; };
  const auto other = rewritten<ExerciseRecord>("event", keep, [](Tick tick, session::LogWriter& log) {
    ExerciseRecord record{tick, {}};
    record.event.kind = ExerciseEventKind::kDropped;
    if (tick == 3000) log.write(record);
  });
  const recording::ResimulationResult result = resimulate(other);
  ASSERT_TRUE(result.difference);
  EXPECT_EQ(result.difference->tick, 3000);
  EXPECT_EQ(result.difference->field, "exercise.dropped is missing");
}

TEST_F(ResimulationTest, NamesTheFirstForceThatIsNotThatOfItsStates) {
  Tick changed = -1;
  const auto other = rewritten<HapticRecord>("force", [&](HapticRecord& record) {
    if (changed >= 0 || record.haptic.force_B[0][0] == 0.0) return true;
    changed = record.haptic.tick;
    record.haptic.force_B[0][0] = std::nextafter(record.haptic.force_B[0][0], 10.0);
    return true;
  });
  ASSERT_GE(changed, 0) << "the hazard caused no force";
  const recording::ResimulationResult result = resimulate(other);
  ASSERT_TRUE(result.difference);
  EXPECT_EQ(result.difference->tick, changed);
  EXPECT_EQ(result.difference->field.rfind("haptic.force_B[0][0]", 0), 0U) << result.difference->field;
}

TEST_F(ResimulationTest, GoesOnBehindMissingForcesOnceNothingOfThemIsLeft) {
  int left_out = 0;
  const auto other = rewritten<HapticRecord>("gap", [&](HapticRecord& record) {
    const bool acts = record.haptic.force_B[0] != Vec3{};
    if (!acts || left_out >= 20) return true;
    ++left_out;
    return false;
  });
  ASSERT_EQ(left_out, 20);
  const recording::ResimulationResult result = resimulate(other);
  EXPECT_FALSE(result.difference) << result.difference->tick << ": " << result.difference->field;
  EXPECT_GT(result.forces_unknown, whole().forces_unknown + 600) << "half a second of rest plus the force under way";
  EXPECT_GT(result.forces, whole().forces / 2);
}

TEST_F(ResimulationTest, RefusesASessionWithAMissingTickOrMissingInputs) {
  const auto no_tick = rewritten<TickRecord>("no_tick", [](TickRecord& record) { return record.model.tick != 3000; });
  EXPECT_THROW(resimulate(no_tick), SessionException);
  const Tick left_out = strokeTick();
  const auto no_command =
      rewritten<CommandRecord>("no_command", [&](CommandRecord& record) { return record.tick != left_out; });
  EXPECT_TRUE(resimulate(no_command).difference);
  const auto no_slip = rewritten<TickRecord>("no_slip", [](TickRecord& record) {
    record.slipped = 0;
    return true;
  });
  EXPECT_TRUE(resimulate(no_slip).difference) << "a time slip is an input, like the others";
}

TEST_F(ResimulationTest, FindsTheConfigurationInTheSessionItself) {
  TrainerConfig recorded = packagedConfig();
  recorded.hazard = "none";
  recorded.seed = 5;
  recorded.model.arm_contacts = {false, true};
  const session::SessionPaths own = session::createSessionDirectory((folder / "own").string());
  {
    Lockstep lockstep(recorded, console::makeMotion(recorded, "scripted"), own, "scripted");
    ASSERT_TRUE(lockstep.run(1.0, {}));
  }
  const TrainerConfig found = recording::sessionConfig(own);
  EXPECT_EQ(found.seed, 5U);
  EXPECT_EQ(found.hazard, "none");
  EXPECT_EQ(found.model.arm_contacts, recorded.model.arm_contacts);
  EXPECT_EQ(found.robot_urdf.rfind(own.directory, 0), 0U) << found.robot_urdf;
  EXPECT_FALSE(recording::Resimulation(found, own, "").run({}).difference);
  std::ofstream(own.directory + "/configuration/config/model.yaml", std::ios::app) << "# changed\n";
  EXPECT_THROW(recording::sessionConfig(own), SessionException);
}

TEST_F(ResimulationTest, PlansNothingInASessionOfCommandsWhateverItsConfigurationSays) {
  TrainerConfig commanded = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml", {},
                                                      {{"runtime/plan_at", "0.1", "a parameter"}});
  raven2_trainer::testing::homeQuickly(&commanded);
  commanded.hazard = "none";
  commanded.runtime.plan_at = -1.0;  // as simulate and a Python session do
  console::HandsCommand up, down;
  down.pedal = true;
  std::vector<console::CommandRow> rows{{4000, up}, {300, down}, {300, up}};
  const session::SessionPaths own = session::createSessionDirectory((folder / "commanded").string());
  {
    Lockstep lockstep(commanded, console::makeCommanded(commanded.console, {}, std::move(rows)), own, "commands");
    ASSERT_TRUE(lockstep.run(30.0, {}, Lockstep::End::kAtOnce));
    ASSERT_GT(lockstep.view().model.session_tick, 400) << "the pedal is up, and the plan would be due";
  }
  const auto difference = recording::Resimulation(recording::sessionConfig(own), own, "").run({}).difference;
  EXPECT_FALSE(difference) << difference->field;
}

TEST_F(ResimulationTest, OfASessionOfAnotherModelIsRefusedInASentence) {
  const session::SessionPaths old = session::createSessionDirectory((folder / "old").string());
  session::LogHeader header;
  header.model_version = 1;
  session::LogWriter(old.log(), header).finish({});
  try {
    recording::sessionConfig(old);
    FAIL() << "the session was accepted";
  } catch (const SessionException& e) {
    const std::string said = "recorded with version 1 of the nominal model, this program has version ";
    EXPECT_NE(std::string(e.what()).find(said + std::to_string(kModelVersion)), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace raven2_trainer::lockstep
