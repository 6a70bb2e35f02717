#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/impair/impairment.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "support/effort.h"
#include "support/rig.h"

// The haptic port in whole sessions: console, daemon and virtual Raven in lockstep.

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::packagedConfig;

// [s] includes the jump at 8 s; in the long form also the jumps at 16 and 24 s
const double kJumpsSeconds = static_cast<double>(raven2_trainer::testing::effort(10, 26));

struct PortOfSession {
  double energy{0.0};      ///< [J] largest, either arm
  double least_gain{1.0};  ///< [-]
  double force{0.0};       ///< [N] largest
  double free_force{0.0};  ///< [N] largest while model and robot were within the tolerance, and 50 ms later
  int felt{0};             ///< ticks with a force
};

class HapticSession : public ::testing::Test {
 protected:
  static PortOfSession run(const TrainerConfig& config, double seconds, const Impairment* impairment = nullptr) {
    raven2_trainer::testing::useOde();
    const auto folder = std::filesystem::temp_directory_path() / ("raven2_haptic_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder);
    PortOfSession port;
    {
      Lockstep session(config, console::makeMotion(config, "scripted"),
                       session::createSessionDirectory(folder.string()), "scripted");
      if (impairment != nullptr) session.impair(*impairment);
      PerArm<int> since_deviation{1000, 1000};
      while (session.view().model.session_tick < static_cast<Tick>(seconds / kTickSeconds)) {
        session.tick();
        add(session.view().haptic, config, &since_deviation, &port);
        if (session.view().model.tick > 60000) {
          ADD_FAILURE() << "the session did not reach that length";
          break;
        }
      }
    }
    std::filesystem::remove_all(folder);
    return port;
  }

  static void add(const HapticState& haptic, const TrainerConfig& config, PerArm<int>* since, PortOfSession* port) {
    for (const Arm arm : kArms) {
      const double force = toEigen(at(haptic.force_I, arm)).norm();
      int& ticks = at(*since, arm);
      ticks = at(haptic.error, arm) > config.haptics.tolerance ? 0 : ticks + 1;
      port->energy = std::max(port->energy, at(haptic.energy, arm));
      port->least_gain = std::min(port->least_gain, at(haptic.gain, arm));
      port->force = std::max(port->force, force);
      if (ticks > 50) port->free_force = std::max(port->free_force, force);
      if (force > 0.0) ++port->felt;
    }
  }

  static void print(const char* what, const PortOfSession& port) {
    std::printf("%-44s largest energy %7.3f mJ, least gain %.3f, largest force %.3f N, %d arm ticks felt\n", what,
                1e3 * port.energy, port.least_gain, port.force, port.felt);
  }
};

TEST_F(HapticSession, TeleoperationWithoutAFaultStaysFreeOfForce) {
  TrainerConfig config = packagedConfig();
  config.hazard = "none";
  const PortOfSession port = run(config, 12.0);
  print("no fault", port);
  EXPECT_EQ(port.force, 0.0);
  EXPECT_EQ(port.energy, 0.0);
}

TEST_F(HapticSession, TheSuddenJumpIsFeltWholeWithThePassivityControllerOn) {
  TrainerConfig config = packagedConfig();
  config.hazard = "sudden_jump";
  ASSERT_TRUE(config.haptics.passivity.enabled);
  const PortOfSession port = run(config, kJumpsSeconds);
  print("sudden_jump", port);
  EXPECT_GT(port.felt, 100);
  EXPECT_GT(port.force, 0.4);
  EXPECT_EQ(port.free_force, 0.0);
  EXPECT_EQ(port.least_gain, 1.0) << "the passivity controller reduced a force that causes no oscillation";
}

TEST_F(HapticSession, ALooseHandBehindFiftyMillisecondsFeelsItToo) {
  TrainerConfig config = packagedConfig();
  config.hazard = "sudden_jump";
  config.console.hand_mass = 0.15;
  config.console.hand_damping = 2.0;
  Impairment link;
  link.delay.constant_ns = 50 * kTickNanoseconds;
  const PortOfSession port = run(config, kJumpsSeconds, &link);
  print("sudden_jump, loose hand, 50 ms each way", port);
  EXPECT_GT(port.felt, 100);
  EXPECT_GT(port.energy, 0.0);
  EXPECT_EQ(port.free_force, 0.0);
  EXPECT_EQ(port.least_gain, 1.0) << "a force of 0.3 s causes no oscillation";
}

}  // namespace
}  // namespace raven2_trainer::lockstep
