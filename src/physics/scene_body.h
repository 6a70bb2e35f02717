#pragma once

#include <cstddef>

#include <ode/ode.h>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/physics/scene_snapshot.h"

namespace raven2_trainer::physics {

constexpr int kRestTicks = 300;  ///< [1 ms] for which a body must be slow to be at rest; ours

/** A body of the scene that no joint holds, or that may come to that. Real-time safe. */
struct FreeBody {
  dBodyID body{nullptr};
  Vector3 com{0, 0, 0};
  Pose X_WL;         ///< last finite pose of the link
  std::size_t id{};  ///< by which the collider reports it
  Pose X_WL_start;   ///< pose at the start
  bool held{false};
  int still{0};  ///< [ticks] slow

  bool isSlow() const noexcept;
  void readPose() noexcept;
  void move(const Vector3& shift, const Vector3& turn) noexcept;

  /** To the last bit; what the collider knows of it is not here. */
  void save(SceneSnapshot::Body* out) const noexcept;
  void restore(const SceneSnapshot::Body& in) noexcept;
};

/** Holds one of the bodies at its foot. */
struct Foot {
  std::size_t body{};  ///< index of the body
  double force{};      ///< [N] that it bears
  double moment{};     ///< [Nm]
  int ticks{};
  int over{0};  ///< [ticks] more than that in a row
};

}  // namespace raven2_trainer::physics
