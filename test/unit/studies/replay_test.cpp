#include "raven2_trainer/studies/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/wire/itp.h"
#include "support/rig.h"

namespace raven2_trainer::studies {
namespace {

constexpr const char* kHeader =
    "t_s,sequence,delx0,delx1,dely0,dely1,delz0,delz1,Qx0,Qx1,Qy0,Qy1,Qz0,Qz1,Qw0,Qw1,buttonstate0,buttonstate1,"
    "grasp0,grasp1,surgeon_mode,checksum,size,pactyp,version\n";
constexpr const char* kRow = "2.5,7,1,2,3,4,5,6,.1,.2,.3,.4,.5,.6,.7,nan,8,9,10,11,-1,12,124,13,14\n";

class ItpTrace : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  std::vector<TraceDatagram> read(const std::string& text) {
    std::ofstream(path_) << text;
    return readItpTrace(path_);
  }

  std::string message(const std::string& text) {
    try {
      read(text);
    } catch (const SessionException& e) {
      return e.what();
    }
    return "";
  }

  std::string path_ = ::testing::TempDir() + "itp_trace_test.csv";
};

TEST_F(ItpTrace, FieldsArriveInTheDatagram) {
  const auto trace = read(std::string(kHeader) + kRow);
  ASSERT_EQ(trace.size(), 1u);
  EXPECT_EQ(trace[0].t_s, 2.5);
  wire::ItpPacket p;
  ASSERT_EQ(wire::decodeItp(trace[0].bytes.data(), trace[0].bytes.size(), &p), Reject::kNone);
  EXPECT_EQ(p.sequence, 7u);
  EXPECT_EQ(p.delx_um, (PerArm<std::int32_t>{1, 2}));
  EXPECT_EQ(p.dely_um, (PerArm<std::int32_t>{3, 4}));
  EXPECT_EQ(p.delz_um, (PerArm<std::int32_t>{5, 6}));
  EXPECT_EQ(p.Qx, (PerArm<double>{.1, .2}));
  EXPECT_EQ(p.Qy, (PerArm<double>{.3, .4}));
  EXPECT_EQ(p.Qz, (PerArm<double>{.5, .6}));
  EXPECT_EQ(p.Qw[0], .7);
  EXPECT_TRUE(std::isnan(p.Qw[1]));
  EXPECT_EQ(p.buttonstate, (PerArm<std::int32_t>{8, 9}));
  EXPECT_EQ(p.grasp_mrad, (PerArm<std::int32_t>{10, 11}));
  EXPECT_EQ(p.surgeon_mode, -1);
  EXPECT_EQ(p.checksum, 12);
  EXPECT_EQ(p.pactyp, 13u);
  EXPECT_EQ(p.version, 14u);
}

TEST_F(ItpTrace, SizeCutsOrPadsTheDatagram) {
  for (const std::size_t size : {0, 123, 134, 1400}) {
    std::string row = kRow;
    row.replace(row.find(",124,"), 5, "," + std::to_string(size) + ",");
    const auto trace = read(std::string(kHeader) + row);
    ASSERT_EQ(trace[0].bytes.size(), size);
    if (size > wire::kItpSize) {
      EXPECT_EQ(trace[0].bytes.back(), 0);
    }
  }
}

TEST_F(ItpTrace, ReadsWhatSpreadsheetsMakeOfIt) {
  std::string header = kHeader, row = kRow;
  header.insert(0, "\xEF\xBB\xBFnote,");  // byte order mark, a column of someone's own
  row.insert(0, "hello,");
  row.replace(row.find(",124,"), 5, ",124.0,");
  row.replace(row.find(",3,4,"), 5, ",,4,");  // an empty cell
  const auto trace = read(header + row);
  ASSERT_EQ(trace.size(), 1U);
  EXPECT_EQ(trace[0].bytes.size(), wire::kItpSize);
  EXPECT_EQ(trace[0].t_s, 2.5);
}

TEST_F(ItpTrace, MayHoldNoDatagram) {
  EXPECT_TRUE(read(kHeader).empty());
}

TEST_F(ItpTrace, ErrorsNameFileLineAndColumn) {
  const std::string good = std::string(kHeader) + kRow;
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string row = kRow;
    row.replace(row.find(from), from.size(), to);
    return message(good + row);
  };
  EXPECT_NE(broken("2.5,7", "2.5,-7").find("itp_trace_test.csv:3: sequence is \"-7\""), std::string::npos);
  EXPECT_NE(broken(",3,4,", ",3000000000,4,").find(":3: dely0"), std::string::npos);
  EXPECT_NE(broken(",124,", ",70000,").find(":3: size"), std::string::npos);
  EXPECT_NE(broken("2.5,", "inf,").find(":3: t_s"), std::string::npos);
  EXPECT_NE(broken(".1,", "x,").find(":3: Qx0"), std::string::npos);
  EXPECT_NE(broken("2.5,7,1,", "2.5,7,").find(":3: 24 fields"), std::string::npos);
  EXPECT_NE(message("t_s,sequence\n").find(":1: column delx0 is missing"), std::string::npos);
  EXPECT_NE(broken("2.5,", "30000.0,").find(":3: t_s is"), std::string::npos) << "longer than any useful trace";
  EXPECT_NE(message("").find("is empty"), std::string::npos);
}

/** Rows of a replay, split into cells. */
struct Rows {
  std::vector<std::vector<std::string>> cells;
  ReplaySummary summary;

  explicit Rows(const std::vector<TraceDatagram>& trace, ReplayOptions options = {/*skip_homing=*/true, -1.0, 0.02}) {
    Replay replay(testing::packagedConfig(), options);
    summary = replay.run(trace,
                         [&](const std::string& text) {
                           std::stringstream line(text);
                           std::vector<std::string> row;
                           for (std::string cell; std::getline(line, cell, ',');)
                             row.push_back(cell);
                           cells.push_back(row);
                         },
                         {});
  }

  double time(std::size_t row) const { return std::stod(cells[row][0]); }
  int lastSequence(std::size_t row) const { return std::stoi(cells[row][1]); }
  int level(std::size_t row) const { return std::stoi(cells[row][2]); }
};

TraceDatagram datagram(double t_s, std::uint32_t sequence, std::int32_t mode = 0) {
  wire::ItpPacket packet;
  packet.sequence = sequence;
  packet.surgeon_mode = mode;
  const wire::ItpBytes bytes = wire::encodeItp(packet);
  return {t_s, {bytes.begin(), bytes.end()}};
}

TEST(Replay, ADatagramIsSeenByTheCycleNearestToItsTimeInTheFilesOrder) {
  const Rows rows({datagram(10.0, 1), datagram(10.0004, 2), datagram(10.0012, 3), datagram(10.0031, 4),
                   datagram(10.0028, 5), datagram(10.0058, 6)});
  EXPECT_EQ(rows.cells[0][0], "t_s");
  const std::vector<int> expected{2, 3, 3, 5, 5, 5, 6};
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(rows.lastSequence(k + 1), expected[k]) << k;
    EXPECT_NEAR(rows.time(k + 1), 10.0 + 0.001 * static_cast<double>(k) + Replay::kPublishDelay, 1e-6);
    EXPECT_EQ(rows.level(k + 1), 2);
  }
  EXPECT_EQ(rows.summary.itp.applied, 6u);
}

TEST(Replay, WithoutSkippingRowsOfHomingComeBeforeTheFirstDatagram) {
  const Rows rows({datagram(10.0, 1)}, {/*skip_homing=*/false, -1.0, 0.02});
  EXPECT_EQ(rows.level(1), 0);
  std::size_t first = 1;
  while (rows.level(first) != 2)
    ++first;
  EXPECT_EQ(rows.lastSequence(first), 111);
  EXPECT_EQ(rows.lastSequence(first + 1), 1);
  EXPECT_NEAR(rows.time(first + 1), 10.0 + Replay::kPublishDelay, 1e-6);
  EXPECT_GT(first, 800u);
}

TEST(Replay, GoesOnUntilThePedalOfASilentMasterIsUp) {
  const Rows rows({datagram(0.0, 1, 1)});
  EXPECT_EQ(rows.level(100), 3);
  EXPECT_EQ(rows.level(rows.cells.size() - 1), 2);
  // 5.000 s since PEDAL_DN, where the accumulators stop following the robot, 4 cycles each for the two changes of level
  EXPECT_NEAR(rows.summary.seconds, 5.010, 0.002);
}

TEST(Replay, EveryRowHasAsManyCellsAsTheHeader) {
  const Rows rows({datagram(0.0, 1)});
  EXPECT_EQ(rows.cells[0].size(), 4u + 12 + 36 + 7 * 16 + 2);
  for (const auto& row : rows.cells)
    EXPECT_EQ(row.size(), rows.cells[0].size());
}

std::vector<std::string> cellsOf(const std::string& row) {
  std::vector<std::string> cells;
  std::stringstream line(row.substr(0, row.size() - 1));
  for (std::string cell; std::getline(line, cell, ',');)
    cells.push_back(cell);
  return cells;
}

/** As raven_2's traces: angles in degrees, torques in Nm. */
TEST(Replay, ARowsAnglesAreInDegrees) {
  RavenReport report;
  report.jpos[0] = 0.5;
  report.jpos_d[1] = -0.25;
  report.mpos[2] = 2.0;
  report.mpos_d[3] = 3.0;
  report.mvel[4] = 10.0;
  report.tau[5] = 0.125;
  report.grasp_d[1] = 0.75;
  const std::vector<std::string> names = cellsOf(stateTraceHeader()), cells = cellsOf(stateTraceRow(1.0, report));
  ASSERT_EQ(names.size(), cells.size());
  for (const auto& [name, cell] : {std::pair("jpos0", "28.6479"),
                                   {"jpos_d1", "-14.32394"},
                                   {"mpos2", "114.59"},
                                   {"mpos_d3", "171.887"},
                                   {"mvel4", "573"},
                                   {"tau5", "0.1250"},
                                   {"grasp_d1", "0.75000"}}) {
    const auto found = std::find(names.begin(), names.end(), name);
    ASSERT_NE(found, names.end()) << name;
    EXPECT_EQ(cells[static_cast<std::size_t>(found - names.begin())], cell) << name;
  }
}

TEST(Replay, RefusesABehaviourThatDoesNotExist) {
  TrainerConfig config = testing::packagedConfig();
  config.virtual_raven.behaviour = "meteor";
  EXPECT_THROW(Replay(config, {}), ConfigException);
}

}  // namespace
}  // namespace raven2_trainer::studies
