#include <diagnostic_msgs/DiagnosticArray.h>

#include <algorithm>

#include "fixture.h"

namespace raven2_trainer {
namespace {

bool robotIsThere(const Latest<diagnostic_msgs::DiagnosticArray>& diagnostics) {
  for (const auto& status : diagnostics.get().status) {
    if (status.name == "raven2_trainer: robot") return status.level == diagnostic_msgs::DiagnosticStatus::OK;
  }
  return false;
}

// The virtual Raven of this test ends some seconds after its start and is started again by roslaunch.
TEST(RobotDrop, TheModelGoesOnAloneAndTheReturningRobotCausesNoForce) {
  Latest<sensor_msgs::JointState> model("model/joint_states"), robot("robot/joint_states");
  Latest<geometry_msgs::WrenchStamped> gold("haptic/gold/force"), green("haptic/green/force");
  Latest<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  ASSERT_TRUE(waitFor([&] { return isMoving(model) && isMoving(robot) && robotIsThere(diagnostics); }, kStartDeadline));

  ASSERT_TRUE(waitFor([&] { return robot.age() > 0.3 && !robotIsThere(diagnostics); }, 30.0)) << "it never dropped";
  const int before = model.count();
  EXPECT_TRUE(waitFor([&] { return model.count() > before + 20; }, 2.0)) << "the model stopped with the robot";

  double force = 0.0;
  const auto watch = [&] { force = std::max({force, magnitude(gold.get()), magnitude(green.get())}); };
  ASSERT_TRUE(waitFor(
      [&] {
        watch();
        return robot.age() < 0.1 && robotIsThere(diagnostics);
      },
      30.0))
      << "it never returned";
  const int back = gold.count();
  waitFor(
      [&] {
        watch();
        return gold.count() > back + 100;
      },
      10.0);
  EXPECT_EQ(force, 0.0) << "the offset of model and robot until the next pedal-down is no hazard";
}

}  // namespace
}  // namespace raven2_trainer

RAVEN2_INTEGRATION_MAIN("robot_drop_test")
