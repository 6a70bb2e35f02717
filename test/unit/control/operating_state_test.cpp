#include "raven2_trainer/control/operating_state.h"

#include <gtest/gtest.h>

#include <string>

namespace raven2_trainer::control {
namespace {

// api-operating-state.rst as a grid: a line a state, a column each of enable, disable, pause, resume. D, E, P: the
// state after it; a dash: invalid, the state stays.
constexpr const char* kPublished[] = {
    "ED--",  // DISABLED
    "EDP-",  // ENABLED
    "-DPE",  // PAUSED
    "ED--",  // FAULT
};

char letter(OperatingState state) {
  return kOperatingStateNames[static_cast<std::size_t>(state)][0];
}

TEST(OperatingState, FollowsThePublishedTable) {
  for (std::size_t s = 0; s < kOperatingStateCount; ++s) {
    std::string row;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto next = nextState(static_cast<OperatingState>(s), static_cast<StateCommand>(c));
      row += next ? letter(*next) : '-';
    }
    EXPECT_EQ(row, kPublished[s]) << kOperatingStateNames[s];
  }
}

TEST(OperatingState, NoCommandLeadsIntoFault) {
  for (std::size_t s = 0; s < kOperatingStateCount; ++s) {
    for (std::size_t c = 0; c < kStateCommandCount; ++c) {
      const auto next = nextState(static_cast<OperatingState>(s), static_cast<StateCommand>(c));
      EXPECT_NE(next.value_or(OperatingState::kDisabled), OperatingState::kFault) << s << " " << c;
    }
  }
}

TEST(OperatingState, HomingIsNoneOfItsBusiness) {
  for (std::size_t s = 0; s < kOperatingStateCount; ++s) {
    EXPECT_FALSE(nextState(static_cast<OperatingState>(s), StateCommand::kHome));
    EXPECT_FALSE(nextState(static_cast<OperatingState>(s), StateCommand::kUnhome));
  }
}

}  // namespace
}  // namespace raven2_trainer::control
