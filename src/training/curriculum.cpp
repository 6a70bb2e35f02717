#include "raven2_trainer/training/curriculum.h"

namespace raven2_trainer::training {

namespace {

void count(const CurriculumStage& stage, bool passed, StageProgress* progress) {
  ++progress->attempts;
  if (progress->in_a_row >= stage.passes) {
    progress->extra += passed ? 1 : 0;
  } else {
    progress->in_a_row = passed ? progress->in_a_row + 1 : 0;
  }
  progress->done = progress->in_a_row >= stage.passes && progress->extra >= stage.extra;
}

}  // namespace

Progress follow(const Curriculum& curriculum, const std::vector<CurriculumAttempt>& attempts) {
  Progress progress;
  progress.stages.resize(curriculum.stages.size());
  for (const CurriculumAttempt& attempt : attempts) {
    if (progress.current >= curriculum.stages.size()) break;
    const CurriculumStage& stage = curriculum.stages[progress.current];
    if (!attempt.passed || attempt.exercise != stage.exercise || attempt.drill != stage.drill) continue;
    StageProgress* own = &progress.stages[progress.current];
    count(stage, *attempt.passed, own);
    if (own->done) ++progress.current;
  }
  return progress;
}

}  // namespace raven2_trainer::training
