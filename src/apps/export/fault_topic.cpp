#include "apps/export/fault_topic.h"

#include "raven2_trainer/FaultChange.h"
#include "ros/node/topic.h"

namespace raven2_trainer::apps {

struct FaultTopic::Impl {
  ros_bridge::Outlet<FaultChange> faults;
};

FaultTopic::FaultTopic(const ros_bridge::TopicMaker& topics)
    : impl_(new Impl{topics.advertise<FaultChange>("faults", ros_bridge::kQueue)}) {}

FaultTopic::~FaultTopic() = default;

void FaultTopic::publish(const BagFault& fault) const {
  FaultChange message;
  message.header.stamp = fault.stamp;
  message.scenario = fault.scenario;
  message.row = fault.row;
  message.acts = fault.acts;
  message.host = fault.host;
  message.site = fault.site;
  message.variable = fault.variable;
  message.arm = fault.arm;
  message.channel = fault.channel;
  message.kind = fault.kind;
  message.value = fault.value;
  message.tick = fault.tick;
  message.cycle = fault.cycle;
  impl_->faults.publish(message);
}

}  // namespace raven2_trainer::apps
