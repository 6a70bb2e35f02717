#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::training {

constexpr std::uint8_t kNoArm = 2;  ///< not an index of an arm

/** Meaning of a body in the contact list. */
struct JudgedBody {
  std::uint8_t arm{kNoArm};      ///< index of the arm it belongs to
  std::uint8_t jaw{kNoArm};      ///< 0 or 1: that jaw of the arm
  std::uint8_t object{kNobody};  ///< index in SceneRoles::objects
  std::uint8_t is_fixed{1};      ///< 1: neither arm nor free body; breakables too
  std::uint16_t owner{};         ///< same for all links of an arm, else its own
  std::uint16_t in_a{}, in_b{};  ///< bit r: of WatchRule r's names_a, names_b
};

/** Where an object is in the contact list and in ModelState::bodies. */
struct JudgedObject {
  std::uint16_t body{};
  std::uint8_t slot{};
};

/** The exercise's names turned into numbers, at set-up. */
struct JudgeScene {
  std::vector<JudgedBody> bodies;         ///< by number in the contact list
  std::vector<JudgedObject> objects;      ///< by index in SceneRoles::objects
  std::vector<std::uint16_t> breakables;  ///< numbers in the contact list, by index in SceneRoles::breakables
  std::uint8_t first_breakable{};         ///< slot in ModelState::bodies
};

/** @throw ConfigException for a name that is not there (exercise_judge.h). */
JudgeScene resolveScene(const Exercise& exercise,
                        const SceneRoles& roles,
                        const model::SceneModel& scene,
                        const std::vector<std::string>& body_names);

/** Of both bodies of a contact, from the force on the first: > 0 where they press on each other. [N] */
inline double pressOf(const Contact& c) noexcept {
  return c.f_W[0] * c.n_W[0] + c.f_W[1] * c.n_W[1] + c.f_W[2] * c.n_W[2];
}

}  // namespace raven2_trainer::training
