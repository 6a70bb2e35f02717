#include <time.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "planning/roll_out.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/raven_world.h"

// Cost of a roll-out: the world of one arm alone, under its control law, and with every state judged in the FRS scene.

namespace raven2_trainer::planning {
namespace {

constexpr int kPasses = 15;

/** [s] processor time of this thread, without other programs. */
double now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/** Prints least and median time of the passes. */
template <typename Part>
void report(const char* what, double simulated, const Part& part) {
  std::vector<double> seconds;
  for (int pass = 0; pass < kPasses; ++pass) {
    const double start = now();
    part();
    seconds.push_back(now() - start);
  }
  std::sort(seconds.begin(), seconds.end());
  const double least = seconds.front(), median = seconds[seconds.size() / 2];
  std::printf("  %-44s %6.2f us a tick (median %6.2f), %5.0f x real time (median %5.0f)\n", what,
              1e3 * least / simulated, 1e3 * median / simulated, simulated / least, simulated / median);
}

class Benchmark {
 public:
  Benchmark() {
    const JointArray home = config_.arms.geometry.home;
    waypoints_ = {home, home, home, home};
    waypoints_[1] = moved(home, {0.2, 0.1, 0.02, 0.5, 0.0, 0.0, 0.0});
    waypoints_[2] = moved(home, {0.2, -0.1, 0.01, 0.2, 0.3, 0.1, -0.1});
    waypoints_[3] = moved(home, {-0.1, -0.1, 0.01, 0.0, 0.0, 0.0, 0.0});
    for (std::size_t i = 0; i + 1 < waypoints_.size(); ++i) {
      JointArray delta{};
      for (std::size_t j = 0; j < kJointCount; ++j)
        delta[j] = waypoints_[i + 1][j] - waypoints_[i][j];
      arrival_.push_back(arrival_.back() + control::quinticDuration(delta, config_.planner.velocity_limit,
                                                                    config_.planner.acceleration_limit));
    }
  }

  void world() {
    physics::ArmWorld world(raven_, Arm::kGold, config_.model);
    world.setState(waypoints_[0], JointArray{});
    const JointArray tau = world.gravityTorque();
    report("world of one arm, torques held", 2.0, [&] {
      world.setState(waypoints_[0], {0.3, -0.3, 0.02, 0.5, 0.5, 0.1, 0.1});
      for (int tick = 0; tick < 2000; ++tick)
        world.step(tau);
    });
    control::ArmController controller(config_.model, Arm::kGold);
    report("world and law along a path", arrival_.back(), [&] {
      world.setState(waypoints_[0], JointArray{});
      std::size_t edge = 0;
      for (int tick = 1; tick * kTickSeconds < arrival_.back(); ++tick) {
        const double t = tick * kTickSeconds;
        while (t >= arrival_[edge + 1])
          ++edge;
        const control::JointTarget target =
            control::quinticTarget(waypoints_[edge], waypoints_[edge + 1], arrival_[edge], arrival_[edge + 1], t);
        world.step(controller.torque(controller.leading(target), world.q(), world.dq(), world.gravityTorque()));
      }
    });
  }

  void rollOut() {
    const SceneObstacles obstacles(scene_);
    RollOut roll_out(raven_, obstacles, config_.model, Arm::kGold);
    const JointArray other = config_.arms.geometry.home;
    const RollOutReport once = roll_out.follow(waypoints_, arrival_, other);
    std::printf("  path of %.2f s: %s, clearance %.1f mm, tracking error %.2f mm\n", once.duration,
                once.free ? "free" : "NOT free", 1e3 * once.clearance, 1e3 * once.tracking_error);
    report("roll-out, FCL's distance", once.duration, [&] { fresh(&roll_out, other); });
    roll_out.useClearance([](const JointArray&) { return 0.005; });
    report("roll-out, a distance of 5 mm for nothing", once.duration, [&] { fresh(&roll_out, other); });
  }

 private:
  static JointArray moved(JointArray q, const JointArray& by) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] += by[j];
    return q;
  }

  /** Follows another path first, so that the roll-out remembers nothing of this path. */
  void fresh(RollOut* roll_out, const JointArray& other) const {
    roll_out->follow({waypoints_[1]}, {0.0}, other);
    roll_out->follow(waypoints_, arrival_, other);
  }

  TrainerConfig config_ = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  model::RavenModel raven_ = model::loadRavenModel(config_);
  model::SceneModel scene_ = model::loadSceneModel(config_);
  std::vector<JointArray> waypoints_;
  std::vector<double> arrival_{0.0};
};

}  // namespace
}  // namespace raven2_trainer::planning

int main() {
  raven2_trainer::physics::initialiseOde();
  raven2_trainer::planning::Benchmark benchmark;
  std::printf("one arm, processor time, least and median of %d passes\n", raven2_trainer::planning::kPasses);
  benchmark.world();
  benchmark.rollOut();
  return 0;
}
