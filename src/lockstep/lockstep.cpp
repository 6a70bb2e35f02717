#include "raven2_trainer/lockstep/lockstep.h"

#include <algorithm>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/recording/recorder.h"

namespace raven2_trainer::lockstep {
namespace {

constexpr Tick kProgressTicks = 100;

}  // namespace

struct Lockstep::Impl {
  Impl(const TrainerConfig& configuration,
       std::unique_ptr<console::MotionSource> source,
       const session::SessionPaths& paths,
       const std::string& motion)
      : config(configuration),
        stack(config, std::move(source)),
        recorder(config, stack.bodyNames(), paths, motion, stack.shared()) {}

  void tick() {
    stack.tick();
    recorder.follow();
  }

  const TrainerConfig config;
  LockstepStack stack;
  recording::Recorder recorder;
  bool finished{false};
};

Lockstep::Lockstep(const TrainerConfig& config,
                   std::unique_ptr<console::MotionSource> source,
                   const session::SessionPaths& paths,
                   const std::string& motion)
    : impl_(std::make_unique<Impl>(config, std::move(source), paths, motion)) {}

Lockstep::~Lockstep() = default;

void Lockstep::impair(const Impairment& impairment) {
  impl_->stack.impair(impairment);
}

void Lockstep::showFirst(const std::string& session) {
  impl_->stack.showFirst(session);
}

void Lockstep::setSignals(const FaultSignals& signals) noexcept {
  impl_->stack.setSignals(signals);
}

void Lockstep::tick() {
  impl_->tick();
}

bool Lockstep::run(double seconds, const std::function<void(double)>& progress, End end) {
  const auto wanted = toTicks(seconds);
  const auto timeout = toTicks(impl_->config.runtime.start_timeout);
  Tick afterwards = 0, shown = 0;
  for (;;) {
    tick();
    const ModelState& model = impl_->stack.view().model;
    if (model.mode == Mode::kReplaying) ++shown;
    if (model.session_tick + 1 >= wanted) break;
    if (end == End::kFinished && impl_->stack.finished() && ++afterwards > kAfterwards) break;
    if (end == End::kAtOnce && impl_->stack.finished()) break;
    if (end != End::kAtOnce && model.session_tick < 0 && timeout > 0 && model.tick - shown >= timeout) {
      finish();
      return false;
    }
    if (progress && model.tick % kProgressTicks == 0) {
      progress(static_cast<double>(std::max<Tick>(model.session_tick, 0)) / static_cast<double>(wanted));
    }
  }
  finish();
  return true;
}

void Lockstep::finish() {
  if (!impl_->finished) {
    impl_->recorder.drain();  // the counts include it
    impl_->recorder.finish(impl_->stack.counts());
  }
  impl_->finished = true;
}

const LockstepView& Lockstep::view() const noexcept {
  return impl_->stack.view();
}

}  // namespace raven2_trainer::lockstep
