#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/shortest_turn.h"
#include "raven2_trainer/render/picture_config.h"
#include "raven2_trainer/render/renderer.h"
#include "render/near_limits.h"
#include "render/overlay_text.h"
#include "render/plan_text.h"
#include "render/planned_path.h"
#include "render/primitives.h"
#include "render/tip_trails.h"

namespace raven2_trainer::render {

namespace {

constexpr float kRcmRadius = 0.006F;                                   // [m]
constexpr std::array<float, 4> kRcmColour{0.98F, 0.84F, 0.10F, 1.0F};  // yellow spheres of the paper's Figure 3
constexpr std::array<float, 4> kGhostColour{0.90F, 0.10F, 0.10F, 0.45F};
// Of a plan: magenta and cyan, which nothing else in the picture has.
constexpr std::array<float, 4> kPathColour{0.90F, 0.12F, 0.86F, 1.0F};
constexpr std::array<float, 4> kTravelledColour{0.50F, 0.30F, 0.50F, 1.0F};
constexpr std::array<float, 4> kGoalColour{0.05F, 0.75F, 0.85F, 0.45F};
constexpr float kStopRadius = 0.0024F;     // [m] twice as thick as the path
constexpr double kArrowBase = 0.010;       // [m] length of the arrow of a force that is just felt
constexpr double kArrowPerNewton = 0.012;  // [m/N] 3.3 N: 50 mm
constexpr double kLongestArrow = 0.12;     // [m] 9 N: a hard hit of a tool shall not fill the picture
constexpr double kLeastForce = 1e-3;       // [N]
// By Trail: red, green and blue of the paper's Figures 7 and 8.
constexpr std::array<std::array<float, 4>, kTrailCount> kTrailColours{
    {{0.86F, 0.08F, 0.08F, 1.0F}, {0.05F, 0.62F, 0.12F, 1.0F}, {0.14F, 0.22F, 0.92F, 1.0F}}};
constexpr float kMarkRadius = 0.0008F;                            // [m] thinner than the path, to distinguish marks
constexpr std::array<float, 3> kWallColour{1.00F, 0.69F, 0.18F};  // amber, as the warning
constexpr double kWallRadius = 0.018;                             // [m] wider than the tool, which it is in front of
constexpr double kFaintWall = 0.20, kPlainWall = 0.65;            // opacity where it is first shown, and at the limit

/** The constant data of one visual: mesh handle, pose in the link, colour. */
struct Visual {
  int link;
  int mesh;
  Pose X_LM;
  std::array<float, 4> colour;
  bool is_fixed;  // no joint on the way to the world moves
};

bool isFixed(const model::Description& description, int link) {
  while (link >= 0 && description.links[static_cast<std::size_t>(link)].joint == model::JointKind::kFixed)
    link = description.links[static_cast<std::size_t>(link)].parent;
  return link < 0;
}

Drawable drawableOf(const Visual& visual, const Pose& X_WL) {
  Drawable drawable{visual.mesh, X_WL * visual.X_LM, visual.colour};
  drawable.is_fixed = visual.is_fixed;
  return drawable;
}

std::vector<Visual> upload(const model::Description& description, Renderer* renderer) {
  std::vector<int> handles;
  for (const model::Mesh& mesh : description.meshes)
    handles.push_back(renderer->addMesh(mesh));
  std::vector<Visual> visuals;
  for (std::size_t link = 0; link < description.links.size(); ++link) {
    const bool is_fixed = isFixed(description, static_cast<int>(link));
    for (const model::VisualShape& shape : description.links[link].visuals) {
      const int handle = shape.mesh < 0 ? -1 : handles.at(static_cast<std::size_t>(shape.mesh));
      visuals.push_back({static_cast<int>(link), handle, shape.X_LS, shape.colour, is_fixed});
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
  return {length * kinematics::shortestTurn(Vector3::UnitZ(), direction).toRotationMatrix(), from};
}

}  // namespace

struct SceneBuilder::Impl {
  Impl(const model::RavenModel& raven_model,
       const model::SceneModel& scene_model,
       const SceneOptions& wanted,
       Renderer* renderer);

  bool shows(OverlayKind kind) const noexcept { return options.overlays.has(kind); }
  void addFixedScene(const Snapshot& snapshot);
  void addArms(const Snapshot& snapshot);
  void addGhost(const PerArm<JointArray>& q, Arm arm, const std::array<float, 4>& colour);
  void followPlan(const Snapshot& snapshot);
  void addPath(double place);
  void addPlan(const Snapshot& snapshot);
  void addOverlay(const Snapshot& snapshot);
  void addArrow(const Snapshot& snapshot, Arm arm, const Vector3& force_W, const std::array<float, 3>& rgb);
  void addForces(const Snapshot& snapshot, Arm arm);
  void addLimits(const Snapshot& snapshot);
  void addTrails();
  bool isGhostShown(const Snapshot& snapshot, Arm arm) const;

  Renderer& pictures;
  model::RavenModel raven;
  model::SceneModel surroundings;
  SceneOptions options;
  std::vector<Visual> raven_visuals, scene_visuals;
  std::vector<int> body_of_link;  // index in ModelState::bodies of the body that carries a scene link, or -1
  std::vector<Pose> X_BodyLink;   // pose of a scene link on that body
  int sphere, arrow, disc, stop, tube;
  std::array<int, kTrailCount> trail_meshes{};
  TipTrails trails;
  std::shared_ptr<const PlanResult> plan;  // that the tube is made from
  PlannedPath path;                        // the same
  std::vector<double> positions;
  std::vector<Pose> X_WL;
  Scene scene;
};

SceneBuilder::Impl::Impl(const model::RavenModel& raven_model,
                         const model::SceneModel& scene_model,
                         const SceneOptions& wanted,
                         Renderer* renderer)
    : pictures(*renderer),
      raven(raven_model),
      surroundings(scene_model),
      options(wanted),
      raven_visuals(upload(raven_model.description, renderer)),
      scene_visuals(upload(scene_model.description, renderer)),
      body_of_link(scene_model.description.links.size(), -1),
      X_BodyLink(scene_model.description.links.size()),
      sphere(renderer->addMesh(makeSphere(kRcmRadius, 24))),
      arrow(renderer->addMesh(makeArrow(16))),
      disc(renderer->addMesh(makeDisc(24))),
      stop(renderer->addMesh(makeSphere(kStopRadius, 10))),
      tube(renderer->addMesh(model::Mesh{})),
      trails(raven_model.arms.geometry, raven_model.X_WB, wanted.trails),
      positions(raven_model.description.links.size(), 0.0),
      X_WL(raven_model.description.links.size()) {
  for (int& mesh : trail_meshes)
    mesh = renderer->addMesh(model::Mesh{});
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
    scene.drawables.push_back(drawableOf(visual, X_W));
    scene.drawables.back().is_fixed = body < 0;  // what may break off hangs on a fixed joint, too
    scene.drawables.back().part = static_cast<std::uint16_t>(1 + raven.description.links.size() + link);
  }
}

void SceneBuilder::Impl::addArms(const Snapshot& snapshot) {
  raven.linkPosesInWorld({snapshot.model.arms[0].q, snapshot.model.arms[1].q}, &positions, &X_WL);
  for (const Visual& visual : raven_visuals) {
    scene.drawables.push_back(drawableOf(visual, X_WL[static_cast<std::size_t>(visual.link)]));
    scene.drawables.back().part = static_cast<std::uint16_t>(1 + visual.link);
  }
  for (const Arm arm : kArms)
    scene.drawables.push_back({sphere, at(raven.X_WB, arm), kRcmColour});
}

bool SceneBuilder::Impl::isGhostShown(const Snapshot& snapshot, Arm arm) const {
  return tipError(snapshot, arm) > options.haptics.tolerance;  // false for NaN
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
  const bool is_under_way = traitsOf(model.mode).follows_plan;
  addPath(is_under_way ? path.placeOf(at(model.arms, at_hand->arm).q_d) : 0.0);
  PerArm<JointArray> q{model.arms[0].q, model.arms[1].q};
  at(q, at_hand->arm) = at_hand->waypoints[at_hand->waypoint_count - 1];
  addGhost(q, at_hand->arm, kGoalColour);
}

void SceneBuilder::Impl::addOverlay(const Snapshot& snapshot) {
  scene.overlay = describe(snapshot, options);
  if (!shows(OverlayKind::kPlan)) return;
  const std::string line = planLine(snapshot, pathError(raven.arms.geometry, snapshot));
  if (!line.empty()) scene.overlay.lines.push_back(line);
}

void SceneBuilder::Impl::addArrow(const Snapshot& snapshot,
                                  Arm arm,
                                  const Vector3& force_W,
                                  const std::array<float, 3>& rgb) {
  const double force = force_W.norm();
  if (!(force > kLeastForce) || !std::isfinite(force)) return;
  const Vector3 tip_W = at(raven.X_WB, arm) * toEigen(at(snapshot.model.arms, arm).p_BT);
  const double length = std::min(kArrowBase + kArrowPerNewton * force, kLongestArrow);
  // A mark: along the shaft, which is where a tool is pulled, the arrow would be inside it.
  const std::array<float, 4> colour{rgb[0], rgb[1], rgb[2], 1.0F};
  scene.drawables.push_back({arrow, arrowPose(tip_W, force_W, length), colour, /*is_mark=*/true});
}

void SceneBuilder::Impl::addForces(const Snapshot& snapshot, Arm arm) {
  addArrow(snapshot, arm, toEigen(at(snapshot.contact_W, arm)), kContactForceColour);
  addArrow(snapshot, arm, at(raven.X_WB, arm).R * toEigen(at(snapshot.haptic.force_B, arm)), kHandForceColour);
}

/** A wall where the tool will be stopped, the plainer the nearer it is, and in words. */
void SceneBuilder::Impl::addLimits(const Snapshot& snapshot) {
  for (const NearLimit& limit : nearLimits(raven.arms.geometry, raven.X_WB, options.haptics.edge, snapshot)) {
    scene.overlay.warnings.push_back(limit.text);
    if (!limit.is_wall) continue;
    const double opacity = kFaintWall + limit.nearness * (kPlainWall - kFaintWall);
    const auto& c = kWallColour;
    scene.drawables.push_back(
        {disc, arrowPose(limit.p_W, limit.along_W, kWallRadius), {c[0], c[1], c[2], static_cast<float>(opacity)}});
  }
}

void SceneBuilder::Impl::addTrails() {
  for (std::size_t i = 0; i < kTrailCount; ++i) {
    const std::vector<Vector3> marks = trails.marks(static_cast<Trail>(i));
    if (marks.empty()) continue;
    pictures.replaceMesh(trail_meshes[i], makeMarks(marks, kMarkRadius));
    scene.drawables.push_back({trail_meshes[i], Pose{}, kTrailColours[i], /*is_mark=*/true});
  }
}

std::vector<std::string> partNames(const model::RavenModel& raven, const model::SceneModel& scene) {
  std::vector<std::string> names{""};
  for (const model::Description* description : {&raven.description, &scene.description})
    for (const model::Link& link : description->links)
      names.push_back(link.name);
  return names;
}

SceneOptions::SceneOptions(const PictureConfig& config, OverlaySet wanted)
    : haptics(config.haptics), overlays(wanted), trails(config.render.trails), stale_after(config.stale_after) {
  for (const ExerciseTrack& track : config.tracks)
    exercise_steps += static_cast<std::uint32_t>(track.steps.size());
}

SceneBuilder::SceneBuilder(const model::RavenModel& raven,
                           const model::SceneModel& scene,
                           const SceneOptions& options,
                           Renderer* renderer)
    : impl_(std::make_unique<Impl>(raven, scene, options, renderer)) {}

SceneBuilder::~SceneBuilder() = default;

void SceneBuilder::follow(const Snapshot& snapshot) {
  if (impl_->shows(OverlayKind::kTrails)) impl_->trails.follow(snapshot);
}

const Scene& SceneBuilder::build(const Snapshot& snapshot) {
  Impl& impl = *impl_;
  follow(snapshot);
  impl.scene.drawables.clear();
  impl.scene.is_black = snapshot.is_black;
  impl.addFixedScene(snapshot);
  impl.addArms(snapshot);
  for (const Arm arm : kArms) {
    if (impl.shows(OverlayKind::kGhost) && impl.isGhostShown(snapshot, arm))
      impl.addGhost({snapshot.robot.arms[0].q, snapshot.robot.arms[1].q}, arm, kGhostColour);
    if (impl.shows(OverlayKind::kForceArrows)) impl.addForces(snapshot, arm);
  }
  if (impl.shows(OverlayKind::kTrails)) impl.addTrails();
  if (impl.shows(OverlayKind::kPlan)) impl.addPlan(snapshot);
  impl.addOverlay(snapshot);
  if (impl.shows(OverlayKind::kWorkspace)) impl.addLimits(snapshot);
  return impl.scene;
}

}  // namespace raven2_trainer::render
