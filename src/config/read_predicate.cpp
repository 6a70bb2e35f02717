#include "config/read_predicate.h"

#include <algorithm>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

/** Index of the part called `name`, the value of `key`. */
template <typename Part>
std::uint8_t indexOf(const Section& section,
                     const std::string& key,
                     const std::string& name,
                     const std::vector<Part>& parts,
                     const std::string& what) {
  std::string known;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].name == name) return static_cast<std::uint8_t>(i);
    known += (i == 0 ? "" : ", ") + parts[i].name;
  }
  throw ConfigException(section.where(key) + " is \"" + name.substr(0, 80) + "\", which is no " + what +
                        " of the scene; " + (known.empty() ? "the scene has no such part" : "there are: " + known));
}

bool isOfObject(PredicateKind kind) {
  switch (kind) {
    case PredicateKind::kTipNear:
    case PredicateKind::kTipInside:
    case PredicateKind::kTipOutside:
    case PredicateKind::kInView:
    case PredicateKind::kCameraNear:
      return false;
    default:
      return true;
  }
}

bool isYesOrNo(PredicateKind kind) {
  return kind == PredicateKind::kUntouched || kind == PredicateKind::kLifted || kind == PredicateKind::kResting;
}

PredicateKind readKind(const Section& entry, const std::string& place) {
  std::string known;
  int found = 0;
  PredicateKind kind{};
  for (std::size_t i = 0; i < kPredicateNames.size(); ++i) {
    known += (i == 0 ? "" : ", ") + std::string(kPredicateNames[i]);
    if (!entry.has(kPredicateNames[i])) continue;
    kind = static_cast<PredicateKind>(i);
    ++found;
  }
  if (found == 1) return kind;
  throw ConfigException(place + (found == 0 ? " holds none of: " : " holds more than one of: ") + known);
}

Hand readHand(Section& entry, const std::string& key) {
  return static_cast<Hand>(entry.choice(key, kHandNames));
}

/** A point, and the largest distance [m] from it. */
void readNear(Section& entry, const std::string& key, const SceneRoles& roles, double least, Predicate* p) {
  p->place = readPoint(entry, key, roles);
  p->value = entry.number("within", least, 1);
}

void readValue(Section& entry, const std::string& key, const SceneRoles& roles, Predicate* p) {
  switch (p->kind) {
    case PredicateKind::kHeld:
    case PredicateKind::kHeldAlone:
      p->hand = readHand(entry, key);
      return;
    case PredicateKind::kUntouched:
    case PredicateKind::kLifted:
    case PredicateKind::kResting:
      p->negated = entry.boolean(key) ? 0 : 1;
      return;
    case PredicateKind::kAround:
      p->place = readPeg(entry, key, roles);
      return;
    case PredicateKind::kAt:
      return readNear(entry, key, roles, 0.0001, p);
    case PredicateKind::kTipNear:
      p->hand = readHand(entry, "arm");
      return readNear(entry, key, roles, 0.0001, p);
    case PredicateKind::kTipInside:
    case PredicateKind::kTipOutside:
      p->place = indexOf(entry, key, entry.text(key), roles.regions, "region");
      p->hand = readHand(entry, "arm");
      return;
    case PredicateKind::kAlong:
      p->place = indexOf(entry, key, entry.text(key), roles.wires, "wire");
      p->value = entry.number("to", 0.01, 1);
      return;
    case PredicateKind::kUnthreaded:
      p->place = indexOf(entry, key, entry.text(key), roles.wires, "wire");
      return;
    case PredicateKind::kInView:
      return readNear(entry, key, roles, 0.01, p);
    case PredicateKind::kCameraNear:
      p->place = readPoint(entry, key, roles);
      p->value = entry.number("within", 0.001, 2);
      return;
  }
}

/** An object that goes over pegs and wires needs an opening. */
void checkOpening(const Section& entry, const std::string& key, const SceneRoles& roles, const Predicate& p) {
  const bool needs =
      p.kind == PredicateKind::kAround || p.kind == PredicateKind::kAlong || (p.kind == PredicateKind::kUnthreaded);
  if (!needs || roles.objects[p.object].inner_radius > 0.0) return;
  throw ConfigException(entry.where(key) + " is for an object with an opening, which " + roles.objects[p.object].name +
                        " has not");
}

}  // namespace

std::uint8_t readObject(Section& section, const std::string& key, const SceneRoles& roles) {
  return indexOf(section, key, section.text(key), roles.objects, "object");
}

std::uint8_t readPeg(Section& section, const std::string& key, const SceneRoles& roles) {
  return indexOf(section, key, section.text(key), roles.pegs, "peg");
}

std::uint8_t readPoint(Section& section, const std::string& key, const SceneRoles& roles) {
  return indexOf(section, key, section.text(key), roles.points, "point");
}

std::vector<std::uint8_t> readPegs(Section& section, const std::string& key, const SceneRoles& roles) {
  std::vector<std::uint8_t> pegs;
  for (const std::string& name : section.texts(key)) {
    const std::uint8_t peg = indexOf(section, key, name, roles.pegs, "peg");
    if (std::find(pegs.begin(), pegs.end(), peg) != pegs.end())
      throw ConfigException(section.where(key) + " names " + name + " twice");
    pegs.push_back(peg);
  }
  return pegs;
}

Predicate readPredicate(Section& entry, const SceneRoles& roles, std::uint8_t object) {
  Predicate p;
  p.kind = readKind(entry, entry.where(""));
  const std::string key = kPredicateNames[static_cast<std::size_t>(p.kind)];
  readValue(entry, key, roles, &p);
  if (isOfObject(p.kind)) {
    p.object = entry.has("object") ? readObject(entry, "object", roles) : object;
    if (p.object == kNobody)
      throw ConfigException(entry.where(key) + " speaks of an object, and neither it nor the track names one");
    checkOpening(entry, key, roles, p);
  }
  if (!isYesOrNo(p.kind) && entry.has("not")) p.negated = entry.boolean("not") ? 1 : 0;
  entry.finish();
  return p;
}

std::vector<Predicate> readPredicates(Section& section,
                                      const std::string& key,
                                      const SceneRoles& roles,
                                      std::uint8_t object) {
  std::vector<Section> entries = section.list(key);
  if (entries.empty() || entries.size() > kMaxPredicates) {
    throw ConfigException(section.where(key) + " has " + std::to_string(entries.size()) + " entries, expected 1 to " +
                          std::to_string(kMaxPredicates));
  }
  std::vector<Predicate> predicates;
  for (Section& entry : entries)
    predicates.push_back(readPredicate(entry, roles, object));
  return predicates;
}

}  // namespace raven2_trainer::config
