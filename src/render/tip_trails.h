#pragma once

#include <array>
#include <deque>
#include <vector>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/render/render_config.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

/** Whose way (paper, Figures 7 and 8). */
enum class Trail : std::uint8_t {
  kUser,   ///< where the hand wanted the tip
  kPlan,   ///< where the plan that is followed wanted it
  kTrack,  ///< where the model's tip was
};
constexpr std::size_t kTrailCount = 3;

/**
 * Marks that the tool tips leave behind, one at each multiple of TrailConfig::step on the model's clock, whatever the
 * rate of the frames: between two frames the tip is taken to go straight. Older ones than TrailConfig::duration are
 * forgotten. Numbers that are not finite leave no mark.
 */
class TipTrails {
 public:
  /** @param[in] X_WB arm bases. */
  TipTrails(const ArmGeometry& geometry, const PerArm<Pose>& X_WB, const TrailConfig& config);

  /** The same tick again changes nothing; an older one begins again. */
  void follow(const Snapshot& snapshot);

  /** [m] [@frame W] of both arms, oldest first. */
  std::vector<Vector3> marks(Trail trail) const;

 private:
  struct Mark {
    Tick tick;
    Trail trail;
    Vector3 p_W;
  };
  /** Where an arm's tip is wanted, and by whom. */
  struct Wanted {
    Trail by{Trail::kTrack};  ///< kTrack: by nobody
    Vector3 p_W;
  };
  struct Past {
    Vector3 tip_W;
    Wanted wanted;
  };

  Past stateOf(const Snapshot& snapshot, Arm arm) const;
  void leave(Tick tick, Trail trail, const Vector3& p_W);
  void markBetween(const Past& past, const Past& now, Tick first, Tick last);

  ArmGeometry geometry_;
  PerArm<Pose> X_WB_;
  Tick step_, duration_;
  Tick last_{-1};  // followed; -1 none
  PerArm<Past> past_;
  std::deque<Mark> marks_;
};

}  // namespace raven2_trainer::render
