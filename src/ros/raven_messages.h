#pragma once

#include <geometry_msgs/Transform.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <boost/array.hpp>

// Messages of the Raven's own package `raven_2`, which need not be installed: fields, order and check sums as there
// (raven2.md 5.2, 5.3). Arrays of 16 go by the robot's channels: gold 0-7, green 8-15, 3 and 11 are not connected.

namespace raven2_trainer::ros_bridge::raven_2 {

using Ints16 = boost::array<std::int32_t, 16>;
using Floats16 = boost::array<float, 16>;

/** raven_2/raven_state of uw-biorobotics/raven2: 980 bytes with an empty frame_id. */
struct RavenState {
  std_msgs::Header hdr;  // stamp: time of publishing
  std::int32_t runlevel{}, sublevel{}, last_seq{};
  boost::array<std::int32_t, 2> type{};  // board serials
  boost::array<std::int32_t, 6> pos{};   // [um] gold xyz, green xyz, frame 0
  boost::array<float, 18> ori{}, ori_d{};
  boost::array<std::int32_t, 6> pos_d{};  // [um]
  ros::Duration dt;                       // since the message before
  Ints16 encVals{}, dac_val{};            // [counts]
  Floats16 tau{};                         // [Nm]
  // degrees and degrees a second, and metres times 180 / pi
  Floats16 mpos{}, jpos{}, mvel{}, jvel{}, mpos_d{}, jpos_d{};
  boost::array<float, 2> grasp_d{};  // [rad]
  Floats16 encoffsets{};             // [counts]
  boost::array<float, 12> jac_vel{}, jac_f{};

  static const char* md5() { return "ce9e7f4969049d8bb365de3c98461a01"; }
};

/** The message of the same name in the authors' fork raven2_sim: 2008 bytes. */
struct ForkRavenState {
  std_msgs::Header hdr;
  std::int32_t runlevel{}, sublevel{}, last_seq{};
  boost::array<std::int32_t, 2> type{};
  boost::array<std::int32_t, 6> pos{};
  boost::array<float, 18> ori{}, ori_d{};
  boost::array<std::int32_t, 6> pos_d{};
  ros::Duration dt;
  Ints16 encVals{};
  Floats16 tau{}, mpos{}, jpos{}, mvel{}, mvel_d{}, jvel{}, mpos_d{}, jpos_d{};
  boost::array<float, 2> grasp_d{};
  Floats16 encoffsets{};
  Ints16 current_cmd{};  // [counts] what raven2 calls dac_val
  boost::array<std::uint8_t, 1024> err_msg{};
  boost::array<float, 3> sim_mpos{}, sim_mvel{}, sim_jpos{};

  static const char* md5() { return "1156a31ded2ee54c003e39e2268ee9c7"; }
};

/** raven_2/raven_automove. */
struct RavenAutomove {
  std_msgs::Header hdr;
  boost::array<std::int32_t, 6> del_pos{};              // ignored by the robot
  boost::array<geometry_msgs::Transform, 2> tf_incr{};  // gold, green: translation in um, frame 0
};

/** Text of raven_2/raven_state with that of std_msgs/Header, as a topic's connection header carries it. */
const char* ravenStateDefinition();

}  // namespace raven2_trainer::ros_bridge::raven_2

namespace ros {
namespace message_traits {

namespace raven_2 = raven2_trainer::ros_bridge::raven_2;

template <typename State>
struct RavenStateMd5 {
  static const char* value() { return State::md5(); }
  static const char* value(const State&) { return value(); }
};
template <typename State>
struct RavenStateName {
  static const char* value() { return "raven_2/raven_state"; }
  static const char* value(const State&) { return value(); }
};

template <>
struct MD5Sum<raven_2::RavenState> : RavenStateMd5<raven_2::RavenState> {};
template <>
struct MD5Sum<raven_2::ForkRavenState> : RavenStateMd5<raven_2::ForkRavenState> {};
template <>
struct DataType<raven_2::RavenState> : RavenStateName<raven_2::RavenState> {};
template <>
struct DataType<raven_2::ForkRavenState> : RavenStateName<raven_2::ForkRavenState> {};
template <>
struct Definition<raven_2::RavenState> {
  static const char* value() { return raven_2::ravenStateDefinition(); }
  static const char* value(const raven_2::RavenState&) { return value(); }
};
// No HasHeader: roscpp numbers a message only if its first field is called "header". This one is "hdr", so that the
// real robot's numbers stay 0.

template <>
struct MD5Sum<raven_2::RavenAutomove> {
  static const char* value() { return "409f695c901a20d6a1f90a4e55ae6f63"; }
  static const char* value(const raven_2::RavenAutomove&) { return value(); }
};
template <>
struct DataType<raven_2::RavenAutomove> {
  static const char* value() { return "raven_2/raven_automove"; }
  static const char* value(const raven_2::RavenAutomove&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<message_traits::raven_2::RavenState> {
  template <typename Stream, typename State>
  static void allInOne(Stream& stream, State m) {
    stream.next(m.hdr);
    stream.next(m.runlevel);
    stream.next(m.sublevel);
    stream.next(m.last_seq);
    stream.next(m.type);
    stream.next(m.pos);
    stream.next(m.ori);
    stream.next(m.ori_d);
    stream.next(m.pos_d);
    stream.next(m.dt);
    stream.next(m.encVals);
    stream.next(m.dac_val);
    for (auto* values : {&m.tau, &m.mpos, &m.jpos, &m.mvel, &m.jvel, &m.mpos_d, &m.jpos_d})
      stream.next(*values);
    stream.next(m.grasp_d);
    stream.next(m.encoffsets);
    stream.next(m.jac_vel);
    stream.next(m.jac_f);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::raven_2::ForkRavenState> {
  template <typename Stream, typename State>
  static void allInOne(Stream& stream, State m) {
    stream.next(m.hdr);
    stream.next(m.runlevel);
    stream.next(m.sublevel);
    stream.next(m.last_seq);
    stream.next(m.type);
    stream.next(m.pos);
    stream.next(m.ori);
    stream.next(m.ori_d);
    stream.next(m.pos_d);
    stream.next(m.dt);
    stream.next(m.encVals);
    for (auto* values : {&m.tau, &m.mpos, &m.jpos, &m.mvel, &m.mvel_d, &m.jvel, &m.mpos_d, &m.jpos_d})
      stream.next(*values);
    stream.next(m.grasp_d);
    stream.next(m.encoffsets);
    stream.next(m.current_cmd);
    stream.next(m.err_msg);
    for (auto* values : {&m.sim_mpos, &m.sim_mvel, &m.sim_jpos})
      stream.next(*values);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<message_traits::raven_2::RavenAutomove> {
  template <typename Stream, typename Move>
  static void allInOne(Stream& stream, Move m) {
    stream.next(m.hdr);
    stream.next(m.del_pos);
    stream.next(m.tf_incr);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
