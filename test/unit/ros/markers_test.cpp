#include "ros/bridge/markers.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "ros/bridge/state_topics.h"

namespace raven2_trainer::ros_bridge {
namespace {

using visualization_msgs::Marker;

const ros::Time kStamp(20, 7);

ContactList twoContacts() {
  ContactList list;
  list.count = 2;
  list.contacts[0].p_W = {0.1, 0.2, 0.3};
  list.contacts[0].f_W = {0.0, 0.0, 2.0};
  list.contacts[1].p_W = {-0.1, 0.0, 0.0};
  list.contacts[1].f_W = {-1.0, 0.0, 0.0};
  return list;
}

void expectPoint(const geometry_msgs::Point& point, double x, double y, double z) {
  EXPECT_NEAR(point.x, x, 1e-12);
  EXPECT_NEAR(point.y, y, 1e-12);
  EXPECT_NEAR(point.z, z, 1e-12);
}

TEST(ContactMarkers, ABallAndALineEach) {
  const auto array = contactMarkers(twoContacts(), kStamp);
  ASSERT_EQ(array.markers.size(), 2U);
  const Marker &places = array.markers[0], &forces = array.markers[1];
  EXPECT_EQ(places.type, Marker::SPHERE_LIST);
  EXPECT_EQ(forces.type, Marker::LINE_LIST);
  for (const Marker& m : array.markers) {
    EXPECT_EQ(m.action, Marker::ADD);
    EXPECT_EQ(m.header.frame_id, "world");
    EXPECT_EQ(m.header.stamp, kStamp);
    EXPECT_EQ(m.pose.orientation.w, 1.0) << "RViz refuses a quaternion of zeros";
    EXPECT_GT(m.color.a, 0.0F);
    EXPECT_GT(m.scale.x, 0.0);
  }
  EXPECT_NE(places.ns, forces.ns) << "a marker replaces one of the same namespace and number";
  ASSERT_EQ(places.points.size(), 2U);
  expectPoint(places.points[1], -0.1, 0.0, 0.0);
  ASSERT_EQ(forces.points.size(), 4U);
  expectPoint(forces.points[0], 0.1, 0.2, 0.3);
  expectPoint(forces.points[1], 0.1, 0.2, 0.34);  // 2 N at 20 mm/N
  expectPoint(forces.points[3], -0.12, 0.0, 0.0);
}

TEST(ContactMarkers, ALongLineIsCut) {
  ContactList list = twoContacts();
  list.contacts[0].f_W = {0.0, -45.0, 0.0};
  list.contacts[1].f_W = {0.0, 0.0, 1e308};
  const Marker forces = contactMarkers(list, kStamp).markers[1];
  ASSERT_EQ(forces.points.size(), 4U);
  expectPoint(forces.points[1], 0.1, 0.2 - kLongestArrow, 0.3);
  EXPECT_LE(forces.points[3].z, kLongestArrow);
}

TEST(ContactMarkers, WithoutContactsTheOldOnesGo) {
  for (const Marker& m : contactMarkers(ContactList{}, kStamp).markers)
    EXPECT_EQ(m.action, Marker::DELETE);
}

TEST(ContactMarkers, WhatIsNotFiniteOrOfNoListIsLeftOut) {
  ContactList list = twoContacts();
  list.contacts[0].f_W[1] = std::numeric_limits<double>::quiet_NaN();
  list.contacts[1].p_W[2] = std::numeric_limits<double>::infinity();
  for (const Marker& m : contactMarkers(list, kStamp).markers)
    EXPECT_TRUE(m.points.empty());
  list.count = 1000000;
  EXPECT_EQ(contactMarkers(list, kStamp).markers[0].points.size(), kMaxContacts - 2);
}

TEST(ForceMarkers, AnArrowAtTheTipOfEachArm) {
  ModelState model;
  model.arms[0].p_BT = {0.0, 0.0, 0.1};
  HapticState haptic;
  haptic.force_B[0] = {1.0, 0.0, 0.0};
  PerArm<Pose> X_WB;
  X_WB[0].R = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();  // x of B is y of W
  X_WB[0].p = Vector3(0.5, 0.0, 0.0);
  const auto array = forceMarkers(model, haptic, X_WB, kStamp);
  ASSERT_EQ(array.markers.size(), 2U);
  ASSERT_EQ(array.markers[0].points.size(), 2U);
  EXPECT_EQ(array.markers[0].type, Marker::ARROW);
  expectPoint(array.markers[0].points[0], 0.5, 0.0, 0.1);
  expectPoint(array.markers[0].points[1], 0.5, kArrowPerNewton, 0.1);
  EXPECT_EQ(array.markers[1].action, Marker::DELETE) << "without a force the marker is deleted";
  EXPECT_NE(array.markers[0].id, array.markers[1].id);
  haptic.force_B[0][0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(forceMarkers(model, haptic, X_WB, kStamp).markers[0].action, Marker::DELETE);
}

TEST(ForceMarkers, EachArmsArrowIsAtItsOwnTipInItsOwnBase) {
  ModelState model;
  HapticState haptic;
  PerArm<Pose> X_WB;
  model.arms = {};
  for (const Arm arm : kArms) {
    const double i = static_cast<double>(index(arm));
    at(model.arms, arm).p_BT = {0.1 + i, 0.2, 0.3};
    at(haptic.force_B, arm) = {0.0, arm == Arm::kGold ? 1.0 : -2.0, 0.0};
    at(X_WB, arm).p = Vector3(0.0, 0.0, 5.0 + i);
  }
  X_WB[1].R << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x of B is y of W
  const auto markers = forceMarkers(model, haptic, X_WB, kStamp).markers;
  expectPoint(markers.at(0).points.at(0), 0.1, 0.2, 5.3);
  expectPoint(markers.at(0).points.at(1), 0.1, 0.2 + kArrowPerNewton, 5.3);
  expectPoint(markers.at(1).points.at(0), -0.2, 1.1, 6.3);
  expectPoint(markers.at(1).points.at(1), -0.2 + 2.0 * kArrowPerNewton, 1.1, 6.3);
}

/** doc/pictures.md: forces that the hand feels are blue, contacts of the tool orange. */
TEST(Markers, HaveThePicturesColours) {
  HapticState haptic;
  haptic.force_B[0] = {1.0, 0.0, 0.0};
  const auto hand = forceMarkers(ModelState{}, haptic, {}, kStamp).markers[0].color;
  EXPECT_TRUE(hand.b > 0.8F && hand.r < 0.3F && hand.g < 0.5F);
  for (const Marker& m : contactMarkers(twoContacts(), kStamp).markers) {
    const auto& contact = m.color;
    EXPECT_TRUE(contact.r > 0.8F && contact.g > 0.3F && contact.g < 0.7F && contact.b < 0.3F) << m.ns;
  }
}

TEST(WorkspaceEdge, AToolThatIsHeldBackOrAHandThatFeelsIt) {
  ModelState model;
  HapticState haptic;
  EXPECT_FALSE(isAtEdge(model, haptic));
  haptic.edge_B[1] = {0.0, 0.0, -0.1};
  EXPECT_TRUE(isAtEdge(model, haptic));
  haptic = {};
  model.arms[1].ik_status = 1;  // clamped
  model.mode = Mode::kPedalUp;
  EXPECT_FALSE(isAtEdge(model, haptic)) << "with the pedal up no hand moves the arm";
  model.mode = Mode::kTeleoperating;
  EXPECT_TRUE(isAtEdge(model, haptic));
}

/** Only a hand that moves the arm writes the status. An old status says nothing about the arm's present motion. */
TEST(WorkspaceEdge, IsNotToldByAStatusOfBefore) {
  ModelState model;
  model.pedal = 1;
  model.arms[0].ik_status = 1;  // clamped
  for (std::size_t i = 0; i < kModeCount; ++i) {
    model.mode = static_cast<Mode>(i);
    const bool is_hand = model.mode == Mode::kTeleoperating || model.mode == Mode::kChoosing ||
                         model.mode == Mode::kSimulating || model.mode == Mode::kTrial;
    EXPECT_EQ(isAtEdge(model, HapticState{}), is_hand) << kModeNames[i];
  }
}

TEST(WorkspaceEdge, IsWhereATipCannotGo) {
  ModelState model;
  model.mode = Mode::kTeleoperating;
  const std::array<bool, 6> expected{false, true, true, true, true, false};  // the wrist's singularity is no edge
  for (std::uint32_t status = 0; status < expected.size(); ++status) {
    model.arms[1].ik_status = status;
    EXPECT_EQ(isAtEdge(model, HapticState{}), expected[status]) << status;
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
