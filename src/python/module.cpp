// The Python module raven2_trainer._core: simulations and kinematics as numpy arrays. doc/python.md.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/arrays.h"
#include "python/constructed.h"
#include "python/docs.h"
#include "python/motion_module.h"
#include "python/picture.h"
#include "python/simulation.h"
#include "python/state_module.h"
#include "python/steps.h"
#include "python/unlocked.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/planning/path_planner.h"

namespace py = pybind11;

namespace raven2_trainer::python {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;  ///< key, value as YAML

/** A caller's methods, `__str__` of a key for example, may change the dict while it is read. */
py::dict copied(const py::handle& given) {
  return py::reinterpret_steal<py::dict>(PyDict_Copy(given.ptr()));
}

/** @throw std::invalid_argument for invalid text, such as half of a surrogate pair. */
std::string keyOf(const py::handle& key) {
  try {
    return py::cast<std::string>(py::str(key));
  } catch (const py::cast_error&) {
    throw std::invalid_argument("a key of the command is no text");
  }
}

ArmCommand armCommand(const py::handle& given, const std::string& arm) {
  ArmCommand command;
  if (!py::isinstance<py::dict>(given)) throw std::invalid_argument(arm + ": expected a dict");
  const py::dict items = copied(given);
  for (const auto& [key, value] : items) {
    const std::string name = keyOf(key);
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

/** True, False, 1 or 0, also of numpy. A text or an array has a truth value in Python, but is a mistake here. */
bool pedalOf(const py::handle& value) {
  py::detail::make_caster<bool> caster;
  if (caster.load(value, /*convert=*/false)) return py::detail::cast_op<bool>(caster);
  const py::object number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  PyErr_Clear();
  if (number && number.equal(py::int_(0))) return false;
  if (number && number.equal(py::int_(1))) return true;
  throw std::invalid_argument("pedal: expected True or False");
}

StepCommand stepCommand(const py::object& given) {
  if (given.is_none()) return {{}, true, true};
  if (!py::isinstance<py::dict>(given)) {
    const auto rows = numbersOf(given);
    PyErr_Clear();
    if (rows && rows.ndim() == 2 && rows.shape(0) == 2 && rows.shape(1) == 7) return rowsCommand(rows);
    throw std::invalid_argument("command: expected None, a dict or an array of shape (2, 7)");
  }
  StepCommand command;
  const py::dict items = copied(given);
  for (const auto& [key, value] : items) {
    const std::string name = keyOf(key);
    if (name == "gold" || name == "green") {
      at(command.arms, name == "gold" ? Arm::kGold : Arm::kGreen) = armCommand(value, name);
    } else if (name == "pedal") {
      command.pedal = pedalOf(value);
    } else {
      throw std::invalid_argument(name + ": unknown key; known: gold, green, pedal");
    }
  }
  return command;
}

int demandTicks(int ticks, const std::string& what = "ticks") {
  if (ticks < 1 || ticks > 1000000) throw std::invalid_argument(what + ": expected 1 to 1000000");
  return ticks;
}

void demandSize(int width, int height) {
  if (width < 1 || width > 4096 || height < 1 || height > 4096)
    throw std::invalid_argument("width, height: expected 1 to 4096");
}

void addCommands(py::class_<Simulation>* target) {
  target
      ->def(
          "step",
          [](Simulation& self, const py::object& command, int ticks) {
            const StepCommand wanted = stepCommand(command);
            demandTicks(ticks);
            const Unlocked unlocked;
            self.step(wanted, ticks, runSignals);
          },
          doc("Simulation.step"), py::arg("command") = py::none(), py::arg("ticks") = 1)
      .def(
          "start", [](Simulation& self, int limit) { return self.start(demandTicks(limit, "limit"), runSignals); },
          doc("Simulation.start"), py::arg("limit") = 20000, py::call_guard<Unlocked>())
      .def(
          "save", [](Simulation& self) { return std::make_shared<Snapshot>(self.save()); }, doc("Simulation.save"),
          py::call_guard<Unlocked>())
      .def("restore", &Simulation::restore, doc("Simulation.restore"), py::arg("snapshot"), py::call_guard<Unlocked>())
      .def("reseed", &Simulation::reseed, doc("Simulation.reseed"), py::arg("seed"), py::call_guard<Unlocked>())
      .def("inject", &Simulation::inject, doc("Simulation.inject"), py::arg("hazard"), py::call_guard<Unlocked>())
      .def("clear_hazards", &Simulation::clearHazards, doc("Simulation.clear_hazards"), py::call_guard<Unlocked>())
      .def("close", &Simulation::close, doc("Simulation.close"), py::call_guard<Unlocked>());
}

void addPictures(py::class_<Simulation>* target) {
  const auto draw = [](Simulation& self, const std::string& camera, int width, int height) {
    demandSize(width, height);
    const auto rgb = withoutLock([&] { return drawPicture(self, camera, width, height); });
    return py::array_t<std::uint8_t>({height, width, 3}, rgb.data());
  };
  const auto measure = [](Simulation& self, const std::string& camera, int width, int height) {
    demandSize(width, height);
    const auto seen = withoutLock([&] { return measurePicture(self, camera, width, height); });
    return py::make_tuple(py::array_t<float>({height, width}, seen.depth.data()),
                          py::array_t<std::uint16_t>({height, width}, seen.part.data()));
  };
  const py::arg_v camera = py::arg("camera") = "endoscope", width = py::arg("width") = 640,
                  height = py::arg("height") = 480;
  target->def("render", draw, doc("Simulation.render"), camera, width, height)
      .def("measure", measure, doc("Simulation.measure"), camera, width, height)
      .def_property_readonly(
          "part_names", [](const Simulation& self) { return render::partNames(self.raven(), self.scene()); },
          doc("Simulation.part_names"))
      .def_property_readonly(
          "cameras",
          [](const Simulation& self) {
            std::vector<std::string> names;
            for (const CameraConfig& each : self.config().render.cameras)
              names.push_back(each.name);
            return names;
          },
          doc("Simulation.cameras"));
}

void addSimulation(py::module_* target) {
  py::module_& module = *target;
  py::class_<Snapshot, std::shared_ptr<Snapshot>>(module, "Snapshot", doc("Snapshot"))
      .def_property_readonly(
          "size", [](const Snapshot& self) { return self.memory.size(); }, doc("Snapshot.size"));

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
      .def_property_readonly("closed", &Simulation::isClosed, doc("Simulation.closed"))
      .def_property_readonly("memory", &Simulation::stateSize, doc("Simulation.memory"))
      .def_property_readonly("state", &newestState, doc("Simulation.state"))
      .def_property_readonly(
          "object_names",
          [](const Simulation& self) {
            std::vector<std::string> names;
            for (const int body : self.scene().free_bodies)
              names.push_back(self.scene().description.links[static_cast<std::size_t>(body)].name);
            return names;
          },
          doc("Simulation.object_names"))
      .def_property_readonly(
          "body_names", [](const Simulation& self) { return withoutLock([&] { return self.bodyNames(); }); },
          doc("Simulation.body_names"));
  addCommands(&simulation);
  addPictures(&simulation);
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
    const Unlocked unlocked;
    stepAll(all, wanted, ticks, threads);
  });
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  serveOde();
  stopThreadsAtExit();
  planning::initialiseOmpl();
  py::register_exception<ConfigException>(module, "ConfigError", PyExc_ValueError);
  py::register_exception<ModelException>(module, "ModelError", PyExc_RuntimeError);
  py::register_exception<RenderException>(module, "RenderError", PyExc_RuntimeError);
  const py::object read_error = py::module_::import("raven2_trainer.session").attr("SessionError");
  py::register_exception<SessionException>(module, "SessionError", read_error);
  module.attr("MOST_SIMULATIONS") = Arena::kMost;
  addSimulation(&module);
  addState(&module);
  addStepAll(&module);
  addPlanner(&module);
  addKinematics(&module);
}

}  // namespace raven2_trainer::python
