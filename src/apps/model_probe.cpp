// One arm of the nominal model in open loop, torques in, states out: to compare with other dynamics of
// urdf/raven2.urdf.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/csv_table.h"
#include "apps/common/paths.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer {
namespace {

constexpr double kFastest = 100.0;       // [rad/s; m/s] 790 rad/s of a motor turn the tool joints by 146 rad/s at most
constexpr std::size_t kLongRun = 20000;  // ticks from which progress is shown

struct Options {
  std::string config, arm, torques{"-"}, out{"-"};
  std::vector<double> q0, dq0{0, 0, 0, 0, 0, 0, 0};
  std::string gravity{"on"}, friction{"on"}, armature{"on"};
};

const std::vector<std::string> kTorques{"tau1", "tau2", "tau3", "tau4", "tau5", "tau6", "tau7"};
const std::vector<std::string> kStates{"q1",  "q2",  "q3",  "q4",  "q5",  "q6",  "q7",
                                       "dq1", "dq2", "dq3", "dq4", "dq5", "dq6", "dq7"};

ModelConfig modelConfig(const Options& options, ModelConfig config) {
  config.arm_contacts.fill(false);
  if (options.gravity == "off") config.gravity = 0.0;
  if (options.friction == "off") config.viscous_friction = config.coulomb_friction = JointArray{};
  if (options.armature == "off") config.rotor_inertia = JointArray{};
  return config;
}

JointArray joints(const std::vector<double>& values) {
  JointArray result{};
  std::copy_n(values.begin(), kJointCount, result.begin());
  return result;
}

/** @throw apps::CsvException: bad input, like a bad table. */
void checkStart(const JointArray& q0, const JointArray& dq0, const model::RavenModel& raven, Arm arm) {
  for (const double rate : dq0) {
    if (!(std::abs(rate) <= kFastest))
      throw apps::CsvException("--dq0: " + std::to_string(rate) + ", allowed [-100, 100]");
  }
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const model::Link& link = raven.description.links.at(static_cast<std::size_t>(at(raven.links, arm)[j]));
    if (q0[j] >= link.lower && q0[j] <= link.upper) continue;
    throw apps::CsvException("--q0: " + link.joint_name + " is " + std::to_string(q0[j]) + ", allowed [" +
                             std::to_string(link.lower) + ", " + std::to_string(link.upper) + "] (" +
                             raven.description.file + ":" + std::to_string(link.line) + ")");
  }
}

/** One arm of a world, in URDF coordinates; the other one rests. */
class Probe {
 public:
  Probe(const model::RavenModel& raven, const ModelConfig& config, Arm arm)
      : arm_(arm), d4_(raven.arms.geometry.d4), world_(raven, model::SceneModel{}, config) {}

  void start(const JointArray& q0, const JointArray& dq0) {
    world_.setJointState(arm_, kinematics::fromUrdf(arm_, d4_, q0), kinematics::rateToUrdf(arm_, dq0));
  }

  bool step(const JointArray& torque) {
    PerArm<JointArray> tau{world_.gravityTorque(Arm::kGold), world_.gravityTorque(Arm::kGreen)};
    at(tau, arm_) = kinematics::rateToUrdf(arm_, torque);
    world_.step(tau);
    return world_.healthy();
  }

  void write(apps::CsvWriter* out) const {
    JointArray q, dq;
    world_.jointState(arm_, &q, &dq);
    for (const JointArray& values : {kinematics::toUrdf(arm_, d4_, q), kinematics::rateToUrdf(arm_, dq)}) {
      for (const double value : values)
        out->cell(value);
    }
    out->endRow();
  }

 private:
  Arm arm_;
  double d4_;
  physics::RavenWorld world_;
};

int run(const std::vector<std::vector<double>>& torques, Probe* probe, apps::CsvWriter* out) {
  apps::ProgressBar bar("model_probe");
  out->header(kStates);
  for (std::size_t row = 0; row < torques.size(); ++row) {
    if (!probe->step(joints(torques[row]))) {
      std::fprintf(stderr, "model_probe: the world broke down in step %zu: torques too large?\n", row + 1);
      return 1;
    }
    probe->write(out);
    if (torques.size() >= kLongRun) bar.update(static_cast<double>(row) / static_cast<double>(torques.size()));
  }
  out->flush();
  if (torques.size() >= kLongRun) bar.done(std::to_string(torques.size()) + " rows");
  return 0;
}

int probe(const Options& options) {
  const TrainerConfig config =
      config::loadTrainerConfig(options.config.empty() ? apps::defaultConfigPath() : options.config);
  const model::RavenModel raven = model::loadRavenModel(config);
  const Arm arm = options.arm == kArmNames[0] ? Arm::kGold : Arm::kGreen;
  checkStart(joints(options.q0), joints(options.dq0), raven, arm);
  const auto torques = apps::readTable(options.torques, kTorques);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      options.out == "-" ? stdout : std::fopen(options.out.c_str(), "wb"), &std::fclose);
  if (!file) throw ConfigException(options.out + ": cannot be written");
  apps::CsvWriter out(file.get());
  Probe arm_probe(raven, modelConfig(options, config.model), arm);
  arm_probe.start(joints(options.q0), joints(options.dq0));
  return run(torques, &arm_probe, &out);
}

void addSwitch(CLI::App* app, const char* name, std::string* value, const char* what) {
  app->add_option(name, *value, what)->check(CLI::IsMember({"on", "off"}))->capture_default_str();
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  Options options;
  CLI::App app{"Moves the model of one arm by a table of joint torques, without a controller, and writes its joint states."};
  app.footer(
      "Joints are those of urdf/raven2.urdf, in its coordinates and signs: shoulder, elbow, insertion, tool_roll,\n"
      "wrist_joint, grasper_joint_1, grasper_joint_2. No controller, no contacts; joint limits are hard stops.\n"
      "  in:  tau1..tau7 [Nm; tau3 N], held for the millisecond; columns are found by name\n"
      "  out: q1..q7 [rad; q3 m], dq1..dq7 [rad/s; dq3 m/s] after it\n"
      "Exit status: 0 written, 1 unstable, wrong configuration or output, 2 wrong input, above 100 wrong arguments.");
  app.add_option("--arm", options.arm, "gold (_L) or green (_R)")->required()->check(CLI::IsMember({"gold", "green"}));
  app.add_option("--q0", options.q0, "Seven positions at the start [rad; m], within the limits: q1,...,q7")
      ->required()
      ->delimiter(',')
      ->expected(7);
  app.add_option("--dq0", options.dq0, "Seven rates at the start [rad/s; m/s] (default: at rest)")
      ->delimiter(',')
      ->expected(7);
  app.add_option("--torques", options.torques, "CSV file of torques; -: stdin")
      ->type_name("FILE")
      ->capture_default_str();
  app.add_option("--out", options.out, "CSV file of states to write; -: stdout")
      ->type_name("FILE")
      ->capture_default_str();
  addSwitch(&app, "--gravity", &options.gravity, "Gravity: on or off");
  addSwitch(&app, "--friction", &options.friction, "Friction and damping of all joints: on or off");
  addSwitch(&app, "--armature", &options.armature, "Inertia of the motors' rotors: on or off");
  app.add_option("--config", options.config, "Root configuration file (default: the packaged config/trainer.yaml)")
      ->type_name("FILE");
  return apps::runProgram(&app, argc, argv, [&] { return probe(options); });
}
