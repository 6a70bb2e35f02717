#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_problem.h"
#include "raven2_trainer/core/exceptions.h"

// A problem of the planner. Input: a byte (even: the text follows; odd: edits of the packaged problem, fuzz_target.h),
// the rest.

namespace raven2_trainer::fuzz {
namespace {

void requireWithin(const ArmGeometry& geometry, const JointArray& q) {
  for (std::size_t j = 0; j < kJointCount; ++j)
    require(q[j] >= geometry.q_min[j] && q[j] <= geometry.q_max[j], "a joint is within its limits");
}

void requireSane(const ArmGeometry& geometry, const PlanRequest& request) {
  requireWithin(geometry, request.start);
  requireWithin(geometry, request.other);
  require(request.goal == GoalKind::kTip || request.goal == GoalKind::kJoints, "a problem has a goal");
  if (request.goal == GoalKind::kJoints) requireWithin(geometry, request.goal_q);
  for (const double x : request.goal_W)
    require(std::abs(x) <= 1.0, "the goal is a place on the table");
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const fuzz::ScratchFolder scratch;
  static const std::string packaged = fuzz::readWhole(fuzz::sourceFile("config/problems/paper.yaml"));
  static const ArmGeometry geometry = config::loadTrainerConfig(fuzz::sourceFile("config/trainer.yaml")).arms.geometry;
  fuzz::Input input(data, size);
  const bool edits = (input.byte() & 1U) != 0;
  const std::string file = scratch.write("paper.yaml", edits ? fuzz::edited(packaged, &input) : input.rest());
  try {
    fuzz::requireSane(geometry, config::loadProblem(file, geometry).request);
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
