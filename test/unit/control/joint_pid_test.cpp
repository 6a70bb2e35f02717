#include "raven2_trainer/control/joint_pid.h"

#include <gtest/gtest.h>

namespace raven2_trainer::control {
namespace {

std::array<JointGains, kJointCount> gains() {
  std::array<JointGains, kJointCount> g;
  g.fill({100.0, 2.0, 0.0, 10.0});
  g[kInsertion] = {100.0, 2.0, 50.0, 10.0};
  return g;
}

TEST(JointPid, IsAPdWithDampingOnTheVelocity) {
  JointPid pid(gains());
  JointArray q_d{}, q{}, dq{}, feed{};
  q_d[kShoulder] = 0.05;
  dq[kShoulder] = 0.5;
  feed[kShoulder] = 0.25;
  EXPECT_DOUBLE_EQ(pid.torque(q_d, q, dq, feed)[kShoulder], 100 * 0.05 - 2 * 0.5 + 0.25);
}

TEST(JointPid, IsBounded) {
  JointPid pid(gains());
  JointArray q_d{};
  q_d.fill(5.0);
  for (const double tau : pid.torque(q_d, {}, {}, {}))
    EXPECT_EQ(tau, 10.0);
}

TEST(JointPid, IntegratesTheInsertionOnlyAndNeverWindsUp) {
  JointPid pid(gains());
  JointArray q_d{};
  q_d.fill(0.01);
  JointArray tau{};
  for (int i = 0; i < 1000; ++i)
    tau = pid.torque(q_d, {}, {}, {});
  EXPECT_NEAR(tau[kShoulder], 1.0, 1e-12);
  EXPECT_NEAR(tau[kInsertion], 1.0 + 50 * 0.01 * 1.0, 1e-9);  // one second of error
  q_d.fill(5.0);
  for (int i = 0; i < 10000; ++i)
    pid.torque(q_d, {}, {}, {});  // at the bound for ten seconds
  q_d.fill(0.0);
  EXPECT_LT(pid.torque(q_d, {}, {}, {})[kInsertion], 1.0) << "the integral grew while saturated";
}

TEST(JointPid, IsBoundedAndNeverWindsUpInEitherDirection) {
  for (const double sign : {-1.0, 1.0}) {
    JointPid pid(gains());
    JointArray q_d{};
    q_d.fill(5.0 * sign);
    for (int i = 0; i < 10000; ++i) {
      for (const double tau : pid.torque(q_d, {}, {}, {}))
        ASSERT_EQ(tau, 10.0 * sign);
    }
    EXPECT_NEAR(pid.torque({}, {}, {}, {})[kInsertion], 0.0, 1e-12) << "the integral grew while saturated";
  }
}

}  // namespace
}  // namespace raven2_trainer::control
