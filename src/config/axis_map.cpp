#include "axis_map.h"

#include <array>
#include <cmath>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

constexpr std::array<const char*, 3> kDirections{"forward", "right", "down"};

bool isSignedPermutation(const AxisMap& map) {
  for (std::size_t i = 0; i < 3; ++i) {
    int in_row = 0, in_column = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (map[i][k] != 0.0 && std::abs(map[i][k]) != 1.0) return false;
      in_row += map[i][k] != 0.0 ? 1 : 0;
      in_column += map[k][i] != 0.0 ? 1 : 0;
    }
    if (in_row != 1 || in_column != 1) return false;
  }
  return true;
}

}  // namespace

AxisMap readAxes(Section& root, const std::string& key, bool may_mirror) {
  Section s = root.section(key);
  AxisMap map{};
  for (std::size_t i = 0; i < 3; ++i)
    map[i] = s.vec3(kDirections[i], -1.0, 1.0);
  s.finish();
  if (!isSignedPermutation(map))
    throw ConfigException(root.where(key) + ": each direction needs one of the device's axes, 1 or -1, and none twice");
  if (!may_mirror && determinant(map) < 0.0)
    throw ConfigException(root.where(key) + " mirrors: both sides are right-handed, so one or three signs are wrong");
  return map;
}

}  // namespace raven2_trainer::config
