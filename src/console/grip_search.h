#pragma once

#include <optional>
#include <vector>

#include "clearance.h"
#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

// How to take hold of a ring so that all that comes after can be done with that grip. Poses of the ring are those of
// its link: the opening lies in the x-y plane.

namespace raven2_trainer::console {

constexpr double kOpenJaws = 0.8;       ///< [rad] for a bar
constexpr double kClosedJaws = -0.05;   ///< [rad] a little beyond each other: they press on what is between them
constexpr double kStandOff = 0.018;     ///< [m] along the tool, before and after a grip
constexpr double kWireLean = 0.5;       ///< [rad] which the opening has room for, and spares the wrist as much
constexpr double kEnoughMargin = 0.14;  ///< [rad] of a joint inside its limits: 8 degrees

/** How a bar is taken: the jaws' hinge along the bar, the tool from the ring's upper side. */
struct Grip {
  Vector3 outward{1, 0, 0};  ///< [@frame ring] from the ring's middle to the bar
  bool turned{false};        ///< jaws changed over
  double along{0.0};         ///< [m] from the bar's middle
  double lean{0.17};         ///< [rad] of the tool about the bar, 0 along the ring's axis, positive leaning outward
  double reach{0.0075};      ///< [m] pivot to the bar's middle line; the jaws are 10 mm long
};

/** Tool pose of a grip in the ring's frame. */
Pose toolInRing(const Grip& grip, const SceneObject& ring) noexcept;

/** The same tool, drawn back along its jaws. */
Pose drawnBack(Pose X_WT, double distance) noexcept;

/** A ring looks the same from both sides: the one that looks most along `up_W`. */
Pose facing(const Pose& X_WR, const Vector3& up_W) noexcept;

/** Level, its x axis along `heading` [rad] from x. */
Pose level(const Vector3& p_W, double heading) noexcept;
double headingOf(const Pose& X_WR) noexcept;

/** Turned about its own axis. */
Pose spun(Pose X_WR, double angle) noexcept;

/** A ring led along a wire from where the wire begins: its axis along the wire, but leaning towards upright by
 * kWireLean where it can, its x axis as little turned as can be, at the start as of level(). A millimetre apart, along
 * a smooth line through `line_W` [m], and `beyond` [m] past its end. */
std::vector<Pose> alongWire(const std::vector<Vec3>& line_W, double heading, double beyond);

/** The same ring lying level, by the shortest turn. */
Pose levelled(const Pose& X_WR) noexcept;

/** [rad] rotation about its own axis of a ring at X_WR against one at `other` with nearly the same axis.
 */
double spinOf(const Pose& X_WR, const Pose& other) noexcept;

/** The one nearest to a point. */
std::size_t nearestTo(const Vector3& p_W, const std::vector<Pose>& poses) noexcept;

/** Follows the joints of one arm along tool poses, as the robot's own inverse kinematics would lead it. */
class JointTrail {
 public:
  JointTrail(const ArmsConfig& arms, Arm arm, const JointArray& q) noexcept : arms_(&arms), arm_(arm), q_(q) {}

  /** Along the straight way there. @return false if the arm cannot follow. */
  bool go(const Pose& X_WT) noexcept;
  /** Least distance of a joint from its limits so far [rad]; of the insertion, 0.115 m count as one. */
  double margin() const noexcept { return margin_; }
  const JointArray& joints() const noexcept { return q_; }
  Pose pose() const noexcept;

 private:
  bool step(const Pose& X_WT) noexcept;

  const ArmsConfig* arms_;
  Arm arm_;
  JointArray q_;
  double margin_{1.0};
};

/** Requirements of a grip. */
struct GripTask {
  Arm arm{};
  JointArray q{};                   ///< [rad, m] of that arm now
  Pose X_WR;                        ///< ring, upright
  SceneObject ring;                 ///< its shape
  std::optional<Vector3> lifted_W;  ///< [m] its middle once it is off what it lies on, turned as it is
  std::vector<Pose> stations_W;     ///< where the ring shall go with it, one after the other; it may be spun
  std::vector<double> shares;       ///< [-] of the spin that is done at the first stations; all of it at the others
  std::optional<Pose> X_WT_other;   ///< tool of the other arm that holds the ring
  Surroundings around;              ///< on the path there and with the ring
  std::optional<Pose> X_WT_start;   ///< from there all is free; the path may pass it
};

struct GripPlan {
  Grip grip;
  double spin{};     ///< [rad] of the ring at the stations, about its own axis
  double score{-1};  ///< [rad] least margin, less than a hundredth of it if an obstacle blocks it; negative: no grip
  std::vector<Pose> via;  ///< tool poses on the path there, before it comes near
};

/**
 * Paths for a tool to a place: straight, over all obstacles, or through a place where all is free.
 * @param[in,out] trail Of the arm, from where it is; goes there.
 * @param[out] via Poses on the path with the fewest obstacles, the first of those.
 * @return number of blocked places; -1 the arm cannot follow.
 */
int findWay(const ArmsConfig& arms,
            Arm arm,
            const Surroundings& around,
            const std::optional<Pose>& X_WT_start,
            const Pose& to,
            JointTrail* trail,
            std::vector<Pose>* via);

/** The search, a few candidates at a time; ties go to the earlier one. */
class GripSearch {
 public:
  GripSearch(const ArmsConfig& arms, const GripTask& task);

  /** Judges the next `count` candidates. @return true once all are judged. */
  bool proceed(int count);
  const GripPlan& best() const noexcept { return best_; }

 private:
  GripPlan judge(const Grip& grip, double spin) const;
  bool keepsApart(const Pose& X_WT) const;
  bool follow(const Pose& to, JointTrail* trail, int* blocked) const;

  const ArmsConfig& arms_;
  GripTask task_;
  std::vector<Grip> grips_;
  Surroundings before_;  ///< until it has the ring
  std::size_t next_{0};
  GripPlan best_;
};

}  // namespace raven2_trainer::console
