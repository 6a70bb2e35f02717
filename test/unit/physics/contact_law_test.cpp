#include "physics/contact_law.h"

#include <cmath>

#include <gtest/gtest.h>

namespace raven2_trainer::physics {
namespace {

const ContactMaterial kSteel{"steel", 4.0e5, 100.0}, kFoam{"foam", 1.0e4, 20.0};
constexpr ArmGive kGive{5.0e3, 30.0, 1.0e-3};
constexpr double kLost = ContactLaw::kOnset / 2;  // [m] of depth, where the surfaces do not bear yet
constexpr double kDeep = 2 * ContactLaw::kOnset;

TEST(ContactLaw, TwoSurfacesAreTwoSpringsInARow) {
  // Under 8 N each spring gives way by itself: 20 um and 800 um
  const ContactLaw law(kSteel, kFoam);
  EXPECT_NEAR(law.force(kLost + 820e-6), 8.0, 1e-9);
  EXPECT_NEAR(ContactLaw(kFoam, kSteel).force(kLost + 820e-6), 8.0, 1e-9) << "whichever comes first";
  EXPECT_FALSE(law.gives());
}

TEST(ContactLaw, DampersAreThoseOfSlowMotion) {
  // GIVEN a slow swing of the force on both springs with their dampers in a row: the loss of a cycle is the sum of both
  const ContactLaw law(kSteel, kFoam);
  const double force = 3.0, omega = 1.0;
  const auto loss = [&](double k, double d) { return kPi * d * omega * std::pow(force / k, 2); };
  EXPECT_NEAR(loss(law.stiffness(kDeep), law.damping(kDeep)), loss(4.0e5, 100.0) + loss(1.0e4, 20.0), 1e-12);
}

TEST(ContactLaw, AnArmGivesWayUpToItsTravel) {
  const ContactLaw law(kSteel, kFoam, kGive, 1);
  EXPECT_TRUE(law.gives());
  // GIVEN 4 N: 10 um, 400 um, 800 um
  EXPECT_NEAR(law.force(kLost + 1210e-6), 4.0, 1e-9);
  // GIVEN 5 N, all of the travel, and 3 N more on the surfaces alone
  const double at_5 = kLost + 5.0 / 4.0e5 + 5.0 / 1.0e4 + 1.0e-3;
  EXPECT_NEAR(law.force(at_5), 5.0, 1e-9);
  EXPECT_NEAR(law.force(at_5 + 3.0 / 4.0e5 + 3.0 / 1.0e4), 8.0, 1e-9);
}

TEST(ContactLaw, TwoArmsGiveWayTwice) {
  const ContactLaw law(kSteel, kSteel, kGive, 2);
  EXPECT_NEAR(law.force(kLost + 4.0 / 2.0e5 + 2 * 4.0 / 5.0e3), 4.0, 1e-9);
  EXPECT_NEAR(law.force(kLost + 10.0 / 2.0e5 + 2 * 1.0e-3), 10.0, 1e-9);
}

TEST(ContactLaw, TheForceRisesWithoutAStepAndItsSlopeIsTheStiffness) {
  const ContactLaw law(kSteel, kFoam, kGive, 1);
  EXPECT_EQ(law.force(0.0), 0.0);
  constexpr double kStep = 1e-7;
  for (double depth = 0.0; depth < 0.003; depth += kStep) {
    const double rise = law.force(depth + kStep) - law.force(depth);
    ASSERT_GT(rise, 0.0) << depth;
    const double slope = rise / kStep, least = std::min(law.stiffness(depth), law.stiffness(depth + kStep)),
                 most = std::max(law.stiffness(depth), law.stiffness(depth + kStep));
    ASSERT_GE(slope, 0.999999 * least - 1e-6) << depth;
    ASSERT_LE(slope, 1.000001 * most + 1e-6) << depth;
    ASSERT_GT(law.damping(depth), 0.0) << depth;
  }
}

TEST(ContactLaw, WithoutTravelAnArmDoesNotGiveWay) {
  const ContactLaw stiff(kSteel, kFoam), none(kSteel, kFoam, {5.0e3, 30.0, 0.0}, 1);
  EXPECT_FALSE(none.gives());
  for (const double depth : {0.0, 1e-5, 1e-3})
    EXPECT_EQ(none.force(depth), stiff.force(depth));
}

}  // namespace
}  // namespace raven2_trainer::physics
