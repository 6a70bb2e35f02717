#include <algorithm>
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/load_exercise.h"
#include "raven2_trainer/core/exceptions.h"

// An exercise. Input: a byte (even: the text follows; odd: edits of the packaged ring_tower_transfer, fuzz_target.h),
// the rest.

namespace raven2_trainer::fuzz {
namespace {

SceneRoles frsRings() {
  SceneRoles roles;
  roles.name = "frs_rings";
  for (const char* name : {"ring_left", "ring_right"})
    roles.objects.push_back({name, name, 0, 0.0075, 0.00175});
  for (const char* name : {"far_left", "far_right", "near_left", "near_right"}) {
    roles.pegs.push_back({name, std::string("tower_") + name, {}, 0.026, 0.004});
    roles.breakables.push_back({std::string("tower_") + name, 6.0, 0.06, 5});
  }
  for (const char* name : {"left", "right"})
    roles.wires.push_back({name, std::string("wire_") + name, 0.00125, {{0, 0, 0}, {0, 0, 0.02}}});
  roles.points = {{"middle", {}}};
  roles.regions = {{"box", {}, {1, 1, 1}}};
  return roles;
}

bool isIn(std::uint8_t index, std::size_t count) {
  return index == kNobody || index < count;
}

void requireSane(const SceneRoles& roles, const Predicate& p) {
  require(isIn(p.object, roles.objects.size()), "an object is one of the scene's");
  require(isIn(p.place, std::max(roles.pegs.size(), std::size_t{1})), "a place is one of the scene's");
  require(std::isfinite(p.value) && p.value >= 0.0 && p.value <= 2.0, "a number is within its range");
}

void requireSane(const SceneRoles& roles, const Exercise& e) {
  require(!e.tracks.empty() && e.tracks.size() <= kMaxTracks, "there are tracks");
  require(e.rules.size() <= kMaxWatchRules, "there are not too many rules");
  require(e.time_limit >= 1.0 && e.time_limit <= 3600.0, "an attempt ends");
  std::size_t steps = 0;
  for (std::size_t t = 0; t < e.tracks.size(); ++t) {
    require(e.tracks[t].after == kNobody || e.tracks[t].after < t, "a track waits for an earlier one");
    steps += e.tracks[t].steps.size();
    for (const ExerciseStep& step : e.tracks[t].steps) {
      require(!step.until.empty() && step.until.size() <= kMaxPredicates, "a step waits for something");
      require(step.dwell >= 0.0 && step.dwell <= 60.0, "a dwell ends");
      for (const Predicate& p : step.until)
        requireSane(roles, p);
    }
  }
  require(steps <= kMaxSteps, "there are not too many steps");
  require(e.drill.scenario.empty() || (e.drill.step >= 1 && e.drill.step <= steps), "a drill's step will come");
  for (const std::uint8_t peg : e.targets)
    require(peg < roles.pegs.size(), "a target is a peg");
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const fuzz::ScratchFolder scratch;
  static const std::string packaged = fuzz::readWhole(fuzz::sourceFile("config/exercises/ring_tower_transfer.yaml"));
  static const SceneRoles roles = fuzz::frsRings();
  fuzz::Input input(data, size);
  const bool edits = (input.byte() & 1U) != 0;
  const std::string file =
      scratch.write("ring_tower_transfer.yaml", edits ? fuzz::edited(packaged, &input) : input.rest());
  try {
    fuzz::requireSane(roles, config::loadExercise(file, roles));
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
