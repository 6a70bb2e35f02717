#include "raven2_trainer/control/operating_state.h"

namespace raven2_trainer::control {
namespace {

struct Transition {
  OperatingState from;
  StateCommand command;
  OperatingState to;
};

constexpr Transition kTransitions[] = {
    // clang-format off
    {OperatingState::kDisabled, StateCommand::kEnable,  OperatingState::kEnabled},
    {OperatingState::kDisabled, StateCommand::kDisable, OperatingState::kDisabled},
    {OperatingState::kEnabled,  StateCommand::kEnable,  OperatingState::kEnabled},
    {OperatingState::kEnabled,  StateCommand::kDisable, OperatingState::kDisabled},
    {OperatingState::kEnabled,  StateCommand::kPause,   OperatingState::kPaused},
    {OperatingState::kPaused,   StateCommand::kDisable, OperatingState::kDisabled},
    {OperatingState::kPaused,   StateCommand::kPause,   OperatingState::kPaused},
    {OperatingState::kPaused,   StateCommand::kResume,  OperatingState::kEnabled},
    {OperatingState::kFault,    StateCommand::kEnable,  OperatingState::kEnabled},   // tries
    {OperatingState::kFault,    StateCommand::kDisable, OperatingState::kDisabled},  // tries
    // clang-format on
};

}  // namespace

std::optional<OperatingState> nextState(OperatingState state, StateCommand command) noexcept {
  for (const Transition& row : kTransitions) {
    if (row.from == state && row.command == command) return row.to;
  }
  return std::nullopt;
}

}  // namespace raven2_trainer::control
