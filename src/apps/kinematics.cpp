// Forward and inverse kinematics and the Jacobian of the Raven's arms, from table to table.

#include "raven2_trainer/kinematics/arm_kinematics.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/csv_table.h"
#include "apps/common/paths.h"
#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer {
namespace {

using apps::CsvWriter;
using Row = std::vector<double>;

constexpr std::size_t kProgressEvery = 1'000'000;  // [rows]
constexpr double kRotationTolerance = 1e-5;        // of R^T R: poses rounded to six digits are welcome

const std::vector<std::string> kJoints{"J1", "J2", "J3", "J4", "J5", "J6", "J7"};
const std::vector<std::string> kPose{"x", "y", "z", "r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"};

/** One of the three conversions: columns in, columns out, and what a row does. */
struct Conversion {
  std::vector<std::string> in, out;
  /** @throw CsvException with the place. */
  std::function<void(const Row&, const apps::CsvReader&, CsvWriter*)> row;
};

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

JointArray jointsFrom(const Row& row, std::size_t first) {
  JointArray q{};
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(first), q.size(), q.begin());
  return q;
}

Pose poseFrom(const Row& row, const apps::CsvReader& reader) {
  Pose X_BT;
  X_BT.p = Vector3(row[0], row[1], row[2]);
  X_BT.R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row.data() + 3);
  const double error = (X_BT.R.transpose() * X_BT.R - Matrix3::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance || X_BT.R.determinant() < 0.0) {
    throw apps::CsvException(reader.place() + ": r11..r33 is not a rotation; R^T R is off by " + std::to_string(error) +
                             ", allowed 1e-5, determinant +1");
  }
  return X_BT;
}

Conversion forward(const ArmGeometry& geometry, Arm arm) {
  return {kJoints, kPose, [=](const Row& row, const apps::CsvReader&, CsvWriter* out) {
            const Pose X_BT = kinematics::forward(geometry, arm, jointsFrom(row, 0));
            for (const double value : X_BT.p)
              out->cell(value);
            for (Eigen::Index i = 0; i < 9; ++i)
              out->cell(X_BT.R(i / 3, i % 3));
          }};
}

Conversion inverse(const ArmGeometry& geometry, Arm arm) {
  return {kPose + std::vector<std::string>{"grasp"} + kJoints, kJoints + std::vector<std::string>{"status"},
          [=](const Row& row, const apps::CsvReader& reader, CsvWriter* out) {
            const JointArray current = jointsFrom(row, 13);
            const auto result = kinematics::inverseWithinLimits(geometry, arm, poseFrom(row, reader), row[12], current);
            for (const double value : kinematics::isUsable(result.status) ? result.q : current)
              out->cell(value);
            out->cell(kinematics::name(result.status));
          }};
}

Conversion jacobian(const ArmGeometry& geometry, Arm arm) {
  std::vector<std::string> names;
  for (int i = 11; i <= 67; ++i) {
    if (i % 10 >= 1 && i % 10 <= 7) names.push_back("j" + std::to_string(i));
  }
  return {kJoints, names, [=](const Row& row, const apps::CsvReader&, CsvWriter* out) {
            const kinematics::Jacobian J = kinematics::jacobian(geometry, arm, jointsFrom(row, 0));
            for (Eigen::Index i = 0; i < J.size(); ++i)
              out->cell(J(i / 7, i % 7));
          }};
}

int convert(const Conversion& conversion) {
  std::ios::sync_with_stdio(false);
  apps::CsvReader reader(std::cin, "stdin", conversion.in);
  CsvWriter writer(stdout);
  writer.header(conversion.out);
  Row row;
  for (std::size_t rows = 1; reader.next(&row); ++rows) {
    conversion.row(row, reader, &writer);
    writer.endRow();
    if (rows % kProgressEvery == 0) std::fprintf(stderr, "kinematics: %zu rows\n", rows);
  }
  writer.flush();
  return 0;
}

constexpr const char* kFooter =
    "Tables are CSV with a header row, from standard input to standard output. Columns are found by name, in any "
    "order;\n"
    "others are ignored. Cells are numbers without quotes. Units: m, rad.\n"
    "  forward   in:  J1..J7\n"
    "            out: x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33   pose of the tool in the arm's base frame 0\n"
    "  inverse   in:  x..r33, grasp (opening, J6 + J7), J1..J7 (where the arm is now)\n"
    "            out: J1..J7,status\n"
    "  jacobian  in:  J1..J7\n"
    "            out: j11..j17,..,j61..j67   rows: 3 linear [m/s], 3 angular [rad/s], in frame 0\n"
    "J1..J7: shoulder, elbow, insertion, tool rotation, wrist, grasper 1, grasper 2; the jaw line is (J7 - J6) / 2.\n"
    "inverse picks the solution nearest to J1..J7 now and clamps it to the software limits, as the robot does:\n"
    "  ok              the tool is at the pose\n"
    "  clamped         joints at a software limit, the tool is not at the pose\n"
    "  singular_wrist  at the pose; the jaw axis passes the remote centre, so roll is free, kept where possible\n"
    "  out_of_reach, singular_rcm (wrist at the remote centre), too_far (further in one step than the robot accepts):\n"
    "                  no solution, J1..J7 are those of the input\n"
    "A wrong table ends it with stdin:LINE: reason; the rows before that line are written.\n"
    "Exit status: 0 done, 2 wrong input, 1 or above 100 wrong configuration or arguments.";

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{"Computes forward or inverse kinematics or the Jacobian of a Raven arm, from CSV on stdin to CSV on stdout."};
  std::string operation, arm_name, tool, config;
  app.add_option("OPERATION", operation, "forward, inverse or jacobian")
      ->required()
      ->check(CLI::IsMember({"forward", "inverse", "jacobian"}));
  app.add_option("--arm", arm_name, "gold (left) or green (right)")
      ->required()
      ->check(CLI::IsMember({kArmNames[0], kArmNames[1]}));
  app.add_option("--tool", tool, "Tool of config/arms.yaml (default: the configuration's)");
  app.add_option("--config", config, "Root configuration file (default: the packaged config/trainer.yaml)")
      ->type_name("FILE");
  app.footer(kFooter);
  return apps::runProgram(&app, argc, argv, [&] {
    const ArmsConfig arms = config::loadTrainerConfig(config.empty() ? apps::defaultConfigPath() : config).arms;
    const ArmGeometry geometry = config::toolGeometry(arms, tool.empty() ? arms.tool : tool);
    const Arm arm = arm_name == name(Arm::kGold) ? Arm::kGold : Arm::kGreen;
    if (operation == "forward") return convert(forward(geometry, arm));
    if (operation == "inverse") return convert(inverse(geometry, arm));
    return convert(jacobian(geometry, arm));
  });
}
