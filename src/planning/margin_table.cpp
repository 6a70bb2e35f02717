#include "planning/margin_table.h"

namespace raven2_trainer::planning {
namespace {

double stepOf(const MarginTable::Axis& axis) {
  return axis.nodes > 1 ? (axis.high - axis.low) / (axis.nodes - 1) : 0.0;
}

}  // namespace

MarginTable::MarginTable(const Axis& a, const Axis& b, const std::function<double(double, double)>& margin)
    : low_a_(a.low),
      per_a_(a.nodes > 1 ? 1.0 / stepOf(a) : 0.0),
      last_a_(a.nodes - 1),
      low_b_(b.low),
      per_b_(b.nodes > 1 ? 1.0 / stepOf(b) : 0.0),
      last_b_(b.nodes - 1),
      nodes_a_(static_cast<std::size_t>(a.nodes)) {
  const double change = (a.lever * stepOf(a) + b.lever * stepOf(b)) / 2;
  for (int k = 0; k < b.nodes; ++k) {
    for (int i = 0; i < a.nodes; ++i)
      value_.push_back(margin(a.low + i * stepOf(a), b.low + k * stepOf(b)) - change);
  }
}

}  // namespace raven2_trainer::planning
