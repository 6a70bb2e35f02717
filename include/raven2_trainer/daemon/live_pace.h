#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "raven2_trainer/render/render_config.h"

namespace raven2_trainer::daemon {

/** How often, and how large, the live picture is drawn. */
struct LiveLevel {
  int fps{};       ///< [Hz]
  double scale{};  ///< [-] of the configured width and height
};

/**
 * Chooses the live picture's size and rate by what frames take. Where most frames of half a second take longer than
 * their period, it goes a level down: first the size (3/4, 1/2), then the rate (20, 15, 10 Hz), as far as the
 * configuration allows. A hand needs a picture that follows it more than a sharp one. So the size also goes down where,
 * in five half seconds in a row, one frame in eight takes longer than 1.2 periods, although most are in time. It goes
 * up by one level if, for `live_settle`, nearly every frame (for a higher rate: most) would have filled at most 85 % of
 * the period there. The time of a larger picture is estimated by its pixels, rather too long than too short. A constant
 * load thus never goes up to where it must come down from; one that changes does so less and less often, since each
 * fall soon after a rise doubles the wait for the next.
 *
 * Knows no clock: it is fed with durations. One thread; takes memory when constructed only.
 */
class LivePace {
 public:
  static constexpr double kWindow = 0.5;  ///< [s] of frames, at least kFewest, that are judged together
  static constexpr std::size_t kFewest = 5;
  static constexpr double kRoom = 0.85;     ///< [-] of the next level's period that a frame may fill
  static constexpr double kLongest = 60.0;  ///< [s] longest wait for the next rise; one that lasted so long was right

  explicit LivePace(const RenderConfig& config);

  /** After each frame that is as costly as those to come: a black one is not. @param[in] busy [s] that drawing and
   * handing it out took. @return whether the level changed. */
  bool add(double busy) noexcept;

  const LiveLevel& level() const noexcept { return levels_[now_]; }
  /** Levels below the configured; 0 none. */
  std::uint32_t lowered() const noexcept { return static_cast<std::uint32_t>(now_); }
  const std::vector<LiveLevel>& levels() const noexcept { return levels_; }  ///< the configured first
  /** [s] between frames. */
  double period() const noexcept { return 1.0 / level().fps; }

 private:
  bool judge() noexcept;
  void fall() noexcept;
  void rise() noexcept;
  bool isTooSlow() const noexcept;
  bool areManyLate() const noexcept;
  bool hasRoom() const noexcept;

  const double settle_;  // [s]
  std::vector<LiveLevel> levels_;
  std::size_t now_{0};
  std::vector<double> window_;  // [s] of its frames, sorted when judged
  double window_time_{0.0};     // [s]
  int late_windows_{0};         // of many late frames, in a row, at this level
  double calm_{0.0};            // [s] with room for the level above
  double wait_;                 // [s] of calm before the next rise
  bool is_on_trial_{false};     // it has risen, and not for long
  double risen_for_{0.0};       // [s]
};

}  // namespace raven2_trainer::daemon
