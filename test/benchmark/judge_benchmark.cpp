// Cost of judging in a physics tick: a whole exercise with a full contact list, and the distance to the tissue alone.
// Usage: judge_benchmark [THOUSAND TICKS]

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_exercise.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/training/exercise_judge.h"
#include "raven2_trainer/training/tissue_distance.h"
#include "support/frs_roles.h"

namespace raven2_trainer {
namespace {

double nowMicroseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

void print(const char* what, std::vector<double>* us) {
  std::sort(us->begin(), us->end());
  double sum = 0.0;
  for (const double each : *us)
    sum += each;
  const auto quantile = [&](double part) {
    return (*us)[static_cast<std::size_t>(part * static_cast<double>(us->size() - 1))];
  };
  std::printf("%-44s mean %6.2f  p50 %6.2f  p99 %6.2f  p99.9 %6.2f us\n", what, sum / static_cast<double>(us->size()),
              quantile(0.5), quantile(0.99), quantile(0.999));
}

std::vector<std::string> bodyNames(const model::SceneModel& scene) {
  std::vector<std::string> names;
  for (const char* ending : kArmLinkEndings) {
    for (const char* stem : kArmLinkStems)
      names.push_back(std::string(stem) + ending);
  }
  for (const model::Link& link : scene.description.links)
    names.push_back(link.name);
  return names;
}

/** A full list of contacts between random bodies, arms first, so that the judge has to check all rules. */
void fill(std::size_t bodies, Random* random, ContactList* list) {
  list->count = kMaxContacts;
  for (Contact& c : list->contacts) {
    const auto a = static_cast<std::uint16_t>(random->next() % bodies),
               b = static_cast<std::uint16_t>(random->next() % bodies);
    c.a = std::min(a, b);
    c.b = std::max(a, b);
    c.n_W = {0.0, 0.0, 1.0};
    c.f_W = {0.0, 0.0, random->uniform(0.0, 1.0)};
  }
}

void move(Random* random, ModelState* model) {
  ++model->tick;
  for (ArmState& arm : model->arms) {
    for (double& p : arm.p_BT)
      p += random->uniform(-1e-4, 1e-4);
  }
  model->bodies[0].p[2] += random->uniform(-1e-5, 1e-5);
}

int run(std::size_t ticks) {
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  const model::SceneModel scene = model::loadSceneModel(config);
  const SceneRoles roles = testing::frsRoles();
  const Exercise exercise =
      config::loadExercise(RAVEN2_TRAINER_SOURCE_DIR "/config/exercises/pick_hand_over_place.yaml", roles);
  const std::vector<std::string> names = bodyNames(scene);
  training::ExerciseJudge judge(exercise, roles, scene, config.arms, config.render.cameras.at(0), names);
  Random random(1);
  ModelState model;
  ContactList contacts;
  model.mode = Mode::kTeleoperating;
  model.bodies[0].p = {0.012, 0.0, 0.016};
  for (ArmState& arm : model.arms)
    arm.p_BT = {0.10, 0.0, 0.05};
  judge.start();
  std::vector<double> full, empty, tissue_us;
  for (std::size_t i = 0; i < ticks; ++i) {
    if (i % 50 == 0) fill(names.size(), &random, &contacts);
    if (i % 20000 == 0) judge.start();
    move(&random, &model);
    const double begin = nowMicroseconds();
    judge.tick(model, contacts, {});
    full.push_back(nowMicroseconds() - begin);
  }
  contacts.count = 0;
  judge.start();
  for (std::size_t i = 0; i < ticks; ++i) {
    move(&random, &model);
    const double begin = nowMicroseconds();
    judge.tick(model, contacts, {});
    empty.push_back(nowMicroseconds() - begin);
  }
  training::TissueDistance tissue(scene, roles.tissue);
  double least = 1.0;
  for (std::size_t i = 0; i < ticks; ++i) {
    PerArm<training::ToolPoints> tools;
    for (training::ToolPoints& points : tools) {
      Pose X_WT;
      X_WT.p = {random.uniform(-0.03, 0.06), random.uniform(-0.03, 0.03), random.uniform(0.01, 0.08)};
      points = training::toolPoints(X_WT, 0.5);
    }
    const double begin = nowMicroseconds();
    least = std::min(least, tissue.measure(tools));
    tissue_us.push_back(nowMicroseconds() - begin);
  }
  std::vector<double> clock;
  for (std::size_t i = 0; i < ticks; ++i) {
    const double begin = nowMicroseconds();
    clock.push_back(nowMicroseconds() - begin);
  }
  print("reading the clock, part of each figure", &clock);
  print("tick, 64 contacts of anything", &full);
  print("tick, no contact", &empty);
  std::printf("%zu shapes of tissue, nearest %.1f mm\n", tissue.shapeCount(), 1e3 * least);
  print("distance to the tissue, tools that jump", &tissue_us);
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  const long thousands = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 200;
  return raven2_trainer::run(static_cast<std::size_t>(thousands > 0 ? thousands : 1) * 1000);
}
