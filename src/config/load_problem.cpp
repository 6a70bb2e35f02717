#include "raven2_trainer/config/load_problem.h"

#include <filesystem>
#include <sstream>

#include "config/names.h"
#include "named_files.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr double kAnyJoint = 10.0;  // [rad, m] looser than any limit: those of the joint are judged one by one
JointArray readJoints(Section& section, const std::string& key, const ArmGeometry& geometry) {
  const JointArray q = section.joints(key, -kAnyJoint, kAnyJoint);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (q[j] >= geometry.q_min[j] && q[j] <= geometry.q_max[j]) continue;
    std::ostringstream text;
    text << section.where(key) << "[" << j << "] (" << kJointNames[j] << ") is " << q[j] << ", expected ["
         << geometry.q_min[j] << ", " << geometry.q_max[j] << "]";
    throw ConfigException(text.str());
  }
  return q;
}

void readGoal(Section section, const ArmGeometry& geometry, PlanRequest* request) {
  // Without the goal of planner.yaml: a problem means the same whatever is set there.
  request->goal = section.text("kind", {"tip", "joints"}) == "tip" ? GoalKind::kTip : GoalKind::kJoints;
  if (request->goal == GoalKind::kTip) request->goal_W = section.vec3("tip_W", -kFarthest, kFarthest);
  if (request->goal == GoalKind::kJoints) request->goal_q = readJoints(section, "joints", geometry);
  section.finish();
}

}  // namespace

PlanProblem loadProblem(const std::string& path, const ArmGeometry& geometry) {
  Section root = Section::fromFile(path);
  PlanProblem problem;
  problem.name = fs::path(path).stem().string();
  problem.description = root.text("description");
  PlanRequest& request = problem.request;
  request.arm = kArms[root.choice("arm", kArmNames)];
  request.choose_arm = root.boolean("choose_arm") ? 1 : 0;
  request.start = readJoints(root, "start", geometry);
  request.other = readJoints(root, "other", geometry);
  readGoal(root.section("goal"), geometry, &request);
  root.finish();
  return problem;
}

PlanProblem findProblem(const std::string& folder, const std::string& name, const ArmGeometry& geometry) {
  if (fs::path(name).extension() == ".yaml") return loadProblem(name, geometry);
  return loadProblem(namedFile(folder, name, "problem", {"FILE.yaml"}), geometry);
}

}  // namespace raven2_trainer::config
