#include "python/planner_module.h"

#include <atomic>
#include <memory>
#include <mutex>

#include "python/arrays.h"
#include "python/constructed.h"
#include "python/simulation.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/planning/path_planner.h"

namespace py = pybind11;

namespace raven2_trainer::python {
namespace {

/** One planner and its scene; calls wait for each other. */
class Planner : public Constructed {
 public:
  explicit Planner(const SimulationOptions& options)
      : config_(loadConfig(options)),
        raven_(model::loadRavenModel(config_)),
        scene_(model::loadSceneModel(config_)),
        planner_(raven_, scene_, config_.planner, config_.model) {
    physics::initialiseOde();
    planner_.prepare();
  }

  PlanResult plan(const PlanRequest& request, std::uint64_t seed) {
    const std::lock_guard<std::mutex> lock(mutex_);
    physics::attachOdeToThread();
    const std::atomic<bool> cancel{false};
    return planner_.plan(request, seed, /*lockstep=*/true, cancel);
  }

  bool inCollision(Arm arm, const JointArray& q, const JointArray& other) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return planner_.inCollision(arm, q, other);
  }

  double edgeCost(Arm arm, const JointArray& a, const JointArray& b) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return planner_.edgeCost(arm, a, b);
  }

  JointArray home() const { return config_.arms.geometry.home; }

 private:
  std::mutex mutex_;
  const TrainerConfig config_;
  const model::RavenModel raven_;
  const model::SceneModel scene_;
  planning::PathPlanner planner_;
};

py::dict describe(const PlanResult& result) {
  const auto count = static_cast<py::ssize_t>(result.waypoint_count);
  py::dict out;
  out["status"] = kPlanStatusNames[static_cast<std::size_t>(result.status)];
  out["waypoints"] = Numbers(std::vector<py::ssize_t>{count, 7}, result.waypoints[0].data());
  out["arrival"] = Numbers(std::vector<py::ssize_t>{count}, result.arrival.data());
  out["cost"] = result.cost;
  out["clearance"] = result.clearance;
  out["tracking_error"] = result.tracking_error;
  out["samples"] = result.samples;
  return out;
}

JointArray jointsOr(const py::object& given, const JointArray& otherwise, const std::string& what) {
  return given.is_none() ? otherwise : arrayOf<JointArray>(given, what);
}

JointArray finiteRow(const Numbers& rows, py::ssize_t i) {
  const JointArray q = rowOf(rows.data() + 7 * i);
  if (!std::all_of(q.begin(), q.end(), [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("joints: not a finite number");
  return q;
}

py::dict plan(Planner& self,
              const std::string& arm,
              const py::object& start,
              const py::object& goal,
              const py::object& other,
              std::uint64_t seed) {
  PlanRequest request;
  request.arm = armOf(arm);
  request.start = arrayOf<JointArray>(start, "start");
  request.other = jointsOr(other, self.home(), "other");
  const auto numbers = Numbers::ensure(goal);
  PyErr_Clear();
  if (!numbers || numbers.ndim() != 1 || (numbers.size() != 3 && numbers.size() != 7))
    throw std::invalid_argument("goal: expected a tip position (3 numbers) or joints (7 numbers)");
  if (numbers.size() == 3) {
    request.goal = GoalKind::kTip;
    request.goal_W = arrayOf<Vec3>(goal, "goal");
  } else {
    request.goal = GoalKind::kJoints;
    request.goal_q = arrayOf<JointArray>(goal, "goal");
  }
  PlanResult result;
  {
    const py::gil_scoped_release release;
    result = self.plan(request, seed);
  }
  return describe(result);
}

py::array_t<bool> inCollision(Planner& self,
                              const std::string& arm,
                              const py::object& joints,
                              const py::object& other) {
  const Numbers rows = jointRows(joints);
  const JointArray there = jointsOr(other, self.home(), "other");
  py::array_t<bool> found(leading(rows, 1, {}));
  for (py::ssize_t i = 0; i < found.size(); ++i)
    found.mutable_data()[i] = self.inCollision(armOf(arm), finiteRow(rows, i), there);
  return found;
}

}  // namespace

void addPlanner(py::module_* module) {
  py::class_<Planner>(*module, "Planner")
      .def(py::init([](const std::string& exercise, const std::string& config) {
             SimulationOptions options;
             options.exercise = exercise;
             options.config = config;
             const py::gil_scoped_release release;
             return made<Planner>(options);
           }),
           py::arg("exercise"), py::arg("config"))
      .def("plan", &plan, py::arg("arm"), py::arg("start"), py::arg("goal"), py::arg("other") = py::none(),
           py::arg("seed") = 1)
      .def("in_collision", &inCollision, py::arg("arm"), py::arg("joints"), py::arg("other") = py::none())
      .def(
          "edge_cost",
          [](Planner& self, const std::string& arm, const py::object& a, const py::object& b) {
            return self.edgeCost(armOf(arm), arrayOf<JointArray>(a, "a"), arrayOf<JointArray>(b, "b"));
          },
          py::arg("arm"), py::arg("a"), py::arg("b"));
}

}  // namespace raven2_trainer::python
