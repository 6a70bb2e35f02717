#pragma once

#include <vector>

#include "raven2_trainer/model/raven_model.h"

// Links joined by fixed joints are one body.

namespace raven2_trainer::physics {

/** The link that carries another one rigidly. */
struct Carrier {
  int link{-1};  ///< index of the link on a moving joint; -1: fixed to the world
  Pose X_KL;     ///< pose of the carried link in the carrier's frame; where fixed to the world, in the URDF's root
};

/** Poses in W of all links with the arms at home: true of the links that nothing moves. */
std::vector<Pose> fixedPoses(const model::RavenModel& raven);

/** Carrier of every link, by link index. */
std::vector<Carrier> findCarriers(const model::Description& description);

/**
 * Mass, centre of mass and inertia of a carrier and of all it carries, in its link frame.
 * @throw ModelException if the mass is not positive or the inertia not positive definite.
 */
model::Inertial combinedInertial(const model::Description& description, const std::vector<Carrier>& carriers, int link);

}  // namespace raven2_trainer::physics
