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

// A jaw pushes a ring that it overlaps out at most this fast: the ring weighs a gram. [m/s]
constexpr double kPartingSpeed = 0.5;
// An arm that was put 10 mm deep into something leaves it no faster. On plastic that bounds the force to 200 N, twice
// what an arm can press with. [m/s]
constexpr double kArmPartingSpeed = 1.5;

dSurfaceParameters surface() noexcept {
  dSurfaceParameters result{};
  result.mode = dContactSoftCFM | dContactSlip1 | dContactSlip2 | dContactMotionN;
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

Collider::Collider(dWorldID world, const ModelConfig& config, double step)
    : world_(world),
      step_(step),
      mu_(config.contact_mu),
      jaw_mu_(config.jaw_mu),
      materials_(config.materials),
      give_(config.arm_give),
      surface_(surface()),
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
  const auto stays = [](const Group& group) { return group.body == nullptr && group.loose_body == nullptr; };
  if (a.id == b.id || (stays(a) && stays(b))) return false;
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

std::vector<Collider::Shape> Collider::createShapes(const model::Link& link,
                                                    const Pose& X_OL,
                                                    const Vector3& com,
                                                    dBodyID body) {
  std::vector<Shape> shapes;
  for (const model::CollisionShape& shape : link.collisions) {
    Pose X_OS = X_OL * shape.X_LS;
    X_OS.p -= com;
    Geom geom = createGeom(shape, X_OS, body);
    if (geom) shapes.push_back({std::move(geom), {}});
  }
  return shapes;
}

/** By the name of its shapes in the URDF (RavenWorld has checked it); without one, the first. */
const ContactMaterial* Collider::materialOf(const model::Link& link) const {
  const std::string& wanted = link.collisions.front().material;
  const auto found = std::find_if(materials_.begin(), materials_.end(),
                                  [&](const ContactMaterial& material) { return material.name == wanted; });
  return found == materials_.end() ? &materials_.front() : &*found;
}

void Collider::addGroup(Group group, const model::Link& link, const Pose& X_OL, const Vector3& com) {
  group.shapes = createShapes(link, X_OL, com, group.body);
  if (group.shapes.empty()) return;
  group.material = group.arm >= 0 ? &materials_.front() : materialOf(link);
  updateBounds(&group);
  groups_.push_back(std::make_unique<Group>(std::move(group)));
  Group* added = groups_.back().get();
  by_id_.resize(std::max(by_id_.size(), static_cast<std::size_t>(added->id) + 1));
  by_id_[static_cast<std::size_t>(added->id)] = added;
  for (const std::vector<Shape>* shapes : {&added->shapes, &added->loose_shapes}) {
    for (const Shape& shape : *shapes)
      dGeomSetData(shape.geom.get(), added);
  }
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
  Group group;
  group.id = id;
  group.arm = static_cast<int>(index(arm));
  group.is_jaw = is_jaw;
  group.body = body;
  addGroup(std::move(group), link, X_OL, com);
}

void Collider::addFreeLink(int id, dBodyID body, const model::Link& link, const Pose& X_OL, const Vector3& com) {
  Group group;
  group.id = id;
  group.body = body;
  addGroup(std::move(group), link, X_OL, com);
}

void Collider::addFixedLink(int id, const model::Link& link, const Pose& X_WL) {
  Group group;
  group.id = id;
  addGroup(std::move(group), link, X_WL, Vector3::Zero());
}

void Collider::addBreakableLink(int id, dBodyID body, const model::Link& link, const Pose& X_WL, const Vector3& com) {
  Group group;
  group.id = id;
  group.loose_body = body;
  group.loose_shapes = createShapes(link, Pose{}, com, body);
  addGroup(std::move(group), link, X_WL, Vector3::Zero());
}

Collider::Group* Collider::find(int id) const noexcept {
  const auto at = static_cast<std::size_t>(id);
  return at < by_id_.size() ? by_id_[at] : nullptr;
}

void Collider::setHeld(int id, bool held) noexcept {
  Group* group = find(id);
  if (group == nullptr || group->loose_body == nullptr || held == (group->body == nullptr)) return;
  std::swap(group->shapes, group->loose_shapes);
  group->body = held ? nullptr : group->loose_body;
  updateBounds(group);
}

bool Collider::isEnabled(const Group& group) const noexcept {
  return group.arm < 0 || enabled_[static_cast<std::size_t>(group.arm)];
}

void Collider::createContacts() {
  found_.clear();
  forces_.clear();
  for (const std::unique_ptr<Group>& group : groups_) {
    if (moves(*group)) updateBounds(group.get());
  }
  while (wakeOnce()) {
  }
  parked_.show();
  for (const auto& [a, b] : pairs_) {
    if (!moves(*a) && !moves(*b)) continue;
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

/** By the boxes of single shapes: an arm's shaft lies across half of the scene. */
bool Collider::isNear(const Group& a, const Group& b) const noexcept {
  if (!overlap(a.bounds, b.bounds) || !isEnabled(a) || !isEnabled(b)) return false;
  for (const Shape& shape_a : a.shapes) {
    if (!overlap(shape_a.bounds, b.bounds)) continue;
    for (const Shape& shape_b : b.shapes) {
      if (overlap(shape_a.bounds, shape_b.bounds)) return true;
    }
  }
  return false;
}

/** Wakes what something that moves is near. @return whether there was any: it may be near others */
bool Collider::wakeOnce() noexcept {
  bool any = false;
  if (parked_count_ == 0) return any;
  for (const auto& [a, b] : pairs_) {
    if (a->parked == b->parked || !(moves(*a) || moves(*b)) || !isNear(*a, *b)) continue;
    setParked(a->parked ? a->id : b->id, false);
    any = true;
  }
  return any;
}

/** Of the drowsy bodies, takes out those that something is near that moves and is not drowsy. */
bool Collider::rouseOnce() noexcept {
  bool any = false;
  for (const auto& [a, b] : pairs_) {
    if (a->drowsy == b->drowsy || !moves(*a) || !moves(*b) || !isNear(*a, *b)) continue;
    setDrowsy(a->drowsy ? a->id : b->id, false);
    any = true;
  }
  return any;
}

void Collider::setDrowsy(int id, bool drowsy) noexcept {
  for (const std::unique_ptr<Group>& group : groups_) {
    if (group->id == id) group->drowsy = drowsy;
  }
}

void Collider::park(const int* ids, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i)
    setDrowsy(ids[i], true);
  while (rouseOnce()) {
  }
  forces_.forEach([this](const Contact& contact) {
    if (find(contact.a)->drowsy || find(contact.b)->drowsy) parked_.add(contact);
  });
  for (std::size_t i = 0; i < count; ++i) {
    const Group* group = find(ids[i]);
    if (group != nullptr && group->drowsy) setParked(ids[i], true);
    setDrowsy(ids[i], false);
  }
}

bool Collider::isParked(int id) const noexcept {
  const Group* group = find(id);
  return group != nullptr && group->parked;
}

void Collider::setParked(int id, bool parked) noexcept {
  const Group* first = find(id);
  if (first == nullptr || first->parked == parked) return;
  const dBodyID body = first->body;
  if (parked) {
    ++parked_count_;
    dBodySetLinearVel(body, 0.0, 0.0, 0.0);
    dBodySetAngularVel(body, 0.0, 0.0, 0.0);
    dBodyDisable(body);
  } else {
    --parked_count_;
    dBodyEnable(body);
    parked_.remove(id);
  }
  for (const std::unique_ptr<Group>& group : groups_) {
    if (group->id != id) continue;
    group->parked = parked;
    updateBounds(group.get());
  }
}

Wrench Collider::wrenchOn(int id, const Vector3& point_W) const noexcept {
  Wrench sum;
  const auto add = [&](const Contact& contact) {
    if (contact.a != id && contact.b != id) return;
    const Vector3 force = contact.a == id ? toEigen(contact.f_W) : Vector3(-toEigen(contact.f_W));
    sum.force += force;
    sum.moment += (toEigen(contact.p_W) - point_W).cross(force);
  };
  forces_.forEach(add);
  parked_.forEach(add);
  return sum;
}

void Collider::report(ContactList* list) const noexcept {
  forces_.report(found_.unseen(), list);
  parked_.report(list);
}

void Collider::save(SceneSnapshot* snapshot) const noexcept {
  forces_.save(snapshot);
  parked_.save(snapshot);
}

void Collider::restore(const SceneSnapshot& snapshot) noexcept {
  counts_ = {};
  obstructed_ = {};
  found_.clear();
  forces_.restore(snapshot);
  parked_.restore(snapshot);
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

/**
 * Of a fixed link with anything: one arm gives way. With a ring, too: an arm presses it there, and a ring that merely
 * lies there does not notice. Of two arms: both give way. Of a ring with an arm or with another ring: none, since what
 * two jaws hold between them bends no shaft.
 */
ContactLaw Collider::lawOf(const Group& a, const Group& b) const noexcept {
  const auto is_fixed = [](const Group& group) { return group.body == nullptr; };
  const int arms = (a.arm >= 0 ? 1 : 0) + (b.arm >= 0 ? 1 : 0);
  if (is_fixed(a) || is_fixed(b)) return {*a.material, *b.material, give_, 1};
  if (arms == 2) return {*a.material, *b.material, give_, 2};
  return {*a.material, *b.material};
}

void Collider::createJoints(const ContactSet::Pair& pair) {
  const bool jaw = groupOf(pair.points[0].g1).is_jaw || groupOf(pair.points[0].g2).is_jaw;
  const double normal = forces_.addPair(pair.first, pair.second);
  const double limit = (jaw ? jaw_mu_ : mu_) * normal / static_cast<double>(pair.count);
  const ContactLaw law = lawOf(groupOf(pair.points[0].g1), groupOf(pair.points[0].g2));
  double deepest = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < pair.count; ++i) {
    deepest = std::max(deepest, pair.points[i].depth);
    sum += std::max(0.0, pair.points[i].depth);
  }
  for (std::size_t i = 0; i < pair.count; ++i) {
    const double depth = pair.points[i].depth;
    const double share = sum > 0.0 && depth > 0.0 ? depth / sum : 1.0 / static_cast<double>(pair.count);
    createJoint(pair.points[i], law.gives() ? deepest : depth, law.gives() ? share : 1.0, law, limit);
  }
}

void Collider::createJoint(const dContactGeom& point, double depth, double share, const ContactLaw& law, double limit) {
  const Group &into = groupOf(point.g1), &from = groupOf(point.g2);
  const double pressed = point.depth > 0.0 ? depth : 0.0;
  const double resistance = share * (law.stiffness(pressed) * step_ + law.damping(pressed));
  dContact contact{};
  contact.geom = point;
  contact.geom.depth = 0.0;
  contact.surface = surface_;
  contact.surface.mu = limit;
  contact.surface.soft_cfm = 1.0 / resistance;
  contact.surface.motionN = point.depth > 0.0 ? share * law.force(pressed) / resistance : point.depth / step_;
  const bool is_fixed = into.body == nullptr || from.body == nullptr;
  contact.surface.motionN =
      std::min(contact.surface.motionN, is_fixed || law.gives() ? kArmPartingSpeed : kPartingSpeed);
  const dJointID joint = dJointCreateContact(world_, joints_.get(), &contact);
  dJointAttach(joint, into.body, from.body);
  const int first_body = into.body != nullptr ? into.id : from.id;  // ODE turns a joint round that begins with none
  dContactGeom reported = point;
  reported.depth = std::max(0.0, point.depth);
  forces_.add(joint, reported, into.id < from.id, first_body == std::min(into.id, from.id));
}

const Collider::Group& Collider::groupOf(dGeomID geom) noexcept {
  return *static_cast<const Group*>(dGeomGetData(geom));
}

void Collider::readForces() noexcept {
  forces_.read();
  counts_ = {};
  obstructed_ = {};
  forces_.forEach([this](const Contact& contact) {
    const Group &first = *find(contact.a), &second = *find(contact.b);
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
  parked_.clear();
  counts_ = {};
  obstructed_ = {};
}

}  // namespace raven2_trainer::physics
