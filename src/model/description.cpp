
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::model {
namespace {

/** Index of the link with `name` in member `field`. */
int find(const Description& description, const std::string& name, std::string Link::*field, const char* what) {
  std::string known;
  for (std::size_t i = 0; i < description.links.size(); ++i) {
    const std::string& candidate = description.links[i].*field;
    if (candidate == name) return static_cast<int>(i);
    if (!candidate.empty()) known += (known.empty() ? "" : ", ") + candidate;
  }
  throw ModelException(description.file + ":1: no " + what + " '" + name + "'; there are: " + known);
}

Pose motion(const Link& link, double position) noexcept {
  Pose X;
  if (link.joint == JointKind::kRevolute) {
    X.R = Eigen::AngleAxisd(position, link.axis).toRotationMatrix();
  } else if (link.joint == JointKind::kPrismatic) {
    X.p = position * link.axis;
  }
  return X;
}

}  // namespace

int Description::linkIndex(const std::string& link_name) const {
  return find(*this, link_name, &Link::name, "link");
}

int Description::jointIndex(const std::string& joint_name) const {
  return find(*this, joint_name, &Link::joint_name, "joint");
}

void linkPoses(const Description& description, const std::vector<double>& positions, std::vector<Pose>* poses) {
  for (std::size_t i = 0; i < description.links.size(); ++i) {
    const Link& link = description.links[i];
    const Pose X_PL = link.X_PJ * motion(link, positions[i]);
    (*poses)[i] = link.parent < 0 ? X_PL : (*poses)[static_cast<std::size_t>(link.parent)] * X_PL;
  }
}

}  // namespace raven2_trainer::model
