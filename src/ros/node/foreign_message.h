#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <string>

// Messages of packages that need not be installed: structs of ours with the fields, their order and the check sums of
// theirs.

namespace raven2_trainer::ros_bridge {

/** A message's text with that of a message it is made of, as a topic's connection header carries it. */
template <typename Part>
std::string withPart(const char* text) {
  return std::string(text) + "\n" + std::string(80, '=') + "\nMSG: " + ros::message_traits::DataType<Part>::value() +
         "\n" + ros::message_traits::Definition<Part>::value();
}

template <typename Message>
struct ForeignMd5 {
  static const char* value() { return Message::md5(); }
  static const char* value(const Message&) { return value(); }
};

template <typename Message>
struct ForeignName {
  static const char* value() { return Message::name(); }
  static const char* value(const Message&) { return value(); }
};

template <typename Message>
struct ForeignText {
  static const char* value() {
    static const std::string text = Message::text();
    return text.c_str();
  }
  static const char* value(const Message&) { return value(); }
};

}  // namespace raven2_trainer::ros_bridge

/**
 * Makes a struct a message of roscpp. It has md5(), name() (package/Message), text() (of those that are published;
 * withPart() adds what it is made of) and fields(m, use), which calls use(m.a, m.b, ...) in the order of the wire. Use
 * it outside of all namespaces.
 */
#define RAVEN2_FOREIGN_MESSAGE(Message)                                                              \
  namespace ros {                                                                                    \
  namespace message_traits {                                                                         \
  template <>                                                                                        \
  struct MD5Sum<Message> : raven2_trainer::ros_bridge::ForeignMd5<Message> {};                       \
  template <>                                                                                        \
  struct DataType<Message> : raven2_trainer::ros_bridge::ForeignName<Message> {};                    \
  template <>                                                                                        \
  struct Definition<Message> : raven2_trainer::ros_bridge::ForeignText<Message> {};                  \
  }                                                                                                  \
  namespace serialization {                                                                          \
  template <>                                                                                        \
  struct Serializer<Message> {                                                                       \
    template <typename Stream, typename Given>                                                       \
    static void allInOne(Stream& stream, Given m) {                                                  \
      Message::fields(m, [&stream](auto&... field) { (stream.next(field), ...); });                  \
    }                                                                                                \
    ROS_DECLARE_ALLINONE_SERIALIZER                                                                  \
  };                                                                                                 \
  }                                                                                                  \
  }
