#include "raven2_trainer/ros/master_devices.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/callback_queue.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <ros/single_subscriber_publisher.h>
#include <ros/spinner.h>
#include <std_msgs/Bool.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "ros/devices/force_messages.h"
#include "ros/devices/force_readers.h"
#include "ros/devices/fresh_force.h"
#include "ros/devices/master_device_messages.h"
#include "ros/devices/master_device_reader.h"
#include "ros/devices/master_status.h"
#include "ros/devices/operator_lines.h"
#include "ros/devices/pedal_hold.h"
#include "ros/devices/rest_watch.h"
#include "ros/node/periodic_thread.h"
#include "ros/node/topic.h"

namespace raven2_trainer::ros_bridge {
namespace {

using Clock = std::chrono::steady_clock;
using Message = topic_tools::ShapeShifter;
using Event = ros::MessageEvent<const Message>;
using namespace std::chrono_literals;

constexpr std::uint32_t kNewestPose = 1;  // [messages] poses: an old one is worth nothing
constexpr std::uint32_t kEvents = 100;    // [messages] each press of a button counts
constexpr double kSettle = 2.0;           // [s] connections are made in
constexpr double kForceNewsPeriod = 0.1;  // [s] who reads forces is looked at
constexpr int kGoodbyes = 5;              // messages of no force at the end, 5 ms apart
constexpr int kMostGoodbyes = 50;         // the same to a hand that goes on: 250 ms of the Supervisor's 500

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/** Nodes that read a topic, by name. Connections come and go on the spinner's thread. */
class Readers {
 public:
  void add(const std::string& name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    names_.push_back(name);
  }

  void remove(const std::string& name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found != names_.end()) names_.erase(found);
  }

  std::vector<std::string> names() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return names_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> names_;
};

template <typename Force>
ros::Publisher advertise(ros::NodeHandle* node, const std::string& topic, Readers* readers) {
  const auto add = [readers](const ros::SingleSubscriberPublisher& reader) {
    readers->add(reader.getSubscriberName());
  };
  const auto remove = [readers](const ros::SingleSubscriberPublisher& reader) {
    readers->remove(reader.getSubscriberName());
  };
  return node->advertise<Force>(topic, kNewestPose, ros::SubscriberStatusCallback(add),
                                ros::SubscriberStatusCallback(remove));
}

/** Publishes forces in the message of a family's driver. */
struct ForceForm {
  ros::Publisher (*advertise)(ros::NodeHandle*, const std::string& topic, Readers*);
  void (*publish)(const ros::Publisher&, const DeviceForce&, const std::string& frame);
};

template <typename Message>
constexpr ForceForm formOf() {
  return {&advertise<Message>, [](const ros::Publisher& publisher, const DeviceForce& out, const std::string& frame) {
            Message message;
            devices::fill(out, frame, &message);
            publisher.publish(message);
          }};
}

/** By DeviceFamily. */
constexpr std::array<ForceForm, kFamilies.size()> kForceForms{
    formOf<devices::OmniFeedback>(),
    formOf<devices::DeviceFeedback>(),
    formOf<geometry_msgs::WrenchStamped>(),
    ForceForm{},
};

ros::Publisher advertiseForce(ros::NodeHandle* node, DeviceFamily family, const std::string& topic, Readers* readers) {
  const ForceForm& form = kForceForms[static_cast<std::size_t>(family)];
  return topic.empty() || form.advertise == nullptr ? ros::Publisher() : form.advertise(node, topic, readers);
}

/** News for the operator, by the thread that writes them. */
struct DeviceNews {
  OperatorLines of_spinner, of_publisher;
};

/** One device's topics. Messages come on the spinner's thread, forces go on the publisher's. */
class Device {
 public:
  Device(const MasterConfig& config, Arm arm, MasterLink* link, ros::NodeHandle* node, DeviceNews* news)
      : config_(config),
        news_(*news),
        arm_(arm),
        topics_(at(config.devices, arm)),
        cell_(at(link->samples, arm)),
        reader_(config, topics_),
        force_(at(link->forces, arm)),
        force_news_(deviceName(arm), topics_.force, topics_.pose, kSettle),
        absolute_news_(deviceName(arm), topics_.force_absolute, kSettle),
        publisher_(advertiseForce(node, config.family, topics_.force, &readers_)) {
    absolute_ = sendTrue(node, topics_.force_absolute);
    gravity_ = sendTrue(node, topics_.gravity_compensation);
    listen(node);
  }

  Arm arm() const noexcept { return arm_; }

  /** @param[in] time [s] of a clock. */
  void press(double time) {
    if (!publisher_) return;
    const DeviceForce out = force_.take(time);
    if (!isDue(out)) return;
    last_ = out;
    if (isAbsoluteMissing()) last_.force = {};
    publish();
  }

  /** No force, where it was last. @return the driver needs no more of that. */
  bool letGo(double time) {
    if (!publisher_ || last_.is_placed == 0) return true;
    last_.force = {};
    publish();
    const bool rests = rest_.look(config_.metres_per_unit * toEigen(cell_.load().position), time);
    return rests || !traitsOf(config_.family).subtracts_velocity;  // the last one's stays
  }

  void reportReaders(double time) {
    news_.of_publisher.say(force_news_.look(readers_.names(), driver(), time));
    if (absolute_) news_.of_publisher.say(absolute_news_.look(!isAbsoluteMissing(), time));
  }

  /** Since the last call, `elapsed` [s] ago. */
  DeviceTraffic traffic(double elapsed) {
    const std::uint32_t poses = cell_.load().poses;
    const std::vector<std::string> readers = readers_.names();
    DeviceTraffic traffic;
    traffic.pose_rate = (poses - counted_) / elapsed;
    traffic.readers = static_cast<std::uint32_t>(readers.size());
    traffic.is_driver_among = isDriverAmong(readers, driver());
    traffic.is_absolute_missing = isAbsoluteMissing();
    counted_ = poses;
    return traffic;
  }

 private:
  /** Once, and to later subscribers. */
  static ros::Publisher sendTrue(ros::NodeHandle* node, const std::string& topic) {
    if (topic.empty()) return {};
    ros::Publisher publisher = node->advertise<std_msgs::Bool>(topic, 1, /*latch=*/true);
    std_msgs::Bool message;
    message.data = 1;
    publisher.publish(message);
    return publisher;
  }

  void publish() { kForceForms[static_cast<std::size_t>(config_.family)].publish(publisher_, last_, frame()); }

  bool isDue(const DeviceForce& force) const noexcept {
    return force.is_placed != 0 && (force.has_begun != 0 || !traitsOf(config_.family).holds_device);
  }

  /** Forces in axes that nobody has turned to those of the base would push anywhere. */
  bool isAbsoluteMissing() const { return absolute_ && absolute_.getNumSubscribers() == 0; }

  void listen(ros::NodeHandle* node) {
    hear(node, topics_.pose, kNewestPose, [this](const Message& m) { return reader_.pose(m); });
    for (std::size_t i = 0; i < topics_.buttons.size(); ++i)
      hear(node, topics_.buttons[i], kEvents, [this, i](const Message& m) { return reader_.buttons(m, i); });
    hear(node, topics_.gripper, kNewestPose, [this](const Message& m) { return reader_.gripper(m); });
    hear(node, topics_.operating_state, kEvents, [this](const Message& m) { return reader_.operatingState(m); });
  }

  void hear(ros::NodeHandle* node,
            const std::string& topic,
            std::uint32_t queue,
            std::function<bool(const Message&)> read) {
    if (topic.empty()) return;
    const boost::function<void(const Event&)> callback = [this, read = std::move(read)](const Event& event) {
      take(event, read);
    };
    subscribers_.push_back(node->subscribe<Message, const Event&>(topic, queue, callback, ros::VoidConstPtr(),
                                                                  ros::TransportHints().tcpNoDelay()));
  }

  void take(const Event& event, const std::function<bool(const Message&)>& read) {
    const std::uint32_t poses = reader_.sample().poses;
    if (!read(*event.getConstMessage())) {
      const std::string line = reader_.refusal();
      if (!line.empty()) news_.of_spinner.say(std::string(deviceName(arm_)) + ": " + line);
      return;
    }
    cell_.store(reader_.sample());
    const std::lock_guard<std::mutex> lock(mutex_);
    frame_ = reader_.frame();
    if (reader_.sample().poses != poses) driver_ = event.getPublisherName();
  }

  std::string driver() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return driver_;
  }

  std::string frame() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return frame_;
  }

  const MasterConfig& config_;
  DeviceNews& news_;
  const Arm arm_;
  const DeviceTopics& topics_;
  StateCell<DeviceSample>& cell_;
  MasterDeviceReader reader_;
  FreshForce force_;
  Readers readers_;
  ForceReaders force_news_;
  AbsoluteListener absolute_news_;
  DeviceForce last_;  ///< that was published
  RestWatch rest_;
  ros::Publisher publisher_, absolute_, gravity_;
  std::vector<ros::Subscriber> subscribers_;
  std::mutex mutex_;
  std::string frame_, driver_;  ///< guarded by it
  std::uint32_t counted_{0};
};

/** A pedal that is a sensor_msgs/Joy. */
class PedalTopic {
 public:
  PedalTopic(const MasterConfig& config, MasterLink* link, ros::NodeHandle* node, DeviceNews* news)
      : config_(config), news_(*news), cell_(link->pedal), hold_(config.pedal_topic, config.pedal_silent_after) {
    if (config.pedal_from != PedalFrom::kTopic) return;
    const boost::function<void(const Message::ConstPtr&)> hear = [this](const Message::ConstPtr& m) { take(*m); };
    subscriber_ = node->subscribe<Message>(config.pedal_topic, kEvents, hear, ros::VoidConstPtr(),
                                           ros::TransportHints().tcpNoDelay());
  }

  /** On the publisher's thread. */
  void say() {
    if (!subscriber_) return;
    std::string news;
    const bool is_held = hold_.look(subscriber_.getNumPublishers() > 0, secondsSince(started_), &news);
    news_.of_publisher.say(news);
    cell_.store(FootPedal{static_cast<std::uint8_t>(is_held ? 1 : 0)});
  }

 private:
  void take(const Message& message) {
    bool held = false;
    const bool is_known = readJoyButton(message, config_.pedal_button, &held);
    hold_.hear(held, secondsSince(started_));
    if (!is_known && !std::exchange(reported_refused_, true))
      news_.of_spinner.say("pedal: refused: " + config_.pedal_topic + " is of type " + message.getDataType() +
                           ", or has no button " + std::to_string(config_.pedal_button) +
                           "; a sensor_msgs/Joy is wanted");
  }

  const MasterConfig& config_;
  DeviceNews& news_;
  StateCell<FootPedal>& cell_;
  const Clock::time_point started_{Clock::now()};
  PedalHold hold_;
  ros::Subscriber subscriber_;
  bool reported_refused_{false};  // of the spinner's thread
};

}  // namespace

struct MasterDevices::Impl {
  Impl(const MasterConfig& master, MasterLink* master_link) : config(master), link(*master_link) {}

  /** The parts that need ROS: between start() and stop(). */
  struct Session {
    explicit Session(Impl* owner) : config(owner->config), link(owner->link) {
      node.setCallbackQueue(&queue);
      for (const Arm arm : kArms) {
        if (at(config.devices, arm).is_used)
          devices.push_back(std::make_unique<Device>(config, arm, &link, &node, &owner->news));
      }
      pedal = std::make_unique<PedalTopic>(config, &link, &node, &owner->news);
      diagnostics = node.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
      spinner = std::make_unique<ros::AsyncSpinner>(1, &queue);
      spinner->start();
      publisher.start(1.0 / config.force_rate, [this] { cycle(); });
    }

    ~Session() {
      publisher.stop();
      letGo();
      spinner->stop();
    }

    void letGo() {
      bool is_done = false;
      for (int i = 0; i < kGoodbyes || (i < kMostGoodbyes && !is_done); ++i) {
        is_done = true;
        for (const auto& device : devices)
          is_done = device->letGo(secondsSince(started)) && is_done;
        std::this_thread::sleep_for(5ms);
      }
    }

    void cycle() {
      const double time = secondsSince(started);
      pedal->say();
      for (const auto& device : devices)
        device->press(time);
      if (time - readers_reported >= kForceNewsPeriod) reportReaders(time);
      if (time - diagnosed >= kDiagnosticsPeriod) diagnose(time);
    }

    void reportReaders(double time) {
      for (const auto& device : devices)
        device->reportReaders(time);
      readers_reported = time;
    }

    void diagnose(double time) {
      diagnostic_msgs::DiagnosticArray array;
      array.header.stamp = ros::Time::now();
      const MasterReport report = link.report.load();
      for (const auto& device : devices) {
        array.status.push_back(masterStatus(config, device->arm(), report, device->traffic(time - diagnosed)));
      }
      diagnostics.publish(array);
      diagnosed = time;
    }

    const MasterConfig& config;
    MasterLink& link;
    ros::CallbackQueue queue;
    ros::NodeHandle node;
    std::vector<std::unique_ptr<Device>> devices;
    std::unique_ptr<PedalTopic> pedal;
    ros::Publisher diagnostics;
    std::unique_ptr<ros::AsyncSpinner> spinner;
    const Clock::time_point started{Clock::now()};
    double diagnosed{0.0}, readers_reported{0.0};
    PeriodicThread publisher;
  };

  const MasterConfig config;
  MasterLink& link;
  DeviceNews news;
  std::unique_ptr<Session> session;
};

MasterDevices::MasterDevices(const MasterConfig& config, MasterLink* link)
    : impl_(std::make_unique<Impl>(config, link)) {}

MasterDevices::~MasterDevices() {
  stop();
}

void MasterDevices::start() {
  impl_->session = std::make_unique<Impl::Session>(impl_.get());
}

void MasterDevices::stop() {
  impl_->session.reset();
}

bool MasterDevices::nextLine(std::string* line) {
  return impl_->news.of_spinner.next(line) || impl_->news.of_publisher.next(line);
}

}  // namespace raven2_trainer::ros_bridge
