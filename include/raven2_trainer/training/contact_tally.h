#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/scene_roles.h"

namespace raven2_trainer::training {

/** Class of a body of contact records. */
enum class BodyClass : std::uint8_t { kOther, kGoldTool, kGreenTool, kTower, kWire, kDome, kPlate, kObject };

/**
 * What each body is: links of an arm end in _L or _R (raven2.md 5.5); those of a scene by their roles, or, without a
 * role, by how their names begin: tower, peg, wire, rail, dome, base_plate, table, ring.
 * @param[in] names by the numbers of contact records. @param[in] roles of the scene; all empty: names alone.
 */
std::vector<BodyClass> classifyBodies(const std::vector<std::string>& names, const SceneRoles& roles);

/** The two parties of a touch. */
enum class Partner : std::uint8_t {
  kTower,       ///< a tool and a tower
  kWire,        ///< a tool and a wire
  kDome,        ///< a tool and the dome
  kPlate,       ///< a tool and plate or table
  kOther,       ///< a tool and another fixed part
  kOtherArm,    ///< the two arms
  kObject,      ///< a tool and a free body: taking it, too
  kObjectWire,  ///< a free body and a wire
};
constexpr std::size_t kPartnerCount = 8;
constexpr std::array<const char*, kPartnerCount> kPartnerNames{"tower", "wire",      "dome",   "plate",
                                                               "other", "other_arm", "object", "object_wire"};

struct Touches {
  std::uint64_t count{};  ///< onsets: of one tool and one body, parted for more than kTouchGap before
  Tick ticks{};           ///< [1 ms] with at least one, pauses in it included
};

constexpr Tick kTouchGap = 100;       ///< [ms] shorter pauses belong to one touch (sources.md 3.4)
constexpr double kTouchForce = 0.05;  ///< [N] less is no touch; ours: six times the weight of the ring (0.82 g)

/** Distribution of a force over the ticks that had any. */
struct ForceSummary {
  double peak{};      ///< [N]
  double p95{};       ///< [N] 95th percentile of the ticks with a force
  double impulse{};   ///< [Ns]
  Tick above{};       ///< [1 ms] above the limit
  Tick with_force{};  ///< [1 ms]
};

/** Builds a ForceSummary; 4 bytes a tick with a force. */
class ForceTally {
 public:
  explicit ForceTally(double limit) noexcept : limit_(limit) {}
  void add(double newton);
  ForceSummary summary() const;

 private:
  double limit_;
  std::vector<float> forces_;
  ForceSummary sum_{};
};

/** Counts contacts, fed in order of their ticks. */
class ContactTally {
 public:
  /** @param[in] force_limit [N] of what a tool may press on what is not carried. */
  ContactTally(std::vector<BodyClass> bodies, double force_limit);
  void add(const ContactRecord& record);

  std::array<Touches, kPartnerCount> touches() const noexcept { return touches_; }
  /** Of tools on fixed parts and each other, all contacts of a tick together. */
  ForceSummary force() const;

 private:
  static constexpr std::size_t kRemembered = 128;  // [1 ms] more than kTouchGap
  void count(Partner partner, std::uint16_t a, std::uint16_t b, Tick tick);
  BodyClass classOf(std::uint16_t body) const noexcept;

  std::vector<BodyClass> bodies_;
  std::array<Touches, kPartnerCount> touches_{};
  std::array<std::array<Tick, kRemembered>, kPartnerCount> counted_;  ///< the newest ticks in `touches_`, by remainder
  std::map<std::pair<std::uint16_t, std::uint16_t>, Tick> last_touch_;  ///< by tool or object, and what it met
  ForceTally force_;
  Tick force_tick_{-1};
  double tick_force_{0.0};  ///< [N] of force_tick_ so far
};

}  // namespace raven2_trainer::training
