#include "ros/crtk/crtk_wrench.h"

#include <gtest/gtest.h>

namespace raven2_trainer::ros_bridge {
namespace {

/** Bodies: 0 ground, 1 gold jaw, 2 gold wrist, 3 green jaw. */
ArmContacts contacts() {
  return ArmContacts({"ground", "grasper1_L", "wrist_L", "grasper1_R"});
}

Contact contact(std::uint16_t a, std::uint16_t b, const Vec3& p_W, const Vec3& f_W) {
  Contact c;
  c.a = a;
  c.b = b;
  c.p_W = p_W;
  c.f_W = f_W;
  return c;
}

ContactList listOf(const std::vector<Contact>& all) {
  ContactList list;
  for (const Contact& c : all)
    list.contacts[list.count++] = c;
  return list;
}

TEST(ArmContacts, TheForceOnTheSecondBodyIsTheOpposite) {
  const auto list = listOf({contact(0, 1, {0, 0, 0}, {0, 0, -2}), contact(1, 3, {0, 0, 0}, {1, 0, 0})});
  const ArmWrench gold = contacts().on(Arm::kGold, list, Vector3::Zero());
  EXPECT_EQ(toArray(gold.force_W), (Vec3{1, 0, 2}));
  const ArmWrench green = contacts().on(Arm::kGreen, list, Vector3::Zero());
  EXPECT_EQ(toArray(green.force_W), (Vec3{-1, 0, 0}));
}

TEST(ArmContacts, TorquesAreAboutTheTip) {
  const auto list = listOf({contact(1, 3, {0.10, 0.02, 0.0}, {0, 0, 5})});
  const ArmWrench gold = contacts().on(Arm::kGold, list, Vector3(0.09, 0.0, 0.0));
  // (0.01, 0.02, 0) x (0, 0, 5)
  EXPECT_NEAR(gold.torque_W.x(), 0.10, 1e-12);
  EXPECT_NEAR(gold.torque_W.y(), -0.05, 1e-12);
  EXPECT_NEAR(gold.torque_W.z(), 0.0, 1e-12);
  geometry_msgs::WrenchStamped message;
  fill(gold, &message);
  EXPECT_EQ(message.wrench.force.z, 5.0);
  EXPECT_NEAR(message.wrench.torque.y, -0.05, 1e-12);
}

TEST(ArmContacts, WithinAnArmAndOfNobodyNothingCounts) {
  const auto list = listOf({contact(1, 2, {0, 0, 0}, {9, 0, 0}), contact(0, 77, {0, 0, 0}, {9, 0, 0})});
  for (const Arm arm : kArms)
    EXPECT_EQ(toArray(contacts().on(arm, list, Vector3::Zero()).force_W), Vec3{});
  ContactList broken;
  broken.count = 1000000;
  EXPECT_EQ(toArray(contacts().on(Arm::kGold, broken, Vector3::Zero()).force_W), Vec3{});
}

/** Action and reaction: where two arms touch, both wrenches about one point add up to zero. */
TEST(ArmContacts, TheWrenchesOfTwoArmsThatTouchCancel) {
  const auto list =
      listOf({contact(1, 3, {0.10, 0.02, 0.01}, {1, -2, 5}), contact(3, 2, {-0.03, 0.01, 0.0}, {0, 4, 1})});
  const Vector3 p_WT(0.02, -0.01, 0.03);
  const ArmWrench gold = contacts().on(Arm::kGold, list, p_WT), green = contacts().on(Arm::kGreen, list, p_WT);
  EXPECT_GT(gold.torque_W.norm(), 0.1);
  EXPECT_NEAR((gold.force_W + green.force_W).norm(), 0.0, 1e-12);
  EXPECT_NEAR((gold.torque_W + green.torque_W).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
