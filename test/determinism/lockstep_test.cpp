#include "raven2_trainer/lockstep/lockstep.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/training/session_metrics.h"
#include "support/rig.h"

namespace raven2_trainer::lockstep {
namespace {

constexpr double kSeconds = 3.0;  // one sudden jump, at 1.5 s

class LockstepTest : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    folder_ = std::filesystem::temp_directory_path() / ("raven2_lockstep_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  session::SessionPaths run(const std::string& name, std::uint64_t seed, const std::string& hazard) {
    TrainerConfig config = raven2_trainer::testing::packagedConfig();
    config.seed = seed;
    config.hazard = hazard;
    config.console.clutch_every = 1.0;
    raven2_trainer::testing::onlyFaultOf(&config, "sudden_jump").first_tick = 1500;
    const session::SessionPaths paths = session::createSessionDirectory((folder_ / name).string());
    Lockstep lockstep(config, console::makeMotion(config, "scripted"), paths, "scripted");
    EXPECT_TRUE(lockstep.run(kSeconds, {}));
    const char* wrong = wrongSum(training::computeMetrics(paths.log()).counts);
    EXPECT_EQ(wrong, nullptr) << wrong;
    return paths;
  }

  std::filesystem::path folder_;
};

TEST_F(LockstepTest, TheSameSeedGivesTheSameBytesAndAnotherSeedDoesNot) {
  const std::string first = session::fileHash(run("a", 1, "sudden_jump").log());
  EXPECT_NE(session::fileHash(run("b", 2, "sudden_jump").log()), first);
  EXPECT_EQ(session::fileHash(run("c", 1, "sudden_jump").log()), first) << "the previous session left something behind";
}

TEST_F(LockstepTest, ABadLinkIsTheSameBadLinkFromTheSameSeed) {
  Impairment link;
  link.loss = 0.05;
  link.delay.constant_ns = 30'000'000;
  link.delay.uniform_ns = 5'000'000;
  link.delay.overtaking = true;
  link.duplicate = 0.05;
  const auto over = [&](const std::string& name, std::uint64_t seed) {
    TrainerConfig config = raven2_trainer::testing::packagedConfig();
    config.seed = seed;
    config.hazard = "none";
    const session::SessionPaths paths = session::createSessionDirectory((folder_ / name).string());
    Lockstep lockstep(config, console::makeMotion(config, "scripted"), paths, "scripted over a bad link");
    lockstep.impair(link);
    EXPECT_TRUE(lockstep.run(2.0, {}));
    return paths.log();
  };
  const std::string first = over("bad_a", 1);
  EXPECT_EQ(session::fileHash(over("bad_b", 1)), session::fileHash(first));
  EXPECT_NE(session::fileHash(over("bad_c", 2)), session::fileHash(first));
  const LinkCounts master = training::computeMetrics(first).counts.master;
  EXPECT_TRUE(master.addsUp());
  EXPECT_GT(master.rejected[static_cast<std::size_t>(Reject::kDuplicate)], 0U);
  EXPECT_GT(master.rejected[static_cast<std::size_t>(Reject::kOutOfOrder)], 0U);
}

TEST_F(LockstepTest, AHazardIsFeltAndOnlyAHazard) {
  const training::SessionMetrics jump = training::computeMetrics(run("jump", 1, "sudden_jump").log());
  ASSERT_EQ(jump.faults.size(), 1U);
  EXPECT_EQ(jump.faults[0].last_tick - jump.faults[0].first_tick + 1, 300) << "the fault lasts 300 cycles";
  EXPECT_GT(jump.faults[0].max_error, 0.003);
  EXPECT_GT(jump.faults[0].max_force, 0.0);
  EXPECT_EQ(jump.error_max_force, 0.0);
  const training::SessionMetrics calm = training::computeMetrics(run("calm", 1, "none").log());
  EXPECT_TRUE(calm.faults.empty());
  EXPECT_EQ(calm.max_force, 0.0);
  EXPECT_EQ(calm.ticks, 3000U);
}

TEST_F(LockstepTest, EveryLinksCountersAddUp) {
  const SessionCounts counts = training::computeMetrics(run("counts", 3, "sudden_jump").log()).counts;
  for (const LinkCounts& link : {counts.master, counts.relay, counts.robot_state}) {
    EXPECT_TRUE(link.addsUp());
    EXPECT_GT(link.applied, 3000U);
    EXPECT_EQ(link.rejectedTotal(), 0U);
  }
  EXPECT_EQ(counts.records_dropped, 0U);
}

}  // namespace
}  // namespace raven2_trainer::lockstep
