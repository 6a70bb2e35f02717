#pragma once

#include <geometry_msgs/Pose.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/service_traits.h>

#include <cstdint>
#include <string>
#include <vector>

// Services of the Collaborative Robotics Toolkit's package `crtk_msgs`, 1.3.0: fields, order and check sums as there.

namespace raven2_trainer::ros_bridge::crtk {

/** crtk_msgs/QueryForwardKinematics. */
struct ForwardRequest {
  std::vector<double> jp;  ///< [rad; m]
  geometry_msgs::Pose cp;  ///< not looked at
};
struct ForwardResponse {
  geometry_msgs::Pose cp;
  std::uint8_t result{};
  std::string message;
};

/** crtk_msgs/QueryInverseKinematics. */
struct InverseRequest {
  geometry_msgs::Pose cp;
  std::vector<double> jp;  ///< [rad; m] near which joints are looked for
};
struct InverseResponse {
  std::vector<double> jp;
  std::uint8_t result{};
  std::string message;
};

}  // namespace raven2_trainer::ros_bridge::crtk

#define RAVEN2_CRTK_MESSAGE(Type, name, sum)               \
  template <>                                              \
  struct MD5Sum<Type> {                                    \
    static const char* value() { return sum; }             \
    static const char* value(const Type&) { return sum; }  \
  };                                                       \
  template <>                                              \
  struct DataType<Type> {                                  \
    static const char* value() { return name; }            \
    static const char* value(const Type&) { return name; } \
  };

namespace ros {
namespace message_traits {
namespace crtk = raven2_trainer::ros_bridge::crtk;
RAVEN2_CRTK_MESSAGE(crtk::ForwardRequest, "crtk_msgs/QueryForwardKinematicsRequest", "07968175ee2bc6192df1ba3531d33794")
RAVEN2_CRTK_MESSAGE(crtk::ForwardResponse,
                    "crtk_msgs/QueryForwardKinematicsResponse",
                    "d966cb9cf689484cac4c0f3d90c6e190")
RAVEN2_CRTK_MESSAGE(crtk::InverseRequest, "crtk_msgs/QueryInverseKinematicsRequest", "b8b1abaa4b0941072565aa04cb862deb")
RAVEN2_CRTK_MESSAGE(crtk::InverseResponse,
                    "crtk_msgs/QueryInverseKinematicsResponse",
                    "f30c14a58d988c5ce642a21cc0bb3683")
}  // namespace message_traits

namespace service_traits {
namespace crtk = raven2_trainer::ros_bridge::crtk;
RAVEN2_CRTK_MESSAGE(crtk::ForwardRequest, "crtk_msgs/QueryForwardKinematics", "787c6da7a75e9886573c4af11f1a381f")
RAVEN2_CRTK_MESSAGE(crtk::ForwardResponse, "crtk_msgs/QueryForwardKinematics", "787c6da7a75e9886573c4af11f1a381f")
RAVEN2_CRTK_MESSAGE(crtk::InverseRequest, "crtk_msgs/QueryInverseKinematics", "ce8dbc3b4384e2f7567488e7e75496d8")
RAVEN2_CRTK_MESSAGE(crtk::InverseResponse, "crtk_msgs/QueryInverseKinematics", "ce8dbc3b4384e2f7567488e7e75496d8")
}  // namespace service_traits

namespace serialization {

template <>
struct Serializer<message_traits::crtk::ForwardRequest> {
  template <typename Stream, typename Query>
  static void allInOne(Stream& stream, Query m) {
    stream.next(m.jp);
    stream.next(m.cp);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::crtk::InverseRequest> {
  template <typename Stream, typename Query>
  static void allInOne(Stream& stream, Query m) {
    stream.next(m.cp);
    stream.next(m.jp);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::crtk::ForwardResponse> {
  template <typename Stream, typename Answer>
  static void allInOne(Stream& stream, Answer m) {
    stream.next(m.cp);
    stream.next(m.result);
    stream.next(m.message);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::crtk::InverseResponse> {
  template <typename Stream, typename Answer>
  static void allInOne(Stream& stream, Answer m) {
    stream.next(m.jp);
    stream.next(m.result);
    stream.next(m.message);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros

#undef RAVEN2_CRTK_MESSAGE
