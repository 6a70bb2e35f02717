#pragma once

#include <ros/time.h>

#include <cstdint>
#include <memory>
#include <string>

#include "ros/node/outlet.h"

namespace raven2_trainer::apps {

/** The content of raven2_trainer/FaultChange, without that header: core has a struct of the same name. */
struct BagFault {
  ros::Time stamp;
  std::string scenario, host, site, variable, arm, kind;
  std::uint32_t row{};
  bool acts{};
  std::int32_t channel{};
  double value{};
  std::int64_t tick{}, cycle{};
};

/** The topic /faults. */
class FaultTopic {
 public:
  explicit FaultTopic(const ros_bridge::TopicMaker& topics);
  ~FaultTopic();
  FaultTopic(const FaultTopic&) = delete;
  FaultTopic& operator=(const FaultTopic&) = delete;

  void publish(const BagFault& fault) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::apps
