#pragma once

#include <array>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/model/raven_model.h"
#include "reference/dynamics/reference_chain.h"

// Runs the nominal model and the reference chain under the same torques, constant within a tick. URDF coordinates.

namespace raven2_trainer::reference {

/** The terms of the model that are on. */
struct Terms {
  bool gravity{true}, friction{true}, rotors{true};
  bool dry{true};  ///< dry friction too, where there is friction
  std::string text() const;
};

/** All eight combinations with viscous friction only, and one with all terms. */
std::vector<Terms> allTerms();

/** The packaged configuration. */
const TrainerConfig& packagedConfig();
const model::RavenModel& packagedRaven();

/** config/model.yaml with those terms, without contacts of the arms, and with so many steps of ODE in a tick. Without
 * rotors, friction is 5e-5 of the robot's. */
ModelConfig modelConfig(const Terms& terms, int sub_steps);
int packagedSubSteps();

ReferenceChain makeReference(Arm arm, const Terms& terms);

using Torques = std::vector<Vector>;    // one a tick
using Trajectory = std::vector<State>;  // the start, then the state after each tick

enum class Family {
  kTracked,  ///< torques that make the joints track sums of sines through most of their range
  kJumps,    ///< torques that make them track targets that jump five times a second: torque steps
  kForced,   ///< torques for accelerations that jump twenty times a second on top of sines, up to 6 Hz
  kSwing,    ///< wrist, jaws and tool roll swing fast without torque while the other joints move
};
constexpr std::array<const char*, 4> kFamilyNames{"tracked", "jumps", "forced", "swing"};
constexpr std::array<Family, 4> kFamilies{Family::kTracked, Family::kJumps, Family::kForced, Family::kSwing};

/** A start, torques under which the reference stays inside the joint limits, and the reference's trajectory. */
struct Sequence {
  Torques torques;
  Trajectory truth;
};

/** One second of motion. */
Sequence makeSequence(Arm arm, const Terms& terms, Family family, std::uint64_t seed);

/** The first `ticks` of a sequence. */
Sequence firstPart(const Sequence& whole, std::size_t ticks);

/** The nominal model under these torques. */
Trajectory runModel(Arm arm, const ModelConfig& config, const State& start, const Torques& torques);

/** Largest difference of each joint, divided by max(range moved, 0.05 rad or 2 mm). */
Vector relativeErrors(const Trajectory& truth, const Trajectory& other);

State lowerLimits(Arm arm);  ///< in q
State upperLimits(Arm arm);

}  // namespace raven2_trainer::reference
