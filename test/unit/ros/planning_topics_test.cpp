#include "ros/planning/planning_topics.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** Counts the messages of each topic. */
struct Sink : MessageSink {
  void write(const TopicWords& topic, const ros::SerializedMessage&) override {
    words.insert_or_assign(topic.name, topic);
    ++messages[topic.name];
  }
  std::map<std::string, TopicWords> words;
  std::map<std::string, int> messages;
};

TEST(PlanningTopicsTest, WhoComesLaterGetsTheNewestOfEach) {
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  const model::RavenModel raven = model::loadRavenModel(config);
  const auto shared = std::make_unique<SharedState>();
  const std::vector<std::string> names;
  Sink sink;
  PlanningTopics topics(TopicMaker(&sink), TopicSource(config, raven, *shared, names, [] { return PlanCounts{}; }));
  PlanResult plan;
  plan.status = PlanStatus::kSuccess;
  plan.waypoint_count = 2;
  plan.waypoints = {config.arms.geometry.home, config.arms.geometry.home};
  plan.arrival[1] = 1.0;
  shared->last_plan.store(plan);
  shared->last_execution.store(ExecutionReport{});
  for (int i = 0; i < 2; ++i)
    topics.publish(ModelState{}, ros::Time(1.0));
  for (const char* name : {"/plan/trajectory", "/plan/tip_path", "/plan/progress", "/plan/execution"}) {
    ASSERT_EQ(sink.messages[name], 1) << name;
    EXPECT_TRUE(sink.words.at(name).latched) << name;
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
