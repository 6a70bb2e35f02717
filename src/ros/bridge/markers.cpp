#include "ros/bridge/markers.h"

#include <algorithm>
#include <array>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/render/overlays.h"

namespace raven2_trainer::ros_bridge {
namespace {

using visualization_msgs::Marker;

constexpr double kBall = 0.003;      // [m] a contact's place
constexpr double kLine = 0.0008;     // [m] wide
constexpr double kShaft = 0.0015;    // [m] of an arrow, its diameter
constexpr double kHead = 0.004;      // [m] of its head
constexpr double kSmallest = 0.001;  // [N] a shorter arrow is a dot: the cue begins at 0.05 N

Marker marker(const char* ns, int id, int type, const ros::Time& stamp) {
  Marker m;
  m.header.stamp = stamp;
  m.header.frame_id = "world";
  m.ns = ns;
  m.id = id;
  m.type = type;
  m.pose.orientation.w = 1.0;
  return m;
}

void paint(const std::array<float, 3>& rgb, Marker* m) {
  m->color.r = rgb[0];
  m->color.g = rgb[1];
  m->color.b = rgb[2];
  m->color.a = 1.0F;
}

void setScale(double x, double y, double z, Marker* m) {
  m->scale.x = x;
  m->scale.y = y;
  m->scale.z = z;
}

geometry_msgs::Point point(const Vector3& p_W) {
  geometry_msgs::Point p;
  p.x = p_W.x();
  p.y = p_W.y();
  p.z = p_W.z();
  return p;
}

geometry_msgs::Point arrowHead(const Vector3& foot_W, const Vector3& force_W) {
  const Vector3 arrow = kArrowPerNewton * force_W;
  return point(foot_W + arrow * (kLongestArrow / std::max(arrow.norm(), kLongestArrow)));
}

/** RViz complains of a list without points. */
void deleteIfEmpty(Marker* m) {
  if (m->points.empty()) m->action = Marker::DELETE;
}

Marker forceArrow(Arm arm,
                  const ModelState& model,
                  const HapticState& haptic,
                  const Pose& X_WB,
                  const ros::Time& stamp) {
  Marker arrow = marker("hand_forces", static_cast<int>(arm), Marker::ARROW, stamp);
  setScale(kShaft, kHead, kHead, &arrow);
  paint(kHandForceColour, &arrow);
  const Vector3 tip_W = X_WB * toEigen(at(model.arms, arm).p_BT);
  const Vector3 force_W = X_WB.R * toEigen(at(haptic.force_B, arm));
  if (tip_W.allFinite() && force_W.allFinite() && force_W.norm() >= kSmallest)
    arrow.points = {point(tip_W), arrowHead(tip_W, force_W)};
  deleteIfEmpty(&arrow);
  return arrow;
}

}  // namespace

visualization_msgs::MarkerArray contactMarkers(const ContactList& contacts, const ros::Time& stamp) {
  Marker places = marker("contact_points", 0, Marker::SPHERE_LIST, stamp);
  setScale(kBall, kBall, kBall, &places);
  paint(kContactForceColour, &places);
  Marker forces = marker("contact_forces", 0, Marker::LINE_LIST, stamp);
  setScale(kLine, 0.0, 0.0, &forces);
  paint(kContactForceColour, &forces);
  const std::size_t count = std::min<std::size_t>(contacts.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 p_W = toEigen(contacts.contacts[i].p_W), f_W = toEigen(contacts.contacts[i].f_W);
    if (!p_W.allFinite() || !f_W.allFinite()) continue;
    places.points.push_back(point(p_W));
    forces.points.push_back(point(p_W));
    forces.points.push_back(arrowHead(p_W, f_W));
  }
  deleteIfEmpty(&places);
  deleteIfEmpty(&forces);
  visualization_msgs::MarkerArray array;
  array.markers = {places, forces};
  return array;
}

visualization_msgs::MarkerArray forceMarkers(const ModelState& model,
                                             const HapticState& haptic,
                                             const PerArm<Pose>& X_WB,
                                             const ros::Time& stamp) {
  visualization_msgs::MarkerArray array;
  for (const Arm arm : kArms)
    array.markers.push_back(forceArrow(arm, model, haptic, at(X_WB, arm), stamp));
  return array;
}

}  // namespace raven2_trainer::ros_bridge
