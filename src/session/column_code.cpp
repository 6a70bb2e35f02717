#include "column_code.h"

#include <algorithm>
#include <cstring>

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

unsigned bitsOf(std::uint64_t number) noexcept {
  return number == 0 ? 0U : 64U - static_cast<unsigned>(__builtin_clzll(number));
}

/** In place, from the end: each number less the one before it; the first stays. */
void difference(std::vector<std::uint64_t>* numbers) noexcept {
  for (std::size_t i = numbers->size(); i-- > 1;)
    (*numbers)[i] -= (*numbers)[i - 1];
}

void sum(std::vector<std::uint64_t>* numbers) noexcept {
  for (std::size_t i = 1; i < numbers->size(); ++i)
    (*numbers)[i] += (*numbers)[i - 1];
}

}  // namespace

std::uint8_t ColumnCoder::encode(ColumnForm form,
                                 const std::uint8_t* values,
                                 std::size_t stride,
                                 std::size_t rows,
                                 std::uint8_t* planes,
                                 std::size_t plane_stride) {
  const std::size_t width = form.width();
  const auto bits = static_cast<unsigned>(8 * width);
  differences_.assign(rows, 0);
  best_.resize(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    std::memcpy(&differences_[i], values + i * stride, width);
    if (form.isFloat()) differences_[i] = ordered(differences_[i]);
  }
  std::uint8_t chosen = 0;
  std::uint64_t least = 0;
  for (std::uint8_t order = 0; order <= kMostDifferences; ++order) {
    if (order > 0) difference(&differences_);
    std::uint64_t cost = 0;
    for (const std::uint64_t d : differences_)
      cost += bitsOf(order == 0 ? d : folded(d, bits));
    // A higher order has to earn its place: with it, an error of the machine's last bit grows.
    if (order > 0 && cost + cost / 64 >= least) continue;
    least = cost;
    chosen = order;
    std::transform(differences_.begin(), differences_.end(), best_.begin(),
                   [&](std::uint64_t d) { return order == 0 ? d : folded(d, bits); });
  }
  for (std::size_t b = 0; b < width; ++b) {
    std::uint8_t* plane = planes + b * plane_stride;
    for (std::size_t i = 0; i < rows; ++i)
      plane[i] = static_cast<std::uint8_t>(best_[i] >> (8 * b));
  }
  return chosen;
}

void ColumnCoder::decode(ColumnForm form,
                         std::uint8_t order,
                         const std::uint8_t* planes,
                         std::size_t plane_stride,
                         std::size_t rows,
                         std::uint8_t* values,
                         std::size_t stride) {
  const std::size_t width = form.width();
  best_.assign(rows, 0);
  for (std::size_t b = 0; b < width; ++b) {
    const std::uint8_t* plane = planes + b * plane_stride;
    for (std::size_t i = 0; i < rows; ++i)
      best_[i] |= static_cast<std::uint64_t>(plane[i]) << (8 * b);
  }
  if (order > 0) std::transform(best_.begin(), best_.end(), best_.begin(), unfolded);
  for (std::uint8_t k = 0; k < order; ++k)
    sum(&best_);
  for (std::size_t i = 0; i < rows; ++i) {
    const std::uint64_t bits = form.isFloat() ? ordered(best_[i]) : best_[i];
    std::memcpy(values + i * stride, &bits, width);
  }
}

}  // namespace raven2_trainer::session
