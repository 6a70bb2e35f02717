#include "raven2_trainer/ros/session_replay.h"

#include <ros/node_handle.h>
#include <ros/param.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <atomic>
#include <chrono>

#include "raven2_trainer/core/exceptions.h"
#include "ros/bridge/session_publisher.h"

namespace raven2_trainer::ros_bridge {
namespace {

// Two seconds of the fastest replay (20 x 100 Hz): who listens is behind by a hiccup, and misses nothing.
constexpr std::uint32_t kReplayQueue = 4000;
constexpr std::int64_t kLongestPause = 1'000'000'000;  // [ns] of the session

/** Thrown out of the reading of a log: the visitor has no other way to end it. */
struct Ended {};

/** When an instant is due by the wall's clock. */
class Pace {
 public:
  explicit Pace(double rate) : rate_(rate) {}

  /** @return [s] from now until the instant of `time_ns` is due; not negative. */
  double waitFor(std::int64_t time_ns) {
    if (!has_begun_ || time_ns - last_ns_ > kLongestPause) {
      begin_ = Clock::now();
      begin_ns_ = time_ns;
    }
    has_begun_ = true;
    last_ns_ = time_ns;
    const std::chrono::duration<double> left = begin_ + toWall(time_ns - begin_ns_) - Clock::now();
    return std::max(0.0, left.count());
  }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::duration toWall(std::int64_t session_ns) const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double, std::nano>(static_cast<double>(session_ns) / rate_));
  }

  const double rate_;
  bool has_begun_{false};
  Clock::time_point begin_;
  std::int64_t begin_ns_{0}, last_ns_{0};
};

ros::Time stampOf(const ModelState& model) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(model.time_ns));
}

}  // namespace

struct SessionReplay::Impl {
  Impl(const TrainerConfig& config, const session::SessionPaths& session, const SessionReplayOptions& wanted)
      : paths(session), options(wanted), publisher(config, session) {}

  bool hasSimTime() const {
    bool is_set = false;
    ros::param::get("/use_sim_time", is_set);
    if (!is_set && options.set_sim_time) ros::param::set("/use_sim_time", true);
    return is_set || options.set_sim_time;
  }

  void publish(const session::ReplayInstant& instant) {
    rosgraph_msgs::Clock now;
    now.clock = stampOf(instant.tick.model);
    clock.publish(now);
    publisher.publish(instant, now.clock);
    ++published;
  }

  void playOnce(const std::function<bool(double)>& wait) {
    Pace pace(options.rate);
    publisher.read(options.from, [&](const session::ReplayInstant& instant) {
      if (wait(pace.waitFor(instant.tick.model.time_ns))) throw Ended{};
      publish(instant);
    });
  }

  const session::SessionPaths paths;
  const SessionReplayOptions options;
  SessionPublisher publisher;
  std::uint64_t published{0};
  std::atomic<bool> refused{false};
  ros::Publisher clock;
  std::unique_ptr<ros::NodeHandle> node;  // between start() and stop(); so the publisher's topics
};

SessionReplay::SessionReplay(const TrainerConfig& config,
                             const session::SessionPaths& paths,
                             const SessionReplayOptions& options)
    : impl_(std::make_unique<Impl>(config, paths, options)) {}

SessionReplay::~SessionReplay() = default;

void SessionReplay::start() {
  Impl& s = *impl_;
  s.refused.store(!s.hasSimTime());
  if (isRefused()) return;  // without topics: /tf_static is latched, and would reach early subscribers
  s.node = std::make_unique<ros::NodeHandle>();
  s.clock = s.node->advertise<rosgraph_msgs::Clock>("/clock", kReplayQueue);
  s.publisher.begin(TopicMaker(s.node.get()), kReplayQueue, ros::Time::now());
}

void SessionReplay::stop() {
  impl_->publisher.end();
  impl_->clock = {};
  impl_->node.reset();
}

bool SessionReplay::isRefused() const noexcept {
  return impl_->refused.load();
}

std::uint64_t SessionReplay::play(const std::function<bool(double)>& wait) {
  try {
    do {
      impl_->publisher.startOver();
      const std::uint64_t before = impl_->published;
      impl_->playOnce(wait);
      if (impl_->published == before) throw SessionException(impl_->paths.log() + ": nothing to play in it");
    } while (impl_->options.loop);
  } catch (const Ended&) {
  }
  return impl_->published;
}

}  // namespace raven2_trainer::ros_bridge
