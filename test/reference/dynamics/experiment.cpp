#include "reference/dynamics/experiment.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/LU>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/physics/raven_world.h"
#include "support/effort.h"

namespace raven2_trainer::reference {
namespace {

constexpr std::size_t kTicks = 1000;
constexpr std::uint64_t kAttempts = 200;
constexpr double kLeastShare = 0.1;
constexpr int kReferenceSteps = 20;  // a tick: 0.05 ms
constexpr int kCoarseSteps = 5;      // to check whether a sequence stays within the limits
constexpr double kWithin = 0.02;     // share of a joint's limits that is kept free

// Share of the robot's friction, for links without rotors. The whole friction would stop a jaw of 8e-9 kg m2 within
// 0.2 us, which the explicit reference cannot follow.
constexpr double kBareFriction = 5e-5;

using Matrix = Eigen::Matrix<double, 7, 7>;

Vector toVector(const JointArray& values) {
  return Eigen::Map<const Eigen::Matrix<double, 7, 1>>(values.data());
}

JointArray toJoints(const Vector& values) {
  JointArray result{};
  std::copy_n(values.data(), kJointCount, result.begin());
  return result;
}

/** One column for each joint's unit torque. @param[out] free accelerations without torque. */
Matrix inverseMass(const ReferenceChain& chain, const State& state, Vector* free) {
  *free = chain.acceleration(state, Vector::Zero(7));
  Matrix inverse;
  for (Eigen::Index j = 0; j < 7; ++j)
    inverse.col(j) = chain.acceleration(state, Vector::Unit(7, j)) - *free;
  return inverse;
}

bool isWithin(Arm arm, const State& state) {
  const Vector low = lowerLimits(arm).q, high = upperLimits(arm).q, margin = kWithin * (high - low);
  return ((state.q - low - margin).array() > 0.0).all() && ((high - margin - state.q).array() > 0.0).all();
}

/** A sum of three sines for each joint, scaled to stay within `share` of the half range around the middle. */
class Sines {
 public:
  Sines(const Vector& middle, const Vector& half, double share, double top_hertz, Random* random) : middle_(middle) {
    for (auto& wave : waves_) {
      for (Eigen::Index j = 0; j < 7; ++j) {
        wave.amplitude[j] = share * half[j] * random->uniform(0.15, 0.33);
        wave.rate[j] = 2.0 * kPi * random->uniform(0.3, top_hertz);
        wave.phase[j] = random->uniform(0.0, 2.0 * kPi);
      }
    }
  }
  void at(double t, Vector* q, Vector* dq, Vector* ddq) const {
    *q = middle_;
    *dq = *ddq = Vector::Zero(7);
    for (const Wave& wave : waves_) {
      for (Eigen::Index j = 0; j < 7; ++j) {
        const double w = wave.rate[j], angle = w * t + wave.phase[j], a = wave.amplitude[j];
        (*q)[j] += a * std::sin(angle);
        (*dq)[j] += a * w * std::cos(angle);
        (*ddq)[j] -= a * w * w * std::sin(angle);
      }
    }
  }

 private:
  struct Wave {
    Vector amplitude{Vector::Zero(7)}, rate{Vector::Zero(7)}, phase{Vector::Zero(7)};
  };
  Vector middle_;
  std::array<Wave, 3> waves_;
};

struct Goal {
  Vector q, dq, ddq;
};

/** The reference, and its number of steps in a tick. */
struct Stepper {
  const ReferenceChain& chain;
  int steps;
};

/** Computes torques for the accelerations `wanted(tick, state)`. Joints from `free_from` on get no torque. */
template <typename Wanted>
Sequence lead(Arm arm, const Stepper& stepper, State start, Eigen::Index free_from, Wanted wanted) {
  Sequence result;
  result.truth.push_back(start);
  for (std::size_t i = 0; i < kTicks && isWithin(arm, start); ++i) {
    Vector free;
    const Matrix inverse = inverseMass(stepper.chain, start, &free);
    const Vector change = wanted(i, start) - free;
    Vector tau = Vector::Zero(7);
    tau.head(free_from) = inverse.topLeftCorner(free_from, free_from).lu().solve(change.head(free_from));
    stepper.chain.advance(tau, kTickSeconds, stepper.steps, &start);
    result.torques.push_back(tau);
    result.truth.push_back(start);
  }
  return result;
}

Vector towards(const Goal& goal, const State& state, double stiffness) {
  return goal.ddq + 2.0 * stiffness * (goal.dq - state.dq) + stiffness * stiffness * (goal.q - state.q);
}

struct Range {
  Vector middle, half;
};

Range range(Arm arm) {
  const Vector low = lowerLimits(arm).q, high = upperLimits(arm).q;
  return {0.5 * (low + high), 0.5 * (high - low)};
}

Sequence tracked(Arm arm, const Stepper& stepper, double share, Random* random) {
  const Range r = range(arm);
  const Sines sines(r.middle, r.half, share, 1.5, random);
  Goal goal;
  sines.at(0.0, &goal.q, &goal.dq, &goal.ddq);
  return lead(arm, stepper, {goal.q, goal.dq}, 7, [&](std::size_t i, const State& state) {
    sines.at(static_cast<double>(i) * kTickSeconds, &goal.q, &goal.dq, &goal.ddq);
    return towards(goal, state, 30.0);
  });
}

Sequence jumps(Arm arm, const Stepper& stepper, double share, Random* random) {
  const Range r = range(arm);
  Goal goal{r.middle, Vector::Zero(7), Vector::Zero(7)};
  return lead(arm, stepper, {r.middle, Vector::Zero(7)}, 7, [&](std::size_t i, const State& state) {
    for (Eigen::Index j = 0; i % 200 == 0 && j < 7; ++j)
      goal.q[j] = r.middle[j] + share * r.half[j] * random->uniform(-0.7, 0.7);
    return towards(goal, state, 15.0);
  });
}

Sequence swing(Arm arm, const Stepper& stepper, double share, Random* random) {
  const Range r = range(arm);
  const Sines sines(r.middle, r.half, 0.7 * share, 1.0, random);
  State start;
  Goal goal;
  sines.at(0.0, &goal.q, &goal.dq, &goal.ddq);
  start.q = goal.q;
  start.dq = goal.dq;
  for (Eigen::Index j = 3; j < 7; ++j) {
    start.q[j] = r.middle[j] + share * r.half[j] * random->uniform(-0.6, 0.6);
    start.dq[j] = share * random->uniform(-25.0, 25.0);
  }
  return lead(arm, stepper, start, 3, [&](std::size_t i, const State& state) {
    sines.at(static_cast<double>(i) * kTickSeconds, &goal.q, &goal.dq, &goal.ddq);
    return towards(goal, state, 30.0);
  });
}

/** Accelerations that jump each 50 ms on top of sines. Without feedback; the torques are for all joints together. */
Sequence forced(Arm arm, const Stepper& stepper, double share, Random* random) {
  const Range r = range(arm);
  const State start{r.middle, Vector::Zero(7)};
  Vector rate(7), side(7), jump(7);
  for (Eigen::Index j = 0; j < 7; ++j) {
    rate[j] = 2.0 * kPi * random->uniform(1.0, 6.0);
    side[j] = random->uniform(-0.4, 0.4);
  }
  return lead(arm, stepper, start, 7, [&](std::size_t i, const State&) {
    Vector wanted(7);
    for (Eigen::Index j = 0; j < 7; ++j) {
      if (i % 50 == 0) jump[j] = i % 100 == 0 ? random->uniform(-40.0, 40.0) : -jump[j];
      const double wave = side[j] * rate[j] * rate[j] * std::cos(rate[j] * static_cast<double>(i) * kTickSeconds);
      wanted[j] = share * r.half[j] * (wave + jump[j]);
    }
    return wanted;
  });
}

Sequence make(Family family, Arm arm, const Stepper& stepper, double share, Random* random) {
  switch (family) {
    case Family::kTracked:
      return tracked(arm, stepper, share, random);
    case Family::kJumps:
      return jumps(arm, stepper, share, random);
    case Family::kForced:
      return forced(arm, stepper, share, random);
    case Family::kSwing:
      return swing(arm, stepper, share, random);
  }
  throw std::logic_error("no such family");
}

}  // namespace

std::string Terms::text() const {
  return std::string(gravity ? "g" : "-") + (friction ? "f" : "-") + (rotors ? "r" : "-") + (dry ? "d" : "-");
}

std::vector<Terms> allTerms() {
  std::vector<Terms> all;
  for (const bool gravity : {true, false}) {
    for (const bool friction : {true, false}) {
      for (const bool rotors : {true, false})
        all.push_back({gravity, friction, rotors, false});
    }
  }
  all.push_back({});
  return all;
}

const TrainerConfig& packagedConfig() {
  static const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  return config;
}

const model::RavenModel& packagedRaven() {
  static const model::RavenModel raven = model::loadRavenModel(packagedConfig());
  return raven;
}

int packagedSubSteps() {
  return packagedConfig().model.sub_steps;
}

ModelConfig modelConfig(const Terms& terms, int sub_steps) {
  ModelConfig config = packagedConfig().model;
  config.arm_contacts.fill(false);
  config.sub_steps = sub_steps;
  if (!terms.gravity) config.gravity = 0.0;
  if (!terms.friction) config.viscous_friction = config.coulomb_friction = JointArray{};
  if (!terms.dry) config.coulomb_friction = JointArray{};
  if (!terms.rotors) {
    config.rotor_inertia = JointArray{};
    for (std::size_t j = 0; j < kJointCount; ++j) {
      config.viscous_friction[j] *= kBareFriction;
      config.coulomb_friction[j] *= kBareFriction;
    }
  }
  return config;
}

ReferenceChain makeReference(Arm arm, const Terms& terms) {
  const ModelConfig config = modelConfig(terms, 1);
  const auto& names = kinematics::urdfJointNames(arm);
  // A joint held by dry friction creeps, in the model too; src/physics/arm_bodies.cpp gives the reason.
  Vector creep = Vector::Constant(7, 1e-4);
  creep[kInsertion] = 1e-5;
  const Drive drive{config.gravity, toVector(config.rotor_inertia), toVector(config.viscous_friction),
                    toVector(config.coulomb_friction), creep};
  return {packagedRaven().description, {names.begin(), names.end()}, drive};
}

State lowerLimits(Arm arm) {
  State state{Vector(7), Vector::Zero(7)};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const int link = at(packagedRaven().links, arm)[j];
    state.q[static_cast<Eigen::Index>(j)] = packagedRaven().description.links[static_cast<std::size_t>(link)].lower;
  }
  return state;
}

State upperLimits(Arm arm) {
  State state{Vector(7), Vector::Zero(7)};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const int link = at(packagedRaven().links, arm)[j];
    state.q[static_cast<Eigen::Index>(j)] = packagedRaven().description.links[static_cast<std::size_t>(link)].upper;
  }
  return state;
}

/** If a sequence reaches a stop, makes a smaller one from another start. Tries all but the first with coarse steps
 *  beforehand, unless friction on bare links makes coarse steps unstable. */
Sequence makeSequence(Arm arm, const Terms& terms, Family family, std::uint64_t seed) {
  const ReferenceChain chain = makeReference(arm, terms);
  const bool takes_half = terms.rotors && !raven2_trainer::testing::isFull();
  const int steps = takes_half ? kReferenceSteps / 2 : kReferenceSteps;
  const bool allows_coarse = terms.rotors || !terms.friction;
  const auto stays = [arm](const Sequence& made) {
    return made.torques.size() == kTicks && isWithin(arm, made.truth.back());
  };
  for (std::uint64_t attempt = 0; attempt < kAttempts; ++attempt) {
    const double share = std::max(kLeastShare, std::pow(0.9, static_cast<double>(attempt)));
    const auto makeWith = [&](int steps_a_tick) {
      Random random(seed, attempt + 1);
      return make(family, arm, {chain, steps_a_tick}, share, &random);
    };
    if (attempt > 0 && allows_coarse && !stays(makeWith(kCoarseSteps))) continue;
    Sequence sequence = makeWith(steps);
    if (stays(sequence)) return sequence;
  }
  throw std::runtime_error(std::string("no sequence stays inside the limits: ") + name(arm) + " " + terms.text());
}

Sequence firstPart(const Sequence& whole, std::size_t ticks) {
  Sequence part = whole;
  part.torques.resize(std::min(ticks, whole.torques.size()));
  part.truth.resize(part.torques.size() + 1);
  return part;
}

Trajectory runModel(Arm arm, const ModelConfig& config, const State& start, const Torques& torques) {
  const model::RavenModel& raven = packagedRaven();
  const double d4 = raven.arms.geometry.d4;
  model::SceneModel scene;
  physics::RavenWorld world(raven, scene, config);
  world.setJointState(arm, kinematics::fromUrdf(arm, d4, toJoints(start.q)),
                      kinematics::rateToUrdf(arm, toJoints(start.dq)));
  Trajectory result{start};
  for (const Vector& tau : torques) {
    PerArm<JointArray> both{world.gravityTorque(Arm::kGold), world.gravityTorque(Arm::kGreen)};
    at(both, arm) = kinematics::rateToUrdf(arm, toJoints(tau));
    world.step(both);
    JointArray q, dq;
    world.jointState(arm, &q, &dq);
    result.push_back({toVector(kinematics::toUrdf(arm, d4, q)), toVector(kinematics::rateToUrdf(arm, dq))});
  }
  if (!world.healthy()) throw std::runtime_error("the world is not healthy");
  return result;
}

Vector relativeErrors(const Trajectory& truth, const Trajectory& other) {
  Vector low = truth.front().q, high = low, worst = Vector::Zero(7);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    low = low.cwiseMin(truth[i].q);
    high = high.cwiseMax(truth[i].q);
    worst = worst.cwiseMax((truth[i].q - other.at(i).q).cwiseAbs());
  }
  Vector least = Vector::Constant(7, 0.05);
  least[kInsertion] = 0.002;
  return worst.cwiseQuotient((high - low).cwiseMax(least));
}

}  // namespace raven2_trainer::reference
