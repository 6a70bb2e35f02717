#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "raven2_trainer/core/spsc_ring.h"

namespace raven2_trainer::ros_bridge {

/**
 * Lines for an operator from one thread, which must not wait for a terminal, to another, which prints them. Wait-free
 * on both sides; longer ones are cut.
 */
class OperatorLines {
 public:
  /** The producer. Nothing for an empty line. */
  void say(const std::string& text) noexcept {
    if (text.empty()) return;
    Line line;
    line.size = std::min(text.size(), line.text.size());
    std::memcpy(line.text.data(), text.data(), line.size);
    ring_.tryPush(line);
  }

  /** The consumer. @return false: no line. */
  bool next(std::string* text) {
    Line line;
    if (!ring_.tryPop(&line)) return reportLost(text);
    text->assign(line.text.data(), line.size);
    return true;
  }

 private:
  struct Line {
    std::size_t size{};
    std::array<char, 504> text{};
  };

  bool reportLost(std::string* text) {
    const std::uint64_t lost = ring_.dropped();
    if (lost == reported_lost_) return false;
    *text = std::to_string(lost - reported_lost_) + " lines more, which were not kept";
    reported_lost_ = lost;
    return true;
  }

  SpscRing<Line, 32> ring_;
  std::uint64_t reported_lost_{0};
};

}  // namespace raven2_trainer::ros_bridge
