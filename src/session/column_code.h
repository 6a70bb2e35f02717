#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// A column is the same number of many records of one kind, oldest first. From one tick to the next a number changes
// little, and its change changes little. So a column is kept as differences of some order, small numbers whose high
// bytes are zero; and byte by byte, all lowest bytes first, so that a compressor meets these zeros together. Everything
// is integer arithmetic modulo 2^bits: exact for any value, NaN included, and the same on every machine.

namespace raven2_trainer::session {

/** How many bytes a number has, and whether it is floating-point. A byte in the log: bit 7 and the width. */
class ColumnForm {
 public:
  static constexpr std::uint8_t kFloatBit = 0x80;

  explicit constexpr ColumnForm(std::uint8_t code) noexcept : code_(code) {}

  constexpr std::size_t width() const noexcept { return code_ & 0x0FU; }
  constexpr bool isFloat() const noexcept { return (code_ & kFloatBit) != 0; }
  /** Whole numbers of 1, 2, 4 and 8 bytes, and double. */
  constexpr bool isValid() const noexcept {
    const std::size_t w = width();
    return (code_ & 0x70U) == 0 && (w == 1 || w == 2 || w == 4 || w == 8) && (!isFloat() || w == 8);
  }

 private:
  std::uint8_t code_;
};

constexpr std::uint8_t kMostDifferences = 4;  ///< a fifth order made no column of a session smaller (measured)

/** How a column is kept, a byte in the log. Bits 0 to 6: order of its differences. Bit 7: a formula's results
 * (formula.h) are subtracted before. */
class ColumnCoding {
 public:
  static constexpr std::uint8_t kFormulaBit = 0x80;

  explicit constexpr ColumnCoding(std::uint8_t code) noexcept : code_(code) {}

  constexpr std::uint8_t order() const noexcept { return code_ & 0x7FU; }
  constexpr bool hasFormula() const noexcept { return (code_ & kFormulaBit) != 0; }

 private:
  std::uint8_t code_;
};

/** How a column of a chunk is to be kept. */
struct ColumnChoice {
  std::uint8_t code;  ///< ColumnCoding
  bool is_constant;
};

/** One number of each of many records. */
struct ColumnView {
  ColumnForm form;
  const std::uint8_t* values;  ///< the first, `form.width()` bytes
  std::size_t stride;          ///< [bytes] from one to the next
  std::size_t rows;
  const double* predicted;  ///< a formula's results for doubles, or null
};

/** Works on one column after the other; keeps its memory. */
class ColumnCoder {
 public:
  /** Takes the memory for columns of so many rows. */
  void reserve(std::size_t rows);
  /** @return the coding that makes a sample smallest. It subtracts the formula's results if that helps. */
  ColumnChoice choose(const ColumnView& column);
  /** @param[out] planes `form.width()` planes of `rows` bytes, lowest first, `plane_stride` [bytes] apart. */
  void encode(const ColumnView& column, ColumnChoice choice, std::uint8_t* planes, std::size_t plane_stride);
  /** The reverse. Of a column with a formula, `values` are differences: addFormula() completes them. */
  void decode(ColumnForm form,
              std::uint8_t code,
              const std::uint8_t* planes,
              std::size_t plane_stride,
              std::size_t rows,
              std::uint8_t* values,
              std::size_t stride);

 private:
  void read(const ColumnView& column, std::size_t first, std::size_t count);
  void subtract(const double* predicted) noexcept;

  std::vector<std::uint64_t> numbers_;  // of a column; in encode() only the first if all are equal
};

/** Adds a formula's results to the differences of one column. */
void addFormula(const double* predicted, std::size_t rows, std::uint8_t* values, std::size_t stride) noexcept;

}  // namespace raven2_trainer::session
