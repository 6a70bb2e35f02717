#include "raven2_trainer/ros/session_replay.h"

#include <ros/node_handle.h>
#include <ros/param.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/replay_timeline.h"
#include "raven2_trainer/session/session_log.h"
#include "ros/planning_messages.h"
#include "ros/state_topics.h"

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

/** A pair's points as one, which is what the log keeps of them. */
ContactList contactList(Tick tick, const std::vector<ContactRecord>& records) {
  ContactList list;
  list.tick = tick;
  list.count = static_cast<std::uint32_t>(std::min(records.size(), kMaxContacts));
  list.dropped = static_cast<std::uint32_t>(records.size()) - list.count;
  for (std::size_t i = 0; i < list.count; ++i) {
    const ContactRecord& record = records[i];
    list.contacts[i] = {record.a, record.b, static_cast<float>(record.depth), record.p_W, {}, record.f_W};
  }
  return list;
}

ros::Time stampOf(const ModelState& model) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(model.time_ns));
}

Tick ticksOf(double seconds) {
  return static_cast<Tick>(std::llround(seconds / kTickSeconds));
}

}  // namespace

struct SessionReplay::Impl {
  Impl(const TrainerConfig& configuration, const session::SessionPaths& session, const SessionReplayOptions& wanted)
      : config(configuration),
        paths(session),
        options(wanted),
        header(session::readLogHeader(paths.log())),
        raven(model::loadRavenModel(config)),
        shared(std::make_unique<SharedState>()) {
    if (header.d4 != config.arms.geometry.d4)
      throw ConfigException(paths.log() + ": was recorded with tools of d4 = " + std::to_string(header.d4) +
                            " m, the configuration's is " + std::to_string(config.arms.geometry.d4));
    if (header.robot_urdf_hash != session::fileHash(config.robot_urdf))
      std::fprintf(stderr, "the robot's description has changed since the session: %s\n", config.robot_urdf.c_str());
  }

  bool hasSimTime() const {
    bool is_set = false;
    ros::param::get("/use_sim_time", is_set);
    if (!is_set && options.set_sim_time) ros::param::set("/use_sim_time", true);
    return is_set || options.set_sim_time;
  }

  /** The cells, as the daemon's threads would leave them; but topics look at each once an instant, whose answers may be
   * all of before --from: the path among them must not be hidden by a later answer that is none. */
  void store(const session::ReplayInstant& instant) {
    if (const PlanResult* path = newestPath(instant.plans)) shared->last_plan.store(*path);
    for (const ExecutionReport& report : instant.executions)
      shared->last_execution.store(report);
    for (const ExerciseRecord& event : instant.events)
      events.add(event);
    shared->exercise_news.store(events);
  }

  void tell(const session::ReplayInstant& instant) {
    const ros::Time stamp = stampOf(instant.tick.model);
    rosgraph_msgs::Clock now;
    now.clock = stamp;
    clock.publish(now);
    store(instant);
    const ModelState& model = instant.tick.model;
    topics->publish({model, instant.tick.robot, instant.haptic, contactList(model.tick, instant.contacts)}, stamp);
    ++told;
  }

  void playOnce(const std::function<bool(double)>& wait) {
    session::ReplayTimeline timeline(std::max<Tick>(1, ticksOf(config.runtime.ros_period)),
                                     options.from < 0.0 ? -1 : ticksOf(options.from));
    Pace pace(options.rate);
    const auto tellComplete = [&] {
      for (session::ReplayInstant instant; timeline.next(&instant);) {
        if (wait(pace.waitFor(instant.tick.model.time_ns))) throw Ended{};
        tell(instant);
      }
    };
    session::LogVisitor visitor;
    visitor.tick = [&](const TickRecord& record) {
      timeline.add(record);
      tellComplete();
    };
    visitor.haptic = [&](const HapticRecord& record) { timeline.add(record); };
    visitor.contact = [&](const ContactRecord& record) { timeline.add(record); };
    visitor.plan = [&](const PlanRecord& record) { timeline.add(record); };
    visitor.execution = [&](const ExecutionRecord& record) { timeline.add(record); };
    visitor.exercise = [&](const ExerciseRecord& record) { timeline.add(record); };
    session::readLog(paths.log(), visitor);
    timeline.finish();
    tellComplete();
  }

  void startOver() {
    events = {};
    shared->exercise_news.store(events);
    topics->startOver();
  }

  const TrainerConfig config;
  const session::SessionPaths paths;
  const SessionReplayOptions options;
  const session::LogHeader header;
  const model::RavenModel raven;
  std::unique_ptr<SharedState> shared;  // the player's own
  ExerciseNews events;
  std::uint64_t told{0};
  std::atomic<bool> refused{false};
  ros::Publisher clock;
  std::unique_ptr<ros::NodeHandle> node;  // between start() and stop(); so the topics
  std::unique_ptr<StateTopics> topics;
};

SessionReplay::SessionReplay(const TrainerConfig& config,
                             const session::SessionPaths& paths,
                             const SessionReplayOptions& options)
    : impl_(std::make_unique<Impl>(config, paths, options)) {}

SessionReplay::~SessionReplay() = default;

void SessionReplay::start() {
  Impl& s = *impl_;
  s.refused.store(!s.hasSimTime());
  if (isRefused()) return;  // without topics: /tf_static is latched, and goes to whoever connects in time
  s.node = std::make_unique<ros::NodeHandle>();
  s.clock = s.node->advertise<rosgraph_msgs::Clock>("/clock", kReplayQueue);
  const TopicSource source{s.config, s.raven, *s.shared, s.header.body_names, [] { return PlanCounts{}; }};
  s.topics = std::make_unique<StateTopics>(s.node.get(), source, kReplayQueue);
}

void SessionReplay::stop() {
  impl_->topics.reset();
  impl_->clock = {};
  impl_->node.reset();
}

bool SessionReplay::isRefused() const noexcept {
  return impl_->refused.load();
}

std::uint64_t SessionReplay::play(const std::function<bool(double)>& wait) {
  try {
    do {
      impl_->startOver();
      const std::uint64_t before = impl_->told;
      impl_->playOnce(wait);
      if (impl_->told == before) throw SessionException(impl_->paths.log() + ": nothing to play in it");
    } while (impl_->options.loop);
  } catch (const Ended&) {
  }
  return impl_->told;
}

}  // namespace raven2_trainer::ros_bridge
