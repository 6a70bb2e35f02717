#include "raven2_trainer/session/csv_export.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "log_file.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {
namespace {

using Row = std::vector<std::string>;

std::vector<Row> readTable(const std::string& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::stringstream cells(line + ",");
    Row row;
    for (std::string cell; std::getline(cells, cell, ',');)
      row.push_back(cell);
    rows.push_back(row);
  }
  return rows;
}

TickRecord makeTick(Tick tick, Tick session_tick) {
  TickRecord record;
  record.model.tick = tick;
  record.model.session_tick = session_tick;
  record.model.mode = Mode::kTeleoperating;
  record.model.pedal = 1;
  return record;
}

HapticRecord makeForce(Tick tick, double fx) {
  HapticRecord record;
  record.haptic.tick = tick;
  at(record.haptic.force_B, Arm::kGreen)[0] = fx;
  return record;
}

/** Exports a log of three ticks: one before the session, one without a robot, one with robot, force and fault. */
std::vector<Row> exportTinyLog(std::size_t* count) {
  LogHeader header;
  header.scenarios = {"pedal, stuck", "sudden_jump"};
  const std::string path = scratchPath("tiny.rlog");
  LogWriter log(path, header);
  log.write(makeTick(99, -1));
  log.write(makeTick(100, 0));
  TickRecord last = makeTick(101, 1);
  last.robot.frame = 5;
  last.robot.runlevel = RunLevel::kPedalDown;
  last.robot.active_fault = 2;
  ArmState& model = at(last.model.arms, Arm::kGreen);
  model.q = {0.1, 0.2, 1.0 / 3.0, -0.0, 1e-300, 5e22, 7.0};
  model.dq[6] = -1.5;
  model.tau[0] = 0.30000000000000004;
  model.p_BT = {1.0, 2.0, 3.0};
  RobotArmState& robot = at(last.robot.arms, Arm::kGreen);
  robot.q[0] = 11.0;
  robot.dq[6] = 12.0;
  robot.p_BT = {4.0, 5.0, 6.0};
  log.write(last);
  log.write(makeForce(100, 0.25));  // written behind the ticks, as the haptic thread's may be
  log.write(makeForce(101, 2.5));
  log.write(makeForce(102, 9.0));
  log.finish({});
  *count = exportTicksCsv(path, scratchPath("tiny.csv"), {});
  return readTable(scratchPath("tiny.csv"));
}

TEST(CsvExport, HasTheDocumentedColumns) {
  std::size_t count = 0;
  const Row titles = exportTinyLog(&count).at(0);
  const Row expected{"tick", "t_s",  "arm",  "mode", "runlevel", "pedal", "q1",   "q2",   "q3",  "q4",   "q5",
                     "q6",   "q7",   "dq1",  "dq2",  "dq3",      "dq4",   "dq5",  "dq6",  "dq7", "tau1", "tau2",
                     "tau3", "tau4", "tau5", "tau6", "tau7",     "rq1",   "rq2",  "rq3",  "rq4", "rq5",  "rq6",
                     "rq7",  "rdq1", "rdq2", "rdq3", "rdq4",     "rdq5",  "rdq6", "rdq7", "px",  "py",   "pz",
                     "rpx",  "rpy",  "rpz",  "fx",   "fy",       "fz",    "fault"};
  EXPECT_EQ(titles, expected);
}

TEST(CsvExport, HasARowATickAndArmFromTheFirstPedalDown) {
  std::size_t count = 0;
  const std::vector<Row> rows = exportTinyLog(&count);
  EXPECT_EQ(count, 4u);
  ASSERT_EQ(rows.size(), 5u);
  for (const Row& row : rows)
    EXPECT_EQ(row.size(), 51u);
  EXPECT_EQ(Row(rows[1].begin(), rows[1].begin() + 6), (Row{"0", "0", "gold", "teleoperating", "", "1"}));
  EXPECT_EQ(Row(rows[2].begin(), rows[2].begin() + 3), (Row{"0", "0", "green"}));
  EXPECT_EQ(Row(rows[3].begin(), rows[3].begin() + 3), (Row{"1", "0.001", "gold"}));
  EXPECT_EQ(Row(rows[4].begin(), rows[4].begin() + 6), (Row{"1", "0.001", "green", "teleoperating", "3", "1"}));
}

TEST(CsvExport, LeavesTheRobotEmptyBeforeItsFirstFrame) {
  std::size_t count = 0;
  const Row row = exportTinyLog(&count).at(2);
  EXPECT_EQ(row[4], "");
  for (std::size_t i = 27; i < 41; ++i)
    EXPECT_EQ(row[i], "") << "column " << i;
  for (std::size_t i = 44; i < 47; ++i)
    EXPECT_EQ(row[i], "") << "column " << i;
  EXPECT_EQ(row[41], "0");
  EXPECT_EQ(row[50], "");
}

TEST(CsvExport, PrintsValuesThatReadBackExactly) {
  std::size_t count = 0;
  const Row row = exportTinyLog(&count).at(4);
  EXPECT_EQ(Row(row.begin() + 6, row.begin() + 13),
            (Row{"0.1", "0.2", "0.3333333333333333", "-0", "1e-300", "5e+22", "7"}));
  EXPECT_EQ(std::stod(row[8]), 1.0 / 3.0);
  EXPECT_EQ(row[19], "-1.5");
  EXPECT_EQ(row[20], "0.30000000000000004");
  EXPECT_EQ(row[27], "11");
  EXPECT_EQ(row[40], "12");
  EXPECT_EQ(Row(row.begin() + 41, row.begin() + 47), (Row{"1", "2", "3", "4", "5", "6"}));
  EXPECT_EQ(row[50], "sudden_jump");
}

TEST(CsvExport, TakesTheNewestForceNoLaterThanTheTick) {
  std::size_t count = 0;
  const std::vector<Row> rows = exportTinyLog(&count);
  EXPECT_EQ(rows[2][47], "0.25");
  EXPECT_EQ(rows[4][47], "2.5");
  EXPECT_EQ(rows[3][47], "0");  // the gold arm's
}

TEST(CsvExport, QuotesAScenarioNameWithAComma) {
  LogHeader header;
  header.scenarios = {"pedal, stuck"};
  LogWriter log(scratchPath("quote.rlog"), header);
  TickRecord tick = makeTick(0, 0);
  tick.robot.frame = 1;
  tick.robot.active_fault = 1;
  log.write(tick);
  tick.robot.active_fault = 9;  // a scenario that the log does not name
  log.write(tick);
  log.finish({});
  exportTicksCsv(scratchPath("quote.rlog"), scratchPath("quote.csv"), {});
  std::ifstream file(scratchPath("quote.csv"));
  std::string line;
  std::getline(file, line);
  std::getline(file, line);
  EXPECT_EQ(line.substr(line.size() - 15), ",\"pedal, stuck\"");
  std::getline(file, line);
  std::getline(file, line);
  EXPECT_EQ(line.substr(line.size() - 8), ",fault_9");
}

TEST(CsvExport, ReportsProgressUpToOne) {
  LogWriter log(scratchPath("progress.rlog"), LogHeader{});
  for (Tick t = 0; t < 4000; ++t)
    log.write(makeTick(t, t));
  log.finish({});
  std::vector<double> seen;
  exportTicksCsv(scratchPath("progress.rlog"), scratchPath("progress.csv"),
                 [&](double share) { seen.push_back(share); });
  EXPECT_EQ(seen, (std::vector<double>{0.25, 0.5, 0.75, 1.0, 1.0}));
}

TEST(CsvExport, RefusesAFileThatCannotBeWritten) {
  LogWriter(scratchPath("empty.rlog"), LogHeader{}).finish({});
  EXPECT_THROW(exportTicksCsv(scratchPath("empty.rlog"), scratchPath("none") + "/ticks.csv", {}), SessionException);
  EXPECT_THROW(exportTicksCsv(scratchPath("empty.rlog"), "/dev/full", {}), SessionException);
}

/** The title and value of each of the arm's columns, computed from the record. */
std::vector<std::pair<std::string, double>> cellsOf(const TickRecord& record, const Vec3& force_B, Arm arm) {
  const ArmState& model = at(record.model.arms, arm);
  const RobotArmState& robot = at(record.robot.arms, arm);
  std::vector<std::pair<std::string, double>> cells;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const std::string number = std::to_string(j + 1);
    cells.emplace_back("q" + number, model.q[j]);
    cells.emplace_back("dq" + number, model.dq[j]);
    cells.emplace_back("tau" + number, model.tau[j]);
    cells.emplace_back("rq" + number, robot.q[j]);
    cells.emplace_back("rdq" + number, robot.dq[j]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const char axis = "xyz"[i];
    cells.emplace_back(std::string("p") + axis, model.p_BT[i]);
    cells.emplace_back(std::string("rp") + axis, robot.p_BT[i]);
    cells.emplace_back(std::string("f") + axis, force_B[i]);
  }
  return cells;
}

TEST(CsvExport, HasInEachRowTheValuesOfItsOwnArm) {
  Random random(11);
  auto tick = makeTick(100, 0);
  for (const Arm arm : kArms) {
    for (JointArray* joints : {&at(tick.model.arms, arm).q, &at(tick.model.arms, arm).dq, &at(tick.model.arms, arm).tau,
                               &at(tick.robot.arms, arm).q, &at(tick.robot.arms, arm).dq}) {
      for (double& value : *joints)
        value = random.normal();
    }
    for (Vec3* place : {&at(tick.model.arms, arm).p_BT, &at(tick.robot.arms, arm).p_BT})
      *place = {random.normal(), random.normal(), random.normal()};
  }
  tick.robot.frame = 1;
  HapticRecord force;
  force.haptic.tick = 100;
  force.haptic.force_B = {Vec3{1.5, -2.5, 3.5}, Vec3{-4.5, 5.5, -6.5}};
  {
    LogWriter log(scratchPath("arms.rlog"), LogHeader{});
    log.write(tick);
    log.write(force);
    log.finish({});
  }
  exportTicksCsv(scratchPath("arms.rlog"), scratchPath("arms.csv"), {});
  const std::vector<Row> rows = readTable(scratchPath("arms.csv"));
  ASSERT_EQ(rows.size(), 3U);
  for (const Arm arm : kArms) {
    const Row& row = rows[arm == Arm::kGold ? 1 : 2];
    EXPECT_EQ(row[2], name(arm));
    for (const auto& [title, value] : cellsOf(tick, at(force.haptic.force_B, arm), arm)) {
      const auto column = std::find(rows[0].begin(), rows[0].end(), title) - rows[0].begin();
      EXPECT_EQ(std::stod(row.at(static_cast<std::size_t>(column))), value) << name(arm) << " " << title;
    }
  }
}

TEST(CsvExport, NamesAFaultOfTheDaemonToo) {
  LogHeader header;
  header.scenarios = {"robots", "daemons"};
  {
    LogWriter log(scratchPath("daemon_fault.rlog"), header);
    for (Tick t = 0; t < 3; ++t) {
      TickRecord tick = makeTick(t, t);
      tick.robot.frame = 1;
      tick.model.faults.active = t >= 1 ? 2 : 0;
      tick.robot.active_fault = t >= 2 ? 1 : 0;  // the robot's word counts
      log.write(tick);
    }
    log.finish({});
  }
  exportTicksCsv(scratchPath("daemon_fault.rlog"), scratchPath("daemon_fault.csv"), {});
  const std::vector<Row> rows = readTable(scratchPath("daemon_fault.csv"));
  for (const std::size_t arm : {0U, 1U}) {
    EXPECT_EQ(rows.at(1 + arm).back(), "");
    EXPECT_EQ(rows.at(3 + arm).back(), "daemons");
    EXPECT_EQ(rows.at(5 + arm).back(), "robots");
  }
}

}  // namespace
}  // namespace raven2_trainer::session
