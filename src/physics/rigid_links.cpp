#include "physics/rigid_links.h"

#include <string>

#include <Eigen/Eigenvalues>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::physics {
namespace {

/** Inertia about a point `d` away from the centre of mass, minus that about the centre of mass (Steiner). */
Matrix3 steiner(double mass, const Vector3& d) {
  return mass * (d.squaredNorm() * Matrix3::Identity() - d * d.transpose());
}

void check(const model::Description& description, int link, const model::Inertial& inertial) {
  const model::Link& part = description.links[static_cast<std::size_t>(link)];
  const std::string place =
      description.file + ":" + std::to_string(part.line) + ": link " + part.name + " moves but has ";
  if (!(inertial.mass > 0.0)) {
    throw ModelException(place + "mass " + std::to_string(inertial.mass) + ", expected above 0 kg");
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> principal(inertial.inertia, Eigen::EigenvaluesOnly);
  const double least = principal.eigenvalues().minCoeff();
  if (!(least > 0.0)) {
    throw ModelException(place + "principal inertia " + std::to_string(least) + ", expected above 0 kg m2");
  }
}

}  // namespace

std::vector<Pose> fixedPoses(const model::RavenModel& raven) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(raven.description.links.size());
  raven.linkPosesInWorld({raven.arms.geometry.home, raven.arms.geometry.home}, &positions, &poses);
  return poses;
}

std::vector<Carrier> findCarriers(const model::Description& description) {
  std::vector<Carrier> carriers;
  carriers.reserve(description.links.size());
  for (std::size_t i = 0; i < description.links.size(); ++i) {
    const model::Link& link = description.links[i];
    Carrier carrier;
    if (link.joint != model::JointKind::kFixed) {
      carrier.link = static_cast<int>(i);
    } else if (link.parent < 0) {
      carrier.X_KL = link.X_PJ;
    } else {
      const Carrier& parent = carriers.at(static_cast<std::size_t>(link.parent));  // parents come before children
      carrier = {parent.link, parent.X_KL * link.X_PJ};
    }
    carriers.push_back(carrier);
  }
  return carriers;
}

model::Inertial combinedInertial(const model::Description& description,
                                 const std::vector<Carrier>& carriers,
                                 int link) {
  model::Inertial total;
  for (std::size_t i = 0; i < carriers.size(); ++i) {
    if (carriers[i].link != link) continue;
    const model::Inertial& part = description.links[i].inertial;
    total.mass += part.mass;
    total.com += part.mass * (carriers[i].X_KL * part.com);
  }
  if (total.mass > 0.0) total.com /= total.mass;
  for (std::size_t i = 0; i < carriers.size(); ++i) {
    if (carriers[i].link != link) continue;
    const model::Inertial& part = description.links[i].inertial;
    const Matrix3& R = carriers[i].X_KL.R;
    total.inertia += R * part.inertia * R.transpose() + steiner(part.mass, carriers[i].X_KL * part.com - total.com);
  }
  check(description, link, total);
  return total;
}

}  // namespace raven2_trainer::physics
