#include "ros/crtk/crtk_states.h"

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "ros/crtk/crtk_reader.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr Tick kLongestGap = 100;  // [1 ms] over which a rate still says something

constexpr PerArm<std::array<const char*, kJointCount>> kRavenNames{
    {{"gold_shoulder", "gold_elbow", "gold_ins", "gold_roll", "gold_wrist", "gold_jaw1", "gold_jaw2"},
     {"green_shoulder", "green_elbow", "green_ins", "green_roll", "green_wrist", "green_jaw1", "green_jaw2"}}};
constexpr PerArm<std::array<const char*, 3>> kRavenGraspNames{
    {{"gold_grasp", "gold_jaw1", "gold_jaw2"}, {"green_grasp", "green_jaw1", "green_jaw2"}}};

/** Positions or rates of all seven. */
JointArray allJoints(const ServoJoints& joints, double jaw) noexcept {
  JointArray q{};
  kinematics::setJaws(0.0, jaw, &q);
  return control::withServoJoints(q, joints);
}

template <std::size_t N>
void assign(const std::array<double, N>& numbers, std::vector<double>* values) {
  values->assign(numbers.begin(), numbers.end());
}

template <std::size_t N>
void assignNames(const std::array<const char*, N>& names, std::vector<std::string>* values) {
  if (values->size() != N) values->assign(names.begin(), names.end());
}

template <typename Xyz>
void set(const Vector3& v, Xyz* xyz) {
  xyz->x = v.x();
  xyz->y = v.y();
  xyz->z = v.z();
}

void set(const Matrix3& R, geometry_msgs::Quaternion* rotation) {
  const Quaternion q(R);
  rotation->x = q.x();
  rotation->y = q.y();
  rotation->z = q.z();
  rotation->w = q.w();
}

Pose inFrame(const CrtkFrame& frame, const Pose& X_BT) {
  return frame.X_BR.inverse() * X_BT;
}

/** Once: names and sizes stay. */
void setLayout(std_msgs::MultiArrayLayout* layout) {
  if (layout->dim.size() == 2) return;
  layout->dim.resize(2);
  layout->dim[0].label = "rows";
  layout->dim[0].size = 6;
  layout->dim[0].stride = 36;
  layout->dim[1].label = "columns";
  layout->dim[1].size = 6;
  layout->dim[1].stride = 6;
}

}  // namespace

CrtkMeasured measured(const ArmGeometry& geometry,
                      Arm arm,
                      const JointArray& q,
                      const JointArray& dq,
                      const JointArray& tau) noexcept {
  CrtkMeasured m;
  m.q = control::servoJoints(q);
  m.dq = control::servoJoints(dq);
  m.effort = control::servoForces(tau);
  m.jaw = kinematics::jawOpening(q);
  m.jaw_rate = kinematics::jawOpening(dq);
  m.jaw_effort = control::jawForce(tau);
  m.X_BT = kinematics::forward(geometry, arm, q);
  m.J_B = control::servoJacobian(geometry, arm, q);
  const Eigen::Matrix<double, 6, 1> twist = m.J_B * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(m.dq.data());
  m.v_B = twist.head<3>();
  m.w_B = twist.tail<3>();
  return m;
}

void MeasuredSource::take(Arm arm, const ModelState& model, const RobotState& robot, const ros::Time& stamp) noexcept {
  if (model.robot_fresh != 0 && robot.connected != 0 && robot.frame > 0) {
    from_ = MeasuredFrom::kRobot;
    q_ = at(robot.arms, arm).q;
    dq_ = at(robot.arms, arm).dq;
    stamp_ = stamp;
    fresh_tick_ = model.tick;
    age_ = 0;
  } else if (fresh_tick_ < 0) {
    q_ = at(model.arms, arm).q;
    dq_ = at(model.arms, arm).dq;
    stamp_ = stamp;
  } else {
    age_ = model.tick - fresh_tick_;
    from_ = age_ <= kRepeated ? MeasuredFrom::kStale : MeasuredFrom::kNone;
  }
}

ServoJacobian atOrigin(const CrtkFrame& frame, const CrtkMeasured& measured) {
  const Vector3 p_RT_B = measured.X_BT.p - frame.X_BR.p;
  ServoJacobian J_B = measured.J_B;
  for (Eigen::Index j = 0; j < J_B.cols(); ++j)
    J_B.col(j).head<3>() += p_RT_B.cross(Vector3(measured.J_B.col(j).tail<3>()));
  return J_B;
}

const ServoJoints& SetpointRate::of(Tick tick, const ServoJoints& q, double jaw) noexcept {
  const Tick gap = tick - tick_;
  if (gap == 0) return rate_;
  const bool is_known = tick_ >= 0 && gap > 0 && gap <= kLongestGap;
  const double per_second = is_known ? 1.0 / (static_cast<double>(gap) * kTickSeconds) : 0.0;
  for (std::size_t j = 0; j < kServoJointCount; ++j)
    rate_[j] = (q[j] - q_[j]) * per_second;
  jaw_rate_ = (jaw - jaw_) * per_second;
  q_ = q;
  jaw_ = jaw;
  tick_ = tick;
  return rate_;
}

void fill(const CrtkJoints& joints, sensor_msgs::JointState* message) {
  assignNames(kServoJointNames, &message->name);
  assign(joints.q, &message->position);
  assign(joints.dq, &message->velocity);
  assign(joints.effort, &message->effort);
}

void fillJaw(const CrtkJoints& joints, sensor_msgs::JointState* message) {
  assignNames(std::array<const char*, 1>{kJawName}, &message->name);
  message->position.assign(1, joints.jaw);
  message->velocity.assign(1, joints.jaw_rate);
  message->effort.assign(1, joints.jaw_effort);
}

void fillRaven(Arm arm, const CrtkJoints& joints, sensor_msgs::JointState* message) {
  assignNames(at(kRavenNames, arm), &message->name);
  assign(allJoints(joints.q, joints.jaw), &message->position);
  assign(allJoints(joints.dq, joints.jaw_rate), &message->velocity);
  assign(control::jointForces(joints.effort, joints.jaw_effort), &message->effort);
}

void fillRavenGrasp(Arm arm, const CrtkJoints& joints, sensor_msgs::JointState* message) {
  fillRaven(arm, joints, message);
  assignNames(at(kRavenGraspNames, arm), &message->name);
  const auto keep = [](double opening, std::vector<double>* values) {
    *values = {opening, (*values)[5], (*values)[6]};
  };
  keep(joints.jaw, &message->position);
  keep(joints.jaw_rate, &message->velocity);
  keep(joints.jaw_effort, &message->effort);
}

void fill(const CrtkFrame& frame, const Pose& X_BT, geometry_msgs::PoseStamped* message) {
  const Pose X_RT = inFrame(frame, X_BT);
  set(X_RT.p, &message->pose.position);
  set(X_RT.R, &message->pose.orientation);
}

void fill(const CrtkFrame& frame, const Pose& X_BT, geometry_msgs::TransformStamped* message) {
  const Pose X_RT = inFrame(frame, X_BT);
  set(X_RT.p, &message->transform.translation);
  set(X_RT.R, &message->transform.rotation);
}

void fill(const CrtkFrame& frame, const Vector3& v_B, const Vector3& w_B, geometry_msgs::TwistStamped* message) {
  const Matrix3 R_RB = frame.X_BR.R.transpose();
  set(R_RB * v_B, &message->twist.linear);
  set(R_RB * w_B, &message->twist.angular);
}

void fill(const CrtkFrame& frame, const ServoJacobian& J_B, std_msgs::Float64MultiArray* message) {
  setLayout(&message->layout);
  ServoJacobian J_R;
  J_R.topRows<3>() = frame.X_BR.R.transpose() * J_B.topRows<3>();
  J_R.bottomRows<3>() = frame.X_BR.R.transpose() * J_B.bottomRows<3>();
  message->data.resize(36);
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message->data.data()) = J_R;
}

}  // namespace raven2_trainer::ros_bridge
