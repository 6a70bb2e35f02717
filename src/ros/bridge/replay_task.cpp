#include "ros/bridge/replay_task.h"

#include <exception>
#include <filesystem>
#include <utility>

#include "ros/node/fill_response.h"

namespace raven2_trainer::ros_bridge {
namespace {

namespace fs = std::filesystem;

/** "DIR" and "DIR/" alike. */
std::string folderOf(const std::string& session) {
  return (fs::absolute(session) / "").lexically_normal().parent_path().parent_path();
}

}  // namespace

ReplayTask::ReplayTask(PlanningClient* client, Open open, const std::string& running)
    : client_(*client), open_(std::move(open)), sessions_(folderOf(running)) {}

ReplayTask::Outcome ReplayTask::begin(const std::string& session) {
  const std::string directory = fs::path(sessions_) / session;  // an absolute one is itself
  std::error_code none;
  if (session.empty() || !fs::is_directory(directory, none))
    return {ErrorCode::kFailure, directory + ": no directory of a session"};
  if (!traitsOf(client_.mode()).may_replay) return {errorCode(PlanningAnswer::kNotNow), words(PlanningAnswer::kNotNow)};
  Request request;
  request.kind = RequestKind::kBeginReplay;
  try {
    request.plan = open_(directory);
  } catch (const std::exception& e) {
    return {ErrorCode::kFailure, e.what()};
  }
  const PlanningAnswer answer = client_.ask(request).answer;
  return {errorCode(answer), words(answer)};
}

}  // namespace raven2_trainer::ros_bridge
