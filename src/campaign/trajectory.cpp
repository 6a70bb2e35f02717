#include "campaign/trajectory.h"

#include <sys/mman.h>

#include <new>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::campaign {

Trajectory::Trajectory(std::size_t capacity) : capacity_(capacity), bytes_(sizeof(Head) + capacity * sizeof(Sample)) {
  void* memory = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw Exception("no memory for a golden run of " + std::to_string(capacity) + " ticks");
  head_ = new (memory) Head{0, kNever};
  samples_ = reinterpret_cast<Sample*>(head_ + 1);
}

Trajectory::~Trajectory() {
  ::munmap(head_, bytes_);
}

void Trajectory::seal() {
  if (::mprotect(head_, bytes_, PROT_READ) != 0) throw Exception("a golden run cannot be sealed");
}

void Trajectory::add(const Sample& sample) noexcept {
  if (isFull()) return;
  new (&samples_[head_->size]) Sample(sample);
  ++head_->size;
}

std::int64_t Trajectory::firstStop() const noexcept {
  bool plc_left = false;  // E-STOP, in which the PLC is powered on: that is no stop
  for (std::int64_t tick = 0; tick < size(); ++tick) {
    const Sample& sample = at(tick);
    const bool plc_stopped = plc_left && sample.plc == RunLevel::kEStop;
    if (plc_stopped || sample.soft_estopped != 0 || sample.program != ProgramState::kRunning) return tick;
    plc_left = plc_left || sample.plc != RunLevel::kEStop;
  }
  return kNever;
}

}  // namespace raven2_trainer::campaign
