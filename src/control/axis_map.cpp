#include "raven2_trainer/control/axis_map.h"

namespace raven2_trainer::control {
namespace {

Matrix3 rows(double a, double b, double c, double d, double e, double f, double g, double h, double i) noexcept {
  Matrix3 m;
  m << a, b, c, d, e, f, g, h, i;
  return m;
}

}  // namespace

const Matrix3& itpToBase(Arm arm) noexcept {
  static const PerArm<Matrix3> maps{rows(0, 0, -1, -1, 0, 0, 0, 1, 0), rows(0, 0, -1, 1, 0, 0, 0, -1, 0)};
  return at(maps, arm);
}

}  // namespace raven2_trainer::control
