#include "ros/bridge/session_publisher.h"

#include <algorithm>
#include <cstdio>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/ticks.h"
#include "ros/planning/planning_messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

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

}  // namespace

SessionPublisher::SessionPublisher(const TrainerConfig& config, const session::SessionPaths& paths)
    : config_(config),
      paths_(paths),
      header_(session::readLogHeader(paths.log())),
      raven_(model::loadRavenModel(config_)),
      shared_(std::make_unique<SharedState>()) {
  if (header_.d4 != config_.arms.geometry.d4)
    throw ConfigException(paths_.log() + ": was recorded with tools of d4 = " + std::to_string(header_.d4) +
                          " m, the configuration's is " + std::to_string(config_.arms.geometry.d4));
  if (header_.robot_urdf_hash != session::fileHash(config_.robot_urdf))
    std::fprintf(stderr, "the robot's description has changed since the session: %s\n", config_.robot_urdf.c_str());
}

void SessionPublisher::begin(const TopicMaker& topics, std::uint32_t queue, const ros::Time& now) {
  const TopicSource source{config_, raven_, *shared_, header_.body_names, [] { return PlanCounts{}; }};
  topics_ = std::make_unique<StateTopics>(topics, source, queue, now);
}

void SessionPublisher::startOver() {
  events_ = {};
  shared_->exercise_news.store(events_);
  topics_->startOver();
}

/** Fills the cells as the daemon's threads would. Topics read each cell once an instant, and all answers of an instant
 * may be from before
 * --from: a later answer without a path must not hide an earlier path. */
void SessionPublisher::remember(const session::ReplayInstant& instant) {
  if (const PlanResult* path = newestPath(instant.plans)) shared_->last_plan.store(*path);
  for (const ExecutionReport& report : instant.executions)
    shared_->last_execution.store(report);
  for (const ExerciseRecord& event : instant.events)
    events_.add(event);
  shared_->exercise_news.store(events_);
}

void SessionPublisher::publish(const session::ReplayInstant& instant, const ros::Time& stamp) {
  remember(instant);
  const ModelState& model = instant.tick.model;
  topics_->publish({model, instant.tick.robot, instant.haptic, contactList(model.tick, instant.contacts)}, stamp);
}

void SessionPublisher::read(double from,
                            const std::function<void(const session::ReplayInstant&)>& use,
                            const std::function<void(const TickRecord&)>& on_tick) const {
  session::ReplayTimeline timeline(std::max<Tick>(1, toTicks(config_.runtime.ros_period)),
                                   from < 0.0 ? -1 : toTicks(from));
  const auto useComplete = [&] {
    for (session::ReplayInstant instant; timeline.next(&instant);)
      use(instant);
  };
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) {
    if (on_tick) on_tick(record);
    timeline.add(record);
    useComplete();
  };
  visitor.haptic = [&](const HapticRecord& record) { timeline.add(record); };
  visitor.contact = [&](const ContactRecord& record) { timeline.add(record); };
  visitor.plan = [&](const PlanRecord& record) { timeline.add(record); };
  visitor.execution = [&](const ExecutionRecord& record) { timeline.add(record); };
  visitor.exercise = [&](const ExerciseRecord& record) { timeline.add(record); };
  session::readLog(paths_.log(), visitor);
  timeline.finish();
  useComplete();
}

}  // namespace raven2_trainer::ros_bridge
