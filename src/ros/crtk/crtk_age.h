#pragma once

#include <ros/datatypes.h>
#include <ros/time.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "ros/crtk/crtk_reader.h"

// Commands that are older than they look: an arm must not do now what was asked for before.

namespace raven2_trainer::ros_bridge {

/** Names of the nodes that publish a topic, by its name. */
using CrtkPublishers = std::map<std::string, std::set<std::string>>;

/** As the master has them now; nothing if it does not answer. */
std::optional<CrtkPublishers> publishersNow();
/** In a master's answer to getSystemState; nothing if it is no such answer. */
std::optional<CrtkPublishers> publishersIn(XmlRpc::XmlRpcValue state);

/** Whether a message is one that its publisher had stored. */
enum class CrtkStorage : std::uint8_t {
  kNew,
  kUnknown,  ///< only its stamp can say that it is new
  kStored,   ///< it came before, by another connection
};

/**
 * Finds the messages of a topic that may have been stored. A latching publisher sends its last message to every new
 * connection. If the publisher is older than our subscription, or connects again, that message may be old. If it is
 * newer, the message is a command: raven2_CRTK_Python_controller says `resume` so, before it is connected. One thread.
 */
class CrtkStored {
 public:
  /** @param[in] before who published it before it was listened to; nothing: anybody may have. */
  explicit CrtkStored(std::optional<std::set<std::string>> before) : before_(std::move(before)) {}

  /** @param[in] connection the header that a message came with; one a connection. @param[in] stamp of the message;
   * zero: none. */
  CrtkStorage storageOf(const ros::M_stringPtr& connection, const ros::Time& stamp);

 private:
  struct Latching {
    ros::M_stringPtr connection;  ///< the newest; held, so that no other is it
    ros::Time newest;             ///< stamp of its messages
  };

  bool wasBefore(const std::string& publisher) const { return !before_ || before_->count(publisher) > 0; }

  const std::optional<std::set<std::string>> before_;
  std::map<std::string, Latching> latching_;  ///< by publisher
};

/** Where a message comes from, and when. */
struct CrtkOrigin {
  std::string publisher;   ///< name of the node
  CrtkStorage storage{};   ///< CrtkStored
  ros::Time stamp, now{};  ///< of its header, zero: none; of its receipt
};

/** hold, free, pause, disable: commands that stop the arms are never too old. */
bool isSafer(const ServoCommand& command) noexcept;

/** The command; or a refusal if its stamp is too old, or if the message may have been stored and its stamp does not say
 * that it is new. crtk_python_client latches and stamps its state commands. */
CrtkAsked unlessOld(const CrtkAsked& asked, const CrtkOrigin& origin);

}  // namespace raven2_trainer::ros_bridge
