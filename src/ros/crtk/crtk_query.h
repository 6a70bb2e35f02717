#pragma once

#include <geometry_msgs/Pose.h>
#include <ros/service_traits.h>

#include <cstdint>
#include <string>
#include <vector>

#include "ros/node/foreign_message.h"

// Services of the Collaborative Robotics Toolkit's package `crtk_msgs`, 1.3.0.

namespace raven2_trainer::ros_bridge::crtk {

/** Of either service: its name and check sum, as each of its two messages knows them. */
struct ForwardService {
  static const char* name() { return "crtk_msgs/QueryForwardKinematics"; }
  static const char* md5() { return "787c6da7a75e9886573c4af11f1a381f"; }
};
struct InverseService {
  static const char* name() { return "crtk_msgs/QueryInverseKinematics"; }
  static const char* md5() { return "ce8dbc3b4384e2f7567488e7e75496d8"; }
};

struct ForwardRequest {
  using Service = ForwardService;
  std::vector<double> jp;  ///< [rad; m]
  geometry_msgs::Pose cp;  ///< not looked at

  static const char* md5() { return "07968175ee2bc6192df1ba3531d33794"; }
  static const char* name() { return "crtk_msgs/QueryForwardKinematicsRequest"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.jp, m.cp);
  }
};

struct ForwardResponse {
  using Service = ForwardService;
  geometry_msgs::Pose cp;
  std::uint8_t result{};
  std::string message;

  static const char* md5() { return "d966cb9cf689484cac4c0f3d90c6e190"; }
  static const char* name() { return "crtk_msgs/QueryForwardKinematicsResponse"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.cp, m.result, m.message);
  }
};

struct InverseRequest {
  using Service = InverseService;
  geometry_msgs::Pose cp;
  std::vector<double> jp;  ///< [rad; m] near which joints are looked for

  static const char* md5() { return "b8b1abaa4b0941072565aa04cb862deb"; }
  static const char* name() { return "crtk_msgs/QueryInverseKinematicsRequest"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.cp, m.jp);
  }
};

struct InverseResponse {
  using Service = InverseService;
  std::vector<double> jp;
  std::uint8_t result{};
  std::string message;

  static const char* md5() { return "f30c14a58d988c5ce642a21cc0bb3683"; }
  static const char* name() { return "crtk_msgs/QueryInverseKinematicsResponse"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.jp, m.result, m.message);
  }
};

}  // namespace raven2_trainer::ros_bridge::crtk

#define RAVEN2_CRTK_QUERY(Query)                                              \
  RAVEN2_FOREIGN_MESSAGE(Query)                                               \
  template <>                                                                 \
  struct ros::service_traits::MD5Sum<Query> {                                 \
    static const char* value(const Query&) { return Query::Service::md5(); }  \
    static const char* value() { return Query::Service::md5(); }              \
  };                                                                          \
  template <>                                                                 \
  struct ros::service_traits::DataType<Query> {                               \
    static const char* value(const Query&) { return Query::Service::name(); } \
    static const char* value() { return Query::Service::name(); }             \
  };
RAVEN2_CRTK_QUERY(raven2_trainer::ros_bridge::crtk::ForwardRequest)
RAVEN2_CRTK_QUERY(raven2_trainer::ros_bridge::crtk::ForwardResponse)
RAVEN2_CRTK_QUERY(raven2_trainer::ros_bridge::crtk::InverseRequest)
RAVEN2_CRTK_QUERY(raven2_trainer::ros_bridge::crtk::InverseResponse)
#undef RAVEN2_CRTK_QUERY
