#include "raven2_trainer/model/raven_model.h"

#include <cmath>
#include <sstream>

#include "model/xml_outline.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/joint_conventions.h"

namespace raven2_trainer::model {
namespace {

constexpr double kSame = 1e-9;       // [m, -] URDF against DH chain
constexpr double kSameLimit = 1e-6;  // [rad, m]
constexpr int kProbes = 16;          // joint vectors tried in addition to home

constexpr PerArm<const char*> kBaseLinks{"base_link_L", "base_link_R"};

const Link& linkAt(const RavenModel& model, int link) {
  return model.description.links[static_cast<std::size_t>(link)];
}

[[noreturn]] void failAtLink(const RavenModel& model, int link, const std::string& what) {
  failAt(model.description.file, linkAt(model, link).line, "link '" + linkAt(model, link).name + "': " + what);
}

double difference(const Pose& a, const Pose& b) {
  return std::max((a.R - b.R).cwiseAbs().maxCoeff(), (a.p - b.p).cwiseAbs().maxCoeff());
}

/** Tool frame by way of a jaw: the mid-line is half the opening away from either jaw. */
Pose toolFromJaw(const Pose& X_WJ, double half_opening) {
  return X_WJ * Pose{Eigen::AngleAxisd(half_opening, Vector3::UnitZ()).toRotationMatrix(), Vector3::Zero()};
}

void checkChainAt(const RavenModel& model, Arm arm, const JointArray& q) {
  PerArm<JointArray> both{model.arms.geometry.home, model.arms.geometry.home};
  at(both, arm) = q;
  std::vector<double> positions(model.description.links.size());
  std::vector<Pose> poses(model.description.links.size());
  model.linkPosesInWorld(both, &positions, &poses);
  const Pose X_WT = at(model.X_WB, arm) * kinematics::forward(model.arms.geometry, arm, q);
  const double half = kinematics::jawOpening(q) / 2.0;
  for (const auto& [jaw, turn] : {std::pair{kGrasp1, half}, std::pair{kGrasp2, -half}}) {
    const int link = at(model.links, arm)[jaw];
    const double error = difference(toolFromJaw(poses[static_cast<std::size_t>(link)], turn), X_WT);
    if (error <= kSame) continue;
    std::ostringstream what;
    what << "the chain differs by " << error << " (allowed " << kSame << ") from the DH chain of arms.yaml with tool "
         << model.arms.tool << "; run scripts/generate_description";
    failAtLink(model, link, what.str());
  }
}

void checkChain(const RavenModel& model, Arm arm) {
  checkChainAt(model, arm, model.arms.geometry.home);
  Random random(1);
  for (int i = 0; i < kProbes; ++i) {
    JointArray q{};
    for (std::size_t j = 0; j < kJointCount; ++j) {
      q[j] = random.uniform(model.arms.geometry.q_min[j], model.arms.geometry.q_max[j]);
    }
    checkChainAt(model, arm, q);
  }
}

void checkBase(const RavenModel& model, Arm arm) {
  const Pose expected{armBaseRotation(arm), toEigen(at(model.arms.rcm_W, arm))};
  const double error = difference(at(model.X_WB, arm), expected);
  if (error <= kSame) return;
  std::ostringstream what;
  what << "its place differs by " << error << " from rcm_W of arms.yaml; run scripts/generate_description";
  failAtLink(model, at(model.base_links, arm), what.str());
}

/** The URDF's limits are those of arms.yaml in URDF coordinates. */
void checkLimits(const RavenModel& model, Arm arm) {
  const ArmGeometry& geometry = model.arms.geometry;
  const JointArray a = kinematics::toUrdf(arm, geometry.d4, geometry.q_min);
  const JointArray b = kinematics::toUrdf(arm, geometry.d4, geometry.q_max);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Link& link = linkAt(model, at(model.links, arm)[j]);
    const double error =
        std::max(std::abs(link.lower - std::min(a[j], b[j])), std::abs(link.upper - std::max(a[j], b[j])));
    if (error <= kSameLimit) continue;
    std::ostringstream what;
    what << "limits of joint '" << link.joint_name << "' differ by " << error << " from arms.yaml with tool "
         << model.arms.tool << "; run scripts/generate_description";
    failAtLink(model, at(model.links, arm)[j], what.str());
  }
}

void findLinks(RavenModel* model, Arm arm) {
  at(model->base_links, arm) = model->description.linkIndex(at(kBaseLinks, arm));
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const int link = model->description.jointIndex(kinematics::urdfJointNames(arm)[j]);
    const JointKind expected = j == kInsertion ? JointKind::kPrismatic : JointKind::kRevolute;
    if (linkAt(*model, link).joint != expected) failAtLink(*model, link, "joint of the wrong type");
    at(model->links, arm)[j] = link;
  }
}

}  // namespace

void RavenModel::jointPositions(const PerArm<JointArray>& q, std::vector<double>* positions) const {
  for (const Arm arm : kArms) {
    const JointArray urdf = kinematics::toUrdf(arm, arms.geometry.d4, at(q, arm));
    for (std::size_t j = 0; j < kJointCount; ++j)
      (*positions)[static_cast<std::size_t>(at(links, arm)[j])] = urdf[j];
  }
}

void RavenModel::linkPosesInWorld(const PerArm<JointArray>& q,
                                  std::vector<double>* positions,
                                  std::vector<Pose>* poses) const {
  jointPositions(q, positions);
  linkPoses(description, *positions, poses);
}

Matrix3 armBaseRotation(Arm arm) noexcept {
  Matrix3 R_WB;  // columns: x0, y0, z0 in W (core/frames.h)
  if (arm == Arm::kGold) {
    R_WB << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  } else {
    R_WB << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  }
  return R_WB;
}

RavenModel loadRavenModel(const ModelSource& config) {
  RavenModel model;
  model.description = loadUrdf(config.robot_urdf);
  model.arms = config.arms;
  for (const Arm arm : kArms)
    findLinks(&model, arm);
  const std::vector<double> zero(model.description.links.size(), 0.0);
  std::vector<Pose> poses(zero.size());
  linkPoses(model.description, zero, &poses);
  for (const Arm arm : kArms) {
    at(model.X_WB, arm) = poses[static_cast<std::size_t>(at(model.base_links, arm))];
    checkBase(model, arm);
    checkLimits(model, arm);
    checkChain(model, arm);
  }
  return model;
}

}  // namespace raven2_trainer::model
