// Prints the cost of the planner's collision checks in the shipped scene, and that of FCL's on the same states:
// planning_benchmark [PASSES]. Times are the thread's own processor time.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "planning/arm_clearance.h"
#include "planning/arm_collision.h"
#include "planning/free_volume.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/planning/clearance_gauge.h"

namespace {

using namespace raven2_trainer;
using namespace raven2_trainer::planning;

constexpr std::size_t kStates = 4096, kEdges = 512;

/** [s] processor time of this thread. */
double now() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/** Times passes over `count` inputs; prints ns a call, least and median, and the share of answers that are yes. */
template <typename Function>
double time(const char* what, std::size_t count, int passes, Function function) {
  std::vector<double> ns;
  std::size_t yes = 0;
  for (int pass = 0; pass < passes; ++pass) {
    const double begin = now();
    for (std::size_t i = 0; i < count; ++i)
      yes += function(i) ? 1 : 0;
    ns.push_back(1e9 * (now() - begin) / static_cast<double>(count));
  }
  std::sort(ns.begin(), ns.end());
  std::printf("%-34s %10.0f %10.0f %9.1f %%\n", what, ns.front(), ns[ns.size() / 2],
              100.0 * static_cast<double>(yes) / static_cast<double>(count) / passes);
  return ns.front();
}

struct Inputs {
  std::vector<JointArray> all, open, from, to;
};

Inputs draw(const JointSpace& space, ArmClearance* judge) {
  Random random(1);
  const auto unit = [&random](const UnitState& near, double reach) {
    UnitState out;
    for (std::size_t i = 0; i < kPlanDimension; ++i)
      out[i] = std::clamp(near[i] + random.uniform(-reach, reach), 0.0, 1.0);
    return out;
  };
  Inputs in;
  UnitState middle;
  middle.fill(0.5);
  while (in.from.size() < kEdges || in.open.size() < kStates) {
    const UnitState a = unit(middle, 0.5), b = unit(a, 0.25);
    if (in.all.size() < kStates) in.all.push_back(space.toJoints(a));
    if (!judge->isFree(space.toJoints(a))) continue;
    if (in.open.size() < kStates) in.open.push_back(space.toJoints(a));
    if (in.from.size() >= kEdges || !judge->isFree(space.toJoints(b))) continue;
    in.from.push_back(space.toJoints(a));
    in.to.push_back(space.toJoints(b));
  }
  return in;
}

/** FMT*'s former check of an edge: states no farther apart than the planner's step. */
bool edgeByFcl(const JointSpace& space, double step, ArmCollision* judge, const JointArray& a, const JointArray& b) {
  const UnitState from = space.toUnit(a), to = space.toUnit(b);
  const int count = static_cast<int>(distance(from, to) / step) + 1;
  for (int k = 0; k <= count; ++k)
    if (judge->touches(space.toJoints(interpolate(from, to, k / static_cast<double>(count))))) return false;
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const int passes = argc > 1 ? std::max(1, std::atoi(argv[1])) : 9;
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  const model::RavenModel raven = model::loadRavenModel(config);
  const model::SceneModel scene = model::loadSceneModel(config);
  const ArmGeometry& geometry = raven.arms.geometry;
  const JointSpace space(geometry, kinematics::jawOpening(geometry.home));

  double begin = now();
  const DistanceGrid grid(raven, scene);
  std::printf("grid      %.3f s, %zu nodes\n", now() - begin, grid.nodeCount());
  begin = now();
  ArmClearance fast(raven, grid, Arm::kGold, config.planner.clearance);
  std::printf("clearance %.3f s\n", now() - begin);
  const SceneObstacles obstacles(scene);
  ArmCollision exact(raven, obstacles, Arm::kGold, config.planner.clearance);
  exact.placeOther(geometry.home);
  fast.placeOther(geometry.home);

  const Inputs in = draw(space, &fast);
  std::size_t stricter = 0, open = 0;
  for (const JointArray& q : in.all) {
    const bool exactly = !exact.touches(q);
    open += exactly ? 1 : 0;
    stricter += exactly && !fast.isFree(q) ? 1 : 0;
  }
  std::printf("free by FCL %zu of %zu; stricter in %zu\n", open, in.all.size(), stricter);

  std::printf("%-34s %10s %10s %11s  of %d passes\n", "", "min ns", "median ns", "yes", passes);
  const double state =
      time("isFree, random states", kStates, passes, [&](std::size_t i) { return fast.isFree(in.all[i]); });
  time("isFree, free states", kStates, passes, [&](std::size_t i) { return fast.isFree(in.open[i]); });
  time("clearance to 10 mm, free states", kStates, passes,
       [&](std::size_t i) { return fast.clearance(in.open[i], 0.01) >= 0.01; });
  ClearanceGauge gauge(raven, scene);
  time("ClearanceGauge, free states", kStates, passes,
       [&](std::size_t i) { return gauge.measure(Arm::kGold, in.open[i], geometry.home) >= 0.01; });
  const double fcl = time("FCL, random states", kStates, 3, [&](std::size_t i) { return !exact.touches(in.all[i]); });
  const double edge = time("isEdgeFree, 0.35 in the cube", kEdges, passes,
                           [&](std::size_t i) { return fast.isEdgeFree(in.from[i], in.to[i]); });
  const double fcl_edge = time("FCL, the same edges in steps", kEdges, 3, [&](std::size_t i) {
    return edgeByFcl(space, config.planner.edge_step, &exact, in.from[i], in.to[i]);
  });
  std::printf("FCL / fast: state %.1f, edge %.1f\n", fcl / state, fcl_edge / edge);

  const auto is_free = [&](const UnitState& unit) { return fast.isFree(space.toJoints(unit)); };
  begin = now();
  const FreeVolume volume = estimateFreeVolume(is_free, 20000, 1, 0.95);
  std::printf("free volume %.4f, at most %.4f (95 %%), %.3f s; r_500 at 1.1: %.3f\n", volume.mean, volume.upper,
              now() - begin, fmtRadius(volume.upper, 1.1, 500));
  return 0;
}
