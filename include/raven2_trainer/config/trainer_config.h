#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/console/surgeon_config.h"
#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/control/execution_config.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/detector/detector_config.h"
#include "raven2_trainer/faults/fault_library.h"
#include "raven2_trainer/faults/scenario.h"
#include "raven2_trainer/haptics/haptics_config.h"
#include "raven2_trainer/impair/impairment.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/model/model_source.h"
#include "raven2_trainer/net/network_config.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/planning/planner_config.h"
#include "raven2_trainer/raven/virtual_raven_config.h"
#include "raven2_trainer/render/picture_config.h"
#include "raven2_trainer/render/render_config.h"
#include "raven2_trainer/session/config_source.h"
#include "raven2_trainer/threads/runtime_config.h"

// Plain structs, one for each file of config/, each in its own header. Read once by module `config`, which demands
// every key, refuses unknown ones and checks the ranges written next to the fields; constant once threads run. Units
// are SI.

namespace raven2_trainer {

/** Everything. `files` lists each file read, in order, for the session's hashes. */
struct TrainerConfig {
  ArmsConfig arms{};
  ModelConfig model{};
  HapticGains haptics{};
  NetworkConfig network{};
  RuntimeConfig runtime{};
  PlannerConfig planner{};
  ExecutionConfig execution{};
  CrtkConfig crtk{};
  RenderConfig render{};
  ConsoleConfig console{};
  VirtualRavenConfig virtual_raven{};
  std::string robot_urdf;                          ///< absolute path
  std::string scene_urdf;                          ///< absolute path
  std::map<std::string, std::string> urdf_places;  ///< the place of each next to the configuration, if it were there
  std::string hazard;                              ///< scenario armed at the start, or "none"
  InjectionConfig injection{};
  DetectorConfig detector{};
  std::vector<Scenario> scenarios;                  ///< the library; Fault::id is the position + 1
  std::vector<Impairment> impairments;              ///< presets that kind `impair` names by position
  std::vector<std::string> impairment_names;        ///< of the same
  std::string exercises, scenes, curricula, bands;  ///< absolute paths of the folders
  std::string exercise_name{"none"};                ///< file in `exercises` without its ending, or "none"
  Exercise exercise{};                              ///< the one named; empty for none
  SceneRoles roles{};                               ///< of the scene; empty for none
  std::string drill{"none"};                        ///< scenario that the exercise runs into, or "none"
  std::string trainee;                              ///< id, or ""
  std::string curriculum{"none"};                   ///< file in `curricula` without its ending, or "none"
  std::uint64_t seed{};
  std::vector<std::string> files;
  std::map<std::string, std::string> overridden;  ///< of `files`, the changed ones: the text that was read

  /** The parts for each module. All refer to this, which has to outlive them. */
  operator model::ModelSource() const;
  operator faults::FaultLibrary() const;
  operator console::SurgeonConfig() const;
  operator session::ConfigSource() const;
  operator render::PictureConfig() const&;
  operator render::PictureConfig() && = delete;
  operator loop::LoopConfig() const&;
  operator loop::LoopConfig() && = delete;
};

/** The camera through which the surgeon looks; ModelState::camera is its pose. */
const CameraConfig& liveCamera(const RenderConfig& render);

}  // namespace raven2_trainer
