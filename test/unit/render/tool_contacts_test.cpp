#include "raven2_trainer/render/tool_contacts.h"

#include <gtest/gtest.h>

namespace raven2_trainer::render {
namespace {

// By index: 0 dome, 1 and 2 gold jaws, 3 green jaw, 4 ring.
const std::vector<std::string> kBodies{"dome", "grasper1_L", "grasper2_L", "grasper1_R", "ring"};

TEST(ToolContacts, SumsWhatPressesOnEachArm) {
  ContactList list;
  list.count = 4;
  list.contacts[0] = {0, 1, 0.0F, {}, {}, {1.0, 0.0, 0.0}};   // on the dome: the gold jaw gets the opposite
  list.contacts[1] = {1, 2, 0.0F, {}, {}, {50.0, 0.0, 0.0}};  // jaw on jaw
  list.contacts[2] = {2, 4, 0.0F, {}, {}, {0.0, 2.0, 0.0}};   // gold jaw on the ring
  list.contacts[3] = {1, 3, 0.0F, {}, {}, {0.0, 0.0, 3.0}};   // the arms at each other
  list.contacts[4] = {0, 3, 0.0F, {}, {}, {9.0, 9.0, 9.0}};   // not in the list
  const PerArm<Vec3> force = ToolContacts(kBodies).sum(list);
  EXPECT_EQ(force[0], (Vec3{-1.0, 2.0, 3.0}));
  EXPECT_EQ(force[1], (Vec3{0.0, 0.0, -3.0}));
}

TEST(ToolContacts, NumbersAndCountsThatThereAreNotAddNothing) {
  ContactList list;
  list.count = 1'000'000;
  list.contacts[0] = {7, 60'000, 0.0F, {}, {}, {1.0, 0.0, 0.0}};
  EXPECT_EQ(ToolContacts(kBodies).sum(list), PerArm<Vec3>{});
  list.contacts[0] = {1, 4, 0.0F, {}, {}, {1.0, 0.0, 0.0}};
  EXPECT_EQ(ToolContacts().sum(list), PerArm<Vec3>{}) << "the contact belongs to no known body";
}

}  // namespace
}  // namespace raven2_trainer::render
