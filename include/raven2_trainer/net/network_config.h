#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/wire/itp_rules.h"

namespace raven2_trainer {

/** Pedals and buttons other than the engaging pedal, as sensor_msgs/Joy (doc/ros.md). */
struct JoyConfig {
  std::string topic;                       ///< empty: none
  double timeout{};                        ///< [s] silence after which the camera's counts as up
  std::array<int, kPedalCount> buttons{};  ///< by Pedal: position in Joy::buttons, -1 none
};

/** config/network.yaml */
struct NetworkConfig {
  std::string bind_address;     ///< of the daemon's and the robot's listeners
  std::uint16_t master_port{};  ///< UDP console -> daemon
  std::string daemon_host;      ///< where the console sends to
  std::string robot_host;
  std::uint16_t robot_port{};  ///< UDP daemon -> robot
  std::string console_host;
  std::uint16_t force_port{};     ///< UDP daemon -> console
  std::uint16_t sight_port{};     ///< UDP daemon -> console: pictures for simulated surgeons
  bool sight{};                   ///< they are sent and taken
  std::uint16_t state_port{};     ///< TCP robot -> daemon
  double stale_after{};           ///< [s] robot state older than this is not used
  double reconnect_min{};         ///< [s] first pause before the TCP link is tried again
  double reconnect_max{};         ///< [s] longest pause
  ItpRules itp{};                 ///< of the daemon's ingest
  std::string master_address;     ///< the only one heard; empty: the first that sends a valid packet
  bool allow_plaintext_remote{};  ///< unsigned ITP from other computers may be listened to
  std::string key_file;           ///< absolute path; empty: none
  std::string stream;             ///< name of the console's profile (config/streams), or none
  JoyConfig joy{};
};

}  // namespace raven2_trainer
