#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "training/hold_watch.h"
#include "training/judge_scene.h"

namespace raven2_trainer::training {

/** Whether an object moves: judged by the mean over kWindow, as contacts make bodies that rest tremble. */
class RestWatch {
 public:
  static constexpr std::int32_t kWindow = 20;  ///< [ticks]

  void clear() noexcept { *this = {}; }
  void observe(const Pose& X_WO) noexcept;
  bool rests() const noexcept { return rests_; }

 private:
  Pose first_;
  std::int32_t ticks_{-1};
  bool rests_{false};
};

/** The quantities of predicates at the end of one tick. Real-time safe except for the constructor. */
class SceneSenses {
 public:
  SceneSenses(const SceneRoles& roles, const JudgeScene& scene, const ArmsConfig& arms, const CameraConfig& camera);

  /** Forgets what took time to become so: who holds what, what rests. */
  void clear() noexcept;
  /** Poses alone. */
  void look(const ModelState& state) noexcept;
  /** Poses and contacts of one tick. */
  void observe(const ModelState& state, const ContactList& list) noexcept;

  /** @param[in] along [-] how far the object was led along the wire so far, for PredicateKind::kAlong. */
  bool holds(const Predicate& predicate, double along) const noexcept;

  /** [m] along the wire, negative: not threaded. */
  double threaded(std::size_t object, std::size_t wire) const noexcept;
  double wireLength(std::size_t wire) const noexcept { return wire_lengths_[wire]; }
  /** Around none of the pegs, touches nothing fixed. */
  bool isLifted(std::size_t object) const noexcept;
  bool isAroundAny(std::size_t object, const std::vector<std::uint8_t>& pegs) const noexcept;
  /** [m] of the nearer tip to what the predicate waits for; infinite if that is no place. */
  double distanceTo(const Predicate& predicate) const noexcept;

  const HoldWatch& hands() const noexcept { return hands_; }
  bool rests(std::size_t object) const noexcept { return rests_[object].rests(); }
  const Pose& object(std::size_t i) const noexcept { return objects_W_[i]; }
  const PerArm<Pose>& tools() const noexcept { return tools_W_; }
  const PerArm<Pose>& bases() const noexcept { return X_WB_; }

 private:
  bool isMet(const Predicate& predicate, double along) const noexcept;
  bool isHeld(const Predicate& predicate, bool alone) const noexcept;
  /** Any or both tips as the predicate's hand says. */
  template <typename Test>
  bool tips(const Predicate& predicate, const Test& test) const noexcept;
  bool isInView(const Predicate& predicate) const noexcept;
  template <typename Measure>
  double nearerTip(const Measure& measure) const noexcept;

  SceneRoles roles_;
  JudgeScene scene_;
  PerArm<Pose> X_WB_;
  double half_view_;  ///< [-] tangent of half the camera's vertical field
  std::vector<double> wire_lengths_;
  HoldWatch hands_;
  std::array<RestWatch, kMaxSceneBodies> rests_{};
  std::array<Pose, kMaxSceneBodies> objects_W_{};
  PerArm<Pose> tools_W_{};
  CameraState camera_{};
};

}  // namespace raven2_trainer::training
