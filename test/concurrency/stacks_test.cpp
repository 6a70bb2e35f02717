#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/faults/arming.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "support/rig.h"

// Several whole stacks in one process, each in its own thread, as the Python module runs them.

namespace raven2_trainer::lockstep {
namespace {

constexpr int kStacks = 4;
constexpr int kTicks = 1500;  // the robot is homed and follows the expert; a hazard acts

TrainerConfig configOf(int stack) {
  TrainerConfig config = testing::packagedConfig();
  config::loadTraining({stack % 2 == 0 ? "pick_hand_over_place" : "peg_transfer", "none", "", "none"}, &config);
  config.seed = static_cast<std::uint64_t>(stack + 1);
  return config;
}

/** Joints of the model and the robot, both arms, tick by tick. */
std::vector<double> jointsOf(const TrainerConfig& config) {
  physics::attachOdeToThread();
  LockstepStack stack(config, console::makeMotion(config, std::string("expert")));
  stack.arm(faults::planFor(config, config::faultId(config, "fk_pos"), 0));
  std::vector<double> joints;
  for (int i = 0; i < kTicks; ++i) {
    stack.tick();
    stack.discardRecords();
    for (const Arm arm : kArms) {
      const JointArray& model = at(stack.view().model.arms, arm).q;
      const JointArray robot = stack.trueJoints(arm);
      joints.insert(joints.end(), model.begin(), model.end());
      joints.insert(joints.end(), robot.begin(), robot.end());
    }
  }
  return joints;
}

TEST(Stacks, FourInThreadsComputeWhatEachComputesAlone) {
  testing::useOde();
  std::vector<TrainerConfig> configs;
  std::vector<std::vector<double>> alone, together(kStacks);
  for (int i = 0; i < kStacks; ++i) {
    configs.push_back(configOf(i));
    alone.push_back(jointsOf(configs.back()));
  }
  std::vector<std::thread> threads;
  for (int i = 0; i < kStacks; ++i)
    threads.emplace_back(
        [&, i] { together[static_cast<std::size_t>(i)] = jointsOf(configs[static_cast<std::size_t>(i)]); });
  for (std::thread& thread : threads)
    thread.join();
  for (std::size_t i = 0; i < kStacks; ++i) {
    EXPECT_EQ(together[i], alone[i]) << "stack " << i;
    EXPECT_NE(alone[i], alone[(i + 1) % kStacks]) << "the stacks do different things";
    EXPECT_NE(alone[i].front(), alone[i][alone[i].size() - 28]) << "the arms moved";
  }
}

}  // namespace
}  // namespace raven2_trainer::lockstep
