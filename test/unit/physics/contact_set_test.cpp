#include "physics/contact_set.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "physics/contact_forces.h"
#include "physics/parked_contacts.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::physics {
namespace {

dContactGeom point(double x, double y, double depth) {
  dContactGeom result{};
  result.pos[0] = x;
  result.pos[1] = y;
  result.depth = depth;
  return result;
}

TEST(ContactSet, KeepsAllOfFourPointsOrFewer) {
  ContactSet set;
  for (int i = 0; i < 4; ++i)
    set.add(2, 1, point(i, 0.0, 0.1));
  set.reduce();
  ASSERT_EQ(set.end() - set.begin(), 1);
  EXPECT_EQ(set.begin()->count, 4U);
  EXPECT_EQ(set.begin()->first, 1);
  EXPECT_EQ(set.begin()->second, 2);
}

TEST(ContactSet, KeepsTheDeepestPointAndSpreadsTheOthers) {
  // GIVEN 24 points on a unit circle, the one at 90 degrees deepest
  ContactSet set;
  for (int i = 0; i < 24; ++i)
    set.add(1, 2, point(std::cos(i * kPi / 12), std::sin(i * kPi / 12), i == 6 ? 0.2 : 0.1));
  set.reduce();
  const ContactSet::Pair& pair = *set.begin();
  ASSERT_EQ(pair.count, 4U);
  EXPECT_NEAR(pair.points[0].pos[1], 1.0, 1e-12);
  // THEN the next is opposite and the last two are a quarter turn away: a square
  EXPECT_NEAR(pair.points[1].pos[1], -1.0, 1e-12);
  EXPECT_NEAR(std::abs(pair.points[2].pos[0]), 1.0, 1e-12);
  EXPECT_NEAR(pair.points[2].pos[0] + pair.points[3].pos[0], 0.0, 1e-12);
}

TEST(ContactSet, SeparatesPairsWhateverTheirOrder) {
  ContactSet set;
  for (int i = 0; i < 10; ++i) {
    set.add(1, 2, point(i, 0.0, 0.1));
    set.add(2, 1, point(i, 1.0, 0.1));
    set.add(1, 3, point(i, 2.0, 0.1));
  }
  set.reduce();
  EXPECT_EQ(set.end() - set.begin(), 2);
}

TEST(ContactSet, DropsTheShallowestOfTooManyPoints) {
  ContactSet set;
  for (int i = 0; i < 1000; ++i)
    set.add(1, 2, point(i, 0.0, i == 777 ? 1.0 : 0.001));
  set.reduce();
  EXPECT_EQ(set.begin()->count, 4U);
  EXPECT_EQ(set.begin()->points[0].pos[0], 777.0);
}

TEST(ContactSet, OfPointsAtOnePlaceKeepsTheDeepest) {
  for (const bool deepest_first : {true, false}) {
    ContactSet set;
    set.add(1, 2, point(0.0, 0.0, deepest_first ? 0.3 : 0.1));
    set.add(1, 2, point(1e-4, 0.0, deepest_first ? 0.1 : 0.3));
    set.reduce();
    ASSERT_EQ(set.begin()->count, 1U);
    EXPECT_EQ(set.begin()->points[0].depth, 0.3);
  }
}

TEST(ContactSet, IgnoresPairsBeyondItsSize) {
  ContactSet set;
  for (int i = 0; i < 1000; ++i)
    set.add(0, i + 1, point(0.0, 0.0, 0.1));
  EXPECT_EQ(static_cast<std::size_t>(set.end() - set.begin()), ContactSet::kMaxPairs);
  set.clear();
  EXPECT_EQ(set.begin(), set.end());
}

TEST(ContactForces, APairsFrictionIsBoundByItsOwnNormalForceOfTheStepBefore) {
  SceneSnapshot snapshot;
  snapshot.pair_count = 3;
  snapshot.pairs[0] = {1, 2, 5.0};
  snapshot.pairs[1] = {1, 3, 7.0};
  snapshot.pairs[2] = {2, 3, 11.0};
  ContactForces forces;
  forces.restore(snapshot);
  forces.clear();
  EXPECT_EQ(forces.addPair(1, 3), 7.0);
  EXPECT_EQ(forces.addPair(1, 4), 0.0) << "new";
  EXPECT_EQ(forces.addPair(2, 3), 11.0);
  EXPECT_EQ(forces.addPair(1, 2), 5.0);
  forces.clear();
  EXPECT_EQ(forces.addPair(1, 2), 0.0) << "nothing acted in the step between";
}

Contact contactOf(std::uint16_t a, std::uint16_t b, double x, double newton) {
  Contact contact;
  contact.a = a;
  contact.b = b;
  contact.depth = 1e-5F;
  contact.p_W = {x, 0.0, 0.0};
  contact.n_W = {0.0, 0.0, 1.0};
  contact.f_W = {0.0, 0.5 * newton, newton};
  return contact;
}

ContactList listOf(const ParkedContacts& parked) {
  ContactList list{};
  parked.report(&list);
  return list;
}

TEST(ParkedContacts, OfEachPairAreOneWithTheSumOfItsForces) {
  ParkedContacts parked;
  parked.add(contactOf(1, 2, 0.0, 1.0));
  parked.add(contactOf(1, 3, 8.0, 5.0));
  parked.add(contactOf(1, 2, 4.0, 3.0));
  EXPECT_EQ(listOf(parked).count, 0U) << "those of the step are still there";
  parked.show();
  const ContactList list = listOf(parked);
  ASSERT_EQ(list.count, 2U);
  EXPECT_EQ(list.contacts[0].f_W, (Vec3{0.0, 2.0, 4.0}));
  EXPECT_EQ(list.contacts[0].p_W, (Vec3{3.0, 0.0, 0.0})) << "where the forces balance";
  EXPECT_EQ(list.contacts[1].f_W, (Vec3{0.0, 2.5, 5.0}));
}

TEST(ParkedContacts, GoWithTheBodyThatIsWokenWhicheverOfTheTwoItIs) {
  for (const int woken : {1, 2, 3}) {
    ParkedContacts parked;
    for (const auto& [a, b] : {std::pair{1, 2}, std::pair{1, 3}, std::pair{2, 3}})
      parked.add(contactOf(static_cast<std::uint16_t>(a), static_cast<std::uint16_t>(b), 0.0, 1.0));
    parked.show();
    parked.remove(woken);
    const ContactList list = listOf(parked);
    ASSERT_EQ(list.count, 1U) << woken;
    EXPECT_NE(list.contacts[0].a, woken);
    EXPECT_NE(list.contacts[0].b, woken);
  }
}

TEST(ParkedContacts, WithoutRoomInTheListAreCountedAndNotWritten) {
  ParkedContacts parked;
  for (std::uint16_t b = 2; b < 5; ++b)
    parked.add(contactOf(1, b, 0.0, 1.0));
  parked.show();
  for (const std::uint32_t room : {0U, 1U, 3U}) {
    ContactList list{};
    list.count = static_cast<std::uint32_t>(kMaxContacts) - room;
    list.dropped = 2;
    for (std::uint32_t i = 0; i < list.count; ++i)
      list.contacts[i] = contactOf(7, 8, 0.0, 1.0);
    parked.report(&list);
    EXPECT_EQ(list.count, kMaxContacts) << room;
    EXPECT_EQ(list.dropped, 2U + 3U - room) << room;
    EXPECT_EQ(list.contacts[kMaxContacts - 1].a, 7U) << room << ": those of the list stay, behind these";
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
