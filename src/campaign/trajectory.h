#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/campaign/outcome.h"

namespace raven2_trainer::campaign {

/** A golden run, in memory that it shares with its forks: one process writes it, all others read it afterwards,
 * once it is sealed. */
class Trajectory {
 public:
  /** @param[in] capacity [ticks]. @throw Exception if there is no memory. */
  explicit Trajectory(std::size_t capacity);
  ~Trajectory();
  Trajectory(const Trajectory&) = delete;
  Trajectory& operator=(const Trajectory&) = delete;

  void add(const Sample& sample) noexcept;
  /** Nobody writes from here on, nor any fork made from here on: a run that writes astray ends, and spoils no other.
   *  @throw Exception if the system refuses. */
  void seal();
  void markPedalDown() noexcept { head_->pedal_down = size(); }

  /** After `tick` ticks of the run, from 0. */
  const Sample& at(std::int64_t tick) const noexcept { return samples_[tick]; }
  /** [ticks] samples there are. */
  std::int64_t size() const noexcept { return head_->size; }
  /** [ticks] that had passed when the robot was first in PEDAL_DN; kNever before. */
  std::int64_t pedalDown() const noexcept { return head_->pedal_down; }
  /** [ticks] that had passed when its control program or PLC stopped it, or the program ended; kNever if none did. */
  std::int64_t firstStop() const noexcept;
  bool isFull() const noexcept { return static_cast<std::size_t>(head_->size) == capacity_; }

 private:
  struct Head {
    std::int64_t size, pedal_down;
  };

  std::size_t capacity_, bytes_;
  Head* head_;
  Sample* samples_;
};

}  // namespace raven2_trainer::campaign
