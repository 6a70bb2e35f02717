#pragma once

#include <ros/message_traits.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/serialization.h>

#include <cstdint>
#include <string>

namespace raven2_trainer::ros_bridge {

/** A topic in the words of ROS. */
struct TopicWords {
  std::string name;  ///< from the root on
  std::string type, md5, definition;
  bool latched{};
  bool has_header{};  ///< its bytes begin with header.seq
};

/** Where messages go that no node publishes: a bag. */
class MessageSink {
 public:
  MessageSink() = default;
  virtual ~MessageSink() = default;
  MessageSink(const MessageSink&) = delete;
  MessageSink& operator=(const MessageSink&) = delete;
  virtual void write(const TopicWords& topic, const ros::SerializedMessage& message) = 0;
};

/** One topic: a node's, or a sink's. */
template <typename Message>
class Outlet {
 public:
  Outlet() = default;
  explicit Outlet(const ros::Publisher& publisher) : publisher_(publisher) {}
  Outlet(MessageSink* sink, const std::string& name, bool latched)
      : sink_(sink),
        words_{name.front() == '/' ? name : "/" + name,
               ros::message_traits::datatype<Message>(),
               ros::message_traits::md5sum<Message>(),
               ros::message_traits::definition<Message>(),
               latched,
               ros::message_traits::hasHeader<Message>()} {}

  void publish(const Message& message) const {
    if (sink_ == nullptr) return publisher_.publish(message);
    sink_->write(words_, ros::serialization::serializeMessage(message));
  }
  /** A bag hears all. */
  bool isHeard() const { return sink_ != nullptr || publisher_.getNumSubscribers() > 0; }

 private:
  ros::Publisher publisher_;
  MessageSink* sink_{nullptr};
  TopicWords words_;
};

/** Whose topics are made. */
class TopicMaker {
 public:
  explicit TopicMaker(ros::NodeHandle* node) : node_(node) {}
  explicit TopicMaker(MessageSink* sink) : sink_(sink) {}

  template <typename Message>
  Outlet<Message> advertise(const std::string& name, std::uint32_t queue, bool latched = false) const {
    if (sink_ != nullptr) return Outlet<Message>(sink_, name, latched);
    return Outlet<Message>(node_->advertise<Message>(name, queue, latched));
  }

 private:
  ros::NodeHandle* node_{nullptr};
  MessageSink* sink_{nullptr};
};

}  // namespace raven2_trainer::ros_bridge
