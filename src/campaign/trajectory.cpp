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

void Trajectory::add(const Sample& sample) noexcept {
  if (isFull()) return;
  new (&samples_[head_->size]) Sample(sample);
  ++head_->size;
}

}  // namespace raven2_trainer::campaign
