#include "ros/planning/planning_services.h"

#include <optional>

#include "ros/node/fill_response.h"
#include "ros/planning/planning_messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kGraceTime = 2.0;  // [s] beyond the planner's limit before an answer is given up

template <typename Response>
void fillResponse(const std::optional<PlanResult>& result, Response* response) {
  if (!result) return fillResponse(ErrorCode::kCommunicationFailure, "no answer from the planner", response);
  fillResponse(errorCode(result->status), kPlanStatusNames[static_cast<std::size_t>(result->status)], response);
  response->plan = result->id;
  response->cost = result->cost;
  response->planning_time = result->planning_time;
}

}  // namespace

PlanningServices::PlanningServices(const ros::NodeHandle& node,
                                   const ArmGeometry& geometry,
                                   double time_limit,
                                   PlanningClient* client,
                                   bool may_command)
    : d4_(geometry.d4),
      patience_(time_limit + kGraceTime),
      client_(*client),
      plan_node_(node),
      order_node_(node),
      plan_spinner_(1, &plan_queue_),
      order_spinner_(1, &order_queue_) {
  plan_node_.setCallbackQueue(&plan_queue_);
  order_node_.setCallbackQueue(&order_queue_);
  cancel_plan_ = order_node_.advertiseService("cancel_plan", &PlanningServices::cancelPlan, this);
  if (may_command) {
    execute_plan_ = order_node_.advertiseService("execute_plan", &PlanningServices::executePlan, this);
    planning_mode_ = plan_node_.advertiseService("planning_mode", &PlanningServices::planningMode, this);
    plan_ = plan_node_.advertiseService("plan", &PlanningServices::plan, this);
  }
  order_spinner_.start();
  plan_spinner_.start();
}

void PlanningServices::stop() {
  client_.stop();
  plan_spinner_.stop();
  order_spinner_.stop();
}

std::vector<std::string> PlanningServices::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer* server : {&plan_, &planning_mode_, &execute_plan_, &cancel_plan_}) {
    if (*server) names.push_back(server->getService());
  }
  return names;
}

bool PlanningServices::plan(PlanPath::Request& message, PlanPath::Response& response) {
  const ReadRequest wanted = planRequest(wantedPlan(message), d4_);
  if (!wanted.isGood()) {
    fillResponse(wanted.code, wanted.status, &response);
    return true;
  }
  const PlanningClient::Asked asked = client_.ask(wanted.request);
  if (asked.answer != PlanningAnswer::kAccepted) {
    fillResponse(asked.answer, &response);
    return true;
  }
  const std::optional<PlanResult> result = client_.awaitPlan(asked.id, patience_);
  fillResponse(result, &response);
  if (!result || result->status != PlanStatus::kSuccess) return true;
  response.arm = name(result->arm);
  response.clearance = result->clearance;
  response.tracking_error = result->tracking_error;
  response.robot_follows = result->robot_follows != 0;
  response.trajectory = trajectory(*result, d4_);
  return true;
}

bool PlanningServices::planningMode(PlanningMode::Request& message, PlanningMode::Response& response) {
  Request request;
  if (message.command == "record_goal") {
    recordGoal(&response);
  } else if (message.command == "end") {
    request.kind = RequestKind::kEndPlanning;
    fillResponse(client_.ask(request).answer, &response);
  } else if (message.command != "begin") {
    fillResponse(ErrorCode::kFailure, "unknown command; known: begin, record_goal, end", &response);
  } else if (!readArm(message.arm, &request.arm)) {
    fillResponse(ErrorCode::kInvalidGroupName, "unknown arm; known: gold, green", &response);
  } else {
    request.kind = RequestKind::kBeginPlanning;
    fillResponse(client_.ask(request).answer, &response);
  }
  return true;
}

void PlanningServices::recordGoal(PlanningMode::Response* response) {
  Request request;
  request.kind = RequestKind::kRecordGoal;
  const PlanningClient::Asked asked = client_.ask(request);
  if (asked.answer != PlanningAnswer::kAccepted) return fillResponse(asked.answer, response);
  fillResponse(client_.awaitPlan(asked.id, patience_), response);
}

bool PlanningServices::executePlan(ExecutePlan::Request& message, ExecutePlan::Response& response) {
  Request request;
  request.kind = RequestKind::kExecutePlan;
  request.on_robot = message.on_robot ? 1 : 0;
  request.plan = message.plan;
  const PlanningClient::Asked asked = client_.ask(request);
  fillResponse(asked.answer, &response);
  if (response.success) response.execution = asked.id;
  return true;
}

bool PlanningServices::cancelPlan(CancelPlan::Request&, CancelPlan::Response& response) {
  const PlanningClient::Cancelled cancelled = client_.cancel();
  fillResponse(cancelled.answer, &response);
  if (!cancelled.has_ended) response.status += "; the planner is still ending";
  response.was = kPlanningStatusNames[static_cast<std::size_t>(cancelled.was)];
  return true;
}

}  // namespace raven2_trainer::ros_bridge
