#include "ros/crtk/crtk_inbox.h"

#include "ros/node/name_of.h"

namespace raven2_trainer::ros_bridge {

std::string CrtkInbox::take(const CrtkAsked& asked) {
  if (!asked.command) {
    shared_.servo_unread.add();
    return asked.refusal;
  }
  const std::string refusal = pass(*asked.command);
  return refusal.empty() && asked.jaw ? pass(*asked.jaw) : refusal;
}

std::string CrtkInbox::pass(ServoCommand command) {
  command.id = ++next_id_;
  if (shared_.servo_commands.tryPush(command)) return "";
  return std::string(nameOf(kServoKindNames, command.kind)) + ": too many commands at once";
}

CrtkCounts CrtkInbox::counts() const noexcept {
  const RingCounts ring = shared_.servo_commands.counts();
  return {ring.pushed, shared_.servo_unread.value(), ring.dropped};
}

}  // namespace raven2_trainer::ros_bridge
