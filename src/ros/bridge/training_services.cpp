#include "ros/bridge/training_services.h"

#include "ros/node/fill_response.h"

namespace raven2_trainer::ros_bridge {
namespace {

Request requestOf(RequestKind kind, Arm arm = Arm::kGold) {
  Request request;
  request.kind = kind;
  request.arm = arm;
  return request;
}

/** success and message of the standard services. */
template <typename Response>
bool sendPlain(PlanningAnswer answer, Response* response) {
  response->success = answer == PlanningAnswer::kAccepted;
  response->message = words(answer);
  return true;
}

}  // namespace

TrainingServices::TrainingServices(ros::NodeHandle* node, PlanningClient* client, ReplayTask* replay, bool may_command)
    : client_(*client), replay_(replay), node_(*node), spinner_(1, &queue_) {
  servers_.push_back(node->advertiseService("emergency_stop", &TrainingServices::emergencyStop, this));
  if (!may_command) return;
  node_.setCallbackQueue(&queue_);
  for (const RequestKind kind :
       {RequestKind::kBeginSimulation, RequestKind::kEndSimulation, RequestKind::kBeginTrial, RequestKind::kEndTrial,
        RequestKind::kDiscardTrial, RequestKind::kClearStop, RequestKind::kStartExercise, RequestKind::kEndReplay})
    offer(kRequestKindNames[static_cast<std::size_t>(kind)], requestOf(kind));
  for (const Arm arm : kArms)
    offer(std::string(name(arm)) + "/tool_change", requestOf(RequestKind::kToolChange, arm));
  for (const RequestKind kind : {RequestKind::kSetView, RequestKind::kSetCameraPedal})
    offerSwitch(kRequestKindNames[static_cast<std::size_t>(kind)], kind);
  servers_.push_back(node_.advertiseService("repeat_trial", &TrainingServices::repeatTrial, this));
  if (replay_ != nullptr)
    servers_.push_back(node_.advertiseService("begin_replay", &TrainingServices::beginReplay, this));
  spinner_.start();
}

std::vector<std::string> TrainingServices::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer& server : servers_)
    names.push_back(server.getService());
  return names;
}

void TrainingServices::offer(const std::string& service, const Request& request) {
  using Callback = boost::function<bool(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&)>;
  const Callback callback = [this, request](std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    return sendPlain(client_.ask(request).answer, &response);
  };
  servers_.push_back(node_.advertiseService(service, callback));
}

void TrainingServices::offerSwitch(const std::string& service, RequestKind kind) {
  using Callback = boost::function<bool(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&)>;
  const Callback callback = [this, kind](std_srvs::SetBool::Request& message, std_srvs::SetBool::Response& response) {
    Request request = requestOf(kind);
    request.enabled = message.data != 0 ? 1 : 0;
    return sendPlain(client_.ask(request).answer, &response);
  };
  servers_.push_back(node_.advertiseService(service, callback));
}

/** Reads the first ticks of the session before it answers. */
bool TrainingServices::beginReplay(BeginReplay::Request& message, BeginReplay::Response& response) {
  const ReplayTask::Outcome outcome = replay_->begin(message.session);
  fillResponse(outcome.code, outcome.status, &response);
  return true;
}

bool TrainingServices::repeatTrial(RepeatTrial::Request& message, RepeatTrial::Response& response) {
  Request request = requestOf(RequestKind::kRepeatTrial);
  request.on_robot = message.on_robot != 0 ? 1 : 0;
  const PlanningClient::Asked asked = client_.ask(request);
  fillResponse(asked.answer, &response);
  if (response.success) response.execution = asked.id;
  return true;
}

/** Posted before anything else: who waits for an answer holds it up no longer than it takes to post. */
bool TrainingServices::emergencyStop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const PlanningClient::Asked asked = client_.askBy([this](std::uint32_t id) {
    Request request = requestOf(RequestKind::kEmergencyStop);
    request.id = id;
    return client_.post(request);
  });
  return sendPlain(asked.answer, &response);
}

}  // namespace raven2_trainer::ros_bridge
