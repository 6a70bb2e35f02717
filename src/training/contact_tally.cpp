#include "raven2_trainer/training/contact_tally.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace raven2_trainer::training {

namespace {

constexpr Tick kNever = std::numeric_limits<Tick>::min() / 2;
// Numbers for "any link of that arm", which no body has.
constexpr std::uint16_t kGoldLinks = 0xFFFE, kGreenLinks = 0xFFFD;

bool beginsWith(const std::string& name, const char* text) {
  return name.rfind(text, 0) == 0;
}

bool endsWith(const std::string& name, const std::string& text) {
  return name.size() >= text.size() && name.compare(name.size() - text.size(), text.size(), text) == 0;
}

template <typename Parts>
bool names(const Parts& parts, const std::string& link) {
  return std::any_of(parts.begin(), parts.end(), [&](const auto& part) { return part.link == link; });
}

std::optional<BodyClass> classByRole(const std::string& name, const SceneRoles& roles) {
  if (names(roles.objects, name)) return BodyClass::kObject;
  if (names(roles.pegs, name)) return BodyClass::kTower;
  if (names(roles.wires, name)) return BodyClass::kWire;
  return std::nullopt;
}

BodyClass classByName(const std::string& name) {
  const std::pair<const char*, BodyClass> kBeginnings[] = {
      {"tower", BodyClass::kTower}, {"peg", BodyClass::kTower},        {"wire", BodyClass::kWire},
      {"rail", BodyClass::kWire},   {"dome", BodyClass::kDome},        {"base_plate", BodyClass::kPlate},
      {"table", BodyClass::kPlate}, {"ring_stand", BodyClass::kOther}, {"ring", BodyClass::kObject}};
  for (const auto& [text, body_class] : kBeginnings) {
    if (beginsWith(name, text)) return body_class;
  }
  return BodyClass::kOther;
}

bool isTool(BodyClass body) {
  return body == BodyClass::kGoldTool || body == BodyClass::kGreenTool;
}

Partner partnerOf(BodyClass body) {
  switch (body) {
    case BodyClass::kTower:
      return Partner::kTower;
    case BodyClass::kWire:
      return Partner::kWire;
    case BodyClass::kDome:
      return Partner::kDome;
    case BodyClass::kPlate:
      return Partner::kPlate;
    case BodyClass::kObject:
      return Partner::kObject;
    case BodyClass::kGoldTool:
    case BodyClass::kGreenTool:
      return Partner::kOtherArm;
    case BodyClass::kOther:
      break;
  }
  return Partner::kOther;
}

/** All links of an arm are one: a touch goes on from one link to the next. */
std::uint16_t asOne(BodyClass body, std::uint16_t number) {
  if (body == BodyClass::kGoldTool) return kGoldLinks;
  return body == BodyClass::kGreenTool ? kGreenLinks : number;
}

}  // namespace

std::vector<BodyClass> classifyBodies(const std::vector<std::string>& names, const SceneRoles& roles) {
  std::vector<BodyClass> classes;
  for (const std::string& name : names) {
    BodyClass body = classByRole(name, roles).value_or(classByName(name));
    if (endsWith(name, "_L")) body = BodyClass::kGoldTool;
    if (endsWith(name, "_R")) body = BodyClass::kGreenTool;
    classes.push_back(body);
  }
  return classes;
}

void ForceTally::add(double newton) {
  if (!(newton > 0.0)) return;
  forces_.push_back(static_cast<float>(newton));
  sum_.peak = std::max(sum_.peak, newton);
  sum_.impulse += newton * kTickSeconds;
  sum_.above += newton > limit_ ? 1 : 0;
  ++sum_.with_force;
}

ForceSummary ForceTally::summary() const {
  ForceSummary summary = sum_;
  if (forces_.empty()) return summary;
  std::vector<float> sorted = forces_;
  const std::size_t rank = (sorted.size() * 95 + 99) / 100 - 1;  // nearest rank
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(rank), sorted.end());
  summary.p95 = static_cast<double>(sorted[rank]);
  return summary;
}

ContactTally::ContactTally(std::vector<BodyClass> bodies, double force_limit)
    : bodies_(std::move(bodies)), force_(force_limit) {
  for (auto& ticks : counted_)
    ticks.fill(kNever);
}

BodyClass ContactTally::classOf(std::uint16_t body) const noexcept {
  return body < bodies_.size() ? bodies_[body] : BodyClass::kOther;
}

void ContactTally::add(const ContactRecord& record) {
  const double newton = std::hypot(record.f_W[0], record.f_W[1], record.f_W[2]);
  if (!(newton >= kTouchForce)) return;
  std::uint16_t a = record.a, b = record.b;
  if (!isTool(classOf(a))) std::swap(a, b);
  const BodyClass tool = classOf(a), other = classOf(b);
  if (isTool(tool)) {
    if (tool == other) return;  // an arm and itself
    count(partnerOf(other), asOne(tool, a), asOne(other, b), record.tick);
    if (other == BodyClass::kObject) return;
    if (record.tick != force_tick_) force_.add(tick_force_);
    tick_force_ = newton + (record.tick == force_tick_ ? tick_force_ : 0.0);
    force_tick_ = record.tick;
    return;
  }
  const bool is_object_at_wire = (tool == BodyClass::kObject && other == BodyClass::kWire) ||
                                 (tool == BodyClass::kWire && other == BodyClass::kObject);
  if (is_object_at_wire) count(Partner::kObjectWire, std::min(a, b), std::max(a, b), record.tick);
}

void ContactTally::count(Partner partner, std::uint16_t a, std::uint16_t b, Tick tick) {
  const auto i = static_cast<std::size_t>(partner);
  const auto [last, is_new] = last_touch_.try_emplace({std::min(a, b), std::max(a, b)}, tick);
  const bool begins = is_new || tick - last->second > kTouchGap;
  if (begins) ++touches_[i].count;
  // The pause that is over now belongs to the touch; another touch of the kind may have counted some of it.
  for (Tick t = begins ? tick : last->second; t <= tick; ++t) {
    Tick& counted = counted_[i][static_cast<std::size_t>(t) % kRemembered];
    if (counted != t) ++touches_[i].ticks;
    counted = t;
  }
  last->second = tick;
}

ForceSummary ContactTally::force() const {
  ForceTally all = force_;
  all.add(tick_force_);
  return all.summary();
}

}  // namespace raven2_trainer::training
