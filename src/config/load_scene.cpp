#include "raven2_trainer/config/load_scene.h"

#include <algorithm>
#include <filesystem>

#include "config/names.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

/** Names of the entries under `key`. */
std::vector<std::string> namesIn(Section& entries, const Section& root, const std::string& key, std::size_t most) {
  const std::vector<std::string> names = entries.keys();
  checkCount(root, key, names.size(), most);
  for (const std::string& name : names) {
    if (isName(name)) continue;
    throw ConfigException(entries.where(name) + ": a name has 1 to 32 letters a to z, digits or underscores");
  }
  return names;
}

/** Reads each entry of a mapping of mappings with read(section, name). */
template <typename Part, typename Read>
std::vector<Part> readParts(Section& root, const std::string& key, std::size_t most, const Read& read) {
  Section entries = root.section(key);
  std::vector<Part> parts;
  for (const std::string& name : namesIn(entries, root, key, most)) {
    Section entry = entries.section(name);
    parts.push_back(read(entry, name));
    entry.finish();
  }
  return parts;
}

/** Of one kind of role, a link has one. */
template <typename Part>
void checkLinks(const Section& root, const std::string& key, const std::vector<Part>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (parts[i].link != parts[j].link) continue;
      throw ConfigException(root.where(key) + " names link " + parts[i].link + " twice");
    }
  }
}

SceneObject readSceneObject(Section& entry, const std::string& name) {
  SceneObject object;
  object.name = name;
  object.link = entry.text("link");
  const std::string shape = entry.text("shape", {"round", "square", "solid"});
  object.square = shape == "square" ? 1 : 0;
  if (shape == "solid") return object;
  object.inner_radius = entry.number("inner_radius", 0.0005, 0.05);
  object.bar_radius = entry.number("bar_radius", 0.0002, 0.02);
  return object;
}

ScenePeg readScenePeg(Section& entry, const std::string& name) {
  ScenePeg peg;
  peg.name = name;
  peg.link = entry.text("link");
  peg.base_W = entry.vec3("base_W", -kFarthest, kFarthest);
  peg.height = entry.number("height", 0.001, 0.2);
  peg.radius = entry.number("radius", 0.0005, 0.05);
  return peg;
}

SceneWire readWire(Section& entry, const std::string& name) {
  SceneWire wire;
  wire.name = name;
  wire.link = entry.text("link");
  wire.radius = entry.number("radius", 0.0002, 0.02);
  wire.line_W = entry.points("line_W", 2, kMaxWirePoints, -kFarthest, kFarthest);
  const auto twice = std::adjacent_find(wire.line_W.begin(), wire.line_W.end());
  if (twice == wire.line_W.end()) return wire;
  throw ConfigException(entry.where("line_W") + " has point " + std::to_string(twice - wire.line_W.begin()) +
                        " twice in a row");
}

SceneBreakable readBreakable(Section& entry) {
  SceneBreakable part;
  part.link = entry.text("link");
  part.force = entry.number("force", 0.1, 100);
  part.moment = entry.number("moment", 0.001, 10);
  part.ticks = static_cast<std::int32_t>(entry.integer("ticks", 1, 1000));
  entry.finish();
  return part;
}

SceneRegion readRegion(Section& entry, const std::string& name) {
  SceneRegion region{name, entry.vec3("low_W", -kFarthest, kFarthest), entry.vec3("high_W", -kFarthest, kFarthest)};
  for (std::size_t i = 0; i < 3; ++i) {
    if (region.low_W[i] < region.high_W[i]) continue;
    throw ConfigException(entry.where("high_W") + "[" + std::to_string(i) + "] is not above low_W");
  }
  return region;
}

void readBreakables(Section& root, SceneRoles* roles) {
  for (Section& entry : root.list("breakables"))
    roles->breakables.push_back(readBreakable(entry));
  checkCount(root, "breakables", roles->breakables.size(), kMaxSceneBodies);
  checkLinks(root, "breakables", roles->breakables);
}

void readPoints(Section& root, SceneRoles* roles) {
  Section entries = root.section("points");
  for (const std::string& name : namesIn(entries, root, "points", kMaxSceneParts))
    roles->points.push_back({name, entries.vec3(name, -kFarthest, kFarthest)});
}

void readUrdf(Section& root, SceneRoles* roles) {
  const std::string folder = fs::absolute(root.file()).parent_path().string();
  const Neighbour urdf = neighbour(folder, root.text("urdf"), "config/scenes");
  std::error_code error;
  if (!fs::is_regular_file(urdf.path, error))
    throw ConfigException(root.where("urdf") + ": there is no file " + urdf.path);
  roles->urdf = urdf.path;
  roles->urdf_place = urdf.place;
}

}  // namespace

SceneRoles loadScene(const std::string& path) {
  Section root = Section::fromFile(path);
  SceneRoles roles;
  roles.name = fs::path(path).stem().string();
  roles.file = path;
  roles.title = root.text("title");
  readUrdf(root, &roles);
  roles.objects = readParts<SceneObject>(root, "objects", kMaxSceneBodies, readSceneObject);
  roles.pegs = readParts<ScenePeg>(root, "pegs", kMaxSceneParts, readScenePeg);
  roles.wires = readParts<SceneWire>(root, "wires", kMaxSceneParts, readWire);
  readBreakables(root, &roles);
  roles.tissue = root.texts("tissue");
  checkCount(root, "tissue", roles.tissue.size(), kMaxSceneParts);
  readPoints(root, &roles);
  roles.regions = readParts<SceneRegion>(root, "regions", kMaxSceneParts, readRegion);
  roles.parking = root.boolean("parking") ? 1 : 0;
  root.finish();
  checkLinks(root, "objects", roles.objects);
  checkCount(root, "breakables", roles.objects.size() + roles.breakables.size(), kMaxSceneBodies);
  return roles;
}

}  // namespace raven2_trainer::config
