#include "tick_formulas.h"

#include <algorithm>
#include <cmath>

#include "record_codec.h"

namespace raven2_trainer::session {
namespace {

/** A visitor of the fields: finds in which column a number of the record is. */
class ColumnFinder {
 public:
  template <typename T>
  void field(const char*, const T& value, const char*, const char*) {
    look(value);
  }

  void count(const char*, const std::uint32_t& value, std::size_t, const char*, const char*) { look(value); }

  /** @param[in] number of `record`. */
  static std::uint16_t columnOf(const TickRecord& record, const void* number) {
    ColumnFinder visitor;
    visitor.wanted_ = number;
    visitFields(visitor, record);
    return visitor.found_;
  }

 private:
  template <typename T>
  void look(const T& value) {
    if constexpr (IsArray<T>::value) {
      for (const auto& element : value)
        look(element);
    } else if constexpr (std::is_arithmetic<T>::value || std::is_enum<T>::value) {
      if (&value == wanted_) found_ = count_;
      ++count_;
    } else {
      visitFields(*this, value);
    }
  }

  const void* wanted_{};
  std::uint16_t count_{0}, found_{0};
};

struct ModelColumns {
  std::uint16_t q, dq, q_d, tau, p, v, orientation;
};
struct RobotColumns {
  std::uint16_t motor, q, dq, p, v;
};
struct TickColumns {
  std::uint16_t cycle;
  PerArm<ModelColumns> model;
  PerArm<RobotColumns> robot;
};

const TickColumns& columnsOfTick() {
  static const TickColumns kColumns = [] {
    const TickRecord r{};
    const auto at = [&r](const auto& number) { return ColumnFinder::columnOf(r, &number); };
    TickColumns c{at(r.robot.cycle), {}, {}};
    for (std::size_t k = 0; k < kArmCount; ++k) {
      const ArmState& m = r.model.arms[k];
      c.model[k] = {at(m.q[0]), at(m.dq[0]), at(m.q_d[0]), at(m.tau[0]), at(m.p_BT[0]), at(m.v_BT[0]), at(m.q_BT[0])};
      const RobotArmState& a = r.robot.arms[k];
      c.robot[k] = {at(a.motor[0]), at(a.q[0]), at(a.dq[0]), at(a.p_BT[0]), at(a.v_BT[0])};
    }
    return c;
  }();
  return kColumns;
}

void add(std::vector<double>* numbers, const JointArray& values) {
  numbers->insert(numbers->end(), values.begin(), values.end());
}

/** A tick's error is proportional to the change of the rate, as the rate of a damped joint is no straight line. The
 * factor is that of least squares. */
Formula positions(const ModelColumns& c, const RecordView& ticks) {
  JointArray missed{}, changed{}, bend{};
  for (std::size_t t = 1; t < ticks.count; ++t) {
    const JointArray q0 = ticks.joints(c.q, t - 1), q1 = ticks.joints(c.q, t);
    const JointArray v0 = ticks.joints(c.dq, t - 1), v1 = ticks.joints(c.dq, t);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double change = v1[j] - v0[j];
      missed[j] += change * ((q1[j] - q0[j]) - (v0[j] + v1[j]) / 2.0 * kTickSeconds);
      changed[j] += change * change;
    }
  }
  for (std::size_t j = 0; j < kJointCount; ++j)
    bend[j] = changed[j] > 0.0 ? missed[j] / changed[j] : 0.0;
  Formula course{FormulaKind::kPositions, {c.dq, c.q}, {}};
  add(&course.numbers, ticks.joints(c.q, 0));
  add(&course.numbers, bend);
  return course;
}

/** Gravity and friction, which the law lacks, change little in a chunk: they are those of its second tick. */
Formula control(const ModelColumns& c, const ControlGains& gains, const RecordView& ticks) {
  Formula law{FormulaKind::kControl, {c.q_d, c.q, c.dq, c.tau}, {}};
  for (const JointArray& each : {gains.kp, gains.kd, gains.ki, JointArray{}})
    add(&law.numbers, each);
  if (ticks.count < 2) return law;
  std::vector<double> without;
  evaluate(law, {ticks.rows, ticks.stride, 2, ticks.offsets}, &without);
  const JointArray tau = ticks.joints(c.tau, 1);
  for (std::size_t j = 0; j < kJointCount; ++j)
    law.numbers[3 * kJointCount + j] = tau[j] - without[2 * j + 1];
  return law;
}

}  // namespace

void TickFormulas::advance(const RecordView& ticks, std::size_t row) {
  const TickColumns& c = columnsOfTick();
  const auto cycle = ticks.get<Tick>(c.cycle, row);
  const std::int64_t cycles = cycle_ ? cyclesBetween(*cycle_, cycle) : kMostCycles;
  for (std::size_t k = 0; k < kArmCount; ++k) {
    const JointArray motor = ticks.joints(c.robot[k].motor, row);
    filters_[k].advance(motor_[k], motor, cycles);
    motor_[k] = motor;
    const JointArray& filtered = filters_[k].y[0];
    const bool is_finite = std::all_of(filtered.begin(), filtered.end(), [](double y) { return std::isfinite(y); });
    if (!is_finite || cycles == kMostCycles) filters_[k] = {};  // at rest: a robot that was not heard for a while
  }
  cycle_ = cycle;
}

/** Its filter is given as it is after the first tick. */
Formula TickFormulas::robot(const RecordView& ticks) {
  const TickColumns& c = columnsOfTick();
  advance(ticks, 0);
  Formula robot{FormulaKind::kRobot,
                {c.cycle, c.robot[0].motor, c.robot[1].motor, c.robot[0].q, c.robot[1].q, c.robot[0].dq, c.robot[1].dq},
                {}};
  for (const auto& matrix : constants_.joint_of_motor) {
    for (const JointArray& row : matrix)
      add(&robot.numbers, row);
  }
  for (const auto lines : {&MotorFilter::x, &MotorFilter::y}) {
    for (const MotorFilter& filter : filters_) {
      for (const JointArray& line : filter.*lines)
        add(&robot.numbers, line);
    }
  }
  for (std::size_t row = 1; row < ticks.count; ++row)
    advance(ticks, row);
  return robot;
}

std::vector<Formula> TickFormulas::of(const RecordView& ticks) {
  const TickColumns& c = columnsOfTick();
  std::vector<Formula> all{robot(ticks)};
  for (std::size_t k = 0; k < kArmCount; ++k) {
    const ModelColumns& m = c.model[k];
    const RobotColumns& r = c.robot[k];
    const std::vector<double> arm{static_cast<double>(k), constants_.d4, constants_.lw};
    all.push_back(positions(m, ticks));
    all.push_back(control(m, constants_.gains[k], ticks));
    all.push_back({FormulaKind::kTip, {m.q, m.dq, m.p, m.v}, arm});
    all.push_back({FormulaKind::kOrientation, {m.q, m.orientation}, arm});
    all.push_back({FormulaKind::kTip, {r.q, r.dq, r.p, r.v}, arm});
  }
  return all;
}

}  // namespace raven2_trainer::session
