#include <Eigen/Eigenvalues>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <tuple>
#include <utility>

#include "model/primitive_meshes.h"
#include "model/quiet_urdf_parser.h"
#include "model/urdf_tree.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::model {
namespace {

constexpr std::uintmax_t kMaxUrdfBytes =
    2U << 20U;  // the files of urdf/ take 31 kB; parsing costs 20 times as much memory
// What a robot or a scene on a table can have; beyond it, sums and products of good numbers stop being good numbers.
constexpr double kMaxLength = 100.0;  // [m]
constexpr double kMinMass = 1e-9;     // [kg]
constexpr double kMaxMass = 1e5;      // [kg]
constexpr double kMinMoment = 1e-18;  // [kg m2] a grain of a milligram and a micrometre
constexpr double kMaxLimit = 1e4;     // [rad; m]
constexpr std::array<float, 4> kGrey{0.6F, 0.6F, 0.6F, 1.0F};
constexpr double kTriangleTolerance = 1e-6;  // relative: files hold rounded numbers

std::string readText(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) failAt(path, 1, "no such file");
  if (std::filesystem::file_size(path, error) > kMaxUrdfBytes) failAt(path, 1, "file over 2 MiB");
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) failAt(path, 1, "cannot be read");
  return text.str();
}

Vector3 fromUrdf(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

/** Turns the parsed URDF into a Description, link by link. */
class Loader {
 public:
  explicit Loader(const std::string& path) { description_.file = path; }

  Description load(const std::string& source) {
    tree_ = readTree(outlineXml(source, description_.file), description_.file);
    std::string errors;
    const auto model = parseQuietly(source, &errors);
    if (!model || !errors.empty()) {
      failAt(description_.file, tree_.lineOf(errors), errors.empty() ? "not a URDF" : errors);
    }
    description_.name = model->getName();
    for (const std::string& name : tree_.links)
      addLink(*model, name);
    return std::move(description_);
  }

 private:
  /** With the line of the link that is being read. */
  [[noreturn]] void fail(const std::string& what) const { failAt(description_.file, line_, what); }

  void addLink(const urdf::ModelInterface& model, const std::string& name) {
    const urdf::LinkConstSharedPtr source = model.getLink(name);
    line_ = tree_.link_lines.at(name);
    what_ = "link '" + name + "'";
    if (!source) fail(what_ + " was not read");
    Link link;
    link.name = name;
    link.line = line_;
    if (source->parent_joint) readJoint(*source->parent_joint, &link);
    readInertial(source->inertial.get(), &link);
    for (const auto& visual : source->visual_array)
      readVisual(*visual, &link);
    for (const auto& collision : source->collision_array)
      readCollision(*collision, &link);
    description_.links.push_back(std::move(link));
    indices_[name] = static_cast<int>(description_.links.size()) - 1;
  }

  Pose readPose(const urdf::Pose& source) const {
    double x = 0, y = 0, z = 0, w = 1;
    source.rotation.getQuaternion(x, y, z, w);
    const Pose pose{Quaternion(w, x, y, z).normalized().toRotationMatrix(), fromUrdf(source.position)};
    if (!pose.R.allFinite() || !pose.p.allFinite()) fail(what_ + ": origin that is not finite");
    if (pose.p.cwiseAbs().maxCoeff() > kMaxLength) fail(what_ + ": origin beyond " + text(kMaxLength) + " m");
    return pose;
  }

  void readJoint(const urdf::Joint& source, Link* link) {
    const auto line = tree_.joint_lines.find(source.name);
    const auto parent = indices_.find(source.parent_link_name);
    if (line == tree_.joint_lines.end() || parent == indices_.end()) {  // markup that the two readers take differently
      fail(what_ + " hangs on joint '" + source.name + "' of link '" + source.parent_link_name +
           "' in one of two readings of the XML");
    }
    line_ = line->second;
    const std::string link_what = std::exchange(what_, "joint '" + source.name + "'");
    link->parent = parent->second;
    link->joint_name = source.name;
    link->joint = kindOf(source);
    link->X_PJ = readPose(source.parent_to_joint_origin_transform);
    if (link->joint == JointKind::kRevolute || link->joint == JointKind::kPrismatic) readMotion(source, link);
    line_ = link->line;
    what_ = link_what;
  }

  JointKind kindOf(const urdf::Joint& source) const {
    switch (source.type) {
      case urdf::Joint::FIXED:
        return JointKind::kFixed;
      case urdf::Joint::REVOLUTE:
        return JointKind::kRevolute;
      case urdf::Joint::PRISMATIC:
        return JointKind::kPrismatic;
      case urdf::Joint::FLOATING:
        return JointKind::kFloating;
      case urdf::Joint::CONTINUOUS:
        fail(what_ + ": continuous, a joint without limits");
      default:
        fail(what_ + ": type must be fixed, revolute, prismatic or floating");
    }
  }

  void readMotion(const urdf::Joint& source, Link* link) const {
    const Vector3 axis = fromUrdf(source.axis);
    if (!axis.allFinite() || axis.norm() < 1e-9) fail(what_ + ": axis without a direction");
    link->axis = axis.normalized();
    if (!source.limits) fail(what_ + ": no limits");
    link->lower = source.limits->lower;
    link->upper = source.limits->upper;
    link->effort = source.limits->effort;
    if (!std::isfinite(link->lower) || !std::isfinite(link->upper) || !(link->lower < link->upper)) {
      fail(what_ + ": limits " + text(link->lower) + " to " + text(link->upper) + " are not a range");
    }
    if (std::max(std::abs(link->lower), std::abs(link->upper)) > kMaxLimit) {
      fail(what_ + ": limits beyond +-" + text(kMaxLimit));
    }
    if (!std::isfinite(link->effort) || !(link->effort > 0.0)) {
      fail(what_ + ": effort " + text(link->effort) + " is not positive");
    }
  }

  void readInertial(const urdf::Inertial* source, Link* link) const {
    if (source == nullptr) {
      if (link->joint != JointKind::kFixed) fail(what_ + " moves but has no inertia");
      return;
    }
    if (!std::isfinite(source->mass) || !(source->mass > 0.0)) {
      fail(what_ + ": mass " + text(source->mass) + " kg is not positive");
    }
    if (source->mass < kMinMass || source->mass > kMaxMass) {
      fail(what_ + ": mass " + text(source->mass) + " kg is not in [" + text(kMinMass) + ", " + text(kMaxMass) + "]");
    }
    Matrix3 inertia;
    inertia << source->ixx, source->ixy, source->ixz, source->ixy, source->iyy, source->iyz, source->ixz, source->iyz,
        source->izz;
    checkInertia(inertia);
    const Pose X_LC = readPose(source->origin);
    link->inertial = {source->mass, X_LC.p, X_LC.R * inertia * X_LC.R.transpose()};
  }

  /** A body's principal moments are positive and no one exceeds the sum of the other two. */
  void checkInertia(const Matrix3& inertia) const {
    if (!inertia.allFinite()) fail(what_ + ": inertia that is not finite");
    const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
    const std::string values = text(moments[0]) + ", " + text(moments[1]) + ", " + text(moments[2]) + " kg m2";
    if (!(moments[0] > 0.0)) fail(what_ + ": inertia is not positive definite, principal moments " + values);
    if (moments[0] < kMinMoment || moments[2] > kMaxMass * kMaxLength * kMaxLength) {
      fail(what_ + ": principal moments " + values + " are out of range");
    }
    if (moments[2] > (moments[0] + moments[1]) * (1.0 + kTriangleTolerance)) {
      fail(what_ + ": inertia no body can have, the largest principal moment exceeds the sum of the others: " + values);
    }
  }

  void readVisual(const urdf::Visual& source, Link* link) {
    VisualShape shape;
    shape.X_LS = readPose(source.origin);
    shape.mesh = visualMesh(source.geometry.get());
    shape.material = source.material_name;
    shape.colour = kGrey;
    if (source.material) {
      const urdf::Color& c = source.material->color;
      shape.colour = {c.r, c.g, c.b, c.a};
      for (const float part : shape.colour) {
        if (!(part >= 0.0F && part <= 1.0F)) fail(what_ + ": colour outside [0, 1]");
      }
    }
    link->visuals.push_back(shape);
  }

  int visualMesh(const urdf::Geometry* geometry) {
    if (geometry == nullptr) fail(what_ + ": visual without geometry");
    if (geometry->type == urdf::Geometry::MESH) return fileMesh(static_cast<const urdf::Mesh&>(*geometry));
    description_.meshes.push_back(primitiveMesh(*geometry));
    return static_cast<int>(description_.meshes.size()) - 1;
  }

  Mesh primitiveMesh(const urdf::Geometry& geometry) const {
    if (geometry.type == urdf::Geometry::BOX) return boxMesh(boxSize(static_cast<const urdf::Box&>(geometry)));
    if (geometry.type == urdf::Geometry::SPHERE) {
      return sphereMesh(length(static_cast<const urdf::Sphere&>(geometry).radius, "sphere radius"));
    }
    const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
    return cylinderMesh(length(cylinder.radius, "cylinder radius"), length(cylinder.length, "cylinder length"));
  }

  double length(double value, const char* what) const {
    if (!std::isfinite(value) || !(value > 0.0)) fail(what_ + ": " + what + " " + text(value) + " m is not positive");
    if (value > kMaxLength) fail(what_ + ": " + what + " " + text(value) + " m is over " + text(kMaxLength) + " m");
    return value;
  }

  Vector3 boxSize(const urdf::Box& box) const {
    return {length(box.dim.x, "box edge"), length(box.dim.y, "box edge"), length(box.dim.z, "box edge")};
  }

  void readCollision(const urdf::Collision& source, Link* link) {
    if (!source.geometry) fail(what_ + ": collision without geometry");
    CollisionShape shape;
    shape.material = source.name;
    shape.X_LS = readPose(source.origin);
    switch (source.geometry->type) {
      case urdf::Geometry::BOX:
        shape.kind = ShapeKind::kBox;
        shape.size = boxSize(static_cast<const urdf::Box&>(*source.geometry));
        break;
      case urdf::Geometry::SPHERE:
        shape.kind = ShapeKind::kSphere;
        shape.size.x() = length(static_cast<const urdf::Sphere&>(*source.geometry).radius, "sphere radius");
        break;
      case urdf::Geometry::CYLINDER:
        readCapsule(static_cast<const urdf::Cylinder&>(*source.geometry), &shape);
        break;
      case urdf::Geometry::MESH:
        shape.kind = ShapeKind::kMesh;
        shape.mesh = fileMesh(static_cast<const urdf::Mesh&>(*source.geometry));
        break;
    }
    link->collisions.push_back(shape);
  }

  void readCapsule(const urdf::Cylinder& cylinder, CollisionShape* shape) const {
    const double radius = length(cylinder.radius, "cylinder radius");
    const double straight = length(cylinder.length, "cylinder length") - 2.0 * radius;
    if (straight < -1e-9) {
      fail(what_ + ": collision cylinder of length " + text(cylinder.length) + " m is shorter than its diameter, so " +
           "it is no capsule; use a box or a sphere");
    }
    shape->kind = ShapeKind::kCapsule;
    shape->size = {radius, std::max(straight, 0.0), 0.0};
  }

  /** Each file is read once for each scale. */
  int fileMesh(const urdf::Mesh& source) {
    const auto key = std::make_tuple(source.filename, source.scale.x, source.scale.y, source.scale.z);
    const auto known = mesh_indices_.find(key);
    if (known != mesh_indices_.end()) return known->second;
    try {
      description_.meshes.push_back(
          loadMesh(resolve(source.filename), {source.scale.x, source.scale.y, source.scale.z}));
    } catch (const ModelException& e) {
      fail(what_ + ": mesh '" + source.filename + "': " + e.what());
    }
    return mesh_indices_[key] = static_cast<int>(description_.meshes.size()) - 1;
  }

  std::string resolve(const std::string& name) const {
    if (name.rfind(kPackage, 0) != 0 && name.find("://") != std::string::npos) {
      fail(what_ + ": mesh '" + name + "': only " + kPackage + " is known");
    }
    const std::string root = modelFolder(description_.file);
    const std::string path = meshPath(description_.file, name);
    const std::string inside = std::filesystem::path(path).lexically_relative(root).string();
    if (inside.empty() || inside.rfind("..", 0) == 0) {
      fail(what_ + ": mesh '" + name + "' is outside the folder " + root);
    }
    return path;
  }

  Description description_;
  UrdfTree tree_;
  std::map<std::string, int> indices_;
  std::map<std::tuple<std::string, double, double, double>, int> mesh_indices_;
  int line_{1};
  std::string what_;
};

}  // namespace

Description loadUrdf(const std::string& path) {
  return Loader(path).load(readText(path));
}

Description parseUrdf(const std::string& text, const std::string& path) {
  return Loader(path).load(text);
}

}  // namespace raven2_trainer::model
