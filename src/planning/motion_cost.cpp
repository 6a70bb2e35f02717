#include "planning/motion_cost.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/chain.h"

namespace raven2_trainer::planning {
namespace {

constexpr std::size_t kPairs = 6;  // of instants, as early as late; 2 x 6 integrate polynomials of degree 23
constexpr std::size_t kInstants = 2 * kPairs;
using Row = std::array<double, kInstants>;

/** [-] largest step of the clearance term's integral in the cube. */
constexpr double kClearanceStep = 0.03;

/** The quintic at Gauss's instants in [0, 1]. The first half lies after the middle, the second as far before it. */
struct Instants {
  Row weight{};
  std::array<double, kPairs> offset{};  // s - 1/2, of the first half
  Row rate_squared{}, acceleration{};   // s'^2 and s''
};

/** Root `k` of the Legendre polynomial of degree kInstants, counted from 1, and its derivative there (Newton). */
std::pair<double, double> legendreRoot(std::size_t k) {
  constexpr double n = kInstants;
  double x = std::cos(kPi * (static_cast<double>(k) - 0.25) / (n + 0.5)), slope = 1.0;
  for (int iteration = 0; iteration < 20; ++iteration) {
    double before = 1.0, value = x;
    for (std::size_t i = 2; i <= kInstants; ++i) {
      const double degree = static_cast<double>(i);
      const double next = ((2 * degree - 1) * x * value - (degree - 1) * before) / degree;
      before = value;
      value = next;
    }
    slope = n * (x * value - before) / (x * x - 1.0);
    x -= value / slope;
  }
  return {x, slope};
}

Instants makeInstants() {
  Instants made;
  for (std::size_t i = 0; i < kPairs; ++i) {
    const auto [x, slope] = legendreRoot(i + 1);
    const double t = (1.0 + x) / 2, u = t * (1.0 - t);
    made.offset[i] = control::quinticBlend(t) - 0.5;
    made.weight[i] = made.weight[i + kPairs] = 1.0 / ((1.0 - x * x) * slope * slope);
    made.rate_squared[i] = made.rate_squared[i + kPairs] = 900.0 * u * u * u * u;
    made.acceleration[i] = 60.0 * u * (1.0 - 2.0 * t);
    made.acceleration[i + kPairs] = -made.acceleration[i];
  }
  return made;
}

const Instants kAt = makeInstants();

/** Cosine and sine of an angle at each instant. */
struct Turn {
  Row c, s;
};

/**
 * By those of its middle and of what it turns from there: up to 3.2 rad, a quarter of it by Taylor's series (error
 * under 1e-9), then doubled twice.
 */
Turn turnAt(double middle, double delta) noexcept {
  std::array<double, kPairs> c, s;
  for (std::size_t i = 0; i < kPairs; ++i) {
    const double x = 0.25 * delta * kAt.offset[i], y = x * x;
    const double s1 = x * (1 + y * (-1.0 / 6 + y * (1.0 / 120 + y * (-1.0 / 5040 + y * (1.0 / 362880)))));
    const double c1 = 1 + y * (-0.5 + y * (1.0 / 24 + y * (-1.0 / 720 + y * (1.0 / 40320 + y * (-1.0 / 3628800)))));
    const double s2 = 2 * s1 * c1, c2 = 1 - 2 * s1 * s1;
    s[i] = 2 * s2 * c2;
    c[i] = 1 - 2 * s2 * s2;
  }
  const double cm = std::cos(middle), sm = std::sin(middle);
  Turn turn;
  for (std::size_t i = 0; i < kPairs; ++i) {
    turn.c[i] = cm * c[i] - sm * s[i];
    turn.c[i + kPairs] = cm * c[i] + sm * s[i];
    turn.s[i] = sm * c[i] + cm * s[i];
    turn.s[i + kPairs] = sm * c[i] - cm * s[i];
  }
  return turn;
}

/** A vector at each instant. */
struct Rows {
  Row x, y, z;
};

/** A point in a frame, and its first two derivatives by s there. */
struct Motion {
  Rows p, d, dd;
};

/**
 * The tip in the frame of the shaft without its roll: insertion along z, then the wrist's bar, which points back
 * along the shaft at wrist 0 (raven2.md 2.1, links 4 to 6).
 */
Motion tipInShaft(const ArmGeometry& geometry, const JointArray& a, const JointArray& b) noexcept {
  const double roll = b[kToolRotation] - a[kToolRotation], bend = b[kWrist] - a[kWrist];
  const double slide = b[kInsertion] - a[kInsertion], middle = (a[kInsertion] + b[kInsertion]) / 2 + geometry.d4;
  const Turn R = turnAt((a[kToolRotation] + b[kToolRotation]) / 2, roll);
  const Turn W = turnAt((a[kWrist] + b[kWrist]) / 2, bend);
  const double lw = geometry.lw, both = bend * bend + roll * roll, mixed = 2 * bend * roll;
  Motion m;
  for (std::size_t i = 0; i < kInstants; ++i) {
    const double offset = i < kPairs ? kAt.offset[i] : -kAt.offset[i - kPairs];
    const double sc = W.s[i] * R.c[i], ss = W.s[i] * R.s[i], cc = W.c[i] * R.c[i], cs = W.c[i] * R.s[i];
    m.p.x[i] = lw * sc;
    m.p.y[i] = lw * ss;
    m.p.z[i] = middle + slide * offset - lw * W.c[i];
    m.d.x[i] = lw * (bend * cc - roll * ss);
    m.d.y[i] = lw * (bend * cs + roll * sc);
    m.d.z[i] = slide + lw * bend * W.s[i];
    m.dd.x[i] = lw * (-both * sc - mixed * cs);
    m.dd.y[i] = lw * (-both * ss + mixed * cc);
    m.dd.z[i] = lw * bend * bend * W.c[i];
  }
  return m;
}

/** Into the frame before, turned by a fixed quarter about z and by a fixed twist about x. */
void twist(const kinematics::Angle& twist_x, double quarter, Rows* v) noexcept {
  for (std::size_t i = 0; i < kInstants; ++i) {
    const double x = -quarter * v->y[i], y = quarter * v->x[i], z = v->z[i];
    v->x[i] = x;
    v->y[i] = twist_x.c * y - twist_x.s * z;
    v->z[i] = twist_x.s * y + twist_x.c * z;
  }
}

/** Derivatives as seen from a frame in which this one turns about z at `rate` by s. */
void addRotation(double rate, Motion* m) noexcept {
  for (std::size_t i = 0; i < kInstants; ++i) {
    m->dd.x[i] += -rate * (2 * m->d.y[i] + rate * m->p.x[i]);
    m->dd.y[i] += rate * (2 * m->d.x[i] - rate * m->p.y[i]);
    m->d.x[i] -= rate * m->p.y[i];
    m->d.y[i] += rate * m->p.x[i];
  }
}

/** Turns by the angle about z, then by the fixed twist about x. */
void turn(const Turn& angle, const kinematics::Angle& twist_x, Rows* v) noexcept {
  for (std::size_t i = 0; i < kInstants; ++i) {
    const double x = angle.c[i] * v->x[i] - angle.s[i] * v->y[i], y = angle.s[i] * v->x[i] + angle.c[i] * v->y[i];
    const double z = v->z[i];
    v->x[i] = x;
    v->y[i] = twist_x.c * y - twist_x.s * z;
    v->z[i] = twist_x.s * y + twist_x.c * z;
  }
}

/** Integral over [0, 1] of |p'' s'^2 + p' s''|^2. */
double integral(const Motion& m) noexcept {
  Row squares;
  for (std::size_t i = 0; i < kInstants; ++i) {
    const double r = kAt.rate_squared[i], a = kAt.acceleration[i];
    const double x = m.dd.x[i] * r + m.d.x[i] * a, y = m.dd.y[i] * r + m.d.y[i] * a, z = m.dd.z[i] * r + m.d.z[i] * a;
    squares[i] = kAt.weight[i] * (x * x + y * y + z * z);
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < kPairs; ++i)
    sum += squares[i] + squares[i + kPairs];
  return sum;
}

}  // namespace

double edgeDuration(const PlannerConfig& config, const JointArray& a, const JointArray& b) noexcept {
  JointArray delta{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    delta[j] = b[j] - a[j];
  return control::quinticDuration(delta, config.velocity_limit, config.acceleration_limit);
}

double tipEffort(const ArmGeometry& geometry,
                 Arm arm,
                 const JointArray& a,
                 const JointArray& b,
                 double duration) noexcept {
  if (duration <= 0.0) return 0.0;
  if (b < a) return tipEffort(geometry, arm, b, a, duration);  // same rounding both ways
  const kinematics::Chain& chain = kinematics::kChains[index(arm)];
  Motion m = tipInShaft(geometry, a, b);
  for (Rows* v : {&m.p, &m.d, &m.dd})
    twist(chain.twist2, chain.theta3.s, v);
  addRotation(b[kElbow] - a[kElbow], &m);
  const Turn elbow = turnAt((a[kElbow] + b[kElbow]) / 2 + chain.offset2, b[kElbow] - a[kElbow]);
  for (Rows* v : {&m.p, &m.d, &m.dd})
    turn(elbow, kinematics::kLink12, v);
  addRotation(b[kShoulder] - a[kShoulder], &m);
  return integral(m) / (duration * duration * duration);
}

MotionCost::MotionCost(const ArmGeometry& geometry,
                       Arm arm,
                       const JointSpace& space,
                       const PlannerConfig& limits,
                       const CostWeights& weights,
                       ClearanceFunction clearance)
    : geometry_(geometry), arm_(arm), space_(space), weights_(weights), clearance_(std::move(clearance)) {
  // The duration is the greatest of one term for each joint, so one joint at a time settles it: a unit's velocity
  // term is proportional to the distance, and so is the square of its acceleration term.
  JointArray none{};
  none.fill(1e300);
  const JointArray from = space.toJoints(UnitState{});
  for (std::size_t k = 0; k < kPlanDimension; ++k) {
    UnitState one{};
    one[k] = 1.0;
    PlannerConfig only = limits;
    only.acceleration_limit = none;
    seconds_[k] = edgeDuration(only, from, space.toJoints(one));
    only = limits;
    only.velocity_limit = none;
    square_seconds_[k] = std::pow(edgeDuration(only, from, space.toJoints(one)), 2);
  }
}

MotionEnd MotionCost::end(const UnitState& unit) const noexcept {
  const Vector3 p_BT = kinematics::forward(geometry_, arm_, space_.toJoints(unit)).p;
  return {unit, {p_BT.x(), p_BT.y(), p_BT.z()}};
}

double MotionCost::duration(const UnitState& a, const UnitState& b) const noexcept {
  double by_velocity = 0.0, by_acceleration = 0.0;
  for (std::size_t k = 0; k < kPlanDimension; ++k) {
    const double far = std::abs(b[k] - a[k]);
    by_velocity = std::max(by_velocity, far * seconds_[k]);
    by_acceleration = std::max(by_acceleration, far * square_seconds_[k]);
  }
  return std::max(by_velocity, std::sqrt(by_acceleration));
}

double MotionCost::lowerBound(const MotionEnd& a, const MotionEnd& b) const noexcept {
  // A little less than the bound: an edge on which it is met is integrated with an error of rounding.
  constexpr double kLess = 1.0 - 1e-9;
  const double length = weights_.length * distance(a.unit, b.unit);
  const double T = duration(a.unit, b.unit);
  if (weights_.acceleration <= 0.0 || T <= 0.0) return length;
  double squared = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    squared += (b.tip_B[i] - a.tip_B[i]) * (b.tip_B[i] - a.tip_B[i]);
  return kLess * (length + weights_.acceleration * 12.0 * squared / (T * T * T));
}

double MotionCost::plain(const UnitState& a, const UnitState& b) const noexcept {
  const double length = weights_.length * distance(a, b);
  if (weights_.acceleration <= 0.0) return length;
  return length +
         weights_.acceleration * tipEffort(geometry_, arm_, space_.toJoints(a), space_.toJoints(b), duration(a, b));
}

double MotionCost::clearanceTerm(const UnitState& a, const UnitState& b, double limit) const {
  if (!countsClearance()) return 0.0;
  const double length = distance(a, b);
  const int pairs = std::max(1, static_cast<int>(std::ceil(length / (2 * kClearanceStep))));
  double sum = 0.0, term = 0.0;
  for (int i = 0; i <= 2 * pairs && term < limit; ++i) {
    const double d = clearance_(interpolate(a, b, static_cast<double>(i) / (2 * pairs)), weights_.range);
    const double shortfall = std::max(0.0, 1.0 - d / weights_.range);
    const bool is_end = i == 0 || i == 2 * pairs;
    sum += (is_end ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * shortfall * shortfall;
    term = weights_.clearance * sum * length / (6 * pairs);
  }
  return term;
}

}  // namespace raven2_trainer::planning
