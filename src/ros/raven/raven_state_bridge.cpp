#include "raven2_trainer/ros/raven_state_bridge.h"

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <topic_tools/shape_shifter.h>

#include <atomic>
#include <cstdio>

#include "raven2_trainer/net/clock.h"
#include "ros/raven/raven_state_reader.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::uint32_t kBridgeQueue = 100;  // [messages]

}  // namespace

struct RavenStateBridge::Impl {
  Impl(const VirtualRavenConfig& config, const std::string& topic_name, robot::StateServer* state_server)
      : reader(config), topic(topic_name), server(*state_server) {}

  void take(const topic_tools::ShapeShifter& message) {
    received.fetch_add(1);
    const std::int64_t now_ns = net::monotonicNow();
    RobotState state;
    if (!read(message, now_ns, &state)) {
      refused.fetch_add(1);
      return;
    }
    server.push(state);
    newest_ns.store(now_ns);
  }

  bool read(const topic_tools::ShapeShifter& message, std::int64_t now_ns, RobotState* state) {
    const std::string& md5 = message.getMD5Sum();
    if (md5 == raven_2::RavenState::md5()) return readAs<raven_2::RavenState>(message, now_ns, state);
    if (md5 == raven_2::ForkRavenState::md5()) return readAs<raven_2::ForkRavenState>(message, now_ns, state);
    reportUnknown(message.getDataType(), md5);
    return false;
  }

  template <typename Message>
  bool readAs(const topic_tools::ShapeShifter& message, std::int64_t now_ns, RobotState* state) {
    try {
      return reader.read(*message.instantiate<Message>(), now_ns, state);
    } catch (const ros::Exception&) {  // shorter than its check sum promises
      return false;
    }
  }

  /** Once for each type met. */
  void reportUnknown(const std::string& type, const std::string& md5) {
    if (md5 == reported_md5) return;
    reported_md5 = md5;
    std::fprintf(stderr,
                 "refused: %s with check sum %s; known: raven_2/raven_state with %s (raven2) or %s (raven2_sim)\n",
                 type.c_str(), md5.c_str(), raven_2::RavenState::md5(), raven_2::ForkRavenState::md5());
  }

  /** The parts that need ROS: between start() and stop(). */
  struct Subscription {
    explicit Subscription(Impl* owner)
        : states(node.subscribe(owner->topic, kBridgeQueue, &Impl::take, owner, ros::TransportHints().tcpNoDelay())),
          spinner(1) {
      spinner.start();
    }
    ~Subscription() { spinner.stop(); }

    ros::NodeHandle node;
    ros::Subscriber states;
    ros::AsyncSpinner spinner;
  };

  RavenStateReader reader;
  const std::string topic;
  robot::StateServer& server;
  std::string reported_md5;
  std::atomic<std::uint64_t> received{0}, refused{0};
  std::atomic<std::int64_t> newest_ns{0};
  std::unique_ptr<Subscription> subscription;
};

RavenStateBridge::RavenStateBridge(const VirtualRavenConfig& config,
                                   const std::string& topic,
                                   robot::StateServer* server)
    : impl_(std::make_unique<Impl>(config, topic, server)) {}

RavenStateBridge::~RavenStateBridge() {
  stop();
}

void RavenStateBridge::start() {
  impl_->subscription = std::make_unique<Impl::Subscription>(impl_.get());
}

void RavenStateBridge::stop() {
  impl_->subscription.reset();
}

std::uint64_t RavenStateBridge::received() const noexcept {
  return impl_->received.load();
}

std::uint64_t RavenStateBridge::refused() const noexcept {
  return impl_->refused.load();
}

std::int64_t RavenStateBridge::newest() const noexcept {
  return impl_->newest_ns.load();
}

}  // namespace raven2_trainer::ros_bridge
