#include "ros/crtk/crtk_device.h"

#include "raven2_trainer/net/clock.h"
#include "ros/crtk/crtk_parameters.h"
#include "ros/node/name_of.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using diagnostic_msgs::KeyValue;

constexpr int kTries = 4;  // to find what the loop stored in one tick

KeyValue value(const std::string& key, std::uint64_t number) {
  KeyValue pair;
  pair.key = key;
  pair.value = std::to_string(number);
  return pair;
}

ros::NodeHandle onQueue(ros::NodeHandle node, ros::CallbackQueue* queue) {
  node.setCallbackQueue(queue);
  return node;
}

}  // namespace

DiagnosticStatus crtkStatus(const ServoState& servo, const CrtkCounts& heard) {
  DiagnosticStatus s;
  s.name = "raven2_trainer: crtk";
  s.message = nameOf(kOperatingStateNames, servo.state);
  if (servo.is_homed == 0) s.message += ", not homed";
  if (servo.holds_pedal != 0) s.message += ", a client moves the arms";
  const bool adds_up = servo.received == servo.applied + servo.refused && servo.received <= heard.passed_on;
  s.level = servo.state == OperatingState::kFault ? DiagnosticStatus::WARN : DiagnosticStatus::OK;
  if (heard.lost > 0) s.level = DiagnosticStatus::WARN;
  if (!adds_up) s.level = DiagnosticStatus::ERROR;
  s.values = {value("received", heard.passed_on + heard.unread + heard.lost), value("applied", servo.applied),
              value("refused", servo.refused), value("unread", heard.unread), value("lost", heard.lost)};
  return s;
}

CrtkDevice::CrtkDevice(const ros::NodeHandle& node, const TopicSource& source, SharedState* shared, bool may_command)
    : source_(source), shared_(*shared), node_(onQueue(node, &queue_)), spinner_(1, &queue_), inbox_(shared) {
  const CrtkConfig& config = source.crtk;
  const auto before = publishersNow();
  for (const Arm arm : kArms) {
    const Pose& X_WB = at(source.raven.X_WB, arm);
    if (config.dialect == CrtkDialect::kRaven) setRavenParameters(node_, config, arm, source.geometry);
    auto& voice = at(voices_, arm) = std::make_unique<CrtkVoice>(&node_, at(config.names, arm));
    at(arms_, arm) =
        std::make_unique<CrtkArm>(&node_, arm, config, source.geometry, X_WB, source.body_names, voice.get());
    at(listeners_, arm) = std::make_unique<CrtkListener>(node_, arm, config, source.geometry, X_WB, may_command, before,
                                                         &inbox_, voice.get());
    if (!may_command) continue;
    at(kinematics_, arm) = std::make_unique<CrtkKinematics>(&node_, arm, at(config.names, arm), source.geometry, X_WB,
                                                            config.dialect == CrtkDialect::kRaven);
  }
  if (config.dialect == CrtkDialect::kRaven)
    state_ = std::make_unique<CrtkStateTopic>(&node_, "operating_state", config);
  spinner_.start();
  publisher_.start(
      config.period, [this] { publish(); }, Missed::kMadeUp);
}

DiagnosticStatus CrtkDevice::status() const {
  const ServoState servo = shared_.servo.load();  // first, so that it counts no more than was passed on
  return crtkStatus(servo, inbox_.counts());
}

std::vector<std::string> CrtkDevice::services() const {
  std::vector<std::string> names;
  for (const auto& kinematics : kinematics_) {
    if (kinematics == nullptr) continue;
    const std::vector<std::string> more = kinematics->names();
    names.insert(names.end(), more.begin(), more.end());
  }
  return names;
}

/** The spinner before the listeners: a message that comes meanwhile would find half of one. */
void CrtkDevice::stop() {
  publisher_.stop();
  spinner_.stop();
  for (auto& listener : listeners_)
    listener.reset();
  for (auto& kinematics : kinematics_)
    kinematics.reset();
}

void CrtkDevice::publish() {
  reportRefused();
  if (!loadCycle()) return;
  cycle_.stamp = stamp_.of(cycle_.model.time_ns, momentNow());
  for (const auto& arm : arms_)
    arm->publish(cycle_);
  const auto& servo = cycle_.servo.arms;
  if (state_ == nullptr) return;
  state_->publish(cycle_.servo, servo[0].is_busy + servo[1].is_busy > 0, servo[0].moves + servo[1].moves, cycle_.stamp);
}

/** @return false if the loop has done nothing new. */
bool CrtkDevice::loadCycle() {
  for (int i = 0; i < kTries; ++i) {
    cycle_.model = shared_.model.load();
    cycle_.servo = shared_.servo.load();
    if (cycle_.servo.tick == cycle_.model.tick) break;
  }
  if (cycle_.servo.tick < 0 || cycle_.servo.tick == published_) return false;
  published_ = cycle_.servo.tick;
  cycle_.robot = shared_.robot.load();
  if (arms_[0]->wantsContacts() || arms_[1]->wantsContacts()) cycle_.contacts = shared_.contacts.load();
  return true;
}

void CrtkDevice::reportRefused() {
  ServoRefused refused;
  while (shared_.servo_refused.tryPop(&refused))
    at(voices_, refused.arm)->complain(level(refused), aboutOf(refused), sentence(refused), net::monotonicNow());
}

}  // namespace raven2_trainer::ros_bridge
