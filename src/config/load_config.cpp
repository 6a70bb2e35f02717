#include "raven2_trainer/config/load_config.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <type_traits>
#include <utility>

#include "raven2_trainer/config/load_impairment.h"
#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr double kAny = 1e6;  // "[0, 1e6]" of the files: physical, not a typing error

constexpr double kLastFelt = 0.05;  ///< [s] age of a state by which no force comes from it any more

/** Opens a file and puts overrides into it; what was read, then, is kept, for the session's copy. */
Section openFile(const std::string& path, const Overrides& overrides, TrainerConfig* all) {
  all->files.push_back(path);
  Section root = Section::fromFile(path);
  if (overrides.empty()) return root;
  std::string head;
  for (const Override& each : overrides) {
    root.put(each);
    head += "# " + each.key + ": by " + each.source + "\n";
  }
  all->overridden[path] = head + root.yaml();
  return root;
}

template <typename Config, typename Read>
Config readFile(const std::string& path, const Overrides& overrides, TrainerConfig* all, Read read) {
  Section root = openFile(path, overrides, all);
  Config config{};
  read(root, &config);
  root.finish();
  return config;
}

void readTools(Section& root, ArmsConfig* c) {
  Section tools = root.section("tools");
  const std::vector<std::string> names = tools.keys();
  if (names.empty()) throw ConfigException(root.where("tools") + " is empty");
  for (const std::string& name : names) {
    Section tool = tools.section(name);
    c->tools.push_back({name, tool.number("d4", -1.0, 0.0), tool.number("lw", 0.001, 0.1)});
    tool.finish();
  }
  c->tool = root.text("tool", names);
}

void readArms(Section& root, ArmsConfig* c) {
  readTools(root, c);
  Section limits = root.section("limits");
  c->geometry.q_min = limits.joints("min", -10.0, 10.0);
  c->geometry.q_max = limits.joints("max", -10.0, 10.0);
  limits.finish();
  c->geometry.home = root.joints("home", -10.0, 10.0);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const ArmGeometry& g = c->geometry;
    if (!(g.q_min[j] < g.q_max[j])) throw ConfigException(root.where("limits") + ": min is not below max");
    if (g.home[j] < g.q_min[j] || g.home[j] > g.q_max[j])
      throw ConfigException(root.where("home") + " is outside limits");
  }
  Section rcm = root.section("rcm_W");
  for (const Arm arm : kArms)
    at(c->rcm_W, arm) = rcm.vec3(name(arm), -1.0, 1.0);
  rcm.finish();
  c->geometry = toolGeometry(*c, c->tool);
}

void readModel(Section& root, ModelConfig* c) {
  Section gains = root.section("gains");
  for (std::size_t j = 0; j < kJointCount; ++j) {
    Section joint = gains.section(kJointNames[j]);
    c->gains[j] = {joint.number("kp", 0, kAny), joint.number("kd", 0, kAny), joint.number("ki", 0, kAny),
                   joint.number("limit", 0, kAny)};
    joint.finish();
  }
  gains.finish();
  c->green_insertion_kd = root.number("green_insertion_kd", 0, kAny);
  c->gravity_compensation = root.boolean("gravity_compensation");
  c->gravity = root.number("gravity", 0, 100);
  c->sub_steps = static_cast<int>(root.integer("sub_steps", 1, 64));
  c->rotor_inertia = root.joints("rotor_inertia", 0, 1e4);
  c->viscous_friction = root.joints("viscous_friction", 0, 1e4);
  c->coulomb_friction = root.joints("coulomb_friction", 0, 1e4);
  c->erp = root.number("erp", 0, 1);
  c->cfm = root.number("cfm", 0, 1);
  c->contact_mu = root.number("contact_mu", 0, 10);
  c->jaw_mu = root.number("jaw_mu", 0, 10);
  c->contact_erp = root.number("contact_erp", 0, 1);
  c->contact_cfm = root.number("contact_cfm", 0, 1);
  Section arm_contacts = root.section("arm_contacts");
  for (const Arm arm : kArms)
    at(c->arm_contacts, arm) = arm_contacts.boolean(name(arm));
  arm_contacts.finish();
}

void readPassivity(Section& root, PassivityConfig* c) {
  c->enabled = root.boolean("enabled");
  c->max_delay = root.number("max_delay", 0, 0.4);
  c->budget = root.number("budget", 0.0001, 10);
  c->bank = root.number("bank", c->budget, 10);
  c->hand_damping = root.number("hand_damping", 0, 100);
  c->rest = root.number("rest", 0, 60);
  root.finish();
}

void readGuidance(Section& root, double max_force, GuidanceConfig* c) {
  c->enabled = root.boolean("enabled");
  c->stiffness = root.number("stiffness", 0, 2000);
  c->max_force = root.number("max_force", 0, max_force);
  c->reach = root.number("reach", 0.001, 0.5);
  c->fade_time = root.number("fade_time", 0.01, 60);
  root.finish();
}

void readEdge(Section& root, double max_force, EdgeConfig* c) {
  c->enabled = root.boolean("enabled");
  c->size_I = root.vec3("size_I", 0.01, 10);
  const double shortest = *std::min_element(c->size_I.begin(), c->size_I.end());
  c->margin = root.number("margin", 0.001, 0.5 * shortest);
  c->max_force = root.number("max_force", 0, max_force);
  c->origin = static_cast<WorkspaceOrigin>(root.choice("origin", kWorkspaceOriginNames));
  root.finish();
}

void readHaptics(Section& root, HapticGains* c) {
  c->kp = root.number("kp", 0, 2000);
  c->kd = root.number("kd", 0, 100);
  c->tolerance = root.number("tolerance", 0, 0.05);
  c->max_force = root.number("max_force", 0, 3.3);
  c->min_force = root.number("min_force", 0, c->max_force);
  // From max_force to nothing in 40 ms at most: of kLastFelt that leaves stale_after 8 ms and more.
  c->max_slew = root.number("max_slew", c->max_force / 0.04, 10000);
  Section passivity = root.section("passivity"), guidance = root.section("guidance"), edge = root.section("edge");
  readPassivity(passivity, &c->passivity);
  readGuidance(guidance, c->max_force, &c->guidance);
  readEdge(edge, c->max_force, &c->edge);
}

std::uint16_t port(Section& section, const std::string& key, int low) {
  return static_cast<std::uint16_t>(section.integer(key, low, 65535));
}

void readItpRules(Section& root, ItpRules* c) {
  c->hardened = root.text("ingest", {"hardened", "compat"}) == "hardened";
  c->auth = static_cast<ItpAuth>(root.choice("auth", kItpAuthNames));
  c->max_increment_um = static_cast<std::int32_t>(root.integer("max_increment_um", 1, 1000000));
  c->max_rotation = root.number("max_rotation", 0.001, kPi);
  c->max_rate = root.number("max_rate", 1, 1e6);
  c->max_burst = static_cast<std::int32_t>(root.integer("max_burst", 1, 10000));
  c->master_timeout = root.number("master_timeout", 0.02, 60);
  c->compat_timeout = root.number("compat_timeout", 0.02, 60);
}

/** Whoever reaches a port where plain ITP is taken moves the arms: beyond this computer only if it is asked for. */
void checkExposure(const Section& root, const NetworkConfig& c) {
  if (c.itp.auth != ItpAuth::kOff && c.key_file.empty()) {
    throw ConfigException(root.where("auth") + " asks for signatures, but key_file is empty");
  }
  if (c.itp.auth != ItpAuth::kOff && !c.itp.hardened) {
    throw ConfigException(root.where("auth") + " asks for signatures, which ingest: compat does not verify");
  }
  const bool is_loopback = c.bind_address.rfind("127.", 0) == 0 || c.bind_address == "localhost";
  if (is_loopback || c.itp.auth == ItpAuth::kRequired || c.allow_plaintext_remote) return;
  throw ConfigException(root.where("bind_address") + " is \"" + c.bind_address +
                        "\", beyond this computer, and unsigned ITP is taken: set auth: required and a key_file, or "
                        "allow_plaintext_remote: true if whoever reaches the port may move the arms");
}

constexpr double kAgeError = 0.004;  // [s] by which a state may be older than it is taken for (wire::FrameDelay)

/** Longest [s] a state may count as fresh: then a tick passes, the force falls, and a tick passes before it is sent. */
double longestFresh(const HapticGains& haptics) {
  return kLastFelt - kAgeError - haptics.max_force / haptics.max_slew - 2.0 * kTickSeconds;
}

/** No two pedals may share a button. */
void readJoy(Section& joy, JoyConfig* c) {
  c->topic = joy.text("topic");
  c->timeout = joy.number("timeout", 0.05, 60);
  for (std::size_t i = 0; i < kPedalCount; ++i) {
    c->buttons[i] = static_cast<int>(joy.integer(kPedalNames[i], -1, 127));
    const auto before = c->buttons.begin() + static_cast<std::ptrdiff_t>(i);
    const auto same = std::find(c->buttons.begin(), before, c->buttons[i]);
    if (c->buttons[i] < 0 || same == before) continue;
    throw ConfigException(joy.where(kPedalNames[i]) + " is button " + std::to_string(c->buttons[i]) + ", as is " +
                          kPedalNames[static_cast<std::size_t>(same - c->buttons.begin())]);
  }
  joy.finish();
}

void readNetwork(Section& root, const HapticGains& haptics, NetworkConfig* c) {
  c->bind_address = root.text("bind_address");
  c->master_port = port(root, "master_port", 0);
  c->daemon_host = root.text("daemon_host");
  c->robot_host = root.text("robot_host");
  c->robot_port = port(root, "robot_port", 1);
  c->console_host = root.text("console_host");
  c->force_port = port(root, "force_port", 1);
  c->sight = root.boolean("sight");
  c->sight_port = port(root, "sight_port", 1);
  c->state_port = port(root, "state_port", 1);
  c->stale_after = root.number("stale_after", 0.002, longestFresh(haptics));
  c->reconnect_min = root.number("reconnect_min", 0.01, 5);
  c->reconnect_max = root.number("reconnect_max", 0.1, 60);
  readItpRules(root, &c->itp);
  c->master_address = root.text("master_address");
  c->allow_plaintext_remote = root.boolean("allow_plaintext_remote");
  c->key_file = root.text("key_file");
  if (!c->key_file.empty()) c->key_file = (fs::absolute(root.file()).parent_path() / c->key_file).string();
  checkExposure(root, *c);
  Section joy = root.section("joy");
  readJoy(joy, &c->joy);
}

ThreadConfig readThread(Section& root, const std::string& key) {
  Section thread = root.section(key);
  const ThreadConfig config{static_cast<int>(thread.integer("priority", 0, 99)),
                            static_cast<int>(thread.integer("cpu", -1, 1023))};
  thread.finish();
  return config;
}

void readRuntime(Section& root, RuntimeConfig* c) {
  c->physics = readThread(root, "physics");
  c->haptic = readThread(root, "haptic");
  c->ingest = readThread(root, "ingest");
  c->robot_link = readThread(root, "robot_link");
  c->sender = readThread(root, "sender");
  c->stack_kib = static_cast<int>(root.integer("stack_kib", 64, 65536));
  c->background_nice = static_cast<int>(root.integer("background_nice", 0, 19));
  c->max_catch_up = static_cast<int>(root.integer("max_catch_up", 0, 20));
  c->max_backlog = root.number("max_backlog", 0.01, 10);
  c->fault_period = root.number("fault_period", 0.001, 1);
  c->recorder_period = root.number("recorder_period", 0.001, 0.05);
  c->flight_recorder = root.text("flight_recorder");
  c->ros_period = root.number("ros_period", 0.001, 1);
  c->plan_at = root.number("plan_at", -1, 36000);
  c->lockstep_plan_delay = root.integer("lockstep_plan_delay", 1, 100000);
  c->start_timeout = root.number("start_timeout", 0, 36000);
  c->enable_remote_control = root.boolean("enable_remote_control");
}

void readPlannerCost(Section& root, PlannerConfig* c) {
  c->eta_length = root.number("eta_length", 0, kAny);
  c->eta_acceleration = root.number("eta_acceleration", 0, kAny);
  c->eta_clearance = root.number("eta_clearance", 0, kAny);
  c->clearance_range = root.number("clearance_range", 0.0001, 1);
}

void readPlanner(Section& root, PlannerConfig* c) {
  // As planning::kPlannerNames, which this layer does not know; a test of the planner holds both together.
  c->planner = root.text("planner", {"FMTstar", "FMT", "RRTstar", "PRMstar", "BITstar", "ABITstar", "RRTConnect"});
  c->samples = static_cast<std::uint32_t>(root.integer("samples", 10, 100000));
  c->max_samples = static_cast<std::uint32_t>(root.integer("max_samples", 10, 100000));
  readPlannerCost(root, c);
  c->radius_multiplier = root.number("radius_multiplier", 1, 10);
  c->volume_samples = static_cast<std::uint32_t>(root.integer("volume_samples", 100, 10000000));
  c->volume_confidence = root.number("volume_confidence", 0.5, 0.999999);
  c->improve_attempts = static_cast<std::uint32_t>(root.integer("improve_attempts", 0, 100000));
  c->max_rollouts = static_cast<std::uint32_t>(root.integer("max_rollouts", 1, 100000));
  c->max_tracking_error = root.number("max_tracking_error", 0.0001, 1);
  c->time_limit = root.number("time_limit", 0.01, 3600);
  c->edge_step = root.number("edge_step", 0.0001, 0.5);
  c->clearance = root.number("clearance", 0, 0.05);
  c->velocity_limit = root.joints("velocity_limit", 1e-3, 100);
  c->acceleration_limit = root.joints("acceleration_limit", 1e-3, 1000);
  c->goal_W = root.vec3("goal_W", -1, 1);
}

void readExecution(Section& root, ExecutionConfig* c) {
  c->speed = root.number("speed", 0.05, 1);
  c->drive = static_cast<ExecutionDrive>(root.choice("drive", kExecutionDriveNames));
  c->hold_time = root.number("hold_time", 0.01, 5);
  c->start_tolerance = root.joints("start_tolerance", 1e-5, 1);
  c->deviation_limit = root.number("deviation_limit", 1e-4, 1);
  c->settle_tolerance = root.number("settle_tolerance", 1e-5, 0.1);
  c->settle_speed = root.number("settle_speed", 1e-5, 1);
  c->settle_time = root.number("settle_time", 0, 60);
  c->pedal_timeout = root.number("pedal_timeout", 0.1, 3600);
  c->robot_timeout = root.number("robot_timeout", 0.1, 60);
}

/** A name that ROS takes below any namespace; the nodes of other programs have theirs beside it. */
std::string readNamespace(Section& root, const std::string& key) {
  const std::string name = root.text(key);
  const auto isWord = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '/'; };
  const bool begins = !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0;
  const bool ends = !name.empty() && name.back() != '/' && name.find("//") == std::string::npos;
  if (begins && ends && std::all_of(name.begin(), name.end(), isWord)) return name;
  throw ConfigException(root.where(key) + " is \"" + name +
                        "\", expected a ROS name: a letter, then letters, digits, _ and single /");
}

void readCrtk(Section& root, CrtkConfig* c) {
  c->enabled = root.boolean("enabled");
  for (const Arm arm : kArms)
    at(c->names, arm) = readNamespace(root, name(arm));
  if (c->names[0] == c->names[1])
    throw ConfigException(root.where("green") + " is \"" + c->names[1] + "\", as is gold");
  c->dialect = static_cast<CrtkDialect>(root.choice("dialect", kCrtkDialectNames));
  c->period = root.number("period", 0.001, 1);
  c->state_period = root.number("state_period", 0.01, 60);
  c->max_speed = root.number("max_speed", 0.001, 1);
  c->max_turn_rate = root.number("max_turn_rate", 0.01, 20);
  c->max_step = root.number("max_step", 1e-4, 0.2);
  c->max_step_turn = root.number("max_step_turn", 0.001, 3);
  c->move_speed = root.number("move_speed", 0.001, c->max_speed);
  c->move_turn_rate = root.number("move_turn_rate", 0.01, c->max_turn_rate);
  c->twist_timeout = root.number("twist_timeout", 0.01, 5);
  c->release_after = root.number("release_after", 0, 3600);
  c->trim_time = root.number("trim_time", 0, 60);
}

CameraConfig readCamera(Section& camera) {
  CameraConfig c;
  c.name = camera.text("name");
  c.eye_W = camera.vec3("eye_W", -10, 10);
  c.target_W = camera.vec3("target_W", -10, 10);
  c.up_W = camera.vec3("up_W", -1, 1);
  c.vertical_fov = camera.number("vertical_fov", 0.1, 2);
  c.moves = static_cast<CameraMoves>(camera.choice("moves", kCameraMovesNames));
  camera.finish();
  return c;
}

/** Puts both cameras of the pair behind those of the file. */
void readStereo(Section stereo, std::vector<std::string>* names, RenderConfig* c) {
  c->stereo.camera = stereo.text("camera", *names);
  c->stereo.baseline = stereo.number("baseline", 0.0005, 0.2);
  stereo.finish();
  const auto middle =
      static_cast<std::size_t>(std::find(names->begin(), names->end(), c->stereo.camera) - names->begin());
  for (const double side : {-0.5, 0.5}) {
    CameraConfig eye = c->cameras[middle];
    eye.name += side < 0.0 ? "_left" : "_right";
    if (std::find(names->begin(), names->end(), eye.name) != names->end())
      throw ConfigException(stereo.where("camera") + ": there is another camera called " + eye.name);
    eye.aside = side * c->stereo.baseline;
    names->push_back(eye.name);
    c->cameras.push_back(std::move(eye));
  }
}

OverlaySet readOverlays(Section* overlays, const std::string& key) {
  try {
    return overlaysOf(overlays->texts(key));
  } catch (const ConfigException& e) {
    throw ConfigException(overlays->where(key) + ": " + e.what());
  }
}

void readRender(Section& root, RenderConfig* c) {
  std::vector<std::string> names;
  for (Section& camera : root.list("cameras")) {
    c->cameras.push_back(readCamera(camera));
    names.push_back(c->cameras.back().name);
  }
  if (names.empty()) throw ConfigException(root.where("cameras") + " is empty");
  readStereo(root.section("stereo"), &names, c);
  Section overlays = root.section("overlays");
  c->video_overlays = readOverlays(&overlays, "video");
  c->live_overlays = readOverlays(&overlays, "live");
  overlays.finish();
  Section trails = root.section("trails");
  c->trails.duration = trails.number("duration", 0.1, 60);
  c->trails.step = trails.number("step", c->trails.duration / 400.0, 10);
  trails.finish();
  Section video = root.section("video");
  c->video_camera = video.text("camera", names);
  c->video_width = static_cast<int>(video.integer("width", 64, 4096)) & ~1;
  c->video_height = static_cast<int>(video.integer("height", 64, 4096)) & ~1;
  c->video_fps = static_cast<int>(video.integer("fps", 1, 120));
  c->encoder_crf = static_cast<int>(video.integer("crf", 0, 51));
  c->encoder_preset = video.text("preset", {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"});
  video.finish();
  Section live = root.section("live");
  c->live_camera = live.text("camera", names);
  c->live_width = static_cast<int>(live.integer("width", 64, 4096));
  c->live_height = static_cast<int>(live.integer("height", 64, 4096));
  c->live_fps = static_cast<int>(live.integer("fps", 1, 120));
  c->live_slowest = static_cast<int>(live.integer("slowest", 1, 120));
  if (c->live_slowest > c->live_fps)
    throw ConfigException(live.where("slowest") + " is " + std::to_string(c->live_slowest) + ", above fps, " +
                          std::to_string(c->live_fps));
  c->live_smallest = live.number("smallest", 0.5, 1);
  c->live_settle = live.number("settle", 0.5, 60);
  c->live_jpeg_quality = static_cast<int>(live.integer("jpeg_quality", 1, 100));
  live.finish();
  Section real = root.section("real_camera");
  c->real_camera_topic = real.text("topic");
  if (c->real_camera_topic == "view/image_raw" || c->real_camera_topic == "/view/image_raw")
    throw ConfigException(real.where("topic") + " is " + c->real_camera_topic + ", where the view itself is shown");
  c->real_stale_after = real.number("stale_after", 0.05, 10);
  real.finish();
}

void readConsole(Section& root, ConsoleConfig* c) {
  c->scale = root.number("scale", 0.001, 1);
  c->hand_mass = root.number("hand_mass", 0.01, 5);
  c->hand_stiffness = root.number("hand_stiffness", 1, 10000);
  c->hand_damping = root.number("hand_damping", 0, 1000);
  c->tremor_amplitude = root.number("tremor_amplitude", 0, 0.01);
  c->tremor_low = root.number("tremor_low", 1, 30);
  c->tremor_high = root.number("tremor_high", c->tremor_low, 30);
  c->start_delay = root.number("start_delay", 0, 60);
  c->motion_time = root.number("motion_time", 0, 36000);
  c->stroke_speed = root.number("stroke_speed", 0.01, 2);
  c->pause_min = root.number("pause_min", 0, 10);
  c->pause_max = root.number("pause_max", c->pause_min, 10);
  c->clutch_every = root.number("clutch_every", 0, 1000);
  c->clutch_time = root.number("clutch_time", 0.05, 10);
  c->task_W_min = root.vec3("task_W_min", -1, 1);
  c->task_W_max = root.vec3("task_W_max", -1, 1);
  c->ready_timeout = root.number("ready_timeout", 0, 3600);
  c->recording_scale = root.number("recording_scale", 0.1, 1000);
  c->recording_lead_in = root.number("recording_lead_in", 0.1, 60);
}

MotorAxis readAxis(Section& axes, const char* joint) {
  Section axis = axes.section(joint);
  MotorAxis m;
  m.transmission = axis.number("transmission", 0, kAny);
  m.torque_per_amp = axis.number("torque_per_amp", 0, kAny);
  m.counts_per_amp = axis.number("counts_per_amp", 0, kAny);
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

/** Puts one training level in place of the values of the file; a level not chosen is read and checked all the same. */
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

PlantAxis readPlantAxis(Section& axes, const char* joint) {
  Section axis = axes.section(joint);
  PlantAxis a;
  a.torque_gain = axis.number("torque_gain", 0.1, 10);
  a.torque_offset = axis.number("torque_offset", -1, 1);
  a.inertia = axis.number("inertia", 1e-7, 1);
  a.coulomb = axis.number("coulomb", 0, 10);
  a.viscous = axis.number("viscous", 0, 10);
  a.link_coulomb = axis.number("link_coulomb", 0, 1e3);
  a.link_viscous = axis.number("link_viscous", 0, 1e4);
  a.cable_stiffness = axis.number("cable_stiffness", 100, 1e12);
  a.cable_damping = axis.number("cable_damping", 0, 1e9);
  axis.finish();
  return a;
}

void readPlant(Section& root, PlantConfig* c) {
  c->title = root.text("title");
  c->elastic_cables = root.text("cables", {"rigid", "elastic"}) == "elastic";
  c->amplifier_limit = root.number("amplifier_limit", 0.1, 10);
  c->amplifier_offset = root.number("amplifier_offset", -1, 1);
  Section axes = root.section("axes");
  for (std::size_t j = 0; j < kJointCount; ++j)
    c->axes[j] = readPlantAxis(axes, kJointNames[j]);
  axes.finish();
}

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

void readInjection(Section& root, InjectionConfig* c) {
  c->enable = root.boolean("enable");
  c->real_robot = root.boolean("real_robot");
}

DetectorThresholds readThresholds(Section& axis, const char* rule) {
  Section section = axis.section(rule);
  DetectorThresholds t;
  t.acceleration = section.number("acceleration", 0, kAny);
  t.motor_velocity = section.number("motor_velocity", 0, kAny);
  t.joint_velocity = section.number("joint_velocity", 0, kAny);
  section.finish();
  return t;
}

DetectorAxis readDetectorAxis(Section& axes, const char* joint) {
  Section axis = axes.section(joint);
  DetectorAxis a;
  a.inertia = axis.number("inertia", 1e-7, 1);
  a.viscous = axis.number("viscous", 0, 10);
  a.coulomb = axis.number("coulomb", 0, 10);
  a.offset = axis.number("offset", -10, 10);
  a.gravity = axis.vec3("gravity", -100, 100);
  a.published = readThresholds(axis, kDetectorRuleNames[0]);
  a.departure = readThresholds(axis, kDetectorRuleNames[1]);
  axis.finish();
  return a;
}

void readDetector(Section& root, DetectorConfig* c) {
  c->mitigate = static_cast<Mitigation>(root.choice("mitigate", kMitigationNames));
  c->rule = static_cast<DetectorRule>(root.choice("rule", kDetectorRuleNames));
  c->factor = root.number("factor", 0.01, 100);
  c->memory = root.number("memory", 0.002, 10);
  c->braking_time = root.number("braking_time", 0.001, 1);
  c->asked = root.number("asked", 0, 1);
  c->persistence = root.number("persistence", 0, 1);
  c->suspicion = root.number("suspicion", 0.01, 100);
  c->suspicion_time = root.number("suspicion_time", 0, 1);
  c->excursion = root.number("excursion", 0, 0.1);
  for (const Arm arm : kArms) {
    Section axes = root.section(name(arm));
    for (std::size_t j = 0; j < kDetectorAxes; ++j)
      at(c->axes, arm)[j] = readDetectorAxis(axes, kJointNames[j]);
    axes.finish();
  }
}

void readImpairments(const std::string& folder, TrainerConfig* c) {
  c->impairment_names = impairmentNames(folder);
  for (const std::string& name : c->impairment_names) {
    c->files.push_back((fs::path(folder) / (name + ".yaml")).string());
    c->impairments.push_back(loadImpairment(c->files.back()));
  }
}

TrainingNames readTrainingNames(Section& root, const TrainingNames& instead) {
  const auto name = [&](const char* key, const std::string& other) {
    const std::string text = root.text(key);
    return other.empty() ? text : other;
  };
  return {name("exercise", instead.exercise), name("drill", instead.drill), name("trainee", instead.trainee),
          name("curriculum", instead.curriculum)};
}

std::vector<std::string> scenarioFiles(const std::string& folder) {
  if (!fs::is_directory(folder)) throw ConfigException(folder + ":1: no such folder of scenarios");
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());  // ids must not depend on the file system
  return files;
}

/** In the order of the list; a user's own, which have number 0, come last and so change no other's id. */
bool isBefore(const Scenario& a, const Scenario& b) {
  const auto rank = [](const Scenario& s) { return std::make_pair(s.number == 0, s.number); };
  return rank(a) < rank(b);
}

std::vector<Scenario> readScenarios(const std::string& folder, TrainerConfig* all) {
  std::vector<Scenario> scenarios;
  for (const std::string& file : scenarioFiles(folder)) {
    all->files.push_back(file);
    scenarios.push_back(loadScenario(file, 0, all->impairment_names));
  }
  std::stable_sort(scenarios.begin(), scenarios.end(), isBefore);  // of one number: by name, as the files come
  std::uint32_t id = 0;
  for (Scenario& scenario : scenarios) {
    ++id;
    for (Fault& fault : scenario.faults)
      fault.id = id;
  }
  return scenarios;
}

}  // namespace

TrainerConfig loadTrainerConfig(const std::string& path, const TrainingNames& instead, const Overrides& overrides) {
  checkOverrides(overrides);
  TrainerConfig c;
  Section root = openFile(path, overridesOfRoot(overrides), &c);
  const fs::path folder = fs::absolute(path).parent_path();
  const auto file = [&](const char* key) { return (folder / root.text(key)).lexically_normal().string(); };
  const auto read = [&](const char* key, auto* part, auto reader) {
    using Part = std::remove_pointer_t<decltype(part)>;
    *part = readFile<Part>(file(key), overridesOf(overrides, key), &c, reader);
  };
  read("arms", &c.arms, readArms);
  read("model", &c.model, readModel);
  read("haptics", &c.haptics, readHaptics);
  const auto readNetworkFor = [&](Section& section, NetworkConfig* network) {
    readNetwork(section, c.haptics, network);  // a force must end in time
  };
  read("network", &c.network, readNetworkFor);
  read("runtime", &c.runtime, readRuntime);
  read("planner", &c.planner, readPlanner);
  read("execution", &c.execution, readExecution);
  read("crtk", &c.crtk, readCrtk);
  read("render", &c.render, readRender);
  read("console", &c.console, readConsole);
  read("virtual_raven", &c.virtual_raven, readVirtualRaven);
  c.virtual_raven.itp = c.network.itp;
  selectPlant(&c, c.virtual_raven.plant_name);
  read("injection", &c.injection, readInjection);
  read("detector", &c.detector, readDetector);
  readImpairments(file("impairments"), &c);
  c.scenarios = readScenarios(file("faults"), &c);
  c.robot_urdf = file("robot_urdf");
  c.scene_urdf = file("scene_urdf");
  c.exercises = file("exercises");
  c.scenes = file("scenes");
  c.curricula = file("curricula");
  c.bands = file("bands");
  const TrainingNames names = readTrainingNames(root, instead);
  c.hazard = root.text("hazard");
  c.seed = static_cast<std::uint64_t>(root.integer("seed", 0, std::int64_t{1} << 53));
  root.finish();
  checkHazard(c);
  loadTraining(names, &c);
  return c;
}

InjectionConfig loadInjection(const std::string& path) {
  Section root = Section::fromFile(path);
  InjectionConfig injection;
  readInjection(root, &injection);
  root.finish();
  return injection;
}

OverlaySet overlaysOf(const std::vector<std::string>& names) {
  OverlaySet set;
  if (names.size() == 1 && names[0] == "all") return OverlaySet::all();
  if (names.size() == 1 && names[0] == "none") return set;
  for (const std::string& name : names) {
    const auto found = std::find(kOverlayNames.begin(), kOverlayNames.end(), name);
    if (found == kOverlayNames.end()) {
      std::string known;
      for (const char* each : kOverlayNames)
        known += std::string(" ") + each;
      throw ConfigException("no overlay is called \"" + name + "\"; known:" + known);
    }
    set.add(static_cast<OverlayKind>(found - kOverlayNames.begin()));
  }
  return set;
}

ArmGeometry toolGeometry(const ArmsConfig& arms, const std::string& name) {
  std::string known;
  for (const ToolPreset& tool : arms.tools) {
    if (tool.name == name) {
      ArmGeometry geometry = arms.geometry;
      geometry.d4 = tool.d4;
      geometry.lw = tool.lw;
      return geometry;
    }
    known += (known.empty() ? "" : ", ") + tool.name;
  }
  throw ConfigException("no tool is called \"" + name + "\"; known: " + known);
}

void selectPlant(TrainerConfig* config, const std::string& name) {
  VirtualRavenConfig& robot = config->virtual_raven;
  const auto fileOf = [&](const std::string& plant) {
    const bool is_file = fs::path(plant).extension() == ".yaml";
    return is_file ? plant : (fs::path(robot.plants_folder) / (plant + ".yaml")).string();
  };
  auto& files = config->files;
  files.erase(std::remove(files.begin(), files.end(), fileOf(robot.plant_name)), files.end());
  robot.plant = readFile<PlantConfig>(fileOf(name), {}, config, readPlant);
  robot.plant_name = name;
}

std::uint32_t faultId(const TrainerConfig& config, const std::string& name) {
  if (name == "none") return 0;
  std::string known = "none";
  for (const Scenario& scenario : config.scenarios) {
    if (scenario.name == name) return scenario.faults[0].id;
    known += ", " + scenario.name;
  }
  throw ConfigException("no hazard is called \"" + name + "\"; known: " + known);
}

void checkHazard(const TrainerConfig& config) {
  if (faultId(config, config.hazard) != 0 && !config.injection.enable)
    throw ConfigException("hazard " + config.hazard + " is to be armed, but injection.yaml does not enable it");
}

FaultPlan planFor(const TrainerConfig& config, std::uint32_t id, std::uint64_t generation) {
  FaultPlan plan;
  plan.generation = generation;
  if (!config.injection.enable || id == 0 || id > config.scenarios.size()) return plan;
  for (Fault fault : config.scenarios[id - 1].faults) {
    fault.seed += config.seed;
    plan.faults[plan.count++] = fault;
  }
  return plan;
}

}  // namespace raven2_trainer::config
