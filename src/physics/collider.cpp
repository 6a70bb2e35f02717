#include "physics/collider.h"

namespace raven2_trainer::physics {
namespace {

// Who meets whom: category bits and the categories each meets. A pair is tested if either side names the other.
constexpr unsigned long kFixed = 1UL << 0U;
constexpr unsigned long kFree = 1UL << 1U;
constexpr unsigned long kArm = 1UL << 2U;
constexpr unsigned long kTool = 1UL << 3U;

constexpr int kPointsPerGeomPair = 8;  // a box on a box has eight at most
constexpr std::size_t kMaxJoints = ContactSet::kMaxPairs * ContactSet::kMaxKept;

dSurfaceParameters surface(const ModelConfig& config) noexcept {
  dSurfaceParameters result{};
  result.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
  result.mu = config.contact_mu;
  result.soft_erp = config.contact_erp;
  result.soft_cfm = config.contact_cfm;
  return result;
}

Owner* owner(dGeomID geom) noexcept {
  return static_cast<Owner*>(dGeomGetData(geom));
}

}  // namespace

Collider::Collider(dWorldID world, const ModelConfig& config)
    : world_(world),
      surface_(surface(config)),
      joints_(dJointGroupCreate(0)),
      free_(dSimpleSpaceCreate(nullptr)),
      fixed_(dSimpleSpaceCreate(nullptr)) {
  for (Space& space : arms_)
    space.reset(dSimpleSpaceCreate(nullptr));
  enabled_.fill(config.arm_contacts);
  // The group's memory grows to the largest number of contacts and stays: grow it here, not in the loop.
  for (std::size_t i = 0; i < kMaxJoints; ++i)
    createJoint(dContactGeom{});
  removeContacts();
}

Owner* Collider::newOwner(int id, int arm, dBodyID body) {
  owners_.push_back(std::make_unique<Owner>(Owner{id, arm, body}));
  return owners_.back().get();
}

void Collider::addArmLink(Arm arm,
                          bool is_tool,
                          int id,
                          dBodyID body,
                          const model::Link& link,
                          const Pose& X_OL,
                          const Vector3& com) {
  const unsigned long collides = kFixed | kFree | (is_tool ? kTool : 0UL);
  addGeoms(at(arms_, arm).get(), link, X_OL, com, newOwner(id, static_cast<int>(index(arm)), body),
           is_tool ? kTool : kArm, collides);
}

void Collider::addFreeLink(int id, dBodyID body, const model::Link& link, const Pose& X_OL, const Vector3& com) {
  addGeoms(free_.get(), link, X_OL, com, newOwner(id, -1, body), kFree, kFixed | kFree | kArm | kTool);
}

void Collider::addFixedLink(int id, const model::Link& link, const Pose& X_WL) {
  addGeoms(fixed_.get(), link, X_WL, Vector3::Zero(), newOwner(id, -1, nullptr), kFixed, kFree | kArm | kTool);
}

void Collider::onNear(void* self, dGeomID a, dGeomID b) {
  const Owner *first = owner(a), *second = owner(b);
  if (first->id == second->id) return;
  std::array<dContactGeom, kPointsPerGeomPair> points;
  const int count = dCollide(a, b, kPointsPerGeomPair, points.data(), sizeof(dContactGeom));
  auto* collider = static_cast<Collider*>(self);
  for (int i = 0; i < count; ++i)
    collider->found_.add(first->id, second->id, points[static_cast<std::size_t>(i)]);
}

void Collider::createContacts() {
  found_.clear();
  counts_ = {};
  for (const Arm arm : kArms) {
    if (!at(enabled_, arm)) continue;
    const auto space = reinterpret_cast<dGeomID>(at(arms_, arm).get());
    dSpaceCollide2(space, reinterpret_cast<dGeomID>(fixed_.get()), this, onNear);
    dSpaceCollide2(space, reinterpret_cast<dGeomID>(free_.get()), this, onNear);
  }
  if (enabled_[0] && enabled_[1]) {
    dSpaceCollide2(reinterpret_cast<dGeomID>(arms_[0].get()), reinterpret_cast<dGeomID>(arms_[1].get()), this, onNear);
  }
  dSpaceCollide2(reinterpret_cast<dGeomID>(free_.get()), reinterpret_cast<dGeomID>(fixed_.get()), this, onNear);
  dSpaceCollide(free_.get(), this, onNear);

  found_.reduce();
  for (const ContactSet::Pair& pair : found_) {
    for (std::size_t i = 0; i < pair.count; ++i)
      createJoint(pair.points[i]);
  }
}

void Collider::createJoint(const dContactGeom& point) {
  dContact contact{};
  contact.surface = surface_;
  contact.geom = point;
  const dJointID joint = dJointCreateContact(world_, joints_.get(), &contact);
  if (point.g1 == nullptr) return;  // reserving memory
  const Owner *first = owner(point.g1), *second = owner(point.g2);
  dJointAttach(joint, first->body, second->body);
  count(*first);
  count(*second);
}

void Collider::count(const Owner& owner) noexcept {
  if (owner.arm >= 0) ++counts_[static_cast<std::size_t>(owner.arm)];
}

}  // namespace raven2_trainer::physics
