#include "config/readers.h"

#include <filesystem>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastScale = 1e-6;  ///< of what commands, torques and motors' positions are divided by

MotorAxis readAxis(Section& axes, const char* joint) {
  Section axis = axes.section(joint);
  MotorAxis m;
  m.transmission = axis.number("transmission", kLeastScale, kAny);
  m.torque_per_amp = axis.number("torque_per_amp", kLeastScale, kAny);
  m.counts_per_amp = axis.number("counts_per_amp", kLeastScale, kAny);
  m.kp = axis.number("kp", 0, kAny);
  m.kd = axis.number("kd", 0, kAny);
  m.ki = axis.number("ki", 0, kAny);
  m.dac_clip = static_cast<std::int32_t>(axis.integer("dac_clip", 0, 32767));
  axis.finish();
  return m;
}

std::array<std::int32_t, kJointCount> readCounts(Section& root, const std::string& key) {
  const JointArray values = root.joints(key, 0, 32767);
  std::array<std::int32_t, kJointCount> counts;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    counts[j] = static_cast<std::int32_t>(values[j]);
    if (counts[j] != values[j]) throw ConfigException(root.where(key) + " holds a fraction, expected whole counts");
  }
  return counts;
}

/** Puts one training level in place of the values of the file; the other levels are read and checked, too. */
void readTrainingLevel(Section level, bool chosen, VirtualRavenConfig* c) {
  const auto clip = readCounts(level, "dac_clip");
  const auto homing = readCounts(level, "homing_dac");
  const auto max_inst = static_cast<std::int32_t>(level.integer("max_inst_dac", 1, 32767));
  const JointArray kp = level.joints("kp", 0, kAny);
  const JointArray ki = level.joints("ki", 0, kAny);
  level.finish();
  if (!chosen) return;
  c->homing_dac = homing;
  c->max_inst_dac = max_inst;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    c->axes[j].dac_clip = clip[j];
    c->axes[j].kp = kp[j];
    c->axes[j].ki = ki[j];
  }
}

void readTrainingLevels(Section& root, VirtualRavenConfig* c) {
  c->training_level = root.text("training_level", {"beginner", "moderate", "advanced", "authors"});
  Section levels = root.section("training_levels");
  for (const char* name : {"beginner", "advanced", "authors"})
    readTrainingLevel(levels.section(name), c->training_level == name, c);
  levels.finish();
}

}  // namespace

void readVirtualRaven(Section& root, VirtualRavenConfig* c) {
  c->behaviour = root.text("behaviour", {"compat", "hardened"});
  Section axes = root.section("axes");
  for (std::size_t j = 0; j < kJointCount; ++j)
    c->axes[j] = readAxis(axes, kJointNames[j]);
  axes.finish();
  c->green_insertion_kd = root.number("green_insertion_kd", 0, 1);
  c->max_inst_dac = static_cast<std::int32_t>(root.integer("max_inst_dac", 1, 32767));
  c->master_timeout = root.integer("master_timeout", 1, 1000000000);
  c->gravity_compensation = root.boolean("gravity_compensation");
  c->homing_dac = readCounts(root, "homing_dac");
  readTrainingLevels(root, c);
  c->overdrive_policy = static_cast<OverdrivePolicy>(root.choice("overdrive_policy", kOverdrivePolicyNames));
  c->low_pass = root.boolean("low_pass");
  c->full_homing = root.text("homing", {"full", "quick"}) == "full";
  c->start_offset = root.joints("start_offset", -1, 1);
  c->homing_time = root.number("homing_time", 0.1, 60);
  c->plant_name = root.text("plant");
  c->plants_folder = (fs::absolute(root.file()).parent_path() / "plants").string();
}

}  // namespace raven2_trainer::config
