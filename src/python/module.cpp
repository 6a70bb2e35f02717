// The Python module raven2_trainer._core: simulations and kinematics as numpy arrays. doc/python.md.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <thread>

#include "python/arrays.h"
#include "python/constructed.h"
#include "python/motion_module.h"
#include "python/picture.h"
#include "python/simulation.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/planning/path_planner.h"

namespace py = pybind11;

namespace raven2_trainer::python {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;  ///< key, value as YAML

/** A caller's methods, `__str__` of a key for example, may change the dict while it is read. */
py::dict copied(const py::handle& given) {
  return py::reinterpret_steal<py::dict>(PyDict_Copy(given.ptr()));
}

ArmCommand armCommand(const py::handle& given, const std::string& arm) {
  ArmCommand command;
  if (!py::isinstance<py::dict>(given)) throw std::invalid_argument(arm + ": expected a dict");
  const py::dict items = copied(given);
  for (const auto& [key, value] : items) {
    const auto name = py::cast<std::string>(py::str(key));
    const std::string what = arm + "/" + name;
    if (name == "move") {
      command.move_W = arrayOf<Vec3>(value, what);
    } else if (name == "turn") {
      command.turn_W = arrayOf<Vec3>(value, what);
    } else if (name == "joints") {
      command.joints = arrayOf<JointArray>(value, what);
    } else if (name == "jaw") {
      command.jaw = arrayOf<std::array<double, 1>>(py::make_tuple(value), what)[0];
    } else {
      throw std::invalid_argument(what + ": unknown key; known: move, turn, joints, jaw");
    }
  }
  if (command.joints && items.size() > 1)
    throw std::invalid_argument(arm + ": joints go alone, they have the jaws in them");
  return command;
}

/** Rows gold and green: move [m], turn [rad], jaw [rad]. */
StepCommand rowsCommand(const Numbers& rows) {
  StepCommand command;
  for (const Arm arm : kArms) {
    const double* const row = rows.data(static_cast<py::ssize_t>(index(arm)), 0);
    for (std::size_t i = 0; i < 7; ++i)
      if (!std::isfinite(row[i])) throw std::invalid_argument("command: not a finite number");
    ArmCommand& one = at(command.arms, arm);
    std::copy(row, row + 3, one.move_W.begin());
    std::copy(row + 3, row + 6, one.turn_W.begin());
    one.jaw = row[6];
  }
  return command;
}

StepCommand stepCommand(const py::object& given) {
  if (given.is_none()) return {{}, true, true};
  if (!py::isinstance<py::dict>(given)) {
    const auto rows = Numbers::ensure(given);
    PyErr_Clear();
    if (rows && rows.ndim() == 2 && rows.shape(0) == 2 && rows.shape(1) == 7) return rowsCommand(rows);
    throw std::invalid_argument("command: expected None, a dict or an array of shape (2, 7)");
  }
  StepCommand command;
  const py::dict items = copied(given);
  for (const auto& [key, value] : items) {
    const auto name = py::cast<std::string>(py::str(key));
    if (name == "gold" || name == "green") {
      at(command.arms, name == "gold" ? Arm::kGold : Arm::kGreen) = armCommand(value, name);
    } else if (name == "pedal") {
      command.pedal = py::cast<bool>(py::bool_(py::reinterpret_borrow<py::object>(value)));
    } else {
      throw std::invalid_argument(name + ": unknown key; known: gold, green, pedal");
    }
  }
  return command;
}

int demandTicks(int ticks) {
  if (ticks < 1 || ticks > 1000000) throw std::invalid_argument("ticks: expected 1 to 1000000");
  return ticks;
}

void demandSize(int width, int height) {
  if (width < 1 || width > 4096 || height < 1 || height > 4096)
    throw std::invalid_argument("width, height: expected 1 to 4096");
}

// ---- views

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
  return out;
}

// ---- many at once

/** Threads that end before it does, however it ends. */
struct Joined {
  ~Joined() {
    for (std::thread& each : threads)
      each.join();
  }
  std::vector<std::thread> threads;
};

/** Steps all of them, each on one of the threads; none if a command is refused. @throw what one of them throws. */
void stepAll(const std::vector<Simulation*>& all,
             const std::vector<StepCommand>& commands,
             int ticks,
             unsigned threads) {
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i]->check(commands[i], ticks);
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr trouble;
  const auto work = [&] {
    for (std::size_t i = next++; i < all.size(); i = next++) {
      try {
        all[i]->step(commands[i], ticks);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!trouble) trouble = std::current_exception();
      }
    }
  };
  {
    Joined others;
    try {
      for (unsigned i = 1; i < threads && i < all.size(); ++i)
        others.threads.emplace_back(work);
    } catch (const std::system_error&) {
      // no more threads on this computer: the others do the work
    }
    work();
  }
  if (trouble) std::rethrow_exception(trouble);
}

void addCommands(py::class_<Simulation>* target) {
  target
      ->def(
          "step",
          [](Simulation& self, const py::object& command, int ticks) {
            const StepCommand wanted = stepCommand(command);
            demandTicks(ticks);
            const py::gil_scoped_release release;
            self.step(wanted, ticks, [] {
              const py::gil_scoped_acquire acquire;
              if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            });
          },
          py::arg("command") = py::none(), py::arg("ticks") = 1)
      .def(
          "start", [](Simulation& self, int limit) { return self.start(demandTicks(limit)); }, py::arg("limit") = 20000,
          py::call_guard<py::gil_scoped_release>())
      .def(
          "save", [](Simulation& self) { return std::make_shared<Snapshot>(self.save()); },
          py::call_guard<py::gil_scoped_release>())
      .def("restore", &Simulation::restore, py::arg("snapshot"), py::call_guard<py::gil_scoped_release>())
      .def("inject", &Simulation::inject, py::arg("hazard"), py::call_guard<py::gil_scoped_release>())
      .def("clear_hazards", &Simulation::clearHazards, py::call_guard<py::gil_scoped_release>())
      .def("close", &Simulation::close, py::call_guard<py::gil_scoped_release>());
}

void addPictures(py::class_<Simulation>* target) {
  const auto draw = [](const Simulation& self, const std::string& camera, int width, int height) {
    demandSize(width, height);
    const auto rgb = withoutLock([&] { return drawPicture(self, camera, width, height); });
    return py::array_t<std::uint8_t>({height, width, 3}, rgb.data());
  };
  const auto measure = [](const Simulation& self, const std::string& camera, int width, int height) {
    demandSize(width, height);
    const auto seen = withoutLock([&] { return measurePicture(self, camera, width, height); });
    return py::make_tuple(py::array_t<float>({height, width}, seen.depth.data()),
                          py::array_t<std::uint16_t>({height, width}, seen.part.data()));
  };
  const py::arg_v camera = py::arg("camera") = "endoscope", width = py::arg("width") = 640,
                  height = py::arg("height") = 480;
  target->def("render", draw, camera, width, height)
      .def("measure", measure, camera, width, height)
      .def_property_readonly("part_names",
                             [](const Simulation& self) { return render::partNames(self.raven(), self.scene()); })
      .def_property_readonly("cameras", [](const Simulation& self) {
        std::vector<std::string> names;
        for (const CameraConfig& each : self.config().render.cameras)
          names.push_back(each.name);
        return names;
      });
}

void addSimulation(py::module_* target) {
  py::module_& module = *target;
  py::class_<Snapshot, std::shared_ptr<Snapshot>>(module, "Snapshot")
      .def_property_readonly("size", [](const Snapshot& self) { return self.memory.size(); });

  py::class_<Simulation> simulation(module, "Simulation");
  simulation
      .def(py::init([](const std::string& exercise, const std::string& hazard, std::uint64_t seed,
                       const std::string& config, bool has_robot, const std::string& motion, const std::string& output,
                       const std::string& plant, const std::string& link, const Settings& settings) {
             SimulationOptions options{exercise, hazard, motion, config, output, seed, has_robot, plant, link, {}};
             for (const auto& [key, value] : settings)
               options.settings.push_back({key, value, "settings[\"" + key + "\"]"});
             return withoutLock([&] { return made<Simulation>(options); });
           }),
           py::arg("exercise"), py::arg("hazard"), py::arg("seed"), py::arg("config"), py::arg("has_robot"),
           py::arg("motion"), py::arg("output"), py::arg("plant"), py::arg("link"), py::arg("settings"))
      .def_property_readonly("closed", &Simulation::isClosed)
      .def_property_readonly("memory", &Simulation::stateSize)
      .def_property_readonly("state", [](py::object self) { return made<State>(std::move(self)); })
      .def_property_readonly("object_names", [](const Simulation& self) {
        std::vector<std::string> names;
        for (const int body : self.scene().free_bodies)
          names.push_back(self.scene().description.links[static_cast<std::size_t>(body)].name);
        return names;
      });
  addCommands(&simulation);
  addPictures(&simulation);
}

/** Numbers of both arms. */
void addArms(py::class_<State>* target) {
  const auto of_model = [target](const char* name, auto member) {
    target->def_property_readonly(name, [member](const State& s) { return perArm(s.model().arms, member, s.owner()); });
  };
  const auto of_robot = [target](const char* name, auto member) {
    target->def_property_readonly(name, [member](const State& s) { return perArm(s.robot().arms, member, s.owner()); });
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

void addState(py::module_* target) {
  py::class_<State> state(*target, "State");
  addArms(&state);
  state.def_property_readonly("tips_in_world", &tipsInWorld)
      .def_property_readonly("desired_tips_in_world", &desiredTipsInWorld)
      .def_property_readonly("force", [](const State& s) { return perArm(s.haptic().force_B, s.owner()); })
      .def_property_readonly(
          "error", [](const State& s) { return view(s.haptic().error.data(), {2}, {sizeof(double)}, s.owner()); })
      .def_property_readonly("objects", &State::objects)
      .def_property_readonly(
          "contacts",
          [](const State& s) {
            return std::array<std::uint32_t, 2>{s.model().arms[0].contacts, s.model().arms[1].contacts};
          })
      .def_property_readonly("true_joints",
                             [](const State& s) {
                               const auto q = withoutLock([&] { return s.simulation().trueJoints(); });
                               return Numbers({2, 7}, q[0].data());
                             })
      .def_property_readonly("mode",
                             [](const State& s) { return kModeNames[static_cast<std::size_t>(s.model().mode)]; })
      .def_property_readonly(
          "runlevel",
          [](const State& s) {
            return s.robot().frame == 0 ? "none" : kRunLevelNames[static_cast<std::size_t>(s.robot().runlevel)];
          })
      .def_property_readonly("tick", [](const State& s) { return s.model().tick; })
      .def_property_readonly("session_tick", [](const State& s) { return s.model().session_tick; })
      .def_property_readonly("hazard",
                             [](const State& s) { return s.robot().active_fault != 0 || s.model().faults.active != 0; })
      .def_property_readonly("exercise", &exerciseOf);
}

void addStepAll(py::module_* target) {
  py::module_& module = *target;
  module.def("step_all", [](const py::list& simulations, const py::list& commands, int ticks, unsigned threads) {
    if (simulations.size() != commands.size()) throw std::invalid_argument("expected a command for each simulation");
    // Their own references: the caller's lists may change meanwhile.
    std::vector<py::object> kept, given;
    for (std::size_t i = 0; i < simulations.size(); ++i) {
      kept.push_back(py::reinterpret_borrow<py::object>(simulations[i]));
      given.push_back(py::reinterpret_borrow<py::object>(commands[i]));
    }
    std::vector<Simulation*> all;
    std::vector<StepCommand> wanted;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      all.push_back(&py::cast<Simulation&>(kept[i]));
      wanted.push_back(stepCommand(given[i]));
    }
    demandTicks(ticks);
    const py::gil_scoped_release release;
    stepAll(all, wanted, ticks, threads);
  });
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  serveOde();
  planning::initialiseOmpl();
  py::register_exception<ConfigException>(module, "ConfigError", PyExc_ValueError);
  py::register_exception<ModelException>(module, "ModelError", PyExc_RuntimeError);
  py::register_exception<RenderException>(module, "RenderError", PyExc_RuntimeError);
  const py::object read_error = py::module_::import("raven2_trainer.session").attr("SessionError");
  py::register_exception<SessionException>(module, "SessionError", read_error);
  addSimulation(&module);
  addState(&module);
  addStepAll(&module);
  addPlanner(&module);
  addKinematics(&module);
}

}  // namespace raven2_trainer::python
