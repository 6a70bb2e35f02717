#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "raven2_trainer/core/bytes.h"
#include "raven2_trainer/core/types.h"

// Some numbers of a tick follow from others: tips from joints, joints from rates or motors, torques from the control
// law. A chunk keeps such a number as its difference to a formula's result, most often a few units in
// the last place. The formulas are part of the log's format (doc/session.md, Formulas): every reader has to get the
// same bits. So they consist only of sums, products, quotients, square roots, rounding and a series for sine and
// cosine, in a fixed order, and use no other code of the trainer. If that code changes, logs become larger, never
// wrong.

namespace raven2_trainer::session {

/** The numbers are in logs. */
enum class FormulaKind : std::uint8_t {
  kRobot = 1,    ///< joints and rates of both arms from the motors: cable coupling, and the robot's low pass
  kPositions,    ///< joints from their rates
  kControl,      ///< torques from set points, joints and rates
  kTip,          ///< place and velocity of the tip from joints and rates
  kOrientation,  ///< its quaternion from the joints
};

/** Columns side by side: those that a formula needs, or those that it gives. */
struct FormulaBlock {
  std::uint8_t width{};
  bool is_result{};
};

constexpr std::size_t kMostFormulas = 16;       ///< of a group
constexpr std::size_t kMostFormulaRows = 1000;  ///< records of a group with formulas; limits a hostile log's time

struct FormulaTraits {
  std::array<FormulaBlock, 7> blocks{};
  std::size_t block_count{};
  std::size_t numbers{};  ///< constants
};

/** @return nullptr for no kind. */
const FormulaTraits* traitsOf(FormulaKind kind) noexcept;

struct Formula {
  FormulaKind kind{};
  std::vector<std::uint16_t> columns;  ///< the first of each block
  std::vector<double> numbers;

  void append(std::vector<std::uint8_t>* bytes) const;
  /** @return false for what no writer makes. */
  bool read(ByteReader* in);
};

/** Records of one type, one after the other. */
struct RecordView {
  const std::uint8_t* rows;
  std::size_t stride;  ///< [bytes] of a record
  std::size_t count;
  const std::size_t* offsets;  ///< [bytes] in the record, of each column

  template <typename T>
  T get(std::size_t column, std::size_t row) const noexcept {
    T value;
    std::memcpy(&value, rows + row * stride + offsets[column], sizeof(value));
    return value;
  }
  JointArray joints(std::size_t column, std::size_t row) const noexcept { return get<JointArray>(column, row); }
};

/** The robot's filter of the motors' rates (raven/low_pass.h), from one record to the next. */
struct MotorFilter {
  std::array<JointArray, 3> x{}, y{};  ///< [rad/s] rates and filtered rates, newest first

  /** @param[in] cycles of the robot's control loop between the two: as many steps. */
  void advance(const JointArray& before, const JointArray& now, std::int64_t cycles) noexcept;
};

constexpr std::int64_t kMostCycles = 8;

/** Cycles of the robot's control loop between two counts, limited to 0 to kMostCycles. */
std::int64_t cyclesBetween(std::int64_t before, std::int64_t now) noexcept;

/** The formula's results, column by column; 0 in place of one that is not finite. Its columns must be in the record. */
void evaluate(const Formula& formula, const RecordView& records, std::vector<double>* results);

/** Calls `use` with each column that the formula gives, and its place among these. */
template <typename Use>
void forResults(const Formula& formula, const Use& use) {
  std::size_t place = 0;
  const auto& blocks = traitsOf(formula.kind)->blocks;
  for (std::size_t b = 0; b < formula.columns.size(); ++b) {
    for (std::size_t i = 0; blocks[b].is_result && i < blocks[b].width; ++i)
      use(formula.columns[b] + i, place++);
  }
}

}  // namespace raven2_trainer::session
