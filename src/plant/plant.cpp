#include "raven2_trainer/plant/plant.h"

#include "plant/arm_plant.h"
#include "plant/plc.h"

namespace raven2_trainer::plant {

struct Plant::Impl {
  Impl(const model::RavenModel& raven, const VirtualRavenConfig& config)
      : arms{ArmPlant(raven, Arm::kGold, config), ArmPlant(raven, Arm::kGreen, config)} {}

  Plc plc;
  PerArm<ArmPlant> arms;
  PerArm<raven::UsbOut> boards{};                                 // a board keeps its last command
  PerArm<std::array<std::int32_t, raven::kChannels>> power_on{};  // [counts] where the encoders began
};

Plant::Plant(const model::RavenModel& raven, const VirtualRavenConfig& config)
    : impl_(std::make_unique<Impl>(raven, config)) {
  for (const Arm arm : kArms) {
    at(impl_->power_on, arm) = at(impl_->arms, arm).encoders();
    raven::decodeOut(raven::startUpWrite(), &at(impl_->boards, arm));
  }
  pressStart();
}

Plant::~Plant() = default;

PerArm<raven::UsbInBytes> Plant::read() const noexcept {
  PerArm<raven::UsbInBytes> in;
  for (const Arm arm : kArms) {
    raven::UsbIn packet{impl_->plc.inputPins(), at(impl_->arms, arm).encoders()};
    for (std::size_t k = 0; k < raven::kChannels; ++k)
      packet.encoder[k] -= at(impl_->power_on, arm)[k];
    at(in, arm) = raven::encodeIn(packet);
  }
  return in;
}

void Plant::step(const PerArm<raven::UsbOutBytes>& out) noexcept {
  for (const Arm arm : kArms)
    raven::decodeOut(at(out, arm), &at(impl_->boards, arm));
  impl_->plc.step({impl_->boards[0].pins, impl_->boards[1].pins});
  constexpr std::array<std::int16_t, raven::kChannels> kOff{};
  for (const Arm arm : kArms) {
    at(impl_->arms, arm).step(impl_->plc.powered() ? at(impl_->boards, arm).dac : kOff, impl_->plc.brakesOn());
  }
}

void Plant::pressStart() noexcept {
  impl_->plc.pressStart();
}

void Plant::startInPedalUp() noexcept {
  impl_->plc.startIn(RunLevel::kPedalUp);
}

RunLevel Plant::runLevel() const noexcept {
  return impl_->plc.level();
}

JointArray Plant::jointPositions(Arm arm) const noexcept {
  JointArray q;
  Eigen::Map<Vector7>(q.data()) = at(impl_->arms, arm).jointPositions();
  return q;
}

}  // namespace raven2_trainer::plant
