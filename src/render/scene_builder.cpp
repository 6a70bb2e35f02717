#include <cmath>

#include "raven2_trainer/render/renderer.h"
#include "render/overlay_text.h"
#include "render/plan_text.h"
#include "render/planned_path.h"
#include "render/primitives.h"

namespace raven2_trainer::render {

namespace {

constexpr float kRcmRadius = 0.006F;                                   // [m]
constexpr std::array<float, 4> kRcmColour{0.98F, 0.84F, 0.10F, 1.0F};  // yellow spheres of the paper's Figure 3
constexpr std::array<float, 4> kGhostColour{0.90F, 0.10F, 0.10F, 0.45F};
// Of a plan: magenta and cyan, which nothing else in the picture has.
constexpr std::array<float, 4> kPathColour{0.90F, 0.12F, 0.86F, 1.0F};
constexpr std::array<float, 4> kTravelledColour{0.50F, 0.30F, 0.50F, 1.0F};
constexpr std::array<float, 4> kGoalColour{0.05F, 0.75F, 0.85F, 0.45F};
constexpr float kStopRadius = 0.0024F;  // [m] twice as thick as the path
constexpr std::array<float, 4> kForceColour{0.10F, 0.35F, 0.95F, 1.0F};
constexpr double kArrowBase = 0.010;       // [m] length of the arrow of a force that is just felt
constexpr double kArrowPerNewton = 0.012;  // [m/N] 3.3 N: 50 mm
constexpr double kLeastForce = 1e-3;       // [N]

/** What never changes of one visual: its mesh handle, its pose in the link, its colour. */
struct Visual {
  int link;
  int mesh;
  Pose X_LM;
  std::array<float, 4> colour;
};

std::vector<Visual> upload(const model::Description& description, Renderer* renderer) {
  std::vector<int> handles;
  for (const model::Mesh& mesh : description.meshes)
    handles.push_back(renderer->addMesh(mesh));
  std::vector<Visual> visuals;
  for (std::size_t link = 0; link < description.links.size(); ++link) {
    for (const model::VisualShape& shape : description.links[link].visuals) {
      const int handle = shape.mesh < 0 ? -1 : handles.at(static_cast<std::size_t>(shape.mesh));
      visuals.push_back({static_cast<int>(link), handle, shape.X_LS, shape.colour});
    }
  }
  return visuals;
}

bool isBelow(const model::Description& description, int link, int ancestor) {
  while (link >= 0 && link != ancestor)
    link = description.links[static_cast<std::size_t>(link)].parent;
  return link == ancestor;
}

/** Pose whose z axis points along `direction`, scaled by `length`. */
Pose arrowPose(const Vector3& from, const Vector3& direction, double length) {
  return {length * Quaternion::FromTwoVectors(Vector3::UnitZ(), direction).toRotationMatrix(), from};
}

}  // namespace

struct SceneBuilder::Impl {
  Impl(const model::RavenModel& raven_model,
       const model::SceneModel& scene_model,
       const HapticGains& gains,
       Renderer* renderer);

  void addFixedScene(const Snapshot& snapshot);
  void addArms(const Snapshot& snapshot);
  void addGhost(const PerArm<JointArray>& q, Arm arm, const std::array<float, 4>& colour);
  void followPlan(const Snapshot& snapshot);
  void addPath(double place);
  void addPlan(const Snapshot& snapshot);
  void addOverlay(const Snapshot& snapshot);
  void addForce(const Snapshot& snapshot, Arm arm);
  bool isGhostShown(const Snapshot& snapshot, Arm arm) const;

  Renderer& pictures;
  model::RavenModel raven;
  model::SceneModel surroundings;
  HapticGains haptics;
  std::vector<Visual> raven_visuals, scene_visuals;
  std::vector<int> body_of_link;  // index in ModelState::bodies of the body that carries a scene link, or -1
  std::vector<Pose> X_BodyLink;   // pose of a scene link on that body
  int sphere, arrow, stop, tube;
  std::shared_ptr<const PlanResult> plan;  // that the tube is made from
  PlannedPath path;                        // the same
  std::vector<double> positions;
  std::vector<Pose> X_WL;
  Scene scene;
};

SceneBuilder::Impl::Impl(const model::RavenModel& raven_model,
                         const model::SceneModel& scene_model,
                         const HapticGains& gains,
                         Renderer* renderer)
    : pictures(*renderer),
      raven(raven_model),
      surroundings(scene_model),
      haptics(gains),
      raven_visuals(upload(raven_model.description, renderer)),
      scene_visuals(upload(scene_model.description, renderer)),
      body_of_link(scene_model.description.links.size(), -1),
      X_BodyLink(scene_model.description.links.size()),
      sphere(renderer->addMesh(makeSphere(kRcmRadius, 24))),
      arrow(renderer->addMesh(makeArrow(16))),
      stop(renderer->addMesh(makeSphere(kStopRadius, 10))),
      tube(renderer->addMesh(model::Mesh{})),
      positions(raven_model.description.links.size(), 0.0),
      X_WL(raven_model.description.links.size()) {
  const std::vector<int> moving = surroundings.movingBodies();
  for (std::size_t body = 0; body < moving.size() && body < kMaxSceneBodies; ++body) {
    const int root = moving[body];
    for (std::size_t link = 0; link < body_of_link.size(); ++link) {
      if (!isBelow(surroundings.description, static_cast<int>(link), root)) continue;
      body_of_link[link] = static_cast<int>(body);
      X_BodyLink[link] = surroundings.X_WL[static_cast<std::size_t>(root)].inverse() * surroundings.X_WL[link];
    }
  }
}

void SceneBuilder::Impl::addFixedScene(const Snapshot& snapshot) {
  for (const Visual& visual : scene_visuals) {
    const auto link = static_cast<std::size_t>(visual.link);
    const int body = body_of_link[link];
    const Pose X_W = body < 0 ? surroundings.X_WL[link]
                              : toEigen(snapshot.model.bodies[static_cast<std::size_t>(body)]) * X_BodyLink[link];
    scene.drawables.push_back({visual.mesh, X_W * visual.X_LM, visual.colour});
  }
}

void SceneBuilder::Impl::addArms(const Snapshot& snapshot) {
  raven.linkPosesInWorld({snapshot.model.arms[0].q, snapshot.model.arms[1].q}, &positions, &X_WL);
  for (const Visual& visual : raven_visuals) {
    scene.drawables.push_back({visual.mesh, X_WL[static_cast<std::size_t>(visual.link)] * visual.X_LM, visual.colour});
  }
  for (const Arm arm : kArms)
    scene.drawables.push_back({sphere, at(raven.X_WB, arm), kRcmColour});
}

bool SceneBuilder::Impl::isGhostShown(const Snapshot& snapshot, Arm arm) const {
  return tipError(snapshot, arm) > haptics.tolerance;  // false for NaN
}

/** An arm, translucent, with both at q. */
void SceneBuilder::Impl::addGhost(const PerArm<JointArray>& q, Arm arm, const std::array<float, 4>& colour) {
  raven.linkPosesInWorld(q, &positions, &X_WL);
  const int base = at(raven.base_links, arm);
  for (const Visual& visual : raven_visuals) {
    if (visual.link == base || !isBelow(raven.description, visual.link, base)) continue;
    scene.drawables.push_back({visual.mesh, X_WL[static_cast<std::size_t>(visual.link)] * visual.X_LM, colour});
  }
}

/** Whether the tube is still that of the plan at hand. A plan's id may come again, the answer in memory may not. */
void SceneBuilder::Impl::followPlan(const Snapshot& snapshot) {
  if (snapshot.plans.path == plan) return;
  plan = snapshot.plans.path;
  path = PlannedPath(raven.arms.geometry, at(raven.X_WB, plan->arm), *plan);
  pictures.replaceMesh(tube, path.tube());
}

/** @param[in] place on the path up to which it is travelled (PlannedPath::placeOf). */
void SceneBuilder::Impl::addPath(double place) {
  const std::uint32_t behind = path.trianglesBefore(place);
  Drawable part{tube, Pose{}, kTravelledColour, /*is_mark=*/true, 0, behind};
  scene.drawables.push_back(part);
  part.colour = kPathColour;
  part.first = behind;
  part.count = Drawable{}.count;
  scene.drawables.push_back(part);
  const std::size_t stops_behind = path.stopsBefore(place);
  for (std::size_t i = 0; i < path.stops().size(); ++i) {
    const auto& colour = i < stops_behind ? kTravelledColour : kPathColour;
    scene.drawables.push_back({stop, {Matrix3::Identity(), path.stops()[i]}, colour, /*is_mark=*/true});
  }
}

void SceneBuilder::Impl::addPlan(const Snapshot& snapshot) {
  const PlanResult* at_hand = planAtHand(snapshot);
  if (at_hand == nullptr) return;
  followPlan(snapshot);
  const ModelState& model = snapshot.model;
  const bool is_under_way = model.mode == Mode::kExecuting || model.mode == Mode::kTracking;
  addPath(is_under_way ? path.placeOf(at(model.arms, at_hand->arm).q_d) : 0.0);
  PerArm<JointArray> q{model.arms[0].q, model.arms[1].q};
  at(q, at_hand->arm) = at_hand->waypoints[at_hand->waypoint_count - 1];
  addGhost(q, at_hand->arm, kGoalColour);
}

void SceneBuilder::Impl::addOverlay(const Snapshot& snapshot) {
  scene.overlay = describe(snapshot, haptics);
  const std::string line = planLine(snapshot, pathError(raven.arms.geometry, snapshot));
  if (!line.empty()) scene.overlay.lines.push_back(line);
}

void SceneBuilder::Impl::addForce(const Snapshot& snapshot, Arm arm) {
  const Pose& X_WB = at(raven.X_WB, arm);
  const Vector3 force_W = X_WB.R * toEigen(at(snapshot.haptic.force_B, arm));
  const double force = force_W.norm();
  if (!(force > kLeastForce)) return;
  const Vector3 tip_W = X_WB * toEigen(at(snapshot.model.arms, arm).p_BT);
  scene.drawables.push_back({arrow, arrowPose(tip_W, force_W, kArrowBase + kArrowPerNewton * force), kForceColour});
}

SceneBuilder::SceneBuilder(const model::RavenModel& raven,
                           const model::SceneModel& scene,
                           const HapticGains& haptics,
                           Renderer* renderer)
    : impl_(std::make_unique<Impl>(raven, scene, haptics, renderer)) {}

SceneBuilder::~SceneBuilder() = default;

const Scene& SceneBuilder::build(const Snapshot& snapshot) {
  Impl& impl = *impl_;
  impl.scene.drawables.clear();
  impl.addFixedScene(snapshot);
  impl.addArms(snapshot);
  for (const Arm arm : kArms) {
    if (impl.isGhostShown(snapshot, arm))
      impl.addGhost({snapshot.robot.arms[0].q, snapshot.robot.arms[1].q}, arm, kGhostColour);
    impl.addForce(snapshot, arm);
  }
  impl.addPlan(snapshot);
  impl.addOverlay(snapshot);
  return impl.scene;
}

}  // namespace raven2_trainer::render
