#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/impairment.h"
#include "raven2_trainer/core/overlays.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/types.h"

// Plain structs, one for each file of config/. Read once by module `config`, which demands every key, refuses unknown
// ones and checks the ranges written beside the fields; constant once threads run. Units are SI.

namespace raven2_trainer {

/** Tool and link constants of the DH chain (config/arms.yaml, `kinematics`). */
struct ArmGeometry {
  double d4{};         ///< [m] frame 3 to wrist along the shaft, -0.47 (raven2.md 2.1)
  double lw{};         ///< [m] wrist axis to frame 6, 0.013 for the Raven grasper
  JointArray q_min{};  ///< [rad, m] software limits (raven2.md 2.3)
  JointArray q_max{};  ///< [rad, m]
  JointArray home{};   ///< [rad, m]
};

/** Constants of an instrument (config/arms.yaml, `tools`). */
struct ToolPreset {
  std::string name;
  double d4{};  ///< [m] ArmGeometry::d4
  double lw{};  ///< [m] ArmGeometry::lw
};

/** config/arms.yaml */
struct ArmsConfig {
  ArmGeometry geometry{};         ///< with the chosen tool
  std::string tool;               ///< its name
  std::vector<ToolPreset> tools;  ///< all known ones, in the file's order
  PerArm<Vec3> rcm_W{};           ///< [m] remote centres of motion in W
};

/** Gains of one joint controller of the nominal model. */
struct JointGains {
  double kp{};     ///< [Nm/rad; N/m]
  double kd{};     ///< [Nms/rad; Ns/m] on the joint velocity (the robot never sets a desired velocity)
  double ki{};     ///< [Nm/(rad s); N/(m s)] only the insertion joint (paper, 3.1)
  double limit{};  ///< [Nm; N] bound of |tau|
};

/** config/model.yaml: dynamics and control of the nominal model. */
struct ModelConfig {
  std::array<JointGains, kJointCount> gains{};
  double green_insertion_kd{};  ///< [Ns/m] the one gain that differs between the robot's arms (raven2.md 3.6)
  bool gravity_compensation{};
  double gravity{};               ///< [m/s2] along -z of W
  int sub_steps{1};               ///< [-] steps of ODE a tick
  JointArray rotor_inertia{};     ///< [kg m2; kg] of the motors, as the joints feel it
  JointArray viscous_friction{};  ///< [Nms/rad; Ns/m]
  JointArray coulomb_friction{};  ///< [Nm; N]
  double erp{};                   ///< [-] ODE error reduction
  double cfm{};                   ///< [-] ODE constraint force mixing
  double contact_mu{};            ///< [-] Coulomb friction of contacts
  double jaw_mu{};                ///< [-] of contacts with a jaw
  double contact_erp{};           ///< [-]
  double contact_cfm{};           ///< [-]
  PerArm<bool> arm_contacts{};    ///< arms collide with the scene (paper, 3.2 switches it off in fault runs)
};

/** Passivity observer and controller of the haptic port (haptics/passivity_guard.h). */
struct PassivityConfig {
  bool enabled{};         ///< false: the energy is observed and recorded, the force is the law's
  double max_delay{};     ///< [s] longest way of a force to the hand and of its motion back that is reckoned with
  double budget{};        ///< [J] that the port may give a hand beyond what the hand's damping takes
  double bank{};          ///< [J] most that can be left of it at any time, whatever the hand took before
  double hand_damping{};  ///< [Ns/m] least damping of hand and master together
  double rest{};          ///< [s] without force after which the account starts anew
};

/** Guidance along a planned path (haptics/path_guidance.h). */
struct GuidanceConfig {
  bool enabled{};
  double stiffness{};  ///< [N/m] at the hand, per metre of the tip
  double max_force{};  ///< [N]
  double reach{};      ///< [m] of the tip; from here on the force fades, at twice this it is gone
  double fade_time{};  ///< [s] from nothing to the whole force once there is a path and the pedal is down
};

/** What the daemon takes for the middle of a master's workspace, of which it is only told increments. */
enum class WorkspaceOrigin : std::uint8_t { kPedalDown, kStart };
constexpr std::array<const char*, 2> kWorkspaceOriginNames{"pedal_down", "start"};

/** Cue at the edge of the master's workspace (haptics/workspace_edge.h). */
struct EdgeConfig {
  bool enabled{};
  Vec3 size_I{};       ///< [m] [@frame I] whole lengths of the box, forward, right, down
  double margin{};     ///< [m] inside the box where the force begins
  double max_force{};  ///< [N] at the edge and beyond
  WorkspaceOrigin origin{WorkspaceOrigin::kPedalDown};
};

/** config/haptics.yaml: eqs. (5) and (6) of the paper, and what goes with them. */
struct HapticGains {
  double kp{};         ///< [N/m]
  double kd{};         ///< [Ns/m]
  double tolerance{};  ///< [m] no force up to this deviation, 3 mm (paper, 3.2)
  double min_force{};  ///< [N] least force beyond it, the "0.05" of eq. (5)
  double max_force{};  ///< [N] saturation; 3.3 N is the Omni's peak
  double max_slew{};   ///< [N/s] fastest rise and fall of a force
  PassivityConfig passivity{};
  GuidanceConfig guidance{};
  EdgeConfig edge{};
};

/** Whether a receiver of ITP asks for signatures (doc/wire.md). */
enum class ItpAuth : std::uint8_t { kOff, kAcceptBoth, kRequired };
constexpr std::size_t kItpAuthCount = 3;
constexpr std::array<const char*, kItpAuthCount> kItpAuthNames{"off", "accept_both", "required"};

/** What a receiver of ITP demands of it (network.yaml). */
struct ItpRules {
  bool hardened{true};  ///< false: a real Raven's own rules, and nothing below but compat_timeout
  ItpAuth auth{ItpAuth::kOff};
  std::int32_t max_increment_um{};  ///< [um] largest accepted increment per axis and packet
  double max_rotation{};            ///< [rad] largest accepted rotation per packet
  double max_rate{};                ///< [1/s] packets used in the long run
  std::int32_t max_burst{};         ///< [-] packets used at once
  double master_timeout{};          ///< [s] silence of the console after which the pedal counts as up
  double compat_timeout{};          ///< [s] the same with a Raven's rules

  double pedalTimeout() const noexcept { return hardened ? master_timeout : compat_timeout; }
};

/** Pedals and buttons beside the one that engages, as sensor_msgs/Joy (doc/ros.md). */
struct JoyConfig {
  std::string topic;                       ///< empty: none
  double timeout{};                        ///< [s] silence after which the camera's counts as up
  std::array<int, kPedalCount> buttons{};  ///< by Pedal: position in Joy::buttons, -1 none
};

/** config/network.yaml */
struct NetworkConfig {
  std::string bind_address;     ///< of the daemon's and the robot's listeners
  std::uint16_t master_port{};  ///< UDP console -> daemon
  std::string daemon_host;      ///< where the console sends to
  std::string robot_host;
  std::uint16_t robot_port{};  ///< UDP daemon -> robot
  std::string console_host;
  std::uint16_t force_port{};     ///< UDP daemon -> console
  std::uint16_t sight_port{};     ///< UDP daemon -> console: pictures for scripted hands
  bool sight{};                   ///< they are sent and taken
  std::uint16_t state_port{};     ///< TCP robot -> daemon
  double stale_after{};           ///< [s] robot state older than this is not used
  double reconnect_min{};         ///< [s] first pause before the TCP link is tried again
  double reconnect_max{};         ///< [s] longest pause
  ItpRules itp{};                 ///< of the daemon's ingest
  std::string master_address;     ///< the only one heard; empty: the first that sends a valid packet
  bool allow_plaintext_remote{};  ///< unsigned ITP from other computers may be listened to
  std::string key_file;           ///< absolute path; empty: none
  JoyConfig joy{};
};

/** Scheduling of one thread. */
struct ThreadConfig {
  int priority{};  ///< SCHED_FIFO priority, 0 = normal scheduling
  int cpu{};       ///< -1 any
};

/** config/runtime.yaml */
struct RuntimeConfig {
  ThreadConfig physics{}, haptic{}, ingest{}, robot_link{}, sender{};
  int stack_kib{};                     ///< [KiB] of each thread above
  int background_nice{};               ///< [-] of planner, renderer, recovery
  int max_catch_up{};                  ///< [ticks] extra steps per tick when behind
  double max_backlog{};                ///< [s] beyond it the backlog is given up as a time-slip event
  double fault_period{};               ///< [s] of the fault director
  double recorder_period{};            ///< [s]
  std::string flight_recorder;         ///< folder on a tmpfs for the record queues, or "none"
  double ros_period{};                 ///< [s] of the ROS publishers
  double plan_at{};                    ///< [s] session time of the scheduled plan; negative = none
  std::int64_t lockstep_plan_delay{};  ///< [ticks] from plan request to result in lockstep
  double start_timeout{};              ///< [s] wait for the first pedal down; 0 = for ever
  bool enable_remote_control{};        ///< offer ROS commands to a network, too
};

/** config/planner.yaml */
struct PlannerConfig {
  std::string planner;               ///< one of planning::kPlannerNames
  std::uint32_t samples{};           ///< n of the paper
  std::uint32_t max_samples{};       ///< most, those added after failures included
  double eta_length{};               ///< eta1 of eq. (1)
  double eta_acceleration{};         ///< eta2 of eq. (1)
  double eta_clearance{};            ///< weight of the clearance term
  double clearance_range{};          ///< [m] nearer than this an obstacle costs
  double radius_multiplier{};        ///< [-] times the smallest radius that keeps FMT* optimal
  std::uint32_t volume_samples{};    ///< of the estimate of the free volume
  double volume_confidence{};        ///< [-] that the bound of the free volume holds
  std::uint32_t improve_attempts{};  ///< [-] of the local improvement; 0 leaves FMT*'s path as it is
  std::uint32_t max_rollouts{};      ///< [-] paths that may fail in the roll-out before the plan does
  double max_tracking_error{};       ///< [m] of the tip in the roll-out; farther astray it does not follow
  double time_limit{};               ///< [s]
  double edge_step{};                ///< [-] eight times the largest step, in the unit cube, between checks along an
                                     ///< edge from or to an end that is nearer than the clearance; of no other edge
  double clearance{};                ///< [m] kept from obstacles
  JointArray velocity_limit{};       ///< [rad/s, m/s]
  JointArray acceleration_limit{};   ///< [rad/s2, m/s2]
  Vec3 goal_W{};                     ///< [m] default goal of the tip: at the ring
};

/** What moves the model's arm along a path. */
enum class ExecutionDrive : std::uint8_t {
  kTracking,  ///< its control law
  kOpenLoop,  ///< torques that the law finds for an arm of its own beside it, whatever the model does (paper, 2.3.3)
};
constexpr std::array<const char*, 2> kExecutionDriveNames{"tracking", "open_loop"};

/** config/execution.yaml */
struct ExecutionConfig {
  double speed{};  ///< [-] of the plan's own
  ExecutionDrive drive{};
  double hold_time{};            ///< [s] from where the arm stands to where the path starts
  JointArray start_tolerance{};  ///< [rad, m] an arm farther from where it stood has moved
  double deviation_limit{};      ///< [m] of either tip from its place on the path
  double settle_tolerance{};     ///< [m] of both tips from the goal, to be there
  double settle_speed{};         ///< [m/s] of both tips, to be at rest
  double settle_time{};          ///< [s] after the path's end, to come to rest
  double pedal_timeout{};        ///< [s] armed without a pedal-down
  double robot_timeout{};        ///< [s] that the path stands still because the robot does not follow
};

/** Which message types CRTK clients are spoken to with. */
enum class CrtkDialect : std::uint8_t {
  kModern,  ///< crtk_msgs 1.3
  kRaven,   ///< the robot's own branch `crtk`: TransformStamped, messages of the retired package
};
constexpr std::array<const char*, 2> kCrtkDialectNames{"modern", "raven"};

/** config/crtk.yaml: the arms as CRTK devices (doc/crtk.md). */
struct CrtkConfig {
  bool enabled{};
  PerArm<std::string> names;  ///< namespace of each arm
  CrtkDialect dialect{};
  double period{};          ///< [s] between two states that are published
  double state_period{};    ///< [s] the operating state is repeated, changed or not
  double max_speed{};       ///< [m/s] of a tip after a servo command
  double max_turn_rate{};   ///< [rad/s] of it, and of a joint
  double max_step{};        ///< [m] a servo command may lead from the set point
  double max_step_turn{};   ///< [rad] the same
  double move_speed{};      ///< [m/s] highest of a move_*; at most max_speed
  double move_turn_rate{};  ///< [rad/s] the same
  double twist_timeout{};   ///< [s] servo_cv without another
  double release_after{};   ///< [s] of silence after which the pedal goes up; 0 never
  double trim_time{};       ///< [s] constant in which a resting robot is brought nearer to the set point; 0 it is not
};

/** Whether a camera stays where it is, and if not, what takes it along. */
enum class CameraMoves : std::uint8_t {
  kNever,
  kClutch,     ///< ModelState::camera: the masters move it while its pedal is held
  kGoldTool,   ///< looks at the model's gold tool tip, from the side that eye and target give
  kGreenTool,  ///< the same, green
};
constexpr std::array<const char*, 4> kCameraMovesNames{"never", "clutch", "gold_tool", "green_tool"};

/** A camera: pose and lens, no drawing. */
struct CameraConfig {
  std::string name;
  Vec3 eye_W{};           ///< [m]
  Vec3 target_W{};        ///< [m] looked at
  Vec3 up_W{};            ///< [-]
  double vertical_fov{};  ///< [rad]
  CameraMoves moves{CameraMoves::kNever};
  double aside{};  ///< [m] to its own right of where eye and target put it, looking the same way: an eye of a pair
};

/** Two cameras side by side, with parallel views. */
struct StereoConfig {
  std::string camera;  ///< in their middle; they are called as it is, with "_left" and "_right" behind
  double baseline{};   ///< [m] between them
};

/** Marks left behind by the tool tips. */
struct TrailConfig {
  double duration{};  ///< [s] of the past that is shown
  double step{};      ///< [s] from mark to mark
};

/** config/render.yaml */
struct RenderConfig {
  std::vector<CameraConfig> cameras;  ///< with both of the stereo pair behind the others
  StereoConfig stereo;
  OverlaySet video_overlays, live_overlays;
  TrailConfig trails;
  std::string video_camera;  ///< of video.mp4
  std::string live_camera;   ///< of camera/image_raw
  int video_width{}, video_height{}, video_fps{};
  int live_width{}, live_height{}, live_fps{};
  int live_slowest{};       ///< [Hz] the rate is not lowered below it
  double live_smallest{};   ///< [-] of width and height, not lowered below it
  double live_settle{};     ///< [s] with room for more before rate or size is raised
  int live_jpeg_quality{};  ///< [-] of camera/image_raw/compressed
  int encoder_crf{};        ///< [-] x264 quality
  std::string encoder_preset;
  std::string real_camera_topic;  ///< of the real camera's pictures; empty: none
  double real_stale_after{};      ///< [s] without one of them after which the virtual scene is shown instead
};

/** config/console.yaml: the surgeon's hands. */
struct ConsoleConfig {
  double scale{};                      ///< [-] motion scale of the master
  double hand_mass{};                  ///< [kg]
  double hand_stiffness{};             ///< [N/m]
  double hand_damping{};               ///< [Ns/m]
  double tremor_amplitude{};           ///< [m] of the hand, peak
  double tremor_low{}, tremor_high{};  ///< [Hz]
  double start_delay{};                ///< [s] pedal stays up this long after the robot is ready
  double motion_time{};                ///< [s] from first pedal down to the final release; 0 = for ever
  double stroke_speed{};               ///< [m/s] mean hand speed of a stroke
  double pause_min{}, pause_max{};     ///< [s] between strokes
  double clutch_every{};               ///< [s] mean time between clutchings; 0 = never
  double clutch_time{};                ///< [s] pedal up while clutching
  Vec3 task_W_min{},
      task_W_max{};            ///< [m] [@frame W] box of the strokes' targets for the gold arm, mirrored in y for green
  double ready_timeout{};      ///< [s] scripted hands begin without a ready robot after this long; 0 = never
  double recording_scale{};    ///< [-] hand motion = recording x this
  double recording_lead_in{};  ///< [s] minimum-jerk move from home to the recording's first position
};

/** What the control software knows of one axis of the emulated robot. */
struct MotorAxis {
  double transmission{};    ///< [rad motor / rad joint; rad/m]
  double torque_per_amp{};  ///< [Nm/A] at the capstan
  double counts_per_amp{};  ///< [counts/A]
  double kp{};              ///< [Nm/rad] control software, motor space (raven2.md 3.6)
  double kd{};              ///< [Nms/rad]
  double ki{};              ///< [Nm/(rad s)]
  std::int32_t dac_clip{};  ///< [counts] (raven2.md 3.5)
};

/** What the overdrive check does with a command above its clip (raven2.md 4.5). */
enum class OverdrivePolicy : std::uint8_t {
  kSoft,  ///< clips
  kHard,  ///< stops the robot after more than 10 of them
  kNone,  ///< lets it pass
};
constexpr std::array<const char*, 3> kOverdrivePolicyNames{"SOFT", "HARD", "NONE"};

/** Drive of one axis of the emulated robot, DAC to link. Torques at the capstan, angles of the motor shaft. */
struct PlantAxis {
  double torque_gain{};      ///< [-] real torque per commanded torque
  double torque_offset{};    ///< [Nm] constant, towards growing motor angle
  double inertia{};          ///< [kg m2] of rotor and gear: capstan torque by shaft acceleration
  double coulomb{};          ///< [Nm] dry friction of motor and gear
  double viscous{};          ///< [Nms/rad] of motor and gear
  double link_coulomb{};     ///< [Nm; N] dry friction at the joint
  double link_viscous{};     ///< [Nms/rad; Ns/m] at the joint
  double cable_stiffness{};  ///< [N/m] force by stretch at the capstan; elastic cables only
  double cable_damping{};    ///< [Ns/m] elastic cables only
};

/** config/plants/NAME.yaml: how the emulated robot differs from its nominal model. */
struct PlantConfig {
  std::string title;
  bool elastic_cables{};      ///< false: joints rigidly coupled to the motors
  double amplifier_limit{};   ///< [V] saturation; 10 V are 32768 counts
  double amplifier_offset{};  ///< [A] current at command 0, every channel
  std::array<PlantAxis, kJointCount> axes{};
};

/** config/virtual_raven.yaml */
struct VirtualRavenConfig {
  std::string behaviour;  ///< compat: a real Raven's rules; hardened: those of `itp`
  ItpRules itp{};         ///< as network.yaml says
  std::array<MotorAxis, kJointCount> axes{};
  double green_insertion_kd{};    ///< [Nms/rad] the one gain that differs between the arms
  std::int32_t max_inst_dac{};    ///< [counts] overdrive threshold of any axis
  std::int64_t master_timeout{};  ///< [cycles]
  std::string training_level;     ///< set of thresholds and gains in force
  OverdrivePolicy overdrive_policy{OverdrivePolicy::kSoft};
  std::array<std::int32_t, kJointCount> homing_dac{};  ///< [counts] demand that means a hard stop (raven2.md 3.5)
  bool low_pass{};                                     ///< motor positions through the 120 Hz Butterworth (3.7)
  bool full_homing{};                                  ///< search the hard stops; else the joints are known at power-on
  bool gravity_compensation{};
  JointArray start_offset{};  ///< [rad, m] joints at power-on, relative to home
  double homing_time{};       ///< [s] half-cosine from there to home
  std::string plant_name;     ///< preset of plants_folder
  std::string plants_folder;  ///< absolute path
  PlantConfig plant{};
};

/** A fault scenario of the library (config/faults/NAME.yaml). */
struct Scenario {
  std::string name;
  std::string title;
  std::int64_t number{};             ///< of the library's list; 0 for one of the user's own
  std::string source;                ///< where its numbers come from
  std::string published;             ///< what the source observed
  std::vector<std::string> hazards;  ///< classes of doc/hazards.md: H1-1, H1-2, H1-3, H-2, H-3
  std::vector<std::string> maude;    ///< report numbers
  std::string maude_link;            ///< how sure the link is: table, similar, none
  std::string basis;                 ///< published or design
  std::string expected;              ///< outcome
  std::string response;              ///< what the trainee should do
  std::vector<Fault> faults;         ///< 1 to kMaxFaults, `id` set
};

constexpr std::size_t kDetectorAxes = 3;  ///< shoulder, elbow, insertion

/** Largest values of fault-free runs. */
struct DetectorThresholds {
  double acceleration{};    ///< [rad/s2] of the motor
  double motor_velocity{};  ///< [rad/s]
  double joint_velocity{};  ///< [rad/s; m/s]
};

/** What the detector believes of one motor axis, identified from commands and encoders alone. */
struct DetectorAxis {
  double inertia{};  ///< [kg m2] capstan torque by acceleration of the motor shaft, link included
  double viscous{};  ///< [Nms/rad]
  double coulomb{};  ///< [Nm]
  double offset{};   ///< [Nm] that the axis needs at joints 0
  Vec3 gravity{};    ///< [Nm/rad, Nm/rad, Nm/m] by which that changes with the joints
  DetectorThresholds published{}, departure{};  ///< for each rule
};

/** What an alarm takes. */
enum class DetectorRule : std::uint8_t {
  kPublished,  ///< DSN 2016: one step ahead, the three quantities of a joint agree
  kDeparture,  ///< the same of the velocities that the command leads to, and the tip departs by `excursion`
};
constexpr std::array<const char*, 2> kDetectorRuleNames{"published", "departure"};

/** What an alarm does. */
enum class Mitigation : std::uint8_t {
  kOff,   ///< nothing
  kHold,  ///< the last safe command is written in its place
  kStop,  ///< software E-stop
};
constexpr std::array<const char*, 3> kMitigationNames{"off", "hold", "stop"};

/** config/detector.yaml */
struct DetectorConfig {
  Mitigation mitigate{Mitigation::kOff};
  DetectorRule rule{DetectorRule::kDeparture};
  double factor{};          ///< [-] on all thresholds
  double memory{};          ///< [s] over which a motor's mean velocity is taken
  double braking_time{};    ///< [s] for which velocity gained carries on
  double asked{};           ///< [-] weight of a position error that a command within the clip stands for
  double persistence{};     ///< [s] that a command beyond the clip is taken to last
  double suspicion{};       ///< [-] of an alarm's size, from which on an arm's motion is not taken to be the surgeon's
  double suspicion_time{};  ///< [s] for which, at most
  double excursion{};       ///< [m] predicted departure of the tip
  PerArm<std::array<DetectorAxis, kDetectorAxes>> axes{};
};

/** What may be injected at all. */
struct InjectionConfig {
  bool enable{};      ///< nothing is armed without
  bool real_robot{};  ///< the second key: the relayed stream to a real robot may be corrupted
};

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
  std::string robot_urdf;  ///< absolute path
  std::string scene_urdf;  ///< absolute path
  std::string hazard;      ///< scenario armed at the start, or "none"
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
  std::map<std::string, std::string> overridden;  ///< those of `files` that were not read as they stand: what was read
};

}  // namespace raven2_trainer
