#include <gtest/gtest.h>
#include <malloc.h>

#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "raven2_trainer/control/joint_pid.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/low_pass.h"
#include "session/formula.h"
#include "session/record_chunk.h"
#include "support/moving_ticks.h"
#include "support/sanitizer.h"
#include "unit/session/log_file.h"
#include "unit/session/record_values.h"

// The formulas of a log (session/formula.h) against the code of the trainer whose results they predict, and chunks with
// them.

namespace raven2_trainer::session {
namespace {

using raven2_trainer::testing::MovingTicks;
using raven2_trainer::testing::tickConstants;

/** Rows of doubles (the first may be whole numbers) as records, and a formula's results for them. */
class Table {
 public:
  explicit Table(std::size_t columns) : columns_(columns) {
    for (std::size_t c = 0; c < columns; ++c)
      offsets_.push_back(c * sizeof(double));
  }

  void add(const std::vector<double>& row) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(row.data());
    bytes_.insert(bytes_.end(), begin, begin + columns_ * sizeof(double));
    ++rows_;
  }

  /** @return result column by result column. */
  std::vector<double> evaluated(const Formula& formula) const {
    std::vector<double> results;
    evaluate(formula, {bytes_.data(), columns_ * sizeof(double), rows_, offsets_.data()}, &results);
    return results;
  }

 private:
  std::size_t columns_, rows_{0};
  std::vector<std::size_t> offsets_;
  Bytes bytes_;
};

std::vector<double> joined(std::initializer_list<JointArray> parts) {
  std::vector<double> row;
  for (const JointArray& part : parts)
    row.insert(row.end(), part.begin(), part.end());
  return row;
}

JointArray randomJoints(Random& random, double size) {
  JointArray joints;
  for (double& joint : joints)
    joint = random.uniform(-size, size);
  return joints;
}

TEST(LogFormulas, GiveTheTipAsTheKinematicsDo) {
  Random random(1);
  ArmGeometry geometry;
  geometry.d4 = -0.47;
  geometry.lw = 0.013;
  for (const Arm arm : kArms) {
    const std::vector<double> constants{static_cast<double>(index(arm)), geometry.d4, geometry.lw};
    Table table(14);
    std::vector<kinematics::TipMotion> expected;
    for (int i = 0; i < 3000; ++i) {
      const JointArray q = randomJoints(random, i % 2 == 0 ? 2.0 : 9.0), dq = randomJoints(random, 1.0);
      table.add(joined({q, dq}));
      expected.push_back(kinematics::tipMotion(geometry, arm, q, dq));
    }
    const std::vector<double> tips = table.evaluated({FormulaKind::kTip, {0, 7, 0, 0}, constants});
    const std::vector<double> orientations = table.evaluated({FormulaKind::kOrientation, {0, 0}, constants});
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Quaternion orientation(expected[i].X_BT.R);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        ASSERT_NEAR(tips[k * expected.size() + i], expected[i].X_BT.p[axis], 2e-14) << i;
        ASSERT_NEAR(tips[(3 + k) * expected.size() + i], expected[i].v_BT[axis], 4e-14) << i;
      }
      for (std::size_t k = 0; k < 4; ++k)
        ASSERT_NEAR(orientations[k * expected.size() + i], orientation.coeffs()[static_cast<Eigen::Index>(k)], 4e-14)
            << i;
    }
  }
}

TEST(LogFormulas, GiveTheRobotsJointsAndRatesAsItsSoftwareDoes) {
  VirtualRavenConfig config;
  for (std::size_t j = 0; j < kJointCount; ++j)
    config.axes[j].transmission = 5.0 + 20.0 * static_cast<double>(j);
  Formula formula{FormulaKind::kRobot, {0, 1, 8, 0, 0, 0, 0}, {}};
  PerArm<std::vector<JointArray>> q, dq;
  Table table(15);
  PerArm<raven::LowPass> filters;
  PerArm<JointArray> motor{};
  for (const Arm arm : kArms) {
    const raven::CableCoupling coupling(arm, config);
    for (Eigen::Index j = 0; j < 7; ++j) {
      for (Eigen::Index m = 0; m < 7; ++m)
        formula.numbers.push_back(coupling.inverse()(j, m));
    }
    at(filters, arm).reset({});
  }
  formula.numbers.resize(182);  // at rest
  Random random(2);
  for (std::int64_t i = 0; i < 400; ++i) {
    double cycle = 0.0;
    std::memcpy(&cycle, &i, sizeof(cycle));
    for (const Arm arm : kArms) {
      const JointArray before = at(motor, arm);
      JointArray rate{};
      for (std::size_t j = 0; j < kJointCount && i > 0; ++j) {
        at(motor, arm)[j] += std::floor(random.uniform(-3.0, 4.0)) * 2.0 * kPi / 4000.0;
        rate[j] = (at(motor, arm)[j] - before[j]) / kTickSeconds;
      }
      const raven::CableCoupling coupling(arm, config);
      at(q, arm).push_back(coupling.toJoint(at(motor, arm)));
      at(dq, arm).push_back(coupling.toJoint(i > 0 ? at(filters, arm).update(rate) : JointArray{}));
    }
    std::vector<double> row{cycle};
    for (const JointArray& joints : motor)
      row.insert(row.end(), joints.begin(), joints.end());
    table.add(row);
  }
  const std::vector<double> results = table.evaluated(formula);
  for (std::size_t k = 0; k < kArmCount; ++k) {
    for (std::size_t i = 0; i < 400; ++i) {
      for (std::size_t j = 0; j < kJointCount; ++j) {
        ASSERT_NEAR(results[(7 * k + j) * 400 + i], q[k][i][j], 1e-15) << k << ' ' << i << ' ' << j;
        ASSERT_NEAR(results[(14 + 7 * k + j) * 400 + i], dq[k][i][j], 1e-14) << k << ' ' << i << ' ' << j;
      }
    }
  }
}

TEST(LogFormulas, TheRobotsFilterGoesByItsCycles) {
  MotorFilter one, two;
  const JointArray rest{};
  JointArray once{}, twice{};
  once.fill(0.3);
  twice.fill(0.6);
  one.advance(rest, once, 1);
  one.advance(once, twice, 1);
  two.advance(rest, twice, 2);
  EXPECT_EQ(one.y, two.y) << "a state that was missed counts as half of the motion";
  two.advance(twice, rest, 0);
  EXPECT_EQ(one.y, two.y) << "a state that is seen again changes nothing";
  EXPECT_EQ(cyclesBetween(5, 4), 0);
  EXPECT_EQ(cyclesBetween(std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()), 1);
  EXPECT_EQ(cyclesBetween(0, 1000), 8);
}

TEST(LogFormulas, GiveTheTorquesAsTheControlLawDoes) {
  Random random(3);
  std::array<JointGains, kJointCount> gains{};
  JointArray kp, kd, ki, base;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    gains[j] = {random.uniform(1.0, 400.0), random.uniform(0.0, 12.0), random.uniform(0.0, 900.0), 1e9};
    kp[j] = gains[j].kp;
    kd[j] = gains[j].kd;
    ki[j] = gains[j].ki;
  }
  base = randomJoints(random, 2.0);
  control::JointPid pid(gains);
  Table table(21);
  std::vector<JointArray> expected;
  JointArray q{}, dq{};
  for (int i = 0; i < 200; ++i) {
    const JointArray q_d = randomJoints(random, 1.0);
    if (i > 0) expected.push_back(pid.torque(q_d, q, dq, base));  // of the state before the tick
    q = randomJoints(random, 1.0);
    dq = randomJoints(random, 1.0);
    table.add(joined({q_d, q, dq}));
  }
  const std::vector<double> results =
      table.evaluated({FormulaKind::kControl, {0, 7, 14, 0}, joined({kp, kd, ki, base})});
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      ASSERT_NEAR(results[j * 200 + i + 1], expected[i][j], 1e-12) << i << ' ' << j;
  }
}

TEST(LogFormulas, GiveTheJointThatItsDampingStops) {
  // dq = exp(-t / T): what the mean of two rates misses is h^2 / (12 T) of their difference.
  constexpr double kTime = 0.01;
  JointArray base, bend;
  base.fill(-kTime);
  bend.fill(kTickSeconds * kTickSeconds / (12.0 * kTime));
  Table table(7);
  for (int i = 0; i < 30; ++i) {
    JointArray dq;
    dq.fill(std::exp(-i * kTickSeconds / kTime));
    table.add(joined({dq}));
  }
  JointArray plain{};
  const std::vector<double> results = table.evaluated({FormulaKind::kPositions, {0, 0}, joined({base, bend})});
  const std::vector<double> straight = table.evaluated({FormulaKind::kPositions, {0, 0}, joined({base, plain})});
  const double q = -kTime * std::exp(-29 * kTickSeconds / kTime);
  EXPECT_LT(std::abs(results[29] - q), 0.01 * std::abs(straight[29] - q));
}

TEST(LogFormulas, GiveZeroWhereTheResultIsNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kHuge = std::numeric_limits<double>::max();
  Table table(14);
  table.add(std::vector<double>(14, kNan));
  table.add(std::vector<double>(14, kHuge));
  table.add(std::vector<double>(14, -std::numeric_limits<double>::infinity()));
  for (const double result : table.evaluated({FormulaKind::kTip, {0, 7, 0, 0}, {1.0, kNan, kHuge}}))
    EXPECT_EQ(result, 0.0);
  for (const double result : table.evaluated({FormulaKind::kOrientation, {0, 0}, {kHuge, kNan, kHuge}}))
    EXPECT_TRUE(std::abs(result) <= 1.0);
}

// ---- logs with them -----------------------------------------------------------------------------------------------

constexpr std::size_t kTicks = 400;

std::string writeMoves(const char* name, const std::optional<TickConstants>& constants) {
  const std::string path = scratchPath(name);
  LogWriter log(path, LogHeader{}, constants);
  MovingTicks ticks(tickConstants());
  for (std::size_t i = 0; i < kTicks; ++i)
    log.write(ticks.next());
  log.finish({});
  return path;
}

std::vector<std::vector<std::uint64_t>> valuesIn(const std::string& path, LogSummary* summary = nullptr) {
  std::vector<std::vector<std::uint64_t>> values;
  LogVisitor visitor;
  visitor.tick = [&values](const TickRecord& tick) { values.push_back(valuesOf(tick)); };
  const LogSummary read = readLog(path, visitor);
  if (summary != nullptr) *summary = read;
  return values;
}

TEST(LogFormulas, MakeALogOfMovingArmsTwoFifthsSmallerAndChangeNoBit) {
  const std::string with = writeMoves("with.rlog", tickConstants()), without = writeMoves("without.rlog", std::nullopt);
  EXPECT_LT(std::filesystem::file_size(with), 0.6 * std::filesystem::file_size(without));
  MovingTicks ticks(tickConstants());
  std::vector<std::vector<std::uint64_t>> expected;
  for (std::size_t i = 0; i < kTicks; ++i)
    expected.push_back(valuesOf(ticks.next()));
  EXPECT_EQ(valuesIn(with), expected);
  EXPECT_EQ(valuesIn(without), expected);
}

/** [bytes] that the program holds now. */
std::size_t memoryHeld() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(LogFormulas, ALogTakesNoMoreMemoryWhenBatchesBecomeLonger) {
  if (raven2_trainer::testing::kIsSanitized) GTEST_SKIP() << "its allocator has no figures";
  LogWriter log(scratchPath("flat.rlog"), LogHeader{}, tickConstants());
  log.reserve(2U << 20U);
  MovingTicks ticks(tickConstants());
  std::size_t after_first = 0;
  for (const int length : {50, 100, 300, 500}) {
    for (int i = 0; i < length; ++i) {
      log.write(ticks.next());
      log.write(HapticRecord{});
      log.write(CommandRecord{});
    }
    ASSERT_TRUE(log.commit());
    if (after_first == 0) after_first = memoryHeld();
  }
  EXPECT_EQ(memoryHeld(), after_first);
}

TEST(LogFormulas, ChangeNoBitOfAnyTicks) {
  Random random(34);
  const std::string path = scratchPath("any.rlog");
  std::vector<std::vector<std::uint64_t>> expected;
  {
    LogWriter log(path, LogHeader{}, tickConstants());
    MovingTicks ticks(tickConstants());
    for (int i = 0; i < 900; ++i) {
      const TickRecord moving = ticks.next();
      const bool is_any = i % 100 < 3 || i > 700;
      const TickRecord tick = is_any ? randomRecord<TickRecord>(random) : moving;
      expected.push_back(valuesOf(tick));
      log.write(tick);
      if (i % 90 == 0) log.commit();
    }
    log.finish({});
  }
  LogSummary summary;
  EXPECT_EQ(valuesIn(path, &summary), expected);
  EXPECT_EQ(summary.bad_bytes, 0U);
}

/** A log of one chunk, taken apart. */
struct Parts {
  Bytes header;  ///< frame of the log's header
  Bytes begin;   ///< of the chunk's contents, up to the forms
  Bytes forms, orders;
  std::vector<Formula> formulas;
  Bytes data;

  Bytes contents(bool has_formulas = true) const {
    Bytes all = begin;
    for (const Bytes* part : {&forms, &orders})
      all.insert(all.end(), part->begin(), part->end());
    if (has_formulas) all.push_back(static_cast<std::uint8_t>(formulas.size()));
    for (const Formula& formula : formulas)
      formula.append(&all);
    all.insert(all.end(), data.begin(), data.end());
    return all;
  }
};

Parts partsOf(const Bytes& log) {
  Parts parts;
  const FrameHeader header = decodeFrameHeader(log.data());
  const std::size_t chunk = kFrameHeaderSize + header.length + kCrcSize;
  parts.header.assign(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(chunk));
  const std::uint8_t* compressed = log.data() + chunk + kFrameHeaderSize + kChunkSpanSize;
  const std::size_t size = decodeFrameHeader(log.data() + chunk).length - kChunkSpanSize;
  Bytes contents(ZSTD_getFrameContentSize(compressed, size));
  EXPECT_EQ(ZSTD_decompress(contents.data(), contents.size(), compressed, size), contents.size());
  std::uint32_t columns = 0;
  std::memcpy(&columns, contents.data() + 16, sizeof(columns));
  ByteReader in(contents.data(), contents.size());
  const auto take = [&in](std::size_t bytes) {
    Bytes part(bytes);
    in.getBytes(part.data(), bytes);
    return part;
  };
  parts.begin = take(20 + kTicks);
  parts.forms = take(columns);
  parts.orders = take(columns);
  parts.formulas.resize(in.get<std::uint8_t>());
  for (Formula& formula : parts.formulas)
    EXPECT_TRUE(formula.read(&in));
  parts.data = take(in.left());
  return parts;
}

Bytes logOf(const Parts& parts, const Bytes& contents, std::uint16_t version = kChunkVersion) {
  Bytes payload(kChunkSpanSize + ZSTD_compressBound(contents.size()));
  payload.resize(kChunkSpanSize + ZSTD_compress(payload.data() + kChunkSpanSize, payload.size() - kChunkSpanSize,
                                                contents.data(), contents.size(), 1));
  Bytes frame(kFrameHeaderSize);
  encodeFrameHeader({kMagic, RecordType::kChunk, version, static_cast<std::uint32_t>(payload.size()), 1}, frame.data());
  frame.insert(frame.end(), payload.begin(), payload.end());
  const std::uint32_t crc = crc32Of(frame.data(), frame.size());
  const auto* tail = reinterpret_cast<const std::uint8_t*>(&crc);
  frame.insert(frame.end(), tail, tail + kCrcSize);
  frame.insert(frame.begin(), parts.header.begin(), parts.header.end());
  return frame;
}

std::size_t ticksIn(const Bytes& log) {
  const std::string path = scratchPath("altered.rlog");
  writeBytes(path, log);
  return valuesIn(path).size();
}

TEST(LogFormulas, AChunkOfTheFirstVersionHasNone) {
  const Parts parts = partsOf(readBytes(writeMoves("second.rlog", std::nullopt)));
  ASSERT_TRUE(parts.formulas.empty());
  EXPECT_EQ(ticksIn(logOf(parts, parts.contents())), kTicks);
  EXPECT_EQ(ticksIn(logOf(parts, parts.contents(false), 1)), kTicks);
  EXPECT_EQ(ticksIn(logOf(parts, parts.contents(), 3)), 0U) << "of a later version";
}

TEST(LogFormulas, ThatNoWriterMakesCostTheChunk) {
  const Parts good = partsOf(readBytes(writeMoves("parts.rlog", tickConstants())));
  ASSERT_EQ(ticksIn(logOf(good, good.contents())), kTicks);
  ASSERT_EQ(good.formulas.size(), 11U);
  ASSERT_GT(std::count_if(good.orders.begin(), good.orders.end(), [](std::uint8_t o) { return o >= 0x80; }), 80);
  const auto expectRefused = [&good](const char* what, const auto& alter) {
    Parts bad = good;
    alter(&bad);
    EXPECT_EQ(ticksIn(logOf(good, bad.contents())), 0U) << what;
  };
  expectRefused("no kind", [](Parts* p) { p->formulas[3].kind = static_cast<FormulaKind>(6); });
  expectRefused("17 formulas", [](Parts* p) { p->formulas.resize(17, p->formulas.back()); });
  expectRefused("the robot twice", [](Parts* p) { p->formulas.push_back(p->formulas[0]); });
  expectRefused("kind 0", [](Parts* p) { p->formulas[0].kind = static_cast<FormulaKind>(0); });
  expectRefused("a cycle that is a double", [](Parts* p) { p->formulas[0].columns[0] = p->formulas[0].columns[1]; });
  expectRefused("no joints", [](Parts* p) { p->formulas[1].columns[0] = 0; });
  expectRefused("columns behind the last", [](Parts* p) { p->formulas[1].columns[1] = 65535; });
  expectRefused("a number without its formula", [](Parts* p) { p->formulas.pop_back(); });
  expectRefused("an input that is still missing",
                [](Parts* p) { std::reverse(p->formulas.begin(), p->formulas.end()); });
  expectRefused("a whole number by a formula", [](Parts* p) { p->orders[0] = p->orders[0] | 0x80U; });
  expectRefused("differences of order 5", [](Parts* p) { p->orders[0] = 5; });
  expectRefused("fewer constants", [](Parts* p) { p->formulas[2].numbers.pop_back(); });
}

TEST(LogFormulas, AGroupWithThemHasAtMostASecondOfTicks) {
  Parts parts;
  const Bytes log = readBytes(writeMoves("limit.rlog", std::nullopt));
  parts.header = partsOf(log).header;
  for (const std::uint32_t rows : {1000U, 1001U}) {
    const std::array<std::uint32_t, 5> head{rows, 1, 99, rows, 14};  // of an unknown type
    const auto* begin = reinterpret_cast<const std::uint8_t*>(head.data());
    parts.begin.assign(begin, begin + sizeof(head));
    parts.begin.insert(parts.begin.end(), rows, 0);
    parts.forms.assign(14, 0x88);
    parts.orders.assign(7, 0);
    parts.orders.insert(parts.orders.end(), 7, 0x80);
    parts.formulas = {{FormulaKind::kPositions, {0, 7}, std::vector<double>(14)}};
    parts.data.assign(14 * 8 * rows, 0);
    const std::string path = scratchPath("limited.rlog");
    writeBytes(path, logOf(parts, parts.contents()));
    EXPECT_EQ(readLog(path, {}).bad_bytes == 0, rows == 1000U);
  }
}

}  // namespace
}  // namespace raven2_trainer::session
