#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/console/truth_log.h"
#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::console {

/** Actions of a scripted surgeon. */
enum class VerbKind : std::uint8_t {
  kGrip,        ///< `arm` takes hold of `object` where it lies
  kCarry,       ///< `arm` carries it level to `to_W`
  kTakeOver,    ///< `arm` takes hold of `object` while the other one holds it, which then lets go
  kPutOver,     ///< `arm` puts `object`, which it holds, over `peg` and lets go
  kFollowWire,  ///< `arm` leads `object`, which it holds and which `wire` goes through, along it and off its end
  kTouch,       ///< the tip of `arm` goes to `to_W`, turned as it is
  kPark,        ///< `arm` goes back to where it was at the start
  kCameraTo,    ///< camera pedal down: both hands bring the camera's eye to `to_W`; its target stays
  kClutch,      ///< pedal up, both hands to their middle, pedal down
  kWait,        ///< for `seconds`
  kPress,       ///< `pedal` for `seconds`
};
constexpr std::size_t kVerbKindCount = 11;
constexpr std::array<const char*, kVerbKindCount> kVerbNames{
    "grip", "carry", "take_over", "put_over", "follow_wire", "touch", "park", "camera_to", "clutch", "wait", "press"};

struct Verb {
  VerbKind kind{};
  Arm arm{Arm::kGold};
  std::uint8_t object{kNobody};  ///< index in SceneRoles::objects
  std::uint8_t peg{kNobody};     ///< index in SceneRoles::pegs
  std::uint8_t wire{kNobody};    ///< index in SceneRoles::wires
  Vec3 to_W{};                   ///< [m]
  double seconds{};              ///< [s]
  Pedal pedal{};
  // Additions of a clumsy one.
  double let_go_at{-1.0};     ///< [-] kCarry: share of the path at which the jaws open; negative: they do not
  std::optional<Vec3> via_W;  ///< [m] kCarry, kTouch: another place that is passed first
  Vec3 push_W{};              ///< [m] kPutOver: the tool pushes that far before it lets go; kFollowWire: the object
                              ///< is led that far off the wire
};

/** Skill of a surgeon. Defaults: an expert's, our choice; aim and speed as in test/grasp. */
struct Skill {
  double aim_error{0.0005};               ///< [m] along each axis, of a grip
  double aim_angle{0.087};                ///< [rad] about any axis
  double tremor{1.0};                     ///< [-] x console.yaml's
  double slowest{0.020}, fastest{0.060};  ///< [m/s] mean speeds of the tool
  double pause{0.2};                      ///< [s] between verbs, up to twice as long
  double clutch_time{0.5};                ///< [s] pedal up at least, while the hands come back
  double clutch_reach{0.25};  ///< [m] of a hand from its middle before it clutches; makeScripted()'s longest stroke
  int tries{3};               ///< [-] of a verb that went wrong
};

/**
 * A scripted surgeon that does verbs through ITP alone: it acts by increments, jaws and pedals, and sees pictures 30
 * times a second. It knows neither joints nor contacts nor the judge's results. Each move is minimum-jerk. Before jaws
 * close or open and after each move with an object it looks and corrects. Failed actions are tried again. Inverse
 * kinematics finds the grip. Finished once all verbs are done or given up.
 *
 * @param[in] truth Gets the beginning and end of each verb; may be null, else it must outlive the source.
 * @throw ConfigException for a verb whose object or peg the scene does not have.
 */
std::unique_ptr<MotionSource> makeExpert(const ConsoleConfig& config,
                                         const ArmsConfig& arms,
                                         const SceneRoles& roles,
                                         const std::vector<Verb>& verbs,
                                         const Skill& skill,
                                         std::uint64_t seed,
                                         TruthLog* truth = nullptr);

}  // namespace raven2_trainer::console
