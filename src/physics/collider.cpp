#include "physics/collider.h"

#include <algorithm>

#include "physics/capsule_box.h"
#include "physics/ode_maths.h"

namespace raven2_trainer::physics {
namespace {

constexpr int kPointsPerGeomPair = 8;  // a box on a box has eight at most
using Points = std::array<dContactGeom, kPointsPerGeomPair>;

// Friction gives way by this much: a bar in a grip is held by more points than it has ways to move, and the equations
// need a unique answer. The wedge of the jaws presses a bar outwards by some 13 N: that creeps 8 um a minute. [m/(N s)]
constexpr double kSlip = 1.0e-8;

// The teeth of a jaw are this high (meshes/jaw.stl): across such a gap they hold a bar that presses on the jaw
// elsewhere against sliding. Without it, a bar that lies askew between the jaws touches each at one point and turns
// about the line through the two. [m]
constexpr double kTeeth = 3.0e-4;

dSurfaceParameters surface(const ModelConfig& config) noexcept {
  dSurfaceParameters result{};
  result.mode = dContactSoftERP | dContactSoftCFM | dContactSlip1 | dContactSlip2 | dContactMotionN;
  result.soft_erp = config.contact_erp;
  result.soft_cfm = config.contact_cfm;
  result.slip1 = result.slip2 = kSlip;
  return result;
}

Pose geomPose(dGeomID geom) noexcept {
  return {rotationFromOde(dGeomGetRotation(geom)), vectorFromOde(dGeomGetPosition(geom))};
}

int collideCapsuleBox(dGeomID capsule, dGeomID box, double margin, Points* points) noexcept {
  dReal radius, length;
  dVector3 edges;
  dGeomCapsuleGetParams(capsule, &radius, &length);
  dGeomBoxGetLengths(box, edges);
  OverlapPoints overlap;
  const int count =
      overlapCapsuleBox(geomPose(capsule), radius, length, geomPose(box), vectorFromOde(edges) / 2, margin, &overlap);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    dContactGeom& point = (*points)[i];
    point = {};
    for (int k = 0; k < 3; ++k) {
      point.pos[k] = overlap[i].p_W(k);
      point.normal[k] = overlap[i].n_W(k);
    }
    point.depth = overlap[i].depth;
    point.g1 = capsule;
    point.g2 = box;
  }
  return count;
}

int collideGeoms(dGeomID a, dGeomID b, double margin, Points* points) {
  const int kind_a = dGeomGetClass(a), kind_b = dGeomGetClass(b);
  if (kind_a == dCapsuleClass && kind_b == dBoxClass) return collideCapsuleBox(a, b, margin, points);
  if (kind_a == dBoxClass && kind_b == dCapsuleClass) return collideCapsuleBox(b, a, margin, points);
  return dCollide(a, b, kPointsPerGeomPair, points->data(), sizeof(dContactGeom));
}

/** Of two pairs of bodies. */
bool isBefore(const ContactSet::Pair* a, const ContactSet::Pair* b) noexcept {
  return a->first != b->first ? a->first < b->first : a->second < b->second;
}

}  // namespace

Collider::Collider(dWorldID world, const ModelConfig& config)
    : world_(world),
      mu_(config.contact_mu),
      jaw_mu_(config.jaw_mu),
      surface_(surface(config)),
      joints_(dJointGroupCreate(0)),
      enabled_(config.arm_contacts) {
  // The group's memory grows to the largest number of contacts and stays: grow it here, not in the loop.
  dContact contact{};
  for (std::size_t i = 0; i < ContactForces::kMax; ++i)
    dJointCreateContact(world_, joints_.get(), &contact);
  dJointGroupEmpty(joints_.get());
}

bool Collider::overlap(const Bounds& a, const Bounds& b) noexcept {
  const dReal *p = a.low_high, *q = b.low_high;
  return p[0] <= q[1] && q[0] <= p[1] && p[2] <= q[3] && q[2] <= p[3] && p[4] <= q[5] && q[4] <= p[5];
}

bool Collider::mayMeet(const Group& a, const Group& b) noexcept {
  if (a.id == b.id || (a.body == nullptr && b.body == nullptr)) return false;
  return a.arm < 0 || a.arm != b.arm;
}

void Collider::updateBounds(Group* group) noexcept {
  Bounds& all = group->bounds;
  all = {{dInfinity, -dInfinity, dInfinity, -dInfinity, dInfinity, -dInfinity}};
  for (Shape& shape : group->shapes) {
    dGeomGetAABB(shape.geom.get(), shape.bounds.low_high);
    for (int i = 0; i < 6; i += 2) {
      shape.bounds.low_high[i] -= group->is_jaw ? kTeeth : 0.0;
      shape.bounds.low_high[i + 1] += group->is_jaw ? kTeeth : 0.0;
      all.low_high[i] = std::min(all.low_high[i], shape.bounds.low_high[i]);
      all.low_high[i + 1] = std::max(all.low_high[i + 1], shape.bounds.low_high[i + 1]);
    }
  }
}

void Collider::addGroup(Group group, const model::Link& link, const Pose& X_OL, const Vector3& com) {
  for (const model::CollisionShape& shape : link.collisions) {
    Pose X_OS = X_OL * shape.X_LS;
    X_OS.p -= com;
    Geom geom = createGeom(shape, X_OS, group.body);
    if (geom) group.shapes.push_back({std::move(geom), {}});
  }
  if (group.shapes.empty()) return;
  updateBounds(&group);
  groups_.push_back(std::make_unique<Group>(std::move(group)));
  Group* added = groups_.back().get();
  by_id_.resize(std::max(by_id_.size(), static_cast<std::size_t>(added->id) + 1));
  by_id_[static_cast<std::size_t>(added->id)] = added;
  for (const Shape& shape : added->shapes)
    dGeomSetData(shape.geom.get(), added);
  for (const std::unique_ptr<Group>& other : groups_) {
    if (mayMeet(*other, *added)) pairs_.emplace_back(other.get(), added);
  }
}

void Collider::addArmLink(Arm arm,
                          Joint joint,
                          int id,
                          dBodyID body,
                          const model::Link& link,
                          const Pose& X_OL,
                          const Vector3& com) {
  const bool is_jaw = joint == kGrasp1 || joint == kGrasp2;
  addGroup({id, static_cast<int>(index(arm)), is_jaw, body, {}, {}}, link, X_OL, com);
}

void Collider::addFreeLink(int id, dBodyID body, const model::Link& link, const Pose& X_OL, const Vector3& com) {
  addGroup({id, -1, false, body, {}, {}}, link, X_OL, com);
}

void Collider::addFixedLink(int id, const model::Link& link, const Pose& X_WL) {
  addGroup({id, -1, false, nullptr, {}, {}}, link, X_WL, Vector3::Zero());
}

bool Collider::isEnabled(const Group& group) const noexcept {
  return group.arm < 0 || enabled_[static_cast<std::size_t>(group.arm)];
}

void Collider::createContacts() {
  found_.clear();
  forces_.clear();
  for (const std::unique_ptr<Group>& group : groups_) {
    if (group->body != nullptr) updateBounds(group.get());
  }
  for (const auto& [a, b] : pairs_) {
    if (overlap(a->bounds, b->bounds) && isEnabled(*a) && isEnabled(*b)) collide(*a, *b);
  }
  found_.reduce();
  std::size_t count = 0;
  for (const ContactSet::Pair& pair : found_)
    order_[count++] = &pair;
  std::sort(order_.begin(), order_.begin() + count, isBefore);
  for (std::size_t i = 0; i < count; ++i)
    createJoints(*order_[i]);
}

void Collider::collide(const Group& a, const Group& b) {
  for (const Shape& shape_a : a.shapes) {
    if (!overlap(shape_a.bounds, b.bounds)) continue;
    for (const Shape& shape_b : b.shapes) {
      if (overlap(shape_a.bounds, shape_b.bounds)) collide(shape_a.geom.get(), shape_b.geom.get());
    }
  }
}

void Collider::collide(dGeomID a, dGeomID b) {
  Points points;
  const int count = collideGeoms(a, b, groupOf(a).is_jaw || groupOf(b).is_jaw ? kTeeth : 0.0, &points);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    found_.add(groupOf(a).id, groupOf(b).id, points[i]);
}

void Collider::createJoints(const ContactSet::Pair& pair) {
  const bool jaw = groupOf(pair.points[0].g1).is_jaw || groupOf(pair.points[0].g2).is_jaw;
  const double normal = forces_.addPair(pair.first, pair.second);
  const double limit = (jaw ? jaw_mu_ : mu_) * normal / static_cast<double>(pair.count);
  for (std::size_t i = 0; i < pair.count; ++i)
    createJoint(pair.points[i], limit);
}

void Collider::createJoint(const dContactGeom& point, double limit) {
  const Group &into = groupOf(point.g1), &from = groupOf(point.g2);
  dContact contact{};
  contact.geom = point;
  contact.surface = surface_;
  contact.surface.mu = limit;
  contact.surface.motionN = std::min(0.0, point.depth) / kTickSeconds;  // a gap may close within the step, no faster
  contact.geom.depth = std::max(0.0, point.depth);
  const dJointID joint = dJointCreateContact(world_, joints_.get(), &contact);
  dJointAttach(joint, into.body, from.body);
  const int first_body = into.body != nullptr ? into.id : from.id;  // ODE turns a joint round that begins with none
  forces_.add(joint, contact.geom, into.id < from.id, first_body == std::min(into.id, from.id));
}

const Collider::Group& Collider::groupOf(dGeomID geom) noexcept {
  return *static_cast<const Group*>(dGeomGetData(geom));
}

void Collider::readForces() noexcept {
  forces_.read();
  counts_ = {};
  obstructed_ = {};
  forces_.forEach([this](std::size_t a, std::size_t b) {
    const Group &first = *by_id_[a], &second = *by_id_[b];
    const bool gives_way = (first.arm < 0 && first.body != nullptr) || (second.arm < 0 && second.body != nullptr);
    for (const Group* group : {&first, &second}) {
      if (group->arm < 0) continue;
      const auto arm = static_cast<std::size_t>(group->arm);
      ++counts_[arm];
      obstructed_[arm] = obstructed_[arm] || !gives_way;
    }
  });
}

void Collider::forget() noexcept {
  found_.clear();
  forces_.clear();
  counts_ = {};
  obstructed_ = {};
}

}  // namespace raven2_trainer::physics
