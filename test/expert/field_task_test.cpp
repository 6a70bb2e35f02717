#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>

#include "expert/truth.h"
#include "expert/worse.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

// Rings along rails, an instrument out of the field, camera and clutch. A scripted surgeon does them through ITP and
// pedals alone.

namespace raven2_trainer::testing {
namespace {

constexpr std::uint64_t kFirst = 1;  ///< seed

/** Kind of the verb that does a step. */
console::VerbKind verbFor(const ExerciseStep& step) {
  switch (step.until.front().kind) {
    case PredicateKind::kHeld:
      return console::VerbKind::kGrip;
    case PredicateKind::kAlong:
    case PredicateKind::kUnthreaded:
      return console::VerbKind::kFollowWire;
    case PredicateKind::kAround:
      return console::VerbKind::kPutOver;
    case PredicateKind::kCameraNear:
      return console::VerbKind::kCameraTo;
    default:
      return console::VerbKind::kTouch;
  }
}

/** Steps of the tracks one after the other, and the verb that does each. One verb may do several steps. */
std::vector<ScriptedStep> stepsInARow(const Exercise& exercise, const std::vector<console::Verb>& verbs) {
  std::vector<ScriptedStep> steps;
  std::size_t verb = 0;
  std::optional<PredicateKind> last;
  for (std::size_t track = 0; track < exercise.tracks.size(); ++track) {
    for (std::size_t i = 0; i < exercise.tracks[track].steps.size(); ++i) {
      const PredicateKind kind = exercise.tracks[track].steps[i].until.front().kind;
      const bool goes_on = kind == PredicateKind::kUnthreaded && last == PredicateKind::kAlong;
      verb += last && !goes_on ? 1 : 0;
      last = kind;
      EXPECT_LT(verb, verbs.size());
      EXPECT_EQ(verbs.at(verb).kind, verbFor(exercise.tracks[track].steps[i])) << "verb " << verb;
      steps.push_back({static_cast<std::uint8_t>(track), static_cast<std::uint8_t>(i), static_cast<int>(verb)});
    }
  }
  return steps;
}

/** A condition on poses that must hold for a time. */
struct Milestone {
  std::function<bool(const ModelState&)> is_there;
  double dwell{};  ///< [s]
};

class FieldExercise : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    useOde();
    config_ = trainingConfig(GetParam());
  }

  std::shared_ptr<Attempt> attempt(std::uint64_t seed, const ClumsyHand* hand = nullptr) const {
    const std::string clumsy = hand == nullptr ? "" : hand->name;
    auto attempt = std::make_shared<Attempt>(config_, seed, clumsy);
    const bool is_done_by_poses = run(attempt.get(), hand);
    const std::string who = (clumsy.empty() ? "seed " : clumsy + ", seed ") + std::to_string(seed);
    tell(who, *attempt);
    if (std::getenv("RAVEN2_TRAINER_TELL") != nullptr || (clumsy.empty() && !isDone(*attempt))) tellAll(*attempt);
    EXPECT_EQ(isDone(*attempt), is_done_by_poses && attempt->isAllPlaced()) << who << ": judge and poses";
    const std::vector<ScriptedStep> steps = stepsInARow(config_.exercise, attempt->verbs());
    expectStepsAsDone(*attempt, steps, who);
    return attempt;
  }

  /** The expert's attempt, with which clumsy surgeons are compared; run once. */
  std::shared_ptr<Attempt> first() const {
    static std::map<std::string, std::shared_ptr<Attempt>> known;
    std::shared_ptr<Attempt>& one = known[GetParam()];
    if (one == nullptr) one = attempt(kFirst);
    return one;
  }

  /** Runs until two seconds after the surgeon is finished, until the exercise has failed, or until the time is over.
   *  @return whether all milestones were passed, in their order. */
  bool run(Attempt* attempt, const ClumsyHand* hand) const {
    const bool ends_at_mistake = hand != nullptr && !isFull() && isLong(GetParam());
    bool was_made = false;
    const std::vector<Milestone> wanted = milestones();
    std::size_t passed = 0;
    Tick rest = 2000, there = 0;
    const auto most = static_cast<Tick>((config_.exercise.time_limit + 30.0) / kTickSeconds);
    for (Tick i = 0; i < most && rest > 0 && attempt->exercise().status != ExerciseStatus::kFailed; ++i) {
      attempt->step();
      was_made = was_made || (ends_at_mistake && madeMistake(*attempt, expectation(*hand)));
      rest -= attempt->finished() || was_made ? 1 : 0;
      if (passed == wanted.size()) continue;
      there = wanted[passed].is_there(attempt->model()) ? there + 1 : 0;
      if (static_cast<double>(there) * kTickSeconds < wanted[passed].dwell) continue;
      ++passed;
      there = 0;
    }
    return passed == wanted.size();
  }

  std::vector<Milestone> milestones() const {
    const std::string name = GetParam();
    if (name == "retrieve_and_reach")
      return {tipAt(Arm::kGreen, "deep", 0.006),
              {[this](const ModelState& m) { return tip(m, Arm::kGreen).x() < 0.018; }, 0.3},
              {[this](const ModelState& m) { return hasBarBetweenJaws(m, Arm::kGreen); }, 0.2}};
    if (name == "camera_clutch")
      return {eyeAt("eye_left"), tipAt(Arm::kGold, "touch_left", 0.005), eyeAt("eye_right"),
              tipAt(Arm::kGreen, "touch_right", 0.005)};
    return {led(0, 0), led(1, 1)};
  }

  Pose tool(const ModelState& model, Arm arm) const {
    const ArmState& state = at(model.arms, arm);
    const Pose X_WB{model::armBaseRotation(arm), toEigen(at(config_.arms.rcm_W, arm))};
    return X_WB * Pose{toEigen(state.q_BT).toRotationMatrix(), toEigen(state.p_BT)};
  }
  Vector3 tip(const ModelState& model, Arm arm) const { return tool(model, arm).p; }

  Vector3 point(const std::string& name) const {
    const auto& points = config_.roles.points;
    return toEigen(std::find_if(points.begin(), points.end(), [&](const auto& p) { return p.name == name; })->p_W);
  }
  Milestone tipAt(Arm arm, const std::string& name, double within) const {
    return {[this, arm, within, p = point(name)](const ModelState& m) { return (tip(m, arm) - p).norm() <= within; },
            0.3};
  }
  Milestone eyeAt(const std::string& name) const {
    return {[p = point(name)](const ModelState& m) { return (toEigen(m.camera.eye_W) - p).norm() <= 0.03; }, 0.3};
  }

  /** Whether a bar of the square ring is between the jaws, which are neither closed nor wide open. */
  bool hasBarBetweenJaws(const ModelState& model, Arm arm) const {
    const SceneObject& ring = config_.roles.objects[0];
    const double middle = ring.inner_radius + ring.bar_radius;
    double nearest = 1e9;
    for (double reach = 0.005; reach <= 0.0105; reach += 0.0005) {
      const Vector3 p_R = toEigen(model.bodies[0]).inverse() * (tool(model, arm) * Vector3(reach, 0, 0));
      const double off = std::abs(p_R.head<2>().cwiseAbs().maxCoeff() - middle);
      nearest = std::min(nearest, std::hypot(off, p_R.z()));
    }
    const ArmState& state = at(model.arms, arm);
    const double opening = kinematics::jawOpening(state.q);
    return nearest < ring.bar_radius && opening > 0.1 && opening < 0.7;
  }

  /** An object was moved along a whole wire: each point of the wire passed through the opening, one after the other. */
  Milestone led(std::size_t object, std::size_t wire) const {
    const SceneObject& ring = config_.roles.objects[object];
    auto next = std::make_shared<std::size_t>(1);  // the wire's foot fills only half of the opening
    return {[object, next, r = ring.inner_radius, line = config_.roles.wires[wire].line_W](const ModelState& m) {
              const Pose X_OW = toEigen(m.bodies[object]).inverse();
              if (*next < line.size()) {
                const Vector3 a = X_OW * toEigen(line[*next - 1]), b = X_OW * toEigen(line[*next]);
                const bool is_between = a.z() * b.z() <= 0.0 && a.z() != b.z();
                const Vector3 p = a + (b - a) * (is_between ? a.z() / (a.z() - b.z()) : 0.0);
                *next += is_between && p.head<2>().norm() < r ? 1 : 0;
              }
              return *next == line.size();
            },
            0.0};
  }

  TrainerConfig config_;
};

TEST_P(FieldExercise, IsDoneThroughItpAndPedalsAlone) {
  std::vector<double> times;
  std::uint32_t mistakes = 0;
  const std::vector<std::uint64_t> all = seeds(seedsOf(GetParam()));
  for (const std::uint64_t seed : all) {
    const auto tried = seed == kFirst ? first() : attempt(seed);
    if (!isDone(*tried)) continue;
    times.push_back(tried->seconds());
    for (const std::uint32_t count : tried->exercise().mistakes)
      mistakes += count;
  }
  tellRate(GetParam(), times, all.size());
  EXPECT_GE(static_cast<double>(times.size()), 0.95 * static_cast<double>(all.size()));
  EXPECT_EQ(mistakes, 0U) << "the expert intends none";
}

TEST_P(FieldExercise, ClumsyHandsDoWorseAsExpected) {
  const auto expert = first();
  ASSERT_TRUE(isDone(*expert));
  for (const ClumsyHand& hand : config_.exercise.clumsy) {
    const auto clumsy = attempt(clumsySeed(GetParam()), &hand);
    EXPECT_TRUE(isWorse(*clumsy, *expert, expectation(hand))) << hand.name;
    if (!isFull()) break;
  }
}

INSTANTIATE_TEST_SUITE_P(Expert,
                         FieldExercise,
                         ::testing::Values("retrieve_and_reach", "ring_along_loops", "camera_clutch"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace raven2_trainer::testing
