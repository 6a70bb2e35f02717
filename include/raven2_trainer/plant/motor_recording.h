#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace raven2_trainer::plant {

/** Motors and commands of the positioning axes of a real gold arm, a row a millisecond. */
struct MotorRecording {
  struct Row {
    std::array<double, 3> position{};   ///< [rad] motor shaft
    std::array<double, 3> rate{};       ///< [rad/s] difference to the row before
    std::array<std::int16_t, 3> dac{};  ///< [counts] as sent to the board
  };
  std::vector<Row> rows;
};

/**
 * Reads a CSV file with the columns mpos1_deg, mpos2_deg, mpos3_deg, dac1, dac2, dac3 (others are skipped) in any
 * order. @throw ConfigException with FILE:LINE for a missing column, a value that is not a finite number or out of
 * range, or fewer than 200 rows.
 */
MotorRecording loadMotorRecording(const std::string& path);

}  // namespace raven2_trainer::plant
