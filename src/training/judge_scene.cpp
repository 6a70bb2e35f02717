#include "training/judge_scene.h"

#include <algorithm>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::training {
namespace {

using Names = std::vector<std::string>;

std::string join(const Names& names) {
  std::string all;
  for (const std::string& name : names)
    all += (all.empty() ? "" : ", ") + name;
  return all;
}

/** Number of a body; `place` begins the message if it is missing. */
std::uint16_t numberOf(const Names& names, const std::string& name, const std::string& place) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw ConfigException(place + " names \"" + name + "\", which is no body; there are: " + join(names));
  return static_cast<std::uint16_t>(found - names.begin());
}

/** Index in the list of free bodies. */
std::uint8_t slotOf(const model::SceneModel& scene, const SceneObject& object, const std::string& place) {
  for (std::size_t i = 0; i < scene.free_bodies.size(); ++i) {
    const auto link = static_cast<std::size_t>(scene.free_bodies[i]);
    if (scene.description.links[link].name == object.link) return static_cast<std::uint8_t>(i);
  }
  throw ConfigException(place + " object \"" + object.name + "\": link \"" + object.link + "\" is no free body of " +
                        scene.description.file);
}

void markArms(const Names& names, JudgeScene* s) {
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    for (std::size_t k = 0; k < kArmLinkStems.size(); ++k) {
      const auto found = std::find(names.begin(), names.end(), std::string(kArmLinkStems[k]) + kArmLinkEndings[arm]);
      if (found == names.end()) continue;  // a link that collides with nothing
      JudgedBody& body = s->bodies[static_cast<std::size_t>(found - names.begin())];
      body.arm = static_cast<std::uint8_t>(arm);
      body.is_fixed = 0;
      body.owner = static_cast<std::uint16_t>(arm);
      const std::size_t first_jaw = kArmLinkStems.size() - 2;
      if (k >= first_jaw) body.jaw = static_cast<std::uint8_t>(k - first_jaw);
    }
  }
}

void markObjects(const SceneRoles& roles, const model::SceneModel& scene, const Names& names, JudgeScene* s) {
  const std::string place = roles.file + ":1:";
  for (const int link : scene.free_bodies) {
    const std::string& name = scene.description.links[static_cast<std::size_t>(link)].name;
    s->bodies[numberOf(names, name, place)].is_fixed = 0;
  }
  for (const SceneObject& object : roles.objects) {
    const JudgedObject judged{numberOf(names, object.link, place), slotOf(scene, object, place)};
    s->bodies[judged.body].object = static_cast<std::uint8_t>(s->objects.size());
    s->objects.push_back(judged);
  }
  s->first_breakable = static_cast<std::uint8_t>(scene.free_bodies.size());
  for (const SceneBreakable& breakable : roles.breakables)
    s->breakables.push_back(numberOf(names, breakable.link, place));
}

void markRules(const Exercise& exercise, const Names& names, JudgeScene* s) {
  for (std::size_t r = 0; r < exercise.rules.size(); ++r) {
    const WatchRule& rule = exercise.rules[r];
    const auto bit = static_cast<std::uint16_t>(1U << r);
    for (const std::string& name : rule.names_a)
      s->bodies[numberOf(names, name, rule.place_a)].in_a |= bit;
    for (const std::string& name : rule.names_b)
      s->bodies[numberOf(names, name, rule.place_b)].in_b |= bit;
  }
}

}  // namespace

JudgeScene resolveScene(const Exercise& exercise,
                        const SceneRoles& roles,
                        const model::SceneModel& scene,
                        const std::vector<std::string>& body_names) {
  JudgeScene s;
  s.bodies.resize(body_names.size());
  for (std::size_t i = 0; i < s.bodies.size(); ++i)
    s.bodies[i].owner = static_cast<std::uint16_t>(kArmCount + i);
  markArms(body_names, &s);
  markObjects(roles, scene, body_names, &s);
  markRules(exercise, body_names, &s);
  return s;
}

}  // namespace raven2_trainer::training
