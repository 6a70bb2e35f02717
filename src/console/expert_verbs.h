#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "surgeon.h"

namespace raven2_trainer::console {

constexpr int kLooks = 3;               ///< [-] corrections of one move, at most
constexpr std::size_t kWireStride = 4;  ///< [mm] between the places of a wire that a grip is judged at
constexpr double kOverWire = 0.020;     ///< [m] higher before the ring is turned level again

/** A scripted surgeon that does verbs one after the other (console/expert.h). */
class Expert : public Surgeon {
 public:
  Expert(const ConsoleConfig& config,
         const ArmsConfig& arms,
         const SceneRoles& roles,
         const std::vector<Verb>& verbs,
         const Skill& skill,
         std::uint64_t seed,
         TruthLog* truth);

 private:
  struct Task {
    Verb verb;
    int number;  ///< in the list as given
    int tries;
  };

  // verbs one after the other
  void nextVerb() override;
  void expand(const Verb& verb);
  void log(const char* what);
  void thenLog(const char* what);
  /** The verb went wrong: `instead` comes next, unless it was tried often enough. */
  void again(std::vector<Verb> instead);
  static std::vector<Verb> regrip(const Verb& verb) {
    Verb grip = verb;
    grip.kind = VerbKind::kGrip;
    return {grip, verb};
  }
  static std::vector<Verb> regripAlone(const Verb& verb) {
    Verb grip = verb;
    grip.kind = VerbKind::kGrip;
    return {grip};
  }
  Tick giveUp(const char* why);

  // expert_grips.cpp: how to take hold of an object
  void grip(const Verb& verb);
  /** Judges grips until the search is done. If none can do all that comes, one will do that can do the first of it. */
  void think(GripTask task);
  Step thinkOn(const GripTask& task);
  GripTask gripTask(const Verb& verb) const;
  /** The arm that holds the ring is no obstacle: it comes along or draws back. */
  Surroundings around(const Verb& verb) const;
  /** Where the ring will go in a coming verb. @return false if it is let go then. */
  bool addStations(const Verb& verb, GripTask* task, double* heading) const;
  /** The other arm holds it. */
  bool isInTheAir(const Verb& verb) const;
  /** Above where it is, off the peg it may be on. */
  Vector3 lifted(std::uint8_t object) const;
  Vector3 abovePeg(const Verb& verb) const;
  Vector3 onPeg(const Verb& verb) const;
  /** How the tool will err from the planned grip: never so that its jaws would touch a peg or the floor, which an
   * expert sees and corrects. */
  Pose aimNextTo(const Verb& verb);
  /** @param care [-] share of the skill's errors. */
  Pose aim(double care);
  const SceneObject& shape(const Verb& verb) const { return roles_.objects[verb.object]; }

  // expert_carries.cpp: what is done with it
  /** Straight up, turned as it lies. */
  void liftOff(Arm arm);
  void carry(const Verb& verb);
  void letGoOnTheWay(const Verb& verb, const Vector3& to_W);
  void takeOver(const Verb& verb);
  void putOver(const Verb& verb);
  void push(const Verb& verb);
  void letGo(Arm arm, const Verb& verb);

  // expert_wires.cpp: along a wire
  void followWire(const Verb& verb);
  /** @return heading of the ring where it is level again behind the wire. */
  double addWire(const Verb& verb, GripTask* task) const;
  /** The rest of the wire from there on, for a ring in this pose that rotates evenly along it. */
  std::vector<Pose> wayAlong(const Verb& verb, const Pose& X_WR, double spin) const;
  /** Some millimetres, a look, and on; where the hand's reach ends it clutches. */
  Step wireLeg(const Verb& verb);
  /** Tool poses for the next part of the way of what it holds, from where the tool is wanted now. */
  std::vector<Pose> withinReach(Arm arm, const std::vector<Pose>& way, const Pose& X_RT);
  /** Slowly along these poses, asking for as much more as the tool is seen to be off. */
  Tick lead(Arm arm, const std::vector<Pose>& leg);

  // the other verbs
  void touch(const Verb& verb);
  void cameraTo(const Verb& verb);
  void hold(const Verb& verb);
  /** One pose after the other. */
  std::vector<Step> passing(Arm arm, const std::vector<Pose>& poses);

  TruthLog* truth_;
  std::deque<Task> verbs_;
  Task task_{};
  std::optional<GripSearch> search_;
  GripPlan plan_;
  Pose miss_;                 ///< [@frame tool] of the grip at hand
  double heading_{};          ///< [rad] of the ring when it was made
  std::size_t wire_left_{0};  ///< [mm] of the path along the wire at the last look
};

}  // namespace raven2_trainer::console
