#pragma once

#include <geometry_msgs/Transform.h>
#include <std_msgs/Header.h>

#include <boost/array.hpp>
#include <string>

#include "ros/node/foreign_message.h"

// Messages of the Raven's own package `raven_2` (raven2.md 5.2, 5.3). No HasHeader: roscpp numbers a message only if
// its first field is called "header". These have "hdr", so that the real robot's numbers stay 0. Arrays of 16 go by the
// robot's channels: gold 0-7, green 8-15, 3 and 11 are not connected.

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
  static const char* name() { return "raven_2/raven_state"; }
  static std::string text() {
    return withPart<std_msgs::Header>(
        "Header hdr\nint32 runlevel\nint32 sublevel\nint32 last_seq\nint32[2] type\nint32[6] pos\nfloat32[18] ori\n"
        "float32[18] ori_d\nint32[6] pos_d\nduration dt\nint32[16] encVals\nint32[16] dac_val\nfloat32[16] tau\n"
        "float32[16] mpos\nfloat32[16] jpos\nfloat32[16] mvel\nfloat32[16] jvel\nfloat32[16] mpos_d\n"
        "float32[16] jpos_d\nfloat32[2] grasp_d\nfloat32[16] encoffsets\nfloat32[12] jac_vel\nfloat32[12] jac_f\n");
  }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.hdr, m.runlevel, m.sublevel, m.last_seq, m.type, m.pos, m.ori, m.ori_d, m.pos_d, m.dt, m.encVals, m.dac_val,
        m.tau, m.mpos, m.jpos, m.mvel, m.jvel, m.mpos_d, m.jpos_d, m.grasp_d, m.encoffsets, m.jac_vel, m.jac_f);
  }
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
  static const char* name() { return "raven_2/raven_state"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.hdr, m.runlevel, m.sublevel, m.last_seq, m.type, m.pos, m.ori, m.ori_d, m.pos_d, m.dt, m.encVals, m.tau,
        m.mpos, m.jpos, m.mvel, m.mvel_d, m.jvel, m.mpos_d, m.jpos_d, m.grasp_d, m.encoffsets, m.current_cmd, m.err_msg,
        m.sim_mpos, m.sim_mvel, m.sim_jpos);
  }
};

/** raven_2/raven_automove. */
struct RavenAutomove {
  std_msgs::Header hdr;
  boost::array<std::int32_t, 6> del_pos{};              // ignored by the robot
  boost::array<geometry_msgs::Transform, 2> tf_incr{};  // gold, green: translation in um, frame 0

  static const char* md5() { return "409f695c901a20d6a1f90a4e55ae6f63"; }
  static const char* name() { return "raven_2/raven_automove"; }
  static std::string text() { return ""; }
  template <typename Self, typename Use>
  static void fields(Self& m, const Use& use) {
    use(m.hdr, m.del_pos, m.tf_incr);
  }
};

}  // namespace raven2_trainer::ros_bridge::raven_2

RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::raven_2::RavenState)
RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::raven_2::ForkRavenState)
RAVEN2_FOREIGN_MESSAGE(raven2_trainer::ros_bridge::raven_2::RavenAutomove)
