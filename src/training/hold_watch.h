#pragma once

#include <array>
#include <cstdint>

#include "training/judge_scene.h"

namespace raven2_trainer::training {

constexpr double kPress = 0.05;        ///< [N] of each jaw: well above what the objects weigh (8 mN)
constexpr std::int32_t kHoldOn = 20;   ///< [ticks] pressed for so long: held
constexpr std::int32_t kHoldOff = 50;  ///< [ticks] not pressed for so long: no longer held

/** Contacts of one object in one tick. */
struct ObjectContacts {
  PerArm<std::array<double, 2>> press{};  ///< [N] of each jaw
  PerArm<bool> arm{};                     ///< any link of the arm presses on it
  bool fixed{};                           ///< so does something that cannot move
  bool object{};                          ///< or another free body
};

/** Finds out which arm holds which object, from contacts alone. Real-time safe except for the constructor. */
class HoldWatch {
 public:
  explicit HoldWatch(const JudgeScene& scene) : scene_(scene) {}

  void clear() noexcept { holds_ = {}; }
  void observe(const ContactList& list) noexcept;

  bool held(std::size_t object, std::size_t arm) const noexcept { return holds_[object][arm].held; }
  bool held(std::size_t object) const noexcept { return held(object, 0) || held(object, 1); }
  /** Nothing but that arm touches it. */
  bool heldAlone(std::size_t object, std::size_t arm) const noexcept;
  /** Both arms hold it, and nothing else touches it. */
  bool heldByBothAlone(std::size_t object) const noexcept;
  bool touchedByArm(std::size_t object) const noexcept { return now_[object].arm[0] || now_[object].arm[1]; }
  const ObjectContacts& contacts(std::size_t object) const noexcept { return now_[object]; }

 private:
  struct Hold {
    bool held{};
    std::int32_t ticks{};  ///< in a row that speak against `held`
  };

  void add(const JudgedBody& on, const JudgedBody& by, double press) noexcept;

  const JudgeScene& scene_;
  std::array<ObjectContacts, kMaxSceneBodies> now_{};
  std::array<PerArm<Hold>, kMaxSceneBodies> holds_{};
};

}  // namespace raven2_trainer::training
