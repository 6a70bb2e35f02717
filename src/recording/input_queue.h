#pragma once

#include <deque>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::recording {

/** Records of one kind that wait for their tick. They come in order of their ticks. */
template <typename Record>
class InputQueue {
 public:
  explicit InputQueue(const char* what) : what_(what) {}

  void add(const Record& record) { waiting_.push_back(record); }

  /** Hands all that belong to `tick` to `use`. @throw SessionException if one belongs to an earlier tick. */
  template <typename Use>
  void take(Tick tick, Use&& use) {
    for (; !waiting_.empty() && waiting_.front().tick <= tick; waiting_.pop_front()) {
      if (waiting_.front().tick < tick) {
        throw SessionException(std::string(what_) + " of tick " + std::to_string(waiting_.front().tick) +
                               " comes after it in the log");
      }
      use(waiting_.front());
    }
  }

 private:
  const char* what_;
  std::deque<Record> waiting_;
};

}  // namespace raven2_trainer::recording
