#include <diagnostic_msgs/DiagnosticArray.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "fixture.h"

namespace raven2_trainer {
namespace {

TEST(NominalSession, ModelAndRobotFollowTheSurgeonTogetherAndNoForceIsFelt) {
  Latest<sensor_msgs::JointState> model("model/joint_states"), robot("robot/joint_states");
  Latest<geometry_msgs::WrenchStamped> gold("haptic/gold/force"), green("haptic/green/force");
  ASSERT_TRUE(waitFor([&] { return isMoving(model) && isMoving(robot); }, kStartDeadline));
  double worst = 0.0, force = 0.0;
  const int begin = gold.count();
  ASSERT_TRUE(waitFor(
      [&] {
        for (const char* joint : {"shoulder_L", "elbow_L", "shoulder_R", "elbow_R"}) {
          worst = std::max(worst, std::abs(position(model.get(), joint) - position(robot.get(), joint)));
        }
        force = std::max({force, magnitude(gold.get()), magnitude(green.get())});
        return gold.count() >= begin + 500;
      },
      20.0));
  // The force begins at 3 mm, which is 0.03 rad at 0.1 m from the remote centre.
  EXPECT_LT(worst, 0.03);
  EXPECT_EQ(force, 0.0);
}

TEST(NominalSession, JointStatesCarryTheRealRobotsNames) {
  Latest<sensor_msgs::JointState> model("model/joint_states"), own("/joint_states");
  ASSERT_TRUE(waitFor([&] { return model.count() > 0 && own.count() > 0; }, kStartDeadline));
  const std::vector<std::string> expected{
      "shoulder_L", "elbow_L", "insertion_L", "tool_roll_L", "wrist_joint_L", "grasper_joint_1_L", "grasper_joint_2_L",
      "shoulder_R", "elbow_R", "insertion_R", "tool_roll_R", "wrist_joint_R", "grasper_joint_1_R", "grasper_joint_2_R"};
  EXPECT_EQ(model.get().name, expected);
  EXPECT_EQ(model.get().velocity.size(), expected.size());
  EXPECT_EQ(model.get().effort.size(), expected.size());
  // the robot's own message also has the desired joints, with a 2 at the end
  std::vector<std::string> both = expected;
  for (const std::string& joint : expected)
    both.push_back(joint + "2");
  EXPECT_EQ(own.get().name, both);
}

TEST(NominalSession, PicturesComeWithTheirCamera) {
  Latest<sensor_msgs::Image> image("camera/image_raw");
  Latest<sensor_msgs::CameraInfo> info("camera/camera_info");
  ASSERT_TRUE(waitFor([&] { return image.count() > 5 && info.count() > 5; }, kStartDeadline));
  EXPECT_EQ(image.get().encoding, "rgb8");
  EXPECT_EQ(image.get().data.size(), image.get().height * image.get().step);
  EXPECT_EQ(image.get().width, info.get().width);
  EXPECT_GT(info.get().K[0], 0.0);
  const std::set<std::uint8_t> values(image.get().data.begin(), image.get().data.end());
  EXPECT_GT(values.size(), 50U) << "an empty picture";
  // the camera info of a picture has its stamp
  const ros::Time stamp = image.get().header.stamp;
  EXPECT_TRUE(waitFor([&] { return info.get().header.stamp >= stamp; }, 2.0));
}

/** Stamps of all messages, and the age of each at its receipt. */
template <typename Message>
class Stamps {
 public:
  explicit Stamps(const std::string& topic)
      : subscriber_(node_.subscribe<Message>(topic, 500, [this](const typename Message::ConstPtr& message) {
          stamps_.push_back(message->header.stamp);
          width_ = message->width;
          ages_.push_back((ros::Time::now() - message->header.stamp).toSec());
        })) {}
  const std::vector<ros::Time>& all() const { return stamps_; }
  unsigned width() const { return width_; }
  double rate() const { return static_cast<double>(stamps_.size() - 1) / (stamps_.back() - stamps_.front()).toSec(); }
  /** [s] The age that this share of all messages did not exceed. */
  double age(double share) const {
    std::vector<double> ages = ages_;
    std::sort(ages.begin(), ages.end());
    return ages[static_cast<std::size_t>(share * static_cast<double>(ages.size() - 1))];
  }

 private:
  ros::NodeHandle node_;
  std::vector<ros::Time> stamps_;
  std::vector<double> ages_;
  unsigned width_{0};
  ros::Subscriber subscriber_;
};

/** Watches five seconds of pictures. @param[in,out] figures what was measured is added to them. @return whether they
 * came at their rate and 95 of 100 were at most 40 ms old. */
bool arePicturesOnTime(std::string* figures) {
  Stamps<sensor_msgs::CameraInfo> infos("camera/camera_info");
  Stamps<sensor_msgs::Image> images("camera/image_raw");
  const auto have_begun = [&] { return !images.all().empty() && !infos.all().empty(); };
  const auto have_ended = [&] {
    return images.all().back() - images.all().front() >= ros::Duration(5.0) &&
           infos.all().back() >= images.all().back();
  };
  if (!waitFor(have_begun, kStartDeadline) || !waitFor(have_ended, 20.0)) {
    *figures += "  no pictures for five seconds\n";
    return false;
  }
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(),
                "  %u pixels wide, %.1f Hz, age: median %.0f ms, 95 of 100 at most %.0f ms, all %.0f ms\n",
                images.width(), images.rate(), 1e3 * images.age(0.5), 1e3 * images.age(0.95), 1e3 * images.age(1.0));
  std::fputs(line.data(), stdout);
  *figures += line.data();
  const std::set<ros::Time> told(infos.all().begin(), infos.all().end());
  std::set<ros::Time> shown;
  for (const ros::Time& stamp : images.all()) {
    EXPECT_EQ(told.count(stamp), stamp >= infos.all().front() ? 1U : 0U) << stamp;
    EXPECT_TRUE(shown.insert(stamp).second) << "an old picture";
  }
  return images.rate() >= 25.0 && images.rate() <= 31.0 && images.age(0.95) < 0.040;
}

/** A busy computer may delay the pictures of five seconds. The daemon passes if one of four such periods is on time. */
TEST(NominalSession, PicturesComeAtTheirRateAreNewAndHaveTheirCamerasStamps) {
  bool are_on_time = false;
  std::string figures;
  for (int i = 0; i < 4 && !are_on_time; ++i)
    are_on_time = arePicturesOnTime(&figures);
  EXPECT_TRUE(are_on_time) << "25 to 31 Hz, 95 of 100 at most 40 ms old; measured:\n" << figures;
}

TEST(NominalSession, BothEyesHaveOneStampAndOneSize) {
  Latest<sensor_msgs::Image> left("camera/left/image_raw"), right("camera/right/image_raw");
  ASSERT_TRUE(waitFor([&] { return left.count() > 5 && right.count() > 5; }, kStartDeadline));
  // The right picture comes after the left one, well before the next pair.
  EXPECT_TRUE(waitFor([&] { return left.get().header.stamp == right.get().header.stamp; }, 5.0));
  EXPECT_EQ(left.get().header.frame_id, "endoscope_left_optical_frame");
  EXPECT_EQ(right.get().header.frame_id, left.get().header.frame_id);
  EXPECT_EQ(left.get().width, right.get().width);
  EXPECT_NE(left.get().data, right.get().data);
}

TEST(NominalSession, TheRightEyesCameraIsTheLeftOnesAsideByTheBaseline) {
  constexpr double kBaseline = 0.005;  // [m] config/render.yaml
  Latest<sensor_msgs::Image> image("camera/right/image_raw");
  Latest<sensor_msgs::CameraInfo> right("camera/right/camera_info"), left("camera/left/camera_info");
  ASSERT_TRUE(waitFor([&] { return image.count() > 5 && right.count() > 5 && left.count() > 5; }, kStartDeadline));
  EXPECT_TRUE(waitFor([&] { return right.get().header.stamp == image.get().header.stamp; }, 5.0));
  EXPECT_EQ(right.get().header.frame_id, "endoscope_left_optical_frame");
  EXPECT_EQ(right.get().width, image.get().width);
  EXPECT_GT(right.get().P[0], 0.0);
  EXPECT_LT(right.get().P[3], 0.0);
  EXPECT_NEAR(right.get().P[3], -right.get().P[0] * kBaseline, 1e-9);
  EXPECT_EQ(left.get().P[3], 0.0);
}

TEST(NominalSession, ACompressedPictureIsAJpegOfTheLiveCamera) {
  Latest<sensor_msgs::CompressedImage> picture("camera/image_raw/compressed");
  ASSERT_TRUE(waitFor([&] { return picture.count() > 0; }, kStartDeadline));
  const std::vector<std::uint8_t>& jpeg = picture.get().data;
  ASSERT_GT(jpeg.size(), 1000U);
  EXPECT_TRUE(jpeg[0] == 0xFF && jpeg[1] == 0xD8) << "SOI";
  EXPECT_TRUE(jpeg[jpeg.size() - 2] == 0xFF && jpeg.back() == 0xD9) << "EOI";
  EXPECT_EQ(picture.get().header.frame_id, "endoscope_optical_frame");
  EXPECT_EQ(picture.get().format, "rgb8; jpeg compressed bgr8");
}

TEST(NominalSession, BothEyesAndTheViewAreThereAsJpegToo) {
  Latest<sensor_msgs::CompressedImage> left("camera/left/image_raw/compressed"),
      right("camera/right/image_raw/compressed"), view("view/image_raw/compressed");
  ASSERT_TRUE(waitFor([&] { return left.count() > 0 && right.count() > 0 && view.count() > 0; }, kStartDeadline));
  for (const auto* picture : {&left, &right, &view}) {
    const std::vector<std::uint8_t>& jpeg = picture->get().data;
    ASSERT_GT(jpeg.size(), 1000U);
    EXPECT_TRUE(jpeg[0] == 0xFF && jpeg[1] == 0xD8) << "SOI";
    EXPECT_EQ(picture->get().format, "rgb8; jpeg compressed bgr8");
  }
  EXPECT_EQ(left.get().header.frame_id, "endoscope_left_optical_frame");
  EXPECT_EQ(right.get().header.frame_id, left.get().header.frame_id);
  EXPECT_EQ(view.get().header.frame_id, "endoscope_optical_frame");
  EXPECT_NE(left.get().data, right.get().data);
}

TEST(NominalSession, TheSecondCameraShowsTheSurroundings) {
  Latest<sensor_msgs::CompressedImage> jpeg("camera/second/image_raw/compressed");
  Latest<sensor_msgs::Image> second("camera/second/image_raw"), live("camera/image_raw");
  Latest<sensor_msgs::CameraInfo> info("camera/second/camera_info");
  ASSERT_TRUE(waitFor([&] { return jpeg.count() > 0 && second.count() > 5 && live.count() > 5 && info.count() > 5; },
                      kStartDeadline));
  EXPECT_EQ(second.get().header.frame_id, "overview_optical_frame");
  EXPECT_EQ(jpeg.get().header.frame_id, "overview_optical_frame");
  EXPECT_EQ(info.get().header.frame_id, "overview_optical_frame");
  EXPECT_EQ(info.get().P[3], 0.0);
  EXPECT_EQ(second.get().width, live.get().width);
  EXPECT_NE(second.get().data, live.get().data);
  EXPECT_LT(second.count(), live.count()) << "one in three";
}

TEST(NominalSession, TheLivePictureIsDiagnosed) {
  Latest<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  ASSERT_TRUE(waitFor([&] { return diagnostics.count() > 1; }, kStartDeadline));
  const auto& all = diagnostics.get().status;
  const auto found = std::find_if(all.begin(), all.end(), [](const diagnostic_msgs::DiagnosticStatus& status) {
    return status.name == "raven2_trainer: live picture";
  });
  ASSERT_NE(found, all.end());
  EXPECT_NE(found->message.find(" Hz, "), std::string::npos) << found->message;
}

TEST(NominalSession, FramesOfModelAndRobotHaveTheirOwnPrefix) {
  Latest<tf2_msgs::TFMessage> tf("/tf");
  ASSERT_TRUE(waitFor([&] { return tf.count() > 0 && tf.get().transforms.size() > 30; }, kStartDeadline));
  std::set<std::string> frames;
  for (const auto& transform : tf.get().transforms)
    frames.insert(transform.child_frame_id);
  EXPECT_TRUE(frames.count("model/grasper1_L") == 1 && frames.count("robot/grasper1_L") == 1);
  EXPECT_EQ(frames.count("endoscope_optical_frame"), 1U);
}

TEST(NominalSession, EveryLinksCountersAddUp) {
  using Statuses = std::vector<diagnostic_msgs::DiagnosticStatus>;
  Latest<diagnostic_msgs::DiagnosticArray> diagnostics("/diagnostics");
  const auto links = [&] {
    const Statuses all = diagnostics.get().status;
    Statuses found;
    std::copy_if(all.begin(), all.end(), std::back_inserter(found),
                 [](const auto& status) { return status.name.find("link") != std::string::npos; });
    return found;
  };
  const auto is_ok = [](const auto& status) { return status.level == diagnostic_msgs::DiagnosticStatus::OK; };
  const auto all_are_ok = [&] {
    const Statuses found = links();
    return found.size() == 4 && std::all_of(found.begin(), found.end(), is_ok);  // master, robot, relay and pedals
  };
  ASSERT_TRUE(waitFor([&] { return diagnostics.count() > 1; }, kStartDeadline));
  waitFor(all_are_ok, 10.0);  // a short stall of a stream is reported for a short time
  const Statuses found = links();
  EXPECT_EQ(found.size(), 4U) << "master, robot, relay and pedals";
  for (const auto& status : found)
    EXPECT_TRUE(is_ok(status)) << status.name << ": " << status.message;
}

}  // namespace
}  // namespace raven2_trainer

RAVEN2_INTEGRATION_MAIN("nominal_test")
