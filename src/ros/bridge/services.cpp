#include "ros/bridge/services.h"

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/faults/arming.h"
#include "raven2_trainer/loop/fault_director.h"
#include "ros/bridge/hazard_refusal.h"
#include "ros/node/fill_response.h"

namespace raven2_trainer::ros_bridge {
Services::Services(ros::NodeHandle* node, daemon::Simulator* simulator, PlanningClient* client, bool may_command)
    : simulator_(*simulator),
      client_(*client),
      stop_hazard_(node->advertiseService("stop_hazard", &Services::stopHazard, this)),
      disengage_(node->advertiseService("disengage", &Services::disengage, this)),
      pause_(node->advertiseService("pause", &Services::pause, this)) {
  if (may_command) offerCommands(node);
}

void Services::offerCommands(ros::NodeHandle* node) {
  start_hazard_ = node->advertiseService("start_hazard", &Services::startHazard, this);
  inject_hazard_ = node->advertiseService("inject_hazard", &Services::injectHazard, this);
  engage_ = node->advertiseService("engage", &Services::engage, this);
  for (const Arm arm : kArms) {
    using Callback = boost::function<bool(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&)>;
    const Callback callback = [this, arm](std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
      return setCollisions(arm, request, &response);
    };
    at(set_collisions_, arm) = node->advertiseService(std::string(name(arm)) + "/set_collisions", callback);
  }
}

std::vector<std::string> Services::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer* server : {&start_hazard_, &inject_hazard_, &stop_hazard_, &engage_, &disengage_,
                                           &pause_, &set_collisions_[0], &set_collisions_[1]}) {
    if (*server) names.push_back(server->getService());
  }
  return names;
}

bool Services::startHazard(StartHazard::Request& request, StartHazard::Response& response) {
  return arm(FaultOrder::kArm, request, &response);
}

bool Services::injectHazard(StartHazard::Request& request, StartHazard::Response& response) {
  return arm(FaultOrder::kArmAtOnce, request, &response);
}

bool Services::arm(FaultOrder order, const StartHazard::Request& request, StartHazard::Response* answer) {
  StartHazard::Response& response = *answer;
  try {
    const std::uint32_t id = config::faultId(simulator_.config(), request.name);
    refuseHazard(simulator_.config(), simulator_.shared().robot.load(), id, order);
    const FaultPlan wanted = faults::planFor(simulator_.config(), id, 0);
    if (!loop::FaultDirector::fits(simulator_.shared().faults.load(), wanted))
      throw ConfigException("too many faults are armed: stop_hazard first");
    response.success = id != 0 && simulator_.shared().fault_requests.tryPush({order, id});
    response.message = !response.success           ? "nothing to arm"
                       : order == FaultOrder::kArm ? "armed; it waits for its trigger"
                                                   : "the hazard acts";
  } catch (const ConfigException& e) {
    response.success = false;
    response.message = e.what();
  }
  return true;
}

bool Services::stopHazard(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.success = simulator_.shared().fault_requests.tryPush({FaultOrder::kClear, 0});
  response.message = response.success ? "all hazards cleared" : "too many requests at once";
  return true;
}

bool Services::post(RequestKind kind, std_srvs::Trigger::Response* response) {
  Request request;
  request.kind = kind;
  response->success = client_.post(request);
  response->message = response->success ? "" : "too many requests at once";
  return true;
}

bool Services::engage(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return post(RequestKind::kEngage, &response);
}

bool Services::disengage(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return post(RequestKind::kDisengage, &response);
}

bool Services::pause(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const PlanningClient::Asked asked =
      client_.askBy([this](std::uint32_t id) { return simulator_.shared().pause_requests.tryPush(id); });
  const std::string mode = kModeNames[static_cast<std::size_t>(asked.mode)];
  response.success = asked.answer == PlanningAnswer::kAccepted;
  response.message = asked.answer == PlanningAnswer::kNone ? words(asked.answer)
                     : !response.success                   ? "nothing to pause in mode " + mode
                     : asked.mode == Mode::kPaused
                         ? "paused until the pedal goes down again"
                         : "the model holds until the pedal goes down again; the timer goes on";
  return true;
}

bool Services::setCollisions(Arm arm,
                             const std_srvs::SetBool::Request& request,
                             std_srvs::SetBool::Response* response) {
  Request order;
  order.kind = RequestKind::kSetCollisions;
  order.arm = arm;
  order.enabled = request.data ? 1 : 0;
  response->success = client_.post(order);
  response->message = response->success ? "" : "too many requests at once";
  return true;
}

}  // namespace raven2_trainer::ros_bridge
