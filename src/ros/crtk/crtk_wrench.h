#pragma once

#include <geometry_msgs/WrenchStamped.h>

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::ros_bridge {

/** Force and moment of the model's contacts at an arm's tool tip, in W unless a name says otherwise. */
struct ArmWrench {
  Vector3 force_W{Vector3::Zero()};   ///< [N]
  Vector3 torque_W{Vector3::Zero()};  ///< [Nm] about the tip
};

/** Sums contacts by the arm that they press on. */
class ArmContacts {
 public:
  /** @param[in] body_names by the numbers of contacts; links of the arms end in _L and _R. */
  explicit ArmContacts(const std::vector<std::string>& body_names);

  /** Of contacts within an arm nothing counts, nor of bodies that there are not. @param[in] p_WT [m] the arm's tip. */
  ArmWrench on(Arm arm, const ContactList& contacts, const Vector3& p_WT) const noexcept;

 private:
  int armOf(std::uint16_t body) const noexcept;

  std::vector<std::int8_t> arms_;  // by body: Arm, or -1
};

/** The same along the tip's own axes. @param[in] X_WT the tip in W. */
ArmWrench alongTip(const ArmWrench& wrench, const Pose& X_WT) noexcept;
/** The same with its torque about the origin of W. */
ArmWrench aboutOrigin(const ArmWrench& wrench, const Pose& X_WT) noexcept;

void fill(const ArmWrench& wrench, geometry_msgs::WrenchStamped* message);

}  // namespace raven2_trainer::ros_bridge
