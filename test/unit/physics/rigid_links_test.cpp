#include "physics/rigid_links.h"

#include <gtest/gtest.h>

#include "test_models.h"

// Links on fixed joints are one body: a box cut in two, its halves turned, has the inertia of the box.

namespace raven2_trainer::physics {
namespace {

/** Of a uniform box about its middle. */
Matrix3 boxTensor(double mass, const Vector3& e) {
  const Vector3 squares = e.cwiseProduct(e);
  return mass / 12.0 *
         Vector3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y()).asDiagonal();
}

/** A carrier on a floating joint with its load: the halves of a box, away from the carrier's origin. */
model::Description makeHalves(const Pose& X_KL, const Vector3& middle, const Vector3& edges, double mass) {
  const Vector3 half(edges.x() / 2, edges.y(), edges.z()), offset(edges.x() / 4, 0, 0);
  model::Link carrier, carried;
  carrier.name = "carrier";
  carrier.joint = model::JointKind::kFloating;
  carrier.inertial = {mass / 2, middle - offset, boxTensor(mass / 2, half)};
  carried.name = "carried";
  carried.parent = 0;
  carried.X_PJ = X_KL;
  const Matrix3 R = X_KL.R.transpose();
  carried.inertial = {mass / 2, X_KL.inverse() * (middle + offset), R * boxTensor(mass / 2, half) * R.transpose()};
  model::Description description;
  description.links = {carrier, carried};
  return description;
}

TEST(RigidLinks, TwoHalvesOfABoxHaveTheInertiaOfTheBoxHoweverTheyAreTurned) {
  const Vector3 middle(0.05, -0.02, 0.08), edges(0.06, 0.02, 0.03);
  for (const double angle : {0.0, 0.5, 1.6, -2.5}) {
    Pose X_KL = testing::shift(0.1, 0.03, -0.04);
    X_KL.R = Eigen::AngleAxisd(angle, Vector3(1, 2, -1).normalized()).toRotationMatrix();
    const model::Description description = makeHalves(X_KL, middle, edges, 0.4);
    const model::Inertial whole = combinedInertial(description, findCarriers(description), 0);
    EXPECT_NEAR(whole.mass, 0.4, 1e-15);
    EXPECT_LT((whole.com - middle).norm(), 1e-15);
    EXPECT_LT((whole.inertia - boxTensor(0.4, edges)).norm(), 1e-15) << angle;
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
