#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/loop/shared_state.h"
#include "ros/crtk/crtk_reader.h"

namespace raven2_trainer::ros_bridge {

/** Messages of CRTK clients: passed on, not understood, or lost. */
struct CrtkCounts {
  std::uint64_t passed_on{};  ///< to the physics loop, which applies or refuses each: ServoState
  std::uint64_t unread{};     ///< no command could be made of them
  std::uint64_t lost{};       ///< more at once than the ring holds
};

/** Brings commands to the physics loop, whose ring has this one producer. */
class CrtkInbox {
 public:
  /** @param[in] shared must outlive this. */
  explicit CrtkInbox(SharedState* shared) : shared_(*shared) {}

  /** One thread. @return why nothing was asked for; empty: it was. */
  std::string take(const CrtkAsked& asked);

  /** Any thread. */
  CrtkCounts counts() const noexcept;

 private:
  std::string pass(ServoCommand command);

  SharedState& shared_;
  std::uint32_t next_id_{0};
};

}  // namespace raven2_trainer::ros_bridge
