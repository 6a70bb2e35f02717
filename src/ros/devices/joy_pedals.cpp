#include "ros/devices/joy_pedals.h"

namespace raven2_trainer::ros_bridge {

std::uint32_t heldPedals(const sensor_msgs::Joy& joy, const JoyConfig& config) noexcept {
  std::uint32_t held = 0;
  for (std::size_t i = 0; i < kPedalCount; ++i) {
    if (config.buttons[i] < 0) continue;
    const auto button = static_cast<std::size_t>(config.buttons[i]);
    if (button < joy.buttons.size() && joy.buttons[button] != 0) held |= bit(static_cast<Pedal>(i));
  }
  return held;
}

JoyPedals::JoyPedals(const JoyConfig& config, const SharedState& shared, PlanningClient* client, bool may_command)
    : config_(config),
      heeded_(may_command ? ~0U : bit(Pedal::kStop)),
      shared_(shared),
      client_(*client),
      gate_(config.timeout) {}

/** TCP keeps messages in order and whole, so each is newer than the one before. */
void JoyPedals::hear(const sensor_msgs::Joy& joy, std::int64_t now_ns) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ModelState model = shared_.model.load();
  ask(gate_.take({++sequence_, heldPedals(joy, config_) & heeded_}, now_ns, model.mode, model.view));
}

void JoyPedals::idle(std::int64_t now_ns) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ask(gate_.idle(now_ns));
}

void JoyPedals::ask(const loop::PedalRequests& requests) {
  for (std::size_t i = 0; i < requests.count; ++i)
    client_.post(requests.items[i]);
}

}  // namespace raven2_trainer::ros_bridge
