#include "raven2_trainer/console/clumsy.h"

#include <initializer_list>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::console {
namespace {

void demand(bool is_so, const std::string& what) {
  if (!is_so) throw ConfigException("clumsy: " + what);
}

/** The verb to be changed, if it is of one of these kinds. */
Verb& changed(const Clumsiness& clumsiness,
              const char* key,
              std::initializer_list<VerbKind> kinds,
              std::vector<Verb>* verbs) {
  demand(clumsiness.verb < verbs->size(),
         "verb " + std::to_string(clumsiness.verb) + ", there are " + std::to_string(verbs->size()));
  Verb& verb = (*verbs)[clumsiness.verb];
  bool fits = false;
  for (const VerbKind kind : kinds)
    fits = fits || verb.kind == kind;
  demand(fits, std::string(key) + " does not go with " + kVerbNames.at(static_cast<std::size_t>(verb.kind)));
  return verb;
}

void demandBetween(double value, double least, double greatest, const char* key) {
  const bool is_within = value >= least && value <= greatest;
  demand(is_within, std::string(key) + " is " + std::to_string(value) + ", expected " + std::to_string(least) + " to " +
                        std::to_string(greatest));
}

}  // namespace

void makeClumsy(const Clumsiness& clumsiness, std::vector<Verb>* verbs, Skill* skill) {
  if (clumsiness.let_go_at) {
    demandBetween(*clumsiness.let_go_at, 0.0, 1.0, "let_go_at");
    changed(clumsiness, "let_go_at", {VerbKind::kCarry}, verbs).let_go_at = *clumsiness.let_go_at;
  }
  if (clumsiness.via_W) {
    changed(clumsiness, "via_W", {VerbKind::kCarry, VerbKind::kTouch}, verbs).via_W = *clumsiness.via_W;
  }
  if (clumsiness.push_W) {
    changed(clumsiness, "push_W", {VerbKind::kPutOver, VerbKind::kFollowWire}, verbs).push_W = *clumsiness.push_W;
  }
  if (clumsiness.speed) {
    demandBetween(*clumsiness.speed, 0.05, 3.0, "speed");
    skill->slowest *= *clumsiness.speed;
    skill->fastest *= *clumsiness.speed;
  }
  if (clumsiness.pause) {
    demandBetween(*clumsiness.pause, 0.0, 60.0, "pause");
    skill->pause = *clumsiness.pause;
  }
  if (clumsiness.tremor) {
    demandBetween(*clumsiness.tremor, 0.0, 100.0, "tremor");
    skill->tremor = *clumsiness.tremor;
  }
  if (clumsiness.clutch_time) {
    demandBetween(*clumsiness.clutch_time, 0.1, 10.0, "clutch_time");
    skill->clutch_time = *clumsiness.clutch_time;
  }
  if (clumsiness.clutch_reach) {
    demandBetween(*clumsiness.clutch_reach, 0.05, 1.0, "clutch_reach");
    skill->clutch_reach = *clumsiness.clutch_reach;
  }
}

}  // namespace raven2_trainer::console
