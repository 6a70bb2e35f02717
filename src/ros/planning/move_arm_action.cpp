#include "ros/planning/move_arm_action.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kLookPeriod = 0.02;  // [s] well under the 100 ms in which a goal is to be cancelled
constexpr int kLooksPerTale = 5;
constexpr bool kStartsLater = false;

MoveArmResult refusal(const ReadRequest& read) {
  MoveArmResult result;
  result.error_code = number(read.code);
  result.status = read.status;
  return result;
}

}  // namespace

MoveArmServer::MoveArmServer(const ros::NodeHandle& node,
                             const ArmGeometry& geometry,
                             const daemon::Simulator& simulator,
                             PlanningClient* client)
    : geometry_(geometry), simulator_(simulator), task_(client), server_(node, "move_arm", kStartsLater) {
  server_.start();
  thread_.start(kLookPeriod, [this] { look(); });
}

void MoveArmServer::stop() {
  thread_.stop();
  if (server_.isActive()) server_.setAborted(moveArmResult(task_.outcome(), ros::Time::now()), "the program ends");
}

void MoveArmServer::look() {
  if (server_.isActive()) {
    if (server_.isPreemptRequested()) task_.cancel();
    if (task_.look()) {
      end();
    } else if (++looks_ % kLooksPerTale == 0) {
      publishFeedback();
    }
  }
  if (!server_.isActive() && server_.isNewGoalAvailable()) begin();
}

void MoveArmServer::begin() {
  const MoveArmGoalConstPtr goal = server_.acceptNewGoal();
  if (!goal) return;  // taken back in between
  const ReadRequest read = planRequest(wantedPlan(*goal), geometry_.d4);
  if (!read.isGood()) return server_.setAborted(refusal(read), read.status);
  task_.begin(read.request, goal->on_robot != 0);
}

void MoveArmServer::end() {
  const MoveArmTask::Outcome& outcome = task_.outcome();
  const MoveArmResult result = moveArmResult(outcome, ros::Time::now());
  if (outcome.code == ErrorCode::kSuccess) return server_.setSucceeded(result, outcome.status);
  if (outcome.was_cancelled) return server_.setPreempted(result, outcome.status);
  server_.setAborted(result, outcome.status);
}

void MoveArmServer::publishFeedback() {
  const ModelState model = simulator_.shared().model.load();
  const TipErrors errors = tipErrors(model, simulator_.shared().robot.load(), geometry_);
  clock_.look(model);
  MoveArmFeedback feedback;
  feedback.progress = planningProgress(model.planning, simulator_.planCounts(), clock_.elapsed(), ros::Time::now());
  feedback.model_error = errors.model;
  feedback.robot_error = errors.robot;
  server_.publishFeedback(feedback);
}

}  // namespace raven2_trainer::ros_bridge
