#include "ros/services.h"

#include <algorithm>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/runtime/fault_director.h"
#include "raven2_trainer/core/exceptions.h"
#include "ros/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kFirstId = 1000;  // smaller ids belong to the daemon's own schedule
constexpr double kGraceTime = 2.0;        // [s] beyond the planner's limit before an answer is given up

}  // namespace

Services::Services(ros::NodeHandle* node, runtime::Simulator* simulator, bool may_command)
    : simulator_(*simulator),
      next_id_(kFirstId),
      plan_node_(*node),
      plan_spinner_(1, &plan_queue_),
      stop_hazard_(node->advertiseService("stop_hazard", &Services::stopHazard, this)),
      disengage_(node->advertiseService("disengage", &Services::disengage, this)) {
  if (may_command) offerCommands(node);
}

void Services::offerCommands(ros::NodeHandle* node) {
  start_hazard_ = node->advertiseService("start_hazard", &Services::startHazard, this);
  engage_ = node->advertiseService("engage", &Services::engage, this);
  for (const Arm arm : kArms) {
    using Callback = boost::function<bool(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&)>;
    const Callback callback = [this, arm](std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
      return setCollisions(arm, request, &response);
    };
    at(set_collisions_, arm) = node->advertiseService(std::string(name(arm)) + "/set_collisions", callback);
  }
  plan_node_.setCallbackQueue(&plan_queue_);
  plan_ = plan_node_.advertiseService("plan", &Services::plan, this);
  plan_spinner_.start();
}

std::vector<std::string> Services::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer* server :
       {&start_hazard_, &stop_hazard_, &plan_, &engage_, &disengage_, &set_collisions_[0], &set_collisions_[1]}) {
    if (*server) names.push_back(server->getService());
  }
  return names;
}

void Services::stop() {
  stop_.store(true);
  plan_spinner_.stop();
}

bool Services::push(const Request& request) {
  const std::lock_guard<std::mutex> lock(push_mutex_);
  return simulator_.shared().requests.tryPush(request);
}

/** @throw ConfigException if it may not be armed, with what it would take. */
void Services::refuseInjection(std::uint32_t id) const {
  const TrainerConfig& config = simulator_.config();
  if (!config.injection.enable) throw ConfigException("injection is not enabled (config/injection.yaml)");
  const RobotState robot = simulator_.shared().robot.load();
  if (id == 0 || robot.frame == 0 || robot.is_virtual != 0) return;
  if (!config.injection.real_robot) throw ConfigException("a real robot is connected: nothing is armed");
  for (const Fault& fault : config.scenarios[id - 1].faults) {
    if (fault.host == FaultHost::kRobot)
      throw ConfigException("a real robot is connected: nothing is injected into its own software");
  }
}

bool Services::startHazard(StartHazard::Request& request, StartHazard::Response& response) {
  try {
    const std::uint32_t id = config::faultId(simulator_.config(), request.name);
    refuseInjection(id);
    const FaultPlan wanted = config::planFor(simulator_.config(), id, 0);
    if (!runtime::FaultDirector::fits(simulator_.shared().faults.load(), wanted))
      throw ConfigException("too many faults are armed: stop_hazard first");
    response.success = id != 0 && simulator_.shared().fault_requests.tryPush({1, id});
    response.message = response.success ? "armed; it waits for its trigger" : "nothing to arm";
  } catch (const ConfigException& e) {
    response.success = false;
    response.message = e.what();
  }
  return true;
}

bool Services::stopHazard(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.success = simulator_.shared().fault_requests.tryPush({0, 0});
  response.message = response.success ? "all hazards cleared" : "too many requests at once";
  return true;
}

bool Services::post(RequestKind kind, std_srvs::Trigger::Response* response) {
  Request request;
  request.kind = kind;
  response->success = push(request);
  response->message = response->success ? "" : "too many requests at once";
  return true;
}

bool Services::engage(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return post(RequestKind::kEngage, &response);
}

bool Services::disengage(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return post(RequestKind::kDisengage, &response);
}

bool Services::setCollisions(Arm arm,
                             const std_srvs::SetBool::Request& request,
                             std_srvs::SetBool::Response* response) {
  Request order;
  order.kind = RequestKind::kSetCollisions;
  order.arm = arm;
  order.enabled = request.data ? 1 : 0;
  response->success = push(order);
  response->message = response->success ? "" : "too many requests at once";
  return true;
}

bool Services::plan(PlanPath::Request& message, PlanPath::Response& response) {
  Request request;
  request.kind = RequestKind::kPlan;
  request.id = next_id_++;
  request.arm = message.arm == "green" ? Arm::kGreen : Arm::kGold;
  request.goal = message.default_goal ? GoalKind::kDefault : GoalKind::kTip;
  std::copy(message.goal.begin(), message.goal.end(), request.goal_W.begin());
  const bool is_known = message.arm.empty() || message.arm == "gold" || message.arm == "green";
  PlanResult result;
  if (!is_known) {
    response.status = "unknown arm; known: gold, green";
  } else if (!push(request) || !awaitPlan(request.id, &result)) {
    response.status = "no answer from the planner";
  } else {
    response.success = result.status == PlanStatus::kSuccess;
    response.status = kPlanStatusNames[static_cast<std::size_t>(result.status)];
    response.cost = result.cost;
    response.planning_time = result.planning_time;
    response.trajectory = trajectory(result, simulator_.config().arms.geometry.d4);
  }
  return true;
}

bool Services::awaitPlan(std::uint32_t id, PlanResult* result) const {
  const ros::SteadyTime deadline =  // a step of the wall clock is no time that passed
      ros::SteadyTime::now() + ros::WallDuration(simulator_.config().planner.time_limit + kGraceTime);
  while (ros::SteadyTime::now() < deadline && !stop_.load()) {
    *result = simulator_.shared().last_plan.load();
    if (result->id == id) return true;
    ros::WallDuration(0.01).sleep();
  }
  return false;
}

}  // namespace raven2_trainer::ros_bridge
