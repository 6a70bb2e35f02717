#include "python/state_module.h"

#include <pybind11/stl.h>

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.h"
#include "python/constructed.h"
#include "python/docs.h"
#include "python/simulation.h"
#include "python/unlocked.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace py = pybind11;

namespace raven2_trainer::python {
namespace {

/** Of numbers that lie in the simulation, which `owner` keeps alive; not to be written. */
template <typename T>
py::array view(const T* first,
               std::vector<py::ssize_t> shape,
               std::vector<py::ssize_t> strides,
               const py::object& owner) {
  py::array_t<T> array(std::move(shape), std::move(strides), first, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return std::move(array);
}

template <typename Struct, typename Array>
py::array perArm(const PerArm<Struct>& arms, const Array Struct::*member, const py::object& owner) {
  const auto& first = arms[0].*member;
  return view(first.data(), {2, static_cast<py::ssize_t>(first.size())},
              {static_cast<py::ssize_t>(sizeof(Struct)), static_cast<py::ssize_t>(sizeof(first[0]))}, owner);
}

template <typename Array>
py::array perArm(const PerArm<Array>& arms, const py::object& owner) {
  return view(arms[0].data(), {2, static_cast<py::ssize_t>(arms[0].size())},
              {static_cast<py::ssize_t>(sizeof(Array)), static_cast<py::ssize_t>(sizeof(double))}, owner);
}

/** The newest state of a simulation: numbers change with each step. */
class State : public Constructed {
 public:
  explicit State(py::object owner) : owner_(std::move(owner)), simulation_(py::cast<Simulation&>(owner_)) {}

  const ModelState& model() const { return simulation_.view().model; }
  const RobotState& robot() const { return simulation_.view().robot; }
  const HapticState& haptic() const { return simulation_.view().haptic; }
  const py::object& owner() const { return owner_; }
  const Simulation& simulation() const { return simulation_; }

  py::array objects() const {
    const std::size_t count = simulation_.scene().free_bodies.size();
    return view(model().bodies[0].p.data(), {static_cast<py::ssize_t>(count), 7},
                {static_cast<py::ssize_t>(sizeof(RigidPose)), static_cast<py::ssize_t>(sizeof(double))}, owner_);
  }

 private:
  py::object owner_;
  Simulation& simulation_;
};
static_assert(sizeof(RigidPose) == 7 * sizeof(double), "an object's row");

/** A copy: the list of the next tick may be shorter. */
py::array contactPoints(const State& state) {
  const ContactList list = withoutLock([&] { return state.simulation().contacts(); });
  py::list names, formats, offsets;
  const auto add = [&](const char* name, const char* format, std::size_t offset) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
  };
  add("a", "u2", offsetof(Contact, a));
  add("b", "u2", offsetof(Contact, b));
  add("depth", "f4", offsetof(Contact, depth));
  add("position", "3f8", offsetof(Contact, p_W));
  add("normal", "3f8", offsetof(Contact, n_W));
  add("force", "3f8", offsetof(Contact, f_W));
  const py::dtype type(names, formats, offsets, sizeof(Contact));
  return py::array(type, static_cast<py::ssize_t>(list.count), list.contacts.data());
}

/** @param[in] tip_B of an arm's state. */
template <typename Tip>
Numbers inWorld(const State& state, Tip tip_B) {
  Numbers tips(std::vector<py::ssize_t>{2, 3});
  for (const Arm arm : kArms) {
    const Vector3 p_W = at(state.simulation().raven().X_WB, arm) * tip_B(arm, at(state.model().arms, arm));
    std::copy(p_W.data(), p_W.data() + 3, tips.mutable_data(static_cast<py::ssize_t>(index(arm)), 0));
  }
  return tips;
}

Numbers tipsInWorld(const State& state) {
  return inWorld(state, [](Arm, const ArmState& arm) -> Vector3 { return toEigen(arm.p_BT); });
}

Numbers desiredTipsInWorld(const State& state) {
  const ArmGeometry& geometry = state.simulation().config().arms.geometry;
  return inWorld(state,
                 [&](Arm which, const ArmState& arm) { return kinematics::forward(geometry, which, arm.q_d).p; });
}

std::vector<std::string> stepNames(const TrainerConfig& config) {
  std::vector<std::string> names;
  for (const ExerciseTrack& track : config.exercise.tracks)
    for (const ExerciseStep& step : track.steps)
      names.push_back(step.name);
  return names;
}

py::dict exerciseOf(const State& state) {
  const ExerciseState& exercise = state.model().exercise;
  py::dict out;
  out["status"] = kExerciseStatusNames[static_cast<std::size_t>(exercise.status)];
  out["attempt"] = exercise.attempt;
  out["steps_done"] = exercise.step > 0 ? exercise.step - 1 : 0;
  out["steps"] = stepNames(state.simulation().config());
  py::dict mistakes;
  for (std::size_t i = 0; i < exercise.mistakes.size(); ++i)
    mistakes[kMistakeNames[i]] = exercise.mistakes[i];
  out["mistakes"] = mistakes;
  return out;
}

const char* docOf(const std::string& property) {
  return doc(("State." + property).c_str());
}

/** Numbers of both arms. */
void addArms(py::class_<State>* target) {
  const auto of_model = [target](const char* name, auto member) {
    target->def_property_readonly(
        name, [member](const State& s) { return perArm(s.model().arms, member, s.owner()); }, docOf(name));
  };
  const auto of_robot = [target](const char* name, auto member) {
    target->def_property_readonly(
        name, [member](const State& s) { return perArm(s.robot().arms, member, s.owner()); }, docOf(name));
  };
  of_model("joints", &ArmState::q);
  of_model("joint_rates", &ArmState::dq);
  of_model("torques", &ArmState::tau);
  of_model("desired_joints", &ArmState::q_d);
  of_model("tips", &ArmState::p_BT);
  of_model("tip_velocities", &ArmState::v_BT);
  of_model("tip_rotations", &ArmState::q_BT);
  of_robot("robot_joints", &RobotArmState::q);
  of_robot("robot_tips", &RobotArmState::p_BT);
  of_robot("dac", &RobotArmState::dac);
}

void addWorld(py::class_<State>* target) {
  target->def_property_readonly("tips_in_world", &tipsInWorld, docOf("tips_in_world"))
      .def_property_readonly("desired_tips_in_world", &desiredTipsInWorld, docOf("desired_tips_in_world"))
      .def_property_readonly(
          "force", [](const State& s) { return perArm(s.haptic().force_B, s.owner()); }, docOf("force"))
      .def_property_readonly(
          "error", [](const State& s) { return view(s.haptic().error.data(), {2}, {sizeof(double)}, s.owner()); },
          docOf("error"))
      .def_property_readonly("objects", &State::objects, docOf("objects"))
      .def_property_readonly(
          "contacts",
          [](const State& s) {
            return std::array<std::uint32_t, 2>{s.model().arms[0].contacts, s.model().arms[1].contacts};
          },
          docOf("contacts"))
      .def_property_readonly("contact_points", &contactPoints, docOf("contact_points"))
      .def_property_readonly(
          "contacts_dropped",
          [](const State& s) { return withoutLock([&] { return s.simulation().contacts().dropped; }); },
          docOf("contacts_dropped"))
      .def_property_readonly(
          "true_joints",
          [](const State& s) {
            const auto q = withoutLock([&] { return s.simulation().trueJoints(); });
            return Numbers({2, 7}, q[0].data());
          },
          docOf("true_joints"));
}

/** Of the trainer, and without units. */
void addTrainer(py::class_<State>* target) {
  target
      ->def_property_readonly(
          "mode", [](const State& s) { return kModeNames[static_cast<std::size_t>(s.model().mode)]; }, docOf("mode"))
      .def_property_readonly(
          "runlevel",
          [](const State& s) {
            return s.robot().frame == 0 ? "none" : kRunLevelNames[static_cast<std::size_t>(s.robot().runlevel)];
          },
          docOf("runlevel"))
      .def_property_readonly(
          "tick", [](const State& s) { return s.model().tick; }, docOf("tick"))
      .def_property_readonly(
          "session_tick", [](const State& s) { return s.model().session_tick; }, docOf("session_tick"))
      .def_property_readonly(
          "hazard", [](const State& s) { return s.robot().active_fault != 0 || s.model().faults.active != 0; },
          docOf("hazard"))
      .def_property_readonly("exercise", &exerciseOf, docOf("exercise"));
}

}  // namespace

py::object newestState(py::object simulation) {
  return py::cast(made<State>(std::move(simulation)));
}

void addState(py::module_* target) {
  py::class_<State> state(*target, "State", doc("State"));
  addArms(&state);
  addWorld(&state);
  addTrainer(&state);
}

}  // namespace raven2_trainer::python
