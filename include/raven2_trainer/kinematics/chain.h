#pragma once

#include <array>
#include <cmath>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/kinematics/eigen.h"

// Shared by forward() and inverse(): the constants of the chain and the walk along it. Real-time safe.

namespace raven2_trainer::kinematics {

/** An angle by its cosine and sine. */
struct Angle {
  double c{1.0}, s{0.0};
};

/** glibc's sincos() gives what its sin() and cos() give, in half the time. */
inline Angle angle(double radians) noexcept {
  Angle result;
  ::sincos(radians, &result.s, &result.c);
  return result;
}

/** Constants of the chain that differ between the arms (raven2.md 2.1, 2.2). */
struct Chain {
  Angle twist0, twist2;     // RotX before shoulder and insertion: 0 and 128 degrees gold, 180 and 52 green
  Angle theta3;             // fixed turn of the insertion frame: +90 gold, -90 green
  double offset1, offset2;  // [rad] joint to DH angle
  double sign;              // +1 gold, -1 green: sign of z in the inverse
};

constexpr Angle kLink12{0.25881904510252076235, 0.96592582628906828675};  // La12 = 75 degrees, r2_kinematics.h
constexpr Angle kLink23{0.61566147532565827967, 0.78801075360672195669};  // La23 = 52 degrees
constexpr Angle kQuarter{0.0, 1.0};
constexpr double kOffset5 = -kPi / 2;

constexpr std::array<Chain, kArmCount> kChains{
    Chain{{1.0, 0.0}, {-kLink23.c, kLink23.s}, {0.0, 1.0}, 205.0 * kDegree, kPi, 1.0},
    Chain{{-1.0, 0.0}, kLink23, {0.0, -1.0}, 25.0 * kDegree, 0.0, -1.0}};

/** A frame that walks along the chain: modified DH is RotX, TransX, RotZ, TransZ. */
struct Walker {
  Vector3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};  // axes in B
  Vector3 p{0.0, 0.0, 0.0};

  void link(const Angle& twist, const Angle& turn) noexcept {
    const Vector3 twisted_y = twist.c * y + twist.s * z;
    z = twist.c * z - twist.s * y;
    y = turn.c * twisted_y - turn.s * x;
    x = turn.c * x + turn.s * twisted_y;
  }
};

/** Orientation of frame 3, the shaft without its roll; its origin is that of B. */
inline Walker shaftFrame(const Chain& chain, const Angle& theta1, const Angle& theta2) noexcept {
  Walker frame;
  frame.link(chain.twist0, theta1);
  frame.link(kLink12, theta2);
  frame.link(chain.twist2, chain.theta3);
  return frame;
}

}  // namespace raven2_trainer::kinematics
