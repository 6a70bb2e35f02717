#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/recording/recorder.h"
#include "raven2_trainer/recording/session_player.h"
#include "session/record_frame.h"
#include "support/mode_driver.h"

// A recorded session shown by the daemon: doc/modes.md.

namespace raven2_trainer::lockstep {
namespace {

namespace fs = std::filesystem;
using raven2_trainer::testing::apart;
using raven2_trainer::testing::ModeDriver;

class SessionReplay : public ::testing::Test {
 protected:
  /** Records a session of about 2 s, with a clutch and a grasp. */
  static void SetUpTestSuite() {
    raven2_trainer::testing::useOde();
    folder = fs::temp_directory_path() / ("raven2_session_replay_" + std::to_string(getpid()));
    fs::remove_all(folder);
    ModeDriver d;
    const session::SessionPaths paths = session::createSessionDirectory((folder / "recorded").string());
    recording::Recorder recorder(d.rig.config, d.rig.physics.bodyNames(), paths, "test", d.rig.shared.get());
    d.rig.record = [&] { recorder.drain(); };
    ASSERT_TRUE(d.begin());
    d.stroke(600, 1.0, 0.002);
    d.rest(false, 80);
    d.stroke(600, 0.5);
    d.rest(false, 300);
    recorder.finish(d.rig.counts());
    d.rig.record = nullptr;
    recorded = paths.directory;
    session::LogVisitor visitor;
    visitor.tick = [](const TickRecord& record) {
      if (record.model.session_tick >= 0) ticks.push_back(record.model);
    };
    session::readLog(paths.log(), visitor);
    ASSERT_GT(ticks.size(), 1500U);
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  void SetUp() override {
    raven2_trainer::testing::useOde();
    d = std::make_unique<ModeDriver>();
    ASSERT_TRUE(d->begin());
    player = std::make_unique<recording::SessionPlayer>(d->rig.config, d->rig.physics.bodyNames(), d->rig.shared.get());
  }

  PlanningAnswer show(std::uint32_t replay, bool pedal = false) {
    Request request;
    request.kind = RequestKind::kBeginReplay;
    request.plan = replay;
    return d->ask(request, pedal);
  }

  /** The error message of open() for a session; empty: accepted. */
  std::string refusal(const std::string& path) {
    try {
      player->open(path);
    } catch (const SessionException& e) {
      return e.what();
    }
    return "";
  }

  /** A log of these ticks with the recorded session's header. */
  static std::string written(const std::string& name,
                             const std::vector<ModelState>& models,
                             const std::function<void(session::LogHeader*)>& change = {}) {
    session::LogHeader header = session::readLogHeader(recorded + "/session.rlog");
    if (change) change(&header);
    const std::string path = (folder / name).string();
    session::LogWriter log(path, header);
    for (const ModelState& model : models)
      log.write(TickRecord{model, {}, 0});
    return path;
  }

  void expectShown(const ModelState& then) const {
    const ModelState now = d->rig.model();
    for (const Arm arm : kArms)
      ASSERT_EQ(at(now.arms, arm).q, at(then.arms, arm).q);
    for (std::size_t i = 0; i < kMaxSceneBodies; ++i) {
      ASSERT_EQ(now.bodies[i].p, then.bodies[i].p);
      ASSERT_EQ(now.bodies[i].q, then.bodies[i].q);
    }
  }

  /** Model and robot are back in their common pose, and linked from the next pedal-down on. */
  void expectNothingChanged(const ModelState& before) {
    for (const Arm arm : kArms)
      EXPECT_LT(apart(d->modelTip(arm), at(before.arms, arm).p_BT), 0.1e-3);
    for (std::size_t i = 0; i < kMaxSceneBodies; ++i)
      EXPECT_LT(apart(d->rig.model().bodies[i].p, before.bodies[i].p), 1e-5);
    d->rest(false, 5);
    d->rest(true, 100);
    EXPECT_EQ(d->mode(), Mode::kTeleoperating);
    EXPECT_EQ(d->rig.model().linked, 1);
    EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
  }

  static inline fs::path folder;
  static inline std::string recorded;
  static inline std::vector<ModelState> ticks;  ///< of it, from the first pedal-down on
  std::unique_ptr<ModeDriver> d;
  std::unique_ptr<recording::SessionPlayer> player;
};

TEST_F(SessionReplay, ShowsItTickByTickAndPutsEverythingBack) {
  const ModelState before = d->rig.model();
  const Vec3 stood = d->robotTip();
  double farthest = 0.0;
  const std::uint32_t replay = player->open(recorded);
  ASSERT_EQ(show(replay), PlanningAnswer::kAccepted);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    ASSERT_EQ(d->mode(), Mode::kReplaying) << i;
    expectShown(ticks[i]);
    if (HasFatalFailure()) return;
    ASSERT_EQ(d->rig.last_relay.command.pedal, 0);
    ASSERT_EQ(d->rig.last_relay.command.dp_I[0], Vec3{});
    ASSERT_EQ(d->rig.force().force_B[0], Vec3{});
    ASSERT_EQ(d->rig.model().linked, 0);
    ASSERT_EQ(d->rig.shared->contacts.load().count, 0U);
    farthest = std::max(farthest, d->rig.error(Arm::kGold));
    if (i % 50 == 0) player->serve();
    MasterCommand moved;  // motion with the pedal up moves nothing
    moved.dp_I[0] = {20e-6, 0.0, 0.0};
    d->tick(moved);
  }
  EXPECT_EQ(d->mode(), Mode::kPedalUp) << "the end of the log ends the replay";
  EXPECT_GT(farthest, 8e-3) << "or the replay showed nothing";
  EXPECT_LT(apart(d->robotTip(), stood), 1e-6);
  expectNothingChanged(before);
}

TEST_F(SessionReplay, APressEndsItAndTheNextOneEngages) {
  const ModelState before = d->rig.model();
  ASSERT_EQ(show(player->open(recorded + "/session.rlog")), PlanningAnswer::kAccepted);
  d->rest(false, 400);
  ASSERT_EQ(d->mode(), Mode::kReplaying);
  ASSERT_GT(d->rig.error(Arm::kGold), 3e-3);
  d->rest(true, 1);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  d->stroke(200, 1.0);
  EXPECT_EQ(d->mode(), Mode::kPedalUp) << "the pedal was pressed during the replay";
  EXPECT_EQ(d->rig.last_relay.command.pedal, 0);
  expectNothingChanged(before);
}

TEST_F(SessionReplay, ARequestOrAStopEndsIt) {
  const ModelState before = d->rig.model();
  EXPECT_EQ(d->ask(RequestKind::kEndReplay), PlanningAnswer::kNotNow) << "no replay is running";
  ASSERT_EQ(show(player->open(recorded)), PlanningAnswer::kAccepted);
  d->rest(false, 400);
  EXPECT_EQ(d->ask(RequestKind::kBeginSimulation), PlanningAnswer::kNotNow);
  EXPECT_EQ(d->ask(RequestKind::kEndReplay), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  ASSERT_EQ(show(player->open(recorded)), PlanningAnswer::kAccepted);
  d->rest(false, 400);
  ASSERT_GT(d->rig.error(Arm::kGold), 3e-3);
  EXPECT_EQ(d->ask(RequestKind::kEmergencyStop), PlanningAnswer::kAccepted);
  EXPECT_EQ(d->mode(), Mode::kStopped);
  EXPECT_LT(d->rig.error(Arm::kGold), 0.5e-3);
  d->rest(false, 50);
  EXPECT_EQ(d->ask(RequestKind::kClearStop), PlanningAnswer::kAccepted);
  expectNothingChanged(before);
}

TEST_F(SessionReplay, WhatIsLeftOfOneThatWasGivenUpIsNeverShown) {
  ASSERT_EQ(show(player->open(recorded)), PlanningAnswer::kAccepted);
  d->rest(false, 300);
  d->ask(RequestKind::kEndReplay);
  const ModelState before = d->rig.model();
  ModelState elsewhere = ticks.front();
  elsewhere.arms[0].q[kInsertion] += 0.015;
  player->open(written("elsewhere.rlog", std::vector<ModelState>(500, elsewhere)));
  ASSERT_EQ(show(2), PlanningAnswer::kAccepted);
  int shown = 0;
  for (int i = 0; i < 700 && d->mode() == Mode::kReplaying; ++i) {
    const double q = d->rig.model().arms[0].q[kInsertion];
    const bool is_it = q == elsewhere.arms[0].q[kInsertion];
    shown += is_it ? 1 : 0;
    ASSERT_TRUE(is_it || q == before.arms[0].q[kInsertion]) << i;
    player->serve();
    d->rest(false, 1);
  }
  EXPECT_EQ(shown, 500);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
}

TEST_F(SessionReplay, WithoutMoreOfItTheLastTickStays) {
  ASSERT_EQ(show(player->open(recorded)), PlanningAnswer::kAccepted);
  d->rest(false, 1200);
  ASSERT_EQ(d->mode(), Mode::kReplaying);
  expectShown(ticks[kReplayFrames - 1]);
  player->serve();
  d->rest(false, 1);
  expectShown(ticks[kReplayFrames]);
}

TEST_F(SessionReplay, ARobotThatMovedMeanwhileIsGoneTo) {
  ASSERT_EQ(show(player->open(recorded)), PlanningAnswer::kAccepted);
  d->rest(false, 100);
  RobotState elsewhere = d->rig.robot();
  elsewhere.arms[0].q[kInsertion] += 0.008;
  d->rig.robot_connected = false;
  std::array<std::uint8_t, wire::kMaxFrame> frame;
  const auto tick = [&] {
    ++elsewhere.cycle;
    const std::int64_t now_ns = elsewhere.time_ns = d->rig.model().time_ns + kTickNanoseconds;
    d->rig.link.receive(frame.data(), wire::encodeState(1, elsewhere, frame.data()), now_ns);
    d->rest(false, 1);
  };
  tick();
  Request end;
  end.kind = RequestKind::kEndReplay;
  ASSERT_TRUE(d->rig.shared->requests.tryPush(end));
  tick();
  EXPECT_EQ(d->mode(), Mode::kReturning);
  Vec3 before = d->modelTip();
  double fastest = 0.0;
  for (int i = 0; i < 4000 && d->mode() == Mode::kReturning; ++i) {
    tick();
    fastest = std::max(fastest, apart(d->modelTip(), before));
    before = d->modelTip();
  }
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
  EXPECT_NEAR(d->rig.model().arms[0].q[kInsertion], elsewhere.arms[0].q[kInsertion], 1e-3);
  EXPECT_LT(fastest, 0.5e-3);
}

TEST_F(SessionReplay, WhatCannotBeShownIsRefusedWithTheReason) {
  EXPECT_NE(refusal((folder / "nowhere").string()).find("cannot be opened"), std::string::npos);
  const std::vector<ModelState> some(ticks.begin(), ticks.begin() + 10);
  EXPECT_EQ(refusal(written("some.rlog", some)), "");
  EXPECT_NE(refusal(written("arms.rlog", some, [](auto* header) { header->d4 += 0.001; })).find("other arms"),
            std::string::npos);
  const auto robot = [](session::LogHeader* header) { header->robot_urdf_hash[0] ^= 1; };
  EXPECT_NE(refusal(written("robot.rlog", some, robot)).find("other arms"), std::string::npos);
  const auto scene = [](session::LogHeader* header) { header->scene_urdf_hash[0] ^= 1; };
  EXPECT_NE(refusal(written("scene.rlog", some, scene)).find("another scene"), std::string::npos);
  const auto bodies = [](session::LogHeader* header) { header->body_names.pop_back(); };
  EXPECT_NE(refusal(written("bodies.rlog", some, bodies)).find("another scene"), std::string::npos);
  std::vector<ModelState> waiting = some;
  for (ModelState& model : waiting)
    model.session_tick = -1;
  EXPECT_NE(refusal(written("waiting.rlog", waiting)).find("no pedal went down"), std::string::npos);
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
}

TEST_F(SessionReplay, APipeInTheLogsPlaceIsNotOpened) {
  const fs::path session = folder / "pipe";
  fs::create_directory(session);
  const std::string pipe = (session / "session.rlog").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int fd = open(pipe.c_str(), O_RDWR);  // keeps a reader of the pipe from waiting for a writer
  ASSERT_GE(fd, 0);
  ASSERT_EQ(write(fd, std::string(4096, 'x').data(), 4096), 4096);
  EXPECT_NE(refusal(session.string()).find("is no file"), std::string::npos);
  close(fd);
}

TEST_F(SessionReplay, ALogOfAnotherVersionIsRefused) {
  std::ifstream in(recorded + "/session.rlog", std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, sizeof(length));
  const std::string ours = "\"version\":" + std::to_string(session::kRecordVersion);
  const std::size_t place = bytes.find(ours);
  ASSERT_LT(place, length);
  bytes[place + ours.size() - 1] ^= 1;  // another digit
  const std::uint32_t crc =
      session::crc32Of(reinterpret_cast<const std::uint8_t*>(bytes.data()), session::kFrameHeaderSize + length);
  std::memcpy(&bytes[session::kFrameHeaderSize + length], &crc, sizeof(crc));
  const fs::path other = folder / "other.rlog";
  std::ofstream(other, std::ios::binary) << bytes;
  EXPECT_NE(refusal(other.string()).find("another version"), std::string::npos);
}

TEST_F(SessionReplay, ItIsRefusedWhereItCannotBe) {
  const std::uint32_t replay = player->open(recorded);
  EXPECT_EQ(show(0), PlanningAnswer::kNotNow) << "no log was opened for it";
  d->rest(true, 50);
  EXPECT_EQ(show(replay, true), PlanningAnswer::kNotNow);
  EXPECT_EQ(d->mode(), Mode::kTeleoperating);
  d->rest(false, 50);
  ASSERT_EQ(show(replay), PlanningAnswer::kAccepted);
  EXPECT_EQ(show(replay + 1), PlanningAnswer::kNotNow);
  d->ask(RequestKind::kEndReplay);
  EXPECT_EQ(show(replay), PlanningAnswer::kNotNow) << "each replay is shown once";
}

TEST_F(SessionReplay, NumbersThatCannotBeAreLeftOut) {
  std::vector<ModelState> damaged(ticks.begin(), ticks.begin() + 8);
  damaged[0].arms[1].q[kShoulder] = std::numeric_limits<double>::quiet_NaN();
  damaged[2].arms[0].q[kElbow] = 11.0;
  damaged[3].bodies[0].p[1] = std::numeric_limits<double>::infinity();
  damaged[5].bodies[kMaxSceneBodies - 1].q = {0.0, 0.0, 0.0, 0.9};
  ASSERT_EQ(show(player->open(written("damaged.rlog", damaged))), PlanningAnswer::kAccepted);
  for (const std::size_t left : {1, 4, 6, 7}) {
    ASSERT_EQ(d->mode(), Mode::kReplaying);
    expectShown(damaged[left]);
    d->rest(false, 1);
  }
  EXPECT_EQ(d->mode(), Mode::kPedalUp);
}

TEST_F(SessionReplay, OfTheSessionThatIsBeingRecordedItShowsWhatWasWritten) {
  const session::SessionPaths paths = session::createSessionDirectory((folder / "own").string());
  recording::Recorder recorder(d->rig.config, d->rig.physics.bodyNames(), paths, "test", d->rig.shared.get());
  d->rig.record = [&] { recorder.drain(); };
  d->stroke(200, 1.0);
  d->rest(false, 60);
  ASSERT_EQ(show(player->open(paths.directory)), PlanningAnswer::kAccepted);
  int shown = 0;
  for (; shown < 1000 && d->mode() == Mode::kReplaying; ++shown) {
    d->rest(false, 1);
    player->serve();
  }
  EXPECT_EQ(shown, 260);
  d->rig.record = nullptr;
}

}  // namespace
}  // namespace raven2_trainer::lockstep
