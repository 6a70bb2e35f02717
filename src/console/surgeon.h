#pragma once

#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "grip_search.h"
#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/console/expert.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "tool_hand.h"

namespace raven2_trainer::console {

constexpr double kShortestMove = 0.3;  ///< [s]
constexpr double kSettle = 0.25;       ///< [s] the tool is behind the hand by 80 ms, the picture by up to 33
constexpr double kLookAgain = 0.25;    ///< [s] in which a correction is made

/** Eyes, hands and pedals of a scripted surgeon, and the steps that verbs are made of: each starts something and says
 *  how long it takes. */
class Surgeon : public MotionSource {
 public:
  Surgeon(const ConsoleConfig& config,
          const ArmsConfig& arms,
          const SceneRoles& roles,
          const Skill& skill,
          std::uint64_t seed);

  Intent tick(const Senses& senses) override;

 protected:
  using Step = std::function<Tick()>;  ///< @return ticks until the next
  using Target = std::function<Pose()>;

  /** Object in the jaws of one arm. */
  struct Hold {
    std::uint8_t object{kNobody};
    Pose X_TR;         ///< ring in the tool, as last seen
    double heading{};  ///< [rad] to carry it at where it is level
    bool lifted{false};
    double spin{};  ///< [rad] of rotation about its own axis on the path for which the grip was chosen
  };

  /** All steps are done: adds more, or finishes. */
  virtual void nextVerb() = 0;
  void finish() noexcept { finished_ = true; }

  // what is seen
  const Sight& sight() const { return *sight_; }
  Pose tool(Arm arm) const { return toEigen(at(sight_->tool_W, arm)); }
  const Pose& ring(std::uint8_t object) const { return rings_.at(object); }
  Pose ringInTool(Arm arm, std::uint8_t object) const { return tool(arm).inverse() * ring(object); }
  bool isClosedOnSomething(Arm arm) const;
  bool holds(Arm arm) const;
  /** The peg in the ring's opening, or null. */
  const ScenePeg* pegIn(std::uint8_t object) const;

  // steps: at the end of what is to come, or ahead of it in this order
  void then(Step step) { steps_.push_back(std::move(step)); }
  void first(std::vector<Step> steps) { steps_.insert(steps_.begin(), steps.begin(), steps.end()); }
  void forgetSteps() { steps_.clear(); }
  void rest(double seconds);

  /** Pedal up, both hands to their middle, pedal down, and a look. */
  std::vector<Step> clutch();
  /** The tool there, in as many reaches of the hand as it takes. */
  Step travel(Arm arm, Target target, double speed);
  /** Waits, looks, and brings the tool to where it should be. */
  Step settle(Arm arm, int looks);
  /** With the ring it holds, its middle there. */
  Step carryTo(Arm arm, const Vector3& to_W, double speed);
  /** Waits, looks where the ring is, and brings it to where it should be. */
  Step settleRing(Arm arm, const Vector3& to_W, int looks);
  void jaws(Arm arm, double opening);
  /** Draws back and has nothing any more. */
  void leave(Arm arm);
  Step pedalStep(Pedal pedal, bool is_down);
  /** With the camera pedal down, as far as the hands reach, then a clutch and a look, until the eye is there. */
  Step leadCamera(const Vec3& to_W, int legs);
  bool isEyeAt(const Vec3& to_W) const;

  /** Starts a move at once. @return its length. */
  Tick move(Arm arm, const Pose& to, double speed);
  /** From where the tools are now, on with what was wanted: far ways without haste. @return its length. */
  Tick takeUpAgain();

  ToolHand& hand(Arm arm) { return at(hands_, arm); }
  double speed() { return random_.uniform(skill_.slowest, skill_.fastest); }
  Tick now() const noexcept { return now_; }
  std::uint32_t sequence() const noexcept { return sequence_; }

  const ArmsConfig arms_;
  const SceneRoles roles_;
  const Skill skill_;
  const double scale_;
  Random random_;
  PerArm<Hold> holds_{};
  PerArm<JointArray> joints_{};  ///< [rad, m] from the tools' poses
  PerArm<Pose> start_{};         ///< of the tools

 private:
  void see(const Senses& senses);
  void giveUpWhatHasFailed();
  void followJoints(Arm arm);
  void followRing(std::uint8_t object);
  Tick next();
  bool waitsForStop();
  void begin();
  Tick press();
  Step until(std::function<bool()> is_so, double timeout);
  double reachable(Arm arm, const Pose& from, const Pose& to);

  PerArm<ToolHand> hands_;
  std::deque<Step> steps_;
  std::optional<Sight> sight_;
  std::array<Pose, kMaxSceneBodies> rings_{};  ///< objects as seen
  std::uint32_t sequence_{0}, pedals_{0};
  std::uint8_t runlevel_{0};
  Tick now_{0}, free_at_{0};
  Tick wait_{0};  ///< because of an emergency stop
  bool pedal_{false}, finished_{false}, saw_open_attempt_{false};
};

}  // namespace raven2_trainer::console
