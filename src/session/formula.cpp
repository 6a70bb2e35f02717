#include "formula.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::session {
namespace {

constexpr double kPeriod = 0.001;  // [s]

// ---- tip: modified DH, as src/kinematics ---------------------------------------------------------------------------

/** The same number of two records. The processor computes both at once, each with the bits that it has alone. */
using Pair = double __attribute__((vector_size(16)));
using PairBits = std::uint64_t __attribute__((vector_size(16)));

template <std::size_t kSize>
struct Pairs {
  Pair at[kSize];

  Pair& operator[](std::size_t i) noexcept { return at[i]; }
  const Pair& operator[](std::size_t i) const noexcept { return at[i]; }
};

PairBits bitsOf(Pair pair) noexcept {
  return reinterpret_cast<PairBits>(pair);
}

Pair pairOf(PairBits bits) noexcept {
  return reinterpret_cast<Pair>(bits);
}

/** Cosine and sine of a rotation. */
struct CosSin {
  double c, s;
};
struct CosSinPair {
  Pair c, s;
};

/** fdlibm's series, less than three units in the last place off (measured); radians beyond 1e5 count as 0. */
CosSinPair cosSin(Pair radians) noexcept {
  constexpr double kQuartersPerRadian = 6.36619772367581382433e-01;  // 2 / pi
  constexpr std::array<double, 3> kQuarter{1.57079632673412561417e+00, 6.07710050630396597660e-11,
                                           2.02226624879595063154e-21};
  constexpr std::array<double, 6> kSine{-1.66666666666666324348e-01, 8.33333333332248946124e-03,
                                        -1.98412698298579493134e-04, 2.75573137070700676789e-06,
                                        -2.50507602534068634195e-08, 1.58969099521155010221e-10};
  constexpr std::array<double, 6> kCosine{4.16666666666666019037e-02, -1.38888888888741095749e-03,
                                          2.48015872894767294178e-05, -2.75573143513906633035e-07,
                                          2.08757232129817482790e-09, -1.13596475577881948265e-11};
  // Rounds to a whole number, a half to the even one, as rint() does, which is a call. It is then in the lowest bits.
  constexpr double kRounding = 6755399441055744.0;  // 1.5 * 2^52
  constexpr Pair kLargest{1e5, 1e5};
  constexpr PairBits kSignBits{1ULL << 63U, 1ULL << 63U}, kOne{1, 1}, kTwo{2, 2};
  const auto is_inside = reinterpret_cast<PairBits>(pairOf(bitsOf(radians) & ~kSignBits) <= kLargest);
  const Pair angle = pairOf(bitsOf(radians) & is_inside);
  const Pair rounded = angle * kQuartersPerRadian + kRounding;
  const Pair k = rounded - kRounding;
  const Pair r = ((angle - k * kQuarter[0]) - k * kQuarter[1]) - k * kQuarter[2];
  const Pair z = r * r;
  Pair sine = z * kSine[5] + kSine[4], cosine = z * kCosine[5] + kCosine[4];
  for (std::size_t i = 4; i-- > 0;) {
    sine = sine * z + kSine[i];
    cosine = cosine * z + kCosine[i];
  }
  const PairBits s = bitsOf(r + (z * r) * sine);
  const PairBits c = bitsOf(1.0 - (0.5 * z - (z * z) * cosine));
  // In odd quarters the two change places; the cosine is negative in quarters 1 and 2, the sine in 2 and 3.
  const PairBits quarter = bitsOf(rounded), is_odd = -(quarter & kOne), swapped = (c ^ s) & is_odd;
  return {pairOf(c ^ swapped ^ (((quarter + kOne) & kTwo) << 62U)), pairOf(s ^ swapped ^ ((quarter & kTwo) << 62U))};
}

/** Constants of an arm's chain (doc/raven2.md 2). */
struct Chain {
  CosSin twist0, twist2, theta3;
  double offset1, offset2;  // [rad]
};

constexpr CosSin kLink12{0.25881904510252076235, 0.96592582628906828675};
constexpr CosSin kLink23{0.61566147532565827967, 0.78801075360672195669};
constexpr std::array<Chain, 2> kChains{Chain{{1.0, 0.0}, {-kLink23.c, kLink23.s}, {0.0, 1.0}, 3.5779249665883754, kPi},
                                       Chain{{-1.0, 0.0}, kLink23, {0.0, -1.0}, 0.43633231299858238, 0.0}};

Pairs<3> cross(const Pairs<3>& a, const Pairs<3>& b) noexcept {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

struct Axes {
  Pairs<3> x{{Pair{1.0, 1.0}, Pair{}, Pair{}}}, y{{Pair{}, Pair{1.0, 1.0}, Pair{}}},
      z{{Pair{}, Pair{}, Pair{1.0, 1.0}}};

  /** @param[in] angle of one or of two records. */
  template <typename Angle>
  void link(const CosSin& twist, const Angle& angle) noexcept {
    for (std::size_t i = 0; i < 3; ++i) {
      const Pair twisted = twist.c * y[i] + twist.s * z[i];
      z[i] = twist.c * z[i] - twist.s * y[i];
      y[i] = angle.c * twisted - angle.s * x[i];
      x[i] = angle.c * x[i] + angle.s * twisted;
    }
  }
};

/** The arm's frames up to the wrist. */
struct Walk {
  Axes wrist;
  Pairs<3> shoulder, elbow, shaft;
};

/** @param[in] constants the arm (0 gold, 1 green), d4 and lw [m]. */
Walk walk(const double* constants, const Pairs<kJointCount>& q) noexcept {
  const Chain& chain = kChains[constants[0] == 0.0 ? 0 : 1];
  Walk w{};
  Axes& a = w.wrist;
  a.link(chain.twist0, cosSin(q[0] + chain.offset1));
  w.shoulder = a.z;
  a.link(kLink12, cosSin(q[1] + chain.offset2));
  w.elbow = a.z;
  a.link(chain.twist2, chain.theta3);
  w.shaft = a.z;
  a.link({1.0, 0.0}, cosSin(q[3]));
  a.link({0.0, 1.0}, cosSin(q[4] - kPi / 2.0));
  return w;
}

struct Tip {
  Pairs<3> p, v;
};

Tip tipOf(const double* constants, const Pairs<kJointCount>& q, const Pairs<kJointCount>& dq) noexcept {
  const Walk w = walk(constants, q);
  const Pair depth = q[2] + constants[1];
  Tip tip{};
  Pairs<3> lever{};
  for (std::size_t i = 0; i < 3; ++i) {
    lever[i] = constants[2] * w.wrist.x[i];
    tip.p[i] = depth * w.shaft[i] + lever[i];
  }
  const std::array<Pairs<3>, 5> columns{cross(w.shoulder, tip.p), cross(w.elbow, tip.p), w.shaft, cross(w.shaft, tip.p),
                                        cross(w.wrist.z, lever)};
  for (std::size_t i = 0; i < 3; ++i) {
    tip.v[i] = columns[0][i] * dq[0];
    for (std::size_t j = 1; j < columns.size(); ++j)
      tip.v[i] += columns[j][i] * dq[j];
  }
  return tip;
}

/** x y z w of one of the two, as Eigen makes it of a rotation. */
std::array<double, 4> quaternion(const Axes& axes, std::size_t one) noexcept {
  std::array<std::array<double, 3>, 3> m{};
  for (std::size_t i = 0; i < 3; ++i)
    m[i] = {axes.x[i][one], axes.y[i][one], axes.z[i][one]};
  std::array<double, 4> q{};
  const double trace = (m[0][0] + m[1][1]) + m[2][2];
  if (trace > 0.0) {
    const double t = std::sqrt(trace + 1.0), f = 0.5 / t;
    return {(m[2][1] - m[1][2]) * f, (m[0][2] - m[2][0]) * f, (m[1][0] - m[0][1]) * f, 0.5 * t};
  }
  std::size_t i = m[1][1] > m[0][0] ? 1 : 0;
  if (m[2][2] > m[i][i]) i = 2;
  const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
  const double t = std::sqrt(((m[i][i] - m[j][j]) - m[k][k]) + 1.0), f = 0.5 / t;
  q[i] = 0.5 * t;
  q[3] = (m[k][j] - m[j][k]) * f;
  q[j] = (m[j][i] + m[i][j]) * f;
  q[k] = (m[k][i] + m[i][k]) * f;
  return q;
}

// ---- the formulas --------------------------------------------------------------------------------------------------

/** Writes results, which are kept column by column. */
class Results {
 public:
  Results(std::vector<double>* values, std::size_t rows) noexcept : values_(*values), rows_(rows) {}

  template <std::size_t kSize>
  void put(std::size_t column, std::size_t row, const std::array<double, kSize>& given) noexcept {
    for (std::size_t i = 0; i < kSize; ++i)
      values_[(column + i) * rows_ + row] = std::isfinite(given[i]) ? given[i] : 0.0;
  }

  /** One of the two. */
  template <std::size_t kSize>
  void put(std::size_t column, std::size_t row, const Pairs<kSize>& given, std::size_t one) noexcept {
    std::array<double, kSize> values;
    for (std::size_t i = 0; i < kSize; ++i)
      values[i] = given[i][one];
    put(column, row, values);
  }

 private:
  std::vector<double>& values_;
  std::size_t rows_;
};

JointArray joints(const std::vector<double>& numbers, std::size_t first) noexcept {
  JointArray result;
  std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(first), result.size(), result.begin());
  return result;
}

/** @param[in] matrix row by row. */
JointArray times(const double* matrix, const JointArray& values) noexcept {
  JointArray result;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    double sum = matrix[j * kJointCount] * values[0];
    for (std::size_t k = 1; k < kJointCount; ++k)
      sum += matrix[j * kJointCount + k] * values[k];
    result[j] = sum;
  }
  return result;
}

void robot(const Formula& f, const RecordView& records, Results out) noexcept {
  constexpr std::size_t kMatrix = kJointCount * kJointCount, kLines = 3 * kJointCount;
  for (std::size_t arm = 0; arm < 2; ++arm) {
    const double* matrix = f.numbers.data() + arm * kMatrix;
    MotorFilter filter;
    for (std::size_t i = 0; i < filter.x.size(); ++i) {
      filter.x[i] = joints(f.numbers, 2 * kMatrix + arm * kLines + i * kJointCount);
      filter.y[i] = joints(f.numbers, 2 * kMatrix + 2 * kLines + arm * kLines + i * kJointCount);
    }
    JointArray before{};
    std::int64_t last = 0;
    for (std::size_t row = 0; row < records.count; ++row) {
      const JointArray motor = records.joints(f.columns[1 + arm], row);
      const auto cycle = records.get<std::int64_t>(f.columns[0], row);
      if (row > 0) filter.advance(before, motor, cyclesBetween(last, cycle));
      last = cycle;
      before = motor;
      out.put(arm * kJointCount, row, times(matrix, motor));
      out.put((2 + arm) * kJointCount, row, times(matrix, filter.y[0]));
    }
  }
}

void positions(const Formula& f, const RecordView& records, Results out) noexcept {
  JointArray q = joints(f.numbers, 0);
  const JointArray bend = joints(f.numbers, kJointCount);
  out.put(0, 0, q);
  for (std::size_t t = 1; t < records.count; ++t) {
    const JointArray before = records.joints(f.columns[0], t - 1), now = records.joints(f.columns[0], t);
    for (std::size_t j = 0; j < kJointCount; ++j)
      q[j] += ((before[j] + now[j]) / 2.0) * kPeriod + bend[j] * (now[j] - before[j]);
    out.put(0, t, q);
  }
}

void control(const Formula& f, const RecordView& records, Results out) noexcept {
  const JointArray kp = joints(f.numbers, 0), kd = joints(f.numbers, 7), ki = joints(f.numbers, 14);
  const JointArray base = joints(f.numbers, 21);
  JointArray integral{}, tau;
  for (std::size_t t = 0; t < records.count; ++t) {
    const std::size_t before = t > 0 ? t - 1 : 0;
    const JointArray q_d = records.joints(f.columns[0], t), q = records.joints(f.columns[1], before);
    const JointArray dq = records.joints(f.columns[2], before);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double error = q_d[j] - q[j];
      if (t > 0) integral[j] += (ki[j] * kPeriod) * error;
      tau[j] = ((kp[j] * error - kd[j] * dq[j]) + integral[j]) + base[j];
    }
    out.put(0, t, tau);
  }
}

/** Joints of a record and of the one after it; of the last one twice. */
Pairs<kJointCount> jointPairs(const RecordView& records, std::size_t column, std::size_t row) noexcept {
  const JointArray first = records.joints(column, row);
  const JointArray second = records.joints(column, std::min(row + 1, records.count - 1));
  Pairs<kJointCount> pairs;
  for (std::size_t j = 0; j < kJointCount; ++j)
    pairs[j] = Pair{first[j], second[j]};
  return pairs;
}

/** Calls `use` with each record and its place in its pair, after `compute` with the pair's first record. */
template <typename Compute, typename Use>
void forPairs(const RecordView& records, const Compute& compute, const Use& use) noexcept {
  for (std::size_t row = 0; row < records.count; row += 2) {
    const auto both = compute(row);
    for (std::size_t one = 0; one < 2 && row + one < records.count; ++one)
      use(both, row + one, one);
  }
}

void tip(const Formula& f, const RecordView& records, Results out) noexcept {
  const auto tips = [&](std::size_t row) {
    return tipOf(f.numbers.data(), jointPairs(records, f.columns[0], row), jointPairs(records, f.columns[1], row));
  };
  forPairs(records, tips, [&](const Tip& both, std::size_t row, std::size_t one) {
    out.put(0, row, both.p, one);
    out.put(3, row, both.v, one);
  });
}

void orientation(const Formula& f, const RecordView& records, Results out) noexcept {
  const auto tools = [&](std::size_t row) {
    const Pairs<kJointCount> q = jointPairs(records, f.columns[0], row);
    Axes tool = walk(f.numbers.data(), q).wrist;
    tool.link({0.0, 1.0}, cosSin((q[6] - q[5]) / 2.0));
    return tool;
  };
  forPairs(records, tools,
           [&](const Axes& both, std::size_t row, std::size_t one) { out.put(0, row, quaternion(both, one)); });
}

using Evaluate = void (*)(const Formula&, const RecordView&, Results);

struct Kind {
  FormulaTraits traits;
  Evaluate evaluate;
};

/** @return nullptr for no kind. */
const Kind* kindOf(FormulaKind kind) noexcept {
  static constexpr FormulaBlock kCycle{1, false}, kNeeded{7, false}, kJoints{7, true}, kVector{3, true},
      kQuaternion{4, true};
  static constexpr std::array<Kind, 5> kKinds{
      Kind{{{kCycle, kNeeded, kNeeded, kJoints, kJoints, kJoints, kJoints}, 7, 182}, robot},
      Kind{{{kNeeded, kJoints}, 2, 14}, positions}, Kind{{{kNeeded, kNeeded, kNeeded, kJoints}, 4, 28}, control},
      Kind{{{kNeeded, kNeeded, kVector, kVector}, 4, 3}, tip}, Kind{{{kNeeded, kQuaternion}, 2, 3}, orientation}};
  const auto number = static_cast<std::size_t>(kind);
  return number >= 1 && number <= kKinds.size() ? &kKinds[number - 1] : nullptr;
}

}  // namespace

const FormulaTraits* traitsOf(FormulaKind kind) noexcept {
  const Kind* found = kindOf(kind);
  return found != nullptr ? &found->traits : nullptr;
}

std::int64_t cyclesBetween(std::int64_t before, std::int64_t now) noexcept {
  // Unsigned, because a log's numbers may be any.
  const auto cycles = static_cast<std::int64_t>(static_cast<std::uint64_t>(now) - static_cast<std::uint64_t>(before));
  return std::clamp<std::int64_t>(cycles, 0, kMostCycles);
}

void MotorFilter::advance(const JointArray& before, const JointArray& now, std::int64_t cycles) noexcept {
  for (std::int64_t step = 0; step < cycles; ++step) {
    JointArray rate, filtered;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      rate[j] = ((now[j] - before[j]) / static_cast<double>(cycles)) / kPeriod;
      const double inputs = ((0.02864 * rate[j] + 0.08591 * x[0][j]) + 0.08591 * x[1][j]) + 0.02864 * x[2][j];
      filtered[j] = ((inputs + 1.5189 * y[0][j]) - 0.9600 * y[1][j]) + 0.2120 * y[2][j];
    }
    x = {rate, x[0], x[1]};
    y = {filtered, y[0], y[1]};
  }
}

void Formula::append(std::vector<std::uint8_t>* bytes) const {
  bytes->push_back(static_cast<std::uint8_t>(kind));
  const auto add = [bytes](const auto& values) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes->insert(bytes->end(), begin, begin + values.size() * sizeof(values[0]));
  };
  add(columns);
  add(numbers);
}

bool Formula::read(ByteReader* in) {
  kind = static_cast<FormulaKind>(in->get<std::uint8_t>());
  const FormulaTraits* traits = traitsOf(kind);
  if (traits == nullptr) return false;
  columns.resize(traits->block_count);
  numbers.resize(traits->numbers);
  in->getBytes(columns.data(), columns.size() * sizeof(columns[0]));
  in->getBytes(numbers.data(), numbers.size() * sizeof(numbers[0]));
  return !in->underflow();
}

void evaluate(const Formula& formula, const RecordView& records, std::vector<double>* results) {
  const Kind& kind = *kindOf(formula.kind);
  std::size_t columns = 0;
  for (const FormulaBlock& block : kind.traits.blocks)
    columns += block.is_result ? block.width : 0U;
  results->resize(columns * records.count);
  kind.evaluate(formula, records, Results(results, records.count));
}

}  // namespace raven2_trainer::session
