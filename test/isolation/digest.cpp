// Prints a digest of some seconds of console, daemon and virtual Raven in lockstep without an armed fault. Built twice,
// with and without the hooks of fault injection: both programs must print the same digest.

#include <cstdio>
#include <cstring>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer {
namespace {

constexpr int kTicks = 12000;

/** FNV-1a, 64 bits. */
class Digest {
 public:
  template <typename Array>
  void add(const Array& values) {
    for (const auto value : values) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &value, sizeof(value));
      for (unsigned n = 0; n < 64; n += 8)
        hash_ = (hash_ ^ (bits >> n & 0xFFU)) * 1099511628211ULL;
    }
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_{14695981039346656037ULL};
};

int run() {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  config.virtual_raven.full_homing = false;
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  physics::initialiseOde();
  physics::attachOdeToThread();
  lockstep::LockstepStack stack(config, console::makeMotion(config, "scripted"));
  Digest digest;
  for (int i = 0; i < kTicks; ++i) {
    stack.tick();
    stack.discardRecords();
    for (const Arm arm : kArms) {
      digest.add(at(stack.view().model.arms, arm).q);
      digest.add(at(stack.view().haptic.force_I, arm));
      digest.add(at(stack.robot().arms, arm).dac);
      digest.add(at(stack.robot().arms, arm).dq);
      digest.add(stack.trueJoints(arm));
    }
  }
  std::fprintf(stderr, "hooks: %s; %d ticks, the last in mode %s\n", faults::kHasHooks ? "yes" : "no", kTicks,
               kModeNames[static_cast<std::size_t>(stack.view().model.mode)]);
  std::printf("%016llx\n", static_cast<unsigned long long>(digest.value()));
  return stack.view().model.session_tick > 0 ? 0 : 1;
}

}  // namespace
}  // namespace raven2_trainer

int main() {
  return raven2_trainer::run();
}
