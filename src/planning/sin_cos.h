#pragma once

#include <cstdint>
#include <cstring>

namespace raven2_trainer::planning {

/** Two doubles, of which compilers make one SSE2 register. */
using Pair = double __attribute__((vector_size(16)));
using PairBits = std::uint64_t __attribute__((vector_size(16)));

inline PairBits bitsOf(Pair x) noexcept {
  PairBits bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

inline Pair pairOf(PairBits bits) noexcept {
  Pair x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/**
 * Sine and cosine of two angles [rad], to 2e-16 for |x| < 1000: reduced by multiples of pi/2 in three parts (Cody and
 * Waite), then the polynomials of fdlibm's __kernel_sin and __kernel_cos (Sun Microsystems 1993). The same bits on
 * every x86-64, which the C library's, chosen by the processor, are not.
 */
inline void sinCos(Pair x, Pair* sine, Pair* cosine) noexcept {
  constexpr double kRound = 6755399441055744.0;  // 1.5 x 2^52: adding it leaves the nearest integer in the last bits
  const Pair shifted = x * 6.36619772367581382433e-01 + kRound;
  const PairBits quarter = bitsOf(shifted);
  const Pair n = shifted - kRound;
  const Pair r =
      ((x - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11) - n * 2.02226624879595063154e-21;
  const Pair z = r * r;
  const Pair ps =
      -1.66666666666666324348e-01 +
      z * (8.33333333332248946124e-03 +
           z * (-1.98412698298579493134e-04 +
                z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))));
  const Pair pc =
      4.16666666666666019037e-02 +
      z * (-1.38888888888741095749e-03 +
           z * (2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 +
                                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
  const PairBits s = bitsOf(r + r * z * ps), c = bitsOf((1.0 - 0.5 * z) + z * z * pc);
  const PairBits odd = -(quarter & 1);  // all ones where sine and cosine change places
  *sine = pairOf(((s & ~odd) | (c & odd)) ^ ((quarter & 2) << 62));
  *cosine = pairOf(((c & ~odd) | (s & odd)) ^ (((quarter + 1) & 2) << 62));
}

}  // namespace raven2_trainer::planning
