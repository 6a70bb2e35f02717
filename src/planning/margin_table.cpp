#include "planning/margin_table.h"

namespace raven2_trainer::planning {

MarginTable::MarginTable(const Axis& a, const Axis& b)
    : a_(a),
      b_(b),
      per_a_(a.nodes > 1 ? 1.0 / stepOf(a) : 0.0),
      last_a_(a.nodes - 1),
      per_b_(b.nodes > 1 ? 1.0 / stepOf(b) : 0.0),
      last_b_(b.nodes - 1),
      value_(static_cast<std::size_t>(a.nodes) * static_cast<std::size_t>(b.nodes), kUnknown) {}

MarginTable::MarginTable(const Axis& a, const Axis& b, const std::function<double(double, double)>& margin)
    : MarginTable(a, b) {
  for (std::size_t node = 0; node < value_.size(); ++node)
    value_[node] = valueAt(node, margin);
}

}  // namespace raven2_trainer::planning
