#include "apps/export/session_bag.h"

#include <geometry_msgs/PoseStamped.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Joy.h>
#include <topic_tools/shape_shifter.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "apps/export/fault_topic.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/training/session_metrics.h"
#include "ros/bridge/session_publisher.h"
#include "ros/bridge/session_topic.h"
#include "ros/node/topic.h"

namespace raven2_trainer::apps {
namespace {

using ros_bridge::Outlet;
using ros_bridge::TopicWords;

constexpr PerArm<const char*> kBases{"model/base_link_L", "model/base_link_R"};

/** A bag whose messages have the time that is set. */
class BagSink : public ros_bridge::MessageSink {
 public:
  explicit BagSink(const std::string& path) : bag_(std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Write)) {}
  /** After a failure: the bag's destructor would write, and throw once more. */
  ~BagSink() override {
    try {
      bag_->close();
    } catch (const rosbag::BagException&) {
      static_cast<void>(bag_.release());
    }
  }

  void setTime(const ros::Time& now) { now_ = now; }
  BagCounts counts() const { return {messages_, topics_.size()}; }
  /** @throw rosbag::BagException on a full disk. */
  void close() { bag_->close(); }

  void write(const TopicWords& topic, const ros::SerializedMessage& message) override {
    Topic& kept = topics_[topic.name];
    if (!kept.words) kept.words = connectionOf(topic);
    if (topic.has_header) std::memcpy(message.message_start, &kept.count, sizeof(kept.count));  // header.seq, as roscpp
    ++kept.count;
    topic_tools::ShapeShifter raw;
    raw.morph(topic.md5, topic.type, topic.definition, topic.latched ? "1" : "0");
    // Behind the length, which is the connection's.
    ros::serialization::IStream stream(message.message_start, static_cast<std::uint32_t>(message.num_bytes) - 4U);
    raw.read(stream);
    bag_->write(topic.name, now_, raw, kept.words);
    ++messages_;
  }

 private:
  struct Topic {
    boost::shared_ptr<ros::M_string> words;
    std::uint32_t count{0};
  };

  /** As in a recorded bag. rosbag play latches what its connection says. */
  static boost::shared_ptr<ros::M_string> connectionOf(const TopicWords& topic) {
    return boost::make_shared<ros::M_string>(ros::M_string{{"callerid", "/raven2_simulator"},
                                                           {"latching", topic.latched ? "1" : "0"},
                                                           {"topic", topic.name},
                                                           {"type", topic.type},
                                                           {"md5sum", topic.md5},
                                                           {"message_definition", topic.definition}});
  }

  std::unique_ptr<rosbag::Bag> bag_;
  ros::Time now_;
  std::uint64_t messages_{0};
  std::map<std::string, Topic> topics_;
};

/** [ns] The wall clock less the log's, to a second: meta.json has the session's start in seconds. */
std::int64_t wallClockOf(const session::SessionPaths& paths, std::int64_t first_tick_ns) {
  std::tm begin{};
  const std::string text = session::readStartTime(paths);
  if (text.empty() || ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &begin) == nullptr) {
    std::fprintf(stderr, "meta.json has no start_time_utc: the bag's stamps are the log's own clock\n");
    return 0;
  }
  return static_cast<std::int64_t>(::timegm(&begin)) * 1'000'000'000 - first_tick_ns;
}

/** A beginning or end of a fault, at the session tick in which the daemon learned of it. */
BagFault faultChange(const training::Injection& injection, bool acts) {
  const Fault& fault = injection.fault;
  BagFault message;
  message.scenario = injection.name;
  message.acts = acts;
  message.row = static_cast<std::uint32_t>(fault.row);
  message.host = kFaultHostNames[static_cast<std::size_t>(fault.host)];
  message.site = kFaultSiteNames[static_cast<std::size_t>(fault.site)];
  message.variable = infoOf(fault.variable).name;
  message.arm = fault.arm < 0 ? "both" : kArmNames[static_cast<std::size_t>(fault.arm)];
  message.channel = fault.channel;
  message.kind = kFaultKindNames[static_cast<std::size_t>(fault.kind)];
  message.value = fault.value;
  message.tick = acts ? injection.inject_tick : injection.clear_tick;
  const std::uint64_t cycle = acts ? injection.inject_cycle : injection.clear_cycle;
  message.cycle = cycle == 0 ? -1 : static_cast<std::int64_t>(cycle);
  return message;
}

std::vector<BagFault> faultChanges(const training::SessionMetrics& metrics) {
  std::vector<BagFault> changes;
  for (const training::Injection& injection : metrics.injections) {
    changes.push_back(faultChange(injection, true));
    const bool has_ended = injection.clear_tick >= 0 || injection.clear_cycle != 0;  // also before the first pedal-down
    if (has_ended) changes.push_back(faultChange(injection, false));
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const BagFault& a, const BagFault& b) { return a.tick < b.tick; });
  return changes;
}

/** Before a file is made. */
training::SessionMetrics metricsOf(const session::SessionPaths& paths) {
  training::SessionMetrics metrics = training::computeMetrics(paths.log());
  if (metrics.ticks == 0)
    throw SessionException(paths.directory + ": the pedal was never pressed, there is nothing to export");
  return metrics;
}

/** Removes what is left of a file that did not get its name. */
struct UnfinishedFile {
  explicit UnfinishedFile(std::string of_path) : path(std::move(of_path)) {}
  ~UnfinishedFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  const std::string path;
};

class BagWriter {
 public:
  BagWriter(const TrainerConfig& config, const session::SessionPaths& paths, const std::string& bag)
      : paths_(paths), publisher_(config, paths), metrics_(metricsOf(paths)), sink_(bag), topics_(&sink_) {}

  BagCounts write(const std::function<void(double)>& progress) {
    const double ticks = static_cast<double>(std::max<std::uint64_t>(metrics_.ticks, 1));
    publisher_.read(
        -1.0, [this](const session::ReplayInstant& instant) { publish(instant); },
        [&](const TickRecord& record) {
          if (!has_clock_) offset_ = wallClockOf(paths_, record.model.time_ns);
          has_clock_ = true;
          stampChanges(record.model);
          if (record.model.session_tick % 1000 == 0) progress(static_cast<double>(record.model.session_tick) / ticks);
        });
    writeChanges(ros::TIME_MAX);
    sink_.close();
    return sink_.counts();
  }

 private:
  ros::Time stampOf(std::int64_t time_ns) const {
    return ros::Time().fromNSec(static_cast<std::uint64_t>(time_ns + offset_));
  }

  void begin(const ros::Time& stamp) {
    has_begun_ = true;
    publisher_.begin(topics_, ros_bridge::kQueue, stamp);
    TrainerConfig recorded = publisher_.config();
    const session::LogHeader& header = publisher_.header();
    recorded.seed = header.seed;
    recorded.hazard = header.hazard;
    recorded.exercise_name = header.exercise;
    recorded.drill = header.drill;
    const std::string directory = std::filesystem::absolute(paths_.directory).lexically_normal().string();
    configuration_.publish(
        ros_bridge::sessionConfiguration(recorded, directory, session::readConfigurationFiles(paths_), stamp));
  }

  void publish(const session::ReplayInstant& instant) {
    const ModelState& model = instant.tick.model;
    if (model.session_tick < 0) return publisher_.remember(instant);
    const ros::Time stamp = stampOf(model.time_ns);
    writeChanges(stamp);
    sink_.setTime(stamp);
    if (!has_begun_) begin(stamp);
    publisher_.publish(instant, stamp);
    for (const Arm arm : kArms)
      publishTip(at(model.arms, arm), arm, stamp);
    publishPedal(model, stamp);
  }

  void publishTip(const ArmState& state, Arm arm, const ros::Time& stamp) {
    geometry_msgs::PoseStamped message;
    message.header.stamp = stamp;
    message.header.frame_id = at(kBases, arm);
    message.pose.position.x = state.p_BT[0];
    message.pose.position.y = state.p_BT[1];
    message.pose.position.z = state.p_BT[2];
    message.pose.orientation.x = state.q_BT[0];
    message.pose.orientation.y = state.q_BT[1];
    message.pose.orientation.z = state.q_BT[2];
    message.pose.orientation.w = state.q_BT[3];
    at(tips_, arm).publish(message);
  }

  void publishPedal(const ModelState& model, const ros::Time& stamp) {
    if (model.pedal == last_pedal_) return;
    last_pedal_ = model.pedal;
    sensor_msgs::Joy message;
    message.header.stamp = stamp;
    message.buttons = {model.pedal};
    pedal_.publish(message);
  }

  /** A change before the first tick gets the time of the first tick. */
  void stampChanges(const ModelState& model) {
    for (; model.session_tick >= 0 && stamped_ < changes_.size() && changes_[stamped_].tick <= model.session_tick;
         ++stamped_)
      changes_[stamped_].stamp = stampOf(model.time_ns);
  }

  void writeChanges(const ros::Time& until) {
    for (; written_ < stamped_ && changes_[written_].stamp <= until; ++written_) {
      sink_.setTime(changes_[written_].stamp);
      faults_.publish(changes_[written_]);
    }
  }

  const session::SessionPaths paths_;
  ros_bridge::SessionPublisher publisher_;
  const training::SessionMetrics metrics_;
  BagSink sink_;
  ros_bridge::TopicMaker topics_;
  Outlet<SessionConfiguration> configuration_ =
      topics_.advertise<SessionConfiguration>("session/configuration", ros_bridge::kQueue, ros_bridge::kLatched);
  PerArm<Outlet<geometry_msgs::PoseStamped>> tips_{
      topics_.advertise<geometry_msgs::PoseStamped>("model/gold/measured_cp", ros_bridge::kQueue),
      topics_.advertise<geometry_msgs::PoseStamped>("model/green/measured_cp", ros_bridge::kQueue)};
  Outlet<sensor_msgs::Joy> pedal_ = topics_.advertise<sensor_msgs::Joy>("console/pedal", ros_bridge::kQueue);
  FaultTopic faults_{topics_};
  std::vector<BagFault> changes_ = faultChanges(metrics_);
  std::size_t stamped_{0}, written_{0};  // of changes_
  std::int64_t offset_{0};               // [ns] the wall clock less the log's
  bool has_clock_{false}, has_begun_{false};
  int last_pedal_{-1};
};

}  // namespace

BagCounts writeSessionBag(const TrainerConfig& config,
                          const session::SessionPaths& paths,
                          const std::string& bag,
                          const std::function<void(double)>& progress) {
  const UnfinishedFile part(bag + ".part");
  try {
    const BagCounts counts = BagWriter(config, paths, part.path).write(progress);
    std::filesystem::rename(part.path, bag);
    return counts;
  } catch (const std::filesystem::filesystem_error& e) {
    throw SessionException(bag + ": " + e.code().message());
  } catch (const rosbag::BagException& e) {
    throw SessionException(bag + ": " + e.what());
  }
}

}  // namespace raven2_trainer::apps
