#include "column_code.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace raven2_trainer::session {
namespace {

constexpr std::uint64_t kSign = 1ULL << 63U;

/** Bits of a double as a number that grows with it. Its own inverse. */
std::uint64_t ordered(std::uint64_t bits) noexcept {
  return (bits & kSign) != 0 ? bits ^ ~kSign : bits;
}

/** A difference modulo 2^bits as a small number if it is near zero: 0, -1, 1, -2 become 0, 1, 2, 3. */
std::uint64_t folded(std::uint64_t difference, unsigned bits) noexcept {
  const unsigned up = 64 - bits;
  const std::uint64_t high = difference << up;  // its sign is that of the 64 bits
  const std::uint64_t sign = (high & kSign) != 0 ? ~0ULL : 0ULL;
  return ((high << 1U) ^ sign) >> up;
}

std::uint64_t unfolded(std::uint64_t number) noexcept {
  return (number >> 1U) ^ ((number & 1U) != 0 ? ~0ULL : 0ULL);
}

/** 0 to 64, without a branch. */
unsigned bitsOf(std::uint64_t number) noexcept {
  return 63U - static_cast<unsigned>(__builtin_clzll(number | 1U)) + (number != 0 ? 1U : 0U);
}

constexpr std::size_t kOrders = kMostDifferences + 1;

/** Differences of every order, number by number: each number less the one before it, and the same of these. */
class Differences {
 public:
  /** @return differences of orders 0 (the number itself) to kMostDifferences. */
  std::array<std::uint64_t, kOrders> next(std::uint64_t number) noexcept {
    std::array<std::uint64_t, kOrders> all{number};
    for (std::size_t k = 1; k < kOrders; ++k)
      all[k] = all[k - 1] - std::exchange(before_[k - 1], all[k - 1]);
    return all;
  }

 private:
  std::array<std::uint64_t, kMostDifferences> before_{};
};

std::uint64_t bitsOfDouble(double value) noexcept {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

/** The order whose differences have the fewest bits in all, as far as a part of the column shows it. */
ColumnChoice bestOrder(const std::vector<std::uint64_t>& numbers, unsigned bits) noexcept {
  constexpr std::size_t kLookedAt = 64;  // in the middle: 160 save 0.01 % (measured)
  const std::size_t rows = std::min(numbers.size(), kLookedAt), first = (numbers.size() - rows) / 2;
  std::array<std::uint64_t, kOrders> cost{};
  Differences differences;
  for (std::size_t i = first; i < first + rows; ++i) {
    const auto all = differences.next(numbers[i]);
    cost[0] += bitsOf(all[0]);
    for (std::size_t k = 1; k < kOrders; ++k)
      cost[k] += bitsOf(folded(all[k], bits));
  }
  std::size_t best = 0;
  for (std::size_t k = 1; k < kOrders; ++k) {
    // A higher order has to earn its place: with it, an error of the machine's last bit grows.
    if (cost[k] + cost[k] / 64 < cost[best]) best = k;
  }
  return {static_cast<std::uint8_t>(best), cost[best]};
}

/** n[i] - n[i - 1], of the first the number itself. */
void subtractBefore(std::vector<std::uint64_t>* numbers) noexcept {
  std::uint64_t before = 0;
  for (std::uint64_t& number : *numbers)
    number -= std::exchange(before, number);
}

void sum(std::vector<std::uint64_t>* numbers) noexcept {
  for (std::size_t i = 1; i < numbers->size(); ++i)
    (*numbers)[i] += (*numbers)[i - 1];
}

/** One number of each record. */
template <typename Word>
class Rows {
 public:
  Rows(const std::uint8_t* values, std::size_t stride, std::size_t rows) noexcept
      : values_(values), stride_(stride), rows_(rows) {}

  Word operator[](std::size_t i) const noexcept {
    Word word;
    std::memcpy(&word, values_ + i * stride_, sizeof(word));
    return word;
  }

  bool areEqual() const noexcept {
    for (std::size_t i = 1; i < rows_; ++i) {
      if ((*this)[i] != (*this)[0]) return false;
    }
    return true;
  }

  /** All of them, or only the first if the others are equal to it. */
  void read(std::vector<std::uint64_t>* numbers) const {
    numbers->resize(areEqual() ? std::min<std::size_t>(rows_, 1) : rows_);
    for (std::size_t i = 0; i < numbers->size(); ++i)
      (*numbers)[i] = (*this)[i];
  }

 private:
  const std::uint8_t* values_;
  std::size_t stride_, rows_;
};

}  // namespace

void ColumnCoder::read(ColumnForm form, const std::uint8_t* values, std::size_t stride, std::size_t rows) {
  switch (form.width()) {
    case 1:
      Rows<std::uint8_t>(values, stride, rows).read(&numbers_);
      break;
    case 2:
      Rows<std::uint16_t>(values, stride, rows).read(&numbers_);
      break;
    case 4:
      Rows<std::uint32_t>(values, stride, rows).read(&numbers_);
      break;
    default:
      Rows<std::uint64_t>(values, stride, rows).read(&numbers_);
      break;
  }
  if (form.isFloat()) std::transform(numbers_.begin(), numbers_.end(), numbers_.begin(), ordered);
}

std::uint8_t ColumnCoder::encode(ColumnForm form,
                                 const std::uint8_t* values,
                                 std::size_t stride,
                                 std::size_t rows,
                                 const double* predicted,
                                 std::uint8_t* planes,
                                 std::size_t plane_stride) {
  const auto bits = static_cast<unsigned>(8 * form.width());
  read(form, values, stride, rows);
  // Most numbers of a tick do not change for seconds: one number, and then differences of zero.
  const bool is_constant = numbers_.size() <= 1, is_zero = numbers_.empty() || numbers_[0] == 0;
  const ColumnChoice best =
      is_constant ? ColumnChoice{static_cast<std::uint8_t>(is_zero ? 0 : 1), 0} : bestOrder(numbers_, bits);
  const ColumnChoice other = predicted != nullptr && !is_constant ? bestWith(predicted) : best;
  const bool has_formula = other.cost < best.cost;
  if (has_formula) numbers_.swap(residuals_);
  const std::uint8_t order = has_formula ? other.order : best.order;
  for (std::uint8_t k = 0; k < order; ++k)
    subtractBefore(&numbers_);
  if (order > 0) {
    for (std::uint64_t& number : numbers_)
      number = folded(number, bits);
  }
  for (std::size_t b = 0; b < form.width(); ++b) {
    std::uint8_t* plane = planes + b * plane_stride;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      plane[i] = static_cast<std::uint8_t>(numbers_[i] >> (8 * b));
    std::fill(plane + numbers_.size(), plane + rows, std::uint8_t{0});
  }
  return has_formula ? order | ColumnCoding::kFormulaBit : order;
}

ColumnChoice ColumnCoder::bestWith(const double* predicted) {
  residuals_.resize(numbers_.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    residuals_[i] = numbers_[i] - ordered(bitsOfDouble(predicted[i]));
  return bestOrder(residuals_, 64);
}

void ColumnCoder::decode(ColumnForm form,
                         std::uint8_t code,
                         const std::uint8_t* planes,
                         std::size_t plane_stride,
                         std::size_t rows,
                         std::uint8_t* values,
                         std::size_t stride) {
  const std::size_t width = form.width();
  const std::uint8_t order = ColumnCoding(code).order();
  const bool is_ordered = form.isFloat() && !ColumnCoding(code).hasFormula();
  numbers_.assign(rows, 0);
  for (std::size_t b = 0; b < width; ++b) {
    const std::uint8_t* plane = planes + b * plane_stride;
    for (std::size_t i = 0; i < rows; ++i)
      numbers_[i] |= static_cast<std::uint64_t>(plane[i]) << (8 * b);
  }
  if (order > 0) std::transform(numbers_.begin(), numbers_.end(), numbers_.begin(), unfolded);
  for (std::uint8_t k = 0; k < order; ++k)
    sum(&numbers_);
  for (std::size_t i = 0; i < rows; ++i) {
    const std::uint64_t bits = is_ordered ? ordered(numbers_[i]) : numbers_[i];
    std::memcpy(values + i * stride, &bits, width);
  }
}

void addFormula(const double* predicted, std::size_t rows, std::uint8_t* values, std::size_t stride) noexcept {
  for (std::size_t i = 0; i < rows; ++i) {
    std::uint64_t number = 0;
    std::memcpy(&number, values + i * stride, sizeof(number));
    number = ordered(number + ordered(bitsOfDouble(predicted[i])));
    std::memcpy(values + i * stride, &number, sizeof(number));
  }
}

}  // namespace raven2_trainer::session
