#include "raven2_trainer/config/load_stream.h"

#include "axis_map.h"
#include "named_files.h"
#include "raven2_trainer/config/section.h"

namespace raven2_trainer::config {
namespace {

constexpr std::array<const char*, 2> kRotations{"quaternion", "counts"};
constexpr std::array<const char*, 2> kGrasps{"increment", "absolute"};
constexpr std::array<const char*, 2> kPedals{"as_sent", "waits_for_press"};

}  // namespace

StreamProfile loadStream(const std::string& path) {
  Section root = Section::fromFile(path);
  StreamProfile profile;
  profile.is_on = true;
  root.text("meaning");
  profile.axes = readAxes(root, "axes", /*may_mirror=*/true);
  profile.um_per_count = root.number("um_per_count", 0.001, 10'000);
  profile.turns_in_counts = root.choice("rotation", kRotations) == 1;
  profile.turn_per_count = root.number("turn_per_count", 1e-9, 1);
  profile.has_absolute_grasp = root.choice("grasp", kGrasps) == 1;
  profile.mrad_per_count = root.number("mrad_per_count", -100, 100);
  profile.waits_for_press = root.choice("pedal", kPedals) == 1;
  root.finish();
  return profile;
}

std::string streamFile(const std::string& folder, const std::string& name) {
  return name == "none" ? "" : namedFile(folder, name, "stream", {"none"});
}

}  // namespace raven2_trainer::config
