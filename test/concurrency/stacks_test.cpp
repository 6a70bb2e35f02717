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

struct StackRun {
  std::vector<double> joints;  ///< of the model and the robot, both arms, tick by tick
  int moved{0}, faulted{0};    ///< ticks in which the expert moved the arms, and in which the hazard acted
};

StackRun runOf(const TrainerConfig& config) {
  physics::attachOdeToThread();
  LockstepStack stack(config, console::makeMotion(config, std::string("expert")));
  StackRun run;
  for (int i = 0; i < kTicks; ++i) {
    stack.tick();
    stack.discardRecords();
    if (stack.view().model.mode == Mode::kTeleoperating && ++run.moved == 100)
      stack.arm(faults::immediatePlan(config, config::faultId(config, "fk_pos"), 0));
    run.faulted += stack.robot().active_fault != 0 ? 1 : 0;
    for (const Arm arm : kArms) {
      const JointArray& model = at(stack.view().model.arms, arm).q;
      const JointArray robot = stack.trueJoints(arm);
      run.joints.insert(run.joints.end(), model.begin(), model.end());
      run.joints.insert(run.joints.end(), robot.begin(), robot.end());
    }
  }
  return run;
}

TEST(Stacks, FourInThreadsComputeWhatEachComputesAlone) {
  testing::useOde();
  std::vector<TrainerConfig> configs;
  std::vector<StackRun> alone, together(kStacks);
  for (int i = 0; i < kStacks; ++i) {
    configs.push_back(configOf(i));
    alone.push_back(runOf(configs.back()));
  }
  std::vector<std::thread> threads;
  for (int i = 0; i < kStacks; ++i)
    threads.emplace_back(
        [&, i] { together[static_cast<std::size_t>(i)] = runOf(configs[static_cast<std::size_t>(i)]); });
  for (std::thread& thread : threads)
    thread.join();
  for (std::size_t i = 0; i < kStacks; ++i) {
    EXPECT_EQ(together[i].joints, alone[i].joints) << "stack " << i;
    EXPECT_NE(alone[i].joints, alone[(i + 1) % kStacks].joints) << "the stacks do different things";
    EXPECT_GT(alone[i].moved, 200);
    EXPECT_GT(alone[i].faulted, 0);
  }
}

}  // namespace
}  // namespace raven2_trainer::lockstep
