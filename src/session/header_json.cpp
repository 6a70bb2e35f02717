#include "header_json.h"

#include <algorithm>
#include <stdexcept>

#include "raven2_trainer/core/pedals.h"
#include "record_codec.h"
#include "record_frame.h"

namespace raven2_trainer::session {

namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kFormatName = "raven2_trainer session log";

template <typename T>
Json describeRecord(const char* name) {
  return {{"type", static_cast<int>(RecordTypeOf<T>::kType)},
          {"name", name},
          {"version", kRecordVersion},
          {"meaning", Meanings::of(Is<T>{})},
          {"fields", SchemaWriter::fieldsOf<T>()}};
}

Json describeRecords() {
  return Json::array({describeRecord<TickRecord>("tick"), describeRecord<HapticRecord>("haptic"),
                      describeRecord<CommandRecord>("command"), describeRecord<RequestRecord>("request"),
                      describeRecord<PlanRecord>("plan"), describeRecord<FaultRecord>("faults"),
                      describeRecord<FaultChangeRecord>("fault_change"), describeRecord<ExecutionRecord>("execution"),
                      describeRecord<ExerciseRecord>("exercise"), describeRecord<ContactRecord>("contact"),
                      describeRecord<SessionCounts>("counts"), describeRecord<GapRecord>("gap"),
                      describeRecord<RecoveryRecord>("recovery")});
}

/** The part that decides over bytes: names, types and shapes. Units and meanings may be reworded. */
Json layoutOf(const Json& fields) {
  Json layout = Json::array();
  for (const Json& field : fields) {
    Json entry{field.at("name"), field.at("type"), field.at("shape")};
    if (field.contains("fields")) entry.push_back(layoutOf(field.at("fields")));
    layout.push_back(std::move(entry));
  }
  return layout;
}

/** Ours must all be in the log with the same layout; otherwise every such record would be passed over. */
void checkLayouts(const Json& records) {
  static const Json kOurs = describeRecords();  // milliseconds to make
  for (const Json& ours : kOurs) {
    const auto theirs = std::find_if(records.begin(), records.end(),
                                     [&](const Json& entry) { return entry.at("type") == ours.at("type"); });
    if (theirs == records.end() || theirs->at("version") != ours.at("version") ||
        layoutOf(theirs->at("fields")) != layoutOf(ours.at("fields"))) {
      throw std::runtime_error("records '" + ours.at("name").get<std::string>() +
                               "' are laid out as by another version of raven2_trainer; raven2_session.py reads any");
    }
  }
}

Json describeConfiguration(const LogHeader& header) {
  Json files = Json::array();
  for (const ConfigurationFile& file : header.configuration)
    files.push_back({{"path", file.path}, {"fnv1a", file.fnv1a}});
  return files;
}

Json describeHand(const HeaderHand& hand) {
  return {{"mass", hand.mass}, {"stiffness", hand.stiffness}, {"damping", hand.damping}};
}

Json describeCamera(const HeaderCamera& camera) {
  return {{"name", camera.name}, {"vertical_fov", camera.vertical_fov}, {"aspect", camera.aspect}};
}

HeaderHand readHand(const Json& json) {
  return {json.at("mass"), json.at("stiffness"), json.at("damping")};
}

HeaderCamera readCamera(const Json& json) {
  return {json.at("name"), json.at("vertical_fov"), json.at("aspect")};
}

}  // namespace

std::string headerToJson(const LogHeader& header) {
  const Json json{{"format", kFormatName},
                  {"format_version", kFormatVersion},
                  {"byte_order", "little"},
                  {"seed", header.seed},
                  {"scenarios", header.scenarios},
                  {"hazard", header.hazard},
                  {"robot_urdf_hash", header.robot_urdf_hash},
                  {"scene_urdf_hash", header.scene_urdf_hash},
                  {"config_hash", header.config_hash},
                  {"motion", header.motion},
                  {"exercise", header.exercise},
                  {"drill", header.drill},
                  {"trainee", header.trainee},
                  {"curriculum", header.curriculum},
                  {"motion_scale", header.motion_scale},
                  {"hand", describeHand(header.hand)},
                  {"camera", describeCamera(header.camera)},
                  {"step_names", header.step_names},
                  {"object_names", header.object_names},
                  {"d4", header.d4},
                  {"tolerance", header.tolerance},
                  {"model_version", header.model_version},
                  {"arm_contacts", header.arm_contacts},
                  {"body_names", header.body_names},
                  {"configuration", describeConfiguration(header)},
                  {"arm_names", kArmNames},
                  {"joint_names", kJointNames},
                  {"loop_names", kLoopNames},
                  {"reject_names", kRejectNames},
                  {"ring_names", kRingNames},
                  {"record_kind_names", kRecordKindNames},
                  {"mistake_names", kMistakeNames},
                  {"pedal_names", kPedalNames},
                  {"records", describeRecords()}};
  // A file name in `motion` may hold any bytes; those that are not UTF-8 become U+FFFD.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

LogHeader headerFromJson(const std::string& text) {
  const Json json = Json::parse(text);
  if (json.at("format") != kFormatName) throw std::runtime_error("not a session log");
  const Json& version = json.at("format_version");
  if (!version.is_number_integer() || version < 1 || version > kFormatVersion) {
    throw std::runtime_error("format version " + version.dump() + ", this program reads 1 to " +
                             std::to_string(kFormatVersion));
  }
  checkLayouts(json.at("records"));
  LogHeader header;
  json.at("seed").get_to(header.seed);
  json.at("scenarios").get_to(header.scenarios);
  json.at("hazard").get_to(header.hazard);
  json.at("robot_urdf_hash").get_to(header.robot_urdf_hash);
  json.at("scene_urdf_hash").get_to(header.scene_urdf_hash);
  json.at("config_hash").get_to(header.config_hash);
  json.at("motion").get_to(header.motion);
  json.at("exercise").get_to(header.exercise);
  json.at("drill").get_to(header.drill);
  json.at("trainee").get_to(header.trainee);
  json.at("curriculum").get_to(header.curriculum);
  json.at("motion_scale").get_to(header.motion_scale);
  header.hand = readHand(json.at("hand"));
  header.camera = readCamera(json.at("camera"));
  json.at("step_names").get_to(header.step_names);
  json.at("object_names").get_to(header.object_names);
  json.at("d4").get_to(header.d4);
  json.at("tolerance").get_to(header.tolerance);
  header.model_version = json.value("model_version", 1);  // logs of version 1 do not say it
  json.at("arm_contacts").get_to(header.arm_contacts);
  json.at("body_names").get_to(header.body_names);
  for (const Json& file : json.at("configuration"))
    header.configuration.push_back({file.at("path"), file.at("fnv1a")});
  return header;
}

}  // namespace raven2_trainer::session
