#include "python/motion_module.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <mutex>
#include <sstream>

#include "python/arrays.h"
#include "python/constructed.h"
#include "python/docs.h"
#include "python/simulation.h"
#include "python/unlocked.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/planning/path_planner.h"

namespace py = pybind11;

namespace raven2_trainer::python {
namespace {

// ---- kinematics

struct Kinematics : Constructed {
  explicit Kinematics(const ArmGeometry& arms) : geometry(arms) {}

  ArmGeometry geometry;
};

JointArray finiteRow(const Numbers& rows, py::ssize_t i) {
  const JointArray q = rowOf(rows.data() + 7 * i);
  if (!std::all_of(q.begin(), q.end(), [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("joints: not a finite number");
  return q;
}

py::tuple forwardOf(const Kinematics& self, const std::string& arm, const py::object& joints) {
  const Numbers rows = jointRows(joints);
  Numbers p(leading(rows, 1, {3})), R(leading(rows, 1, {3, 3}));
  for (py::ssize_t i = 0; i < rows.size() / 7; ++i) {
    const Pose pose = kinematics::forward(self.geometry, armOf(arm), finiteRow(rows, i));
    for (int k = 0; k < 3; ++k)
      p.mutable_data()[3 * i + k] = pose.p[k];
    for (int k = 0; k < 9; ++k)
      R.mutable_data()[9 * i + k] = pose.R(k / 3, k % 3);
  }
  return py::make_tuple(p, R);
}

Numbers jacobianOf(const Kinematics& self, const std::string& arm, const py::object& joints) {
  const Numbers rows = jointRows(joints);
  Numbers J(leading(rows, 1, {6, 7}));
  for (py::ssize_t i = 0; i < rows.size() / 7; ++i) {
    const kinematics::Jacobian one = kinematics::jacobian(self.geometry, armOf(arm), finiteRow(rows, i));
    for (int k = 0; k < 42; ++k)
      J.mutable_data()[42 * i + k] = one(k / 7, k % 7);
  }
  return J;
}

/** All solutions of a pose; of a matrix that is no rotation, or a reflection, all are invalid. */
kinematics::IkSolutions solutionsOf(const ArmGeometry& arms,
                                    Arm arm,
                                    const double* p,
                                    const double* R,
                                    double opening) {
  Pose pose;
  for (int k = 0; k < 3; ++k)
    pose.p[k] = p[k];
  for (int k = 0; k < 9; ++k)
    pose.R(k / 3, k % 3) = R[k];
  kinematics::IkSolutions solutions{};
  const bool is_rotation =
      (pose.R * pose.R.transpose() - Matrix3::Identity()).norm() < 1e-6 && pose.R.determinant() > 0.0;
  if (is_rotation) kinematics::inverseAll(arms, arm, pose, opening, &solutions);
  return solutions;
}

void demandFinite(const Numbers& numbers, const std::string& what) {
  const auto is_finite = [](double x) { return std::isfinite(x); };
  if (!std::all_of(numbers.data(), numbers.data() + numbers.size(), is_finite))
    throw std::invalid_argument(what + ": not a finite number");
}

py::tuple inverseOf(const Kinematics& self,
                    const std::string& arm,
                    const py::object& given_p,
                    const py::object& given_R,
                    double opening) {
  const Numbers p = numbersOf(given_p), R = numbersOf(given_R);
  PyErr_Clear();
  const bool fits = p && R && p.ndim() >= 1 && R.ndim() == p.ndim() + 1 && p.shape(p.ndim() - 1) == 3 &&
                    R.shape(R.ndim() - 1) == 3 && R.shape(R.ndim() - 2) == 3 &&
                    std::equal(p.shape(), p.shape() + p.ndim() - 1, R.shape());
  if (!fits) throw std::invalid_argument("p, R: expected arrays of shapes (..., 3) and (..., 3, 3)");
  demandFinite(p, "p");
  demandFinite(R, "R");
  if (!(std::abs(opening) <= kPi)) throw std::invalid_argument("opening: expected -3.14 to 3.14 rad");
  Numbers joints(leading(p, 1, {8, 7}));
  py::array_t<bool> valid(leading(p, 1, {8}));
  double* q = joints.mutable_data();
  bool* is_valid = valid.mutable_data();
  for (py::ssize_t i = 0; i < p.size() / 3; ++i) {
    for (const auto& solution : solutionsOf(self.geometry, armOf(arm), p.data() + 3 * i, R.data() + 9 * i, opening)) {
      *is_valid++ = solution.valid;
      for (std::size_t k = 0; k < kJointCount; ++k)
        *q++ = solution.valid ? solution.q[k] : std::nan("");
    }
  }
  return py::make_tuple(joints, valid);
}

// ---- planner

/** [rad; m] as of a robot's state (wire/robot_frame.cpp). An assertion of FCL's distance fails from some 1e8 on. */
constexpr double kFarthestJoint = 1e4;

/** @return q. @throw std::invalid_argument. */
const JointArray& plannable(const JointArray& q, const std::string& what) {
  for (const double x : q) {
    if (std::abs(x) <= kFarthestJoint) continue;
    std::ostringstream text;
    text << what << ": " << x << " is not between -10000 and 10000 rad or m";
    throw std::invalid_argument(text.str());
  }
  return q;
}

JointArray plannableOf(const py::object& given, const std::string& what) {
  return plannable(arrayOf<JointArray>(given, what), what);
}

/** One planner and its scene; calls wait for each other. */
class Planner : public Constructed {
  /** On another thread: the caller runs signals meanwhile. @throw what they throw; then the work is cancelled. */
  template <typename Work>
  auto await(const Work& work) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::atomic<bool> cancel{false};
    auto answer = std::async(std::launch::async, [&] {
      physics::attachOdeToThread();
      return work(cancel);
    });
    try {
      while (answer.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready)
        runSignals();
    } catch (...) {
      cancel = true;  // the destructor of `answer` waits for its thread
      throw;
    }
    return answer.get();
  }

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
    return await(
        [&](const std::atomic<bool>& cancel) { return planner_.plan(request, seed, /*lockstep=*/true, cancel); });
  }

  planning::FollowedPath rollOut(Arm arm, const std::vector<JointArray>& waypoints, const JointArray& other) {
    return await([&](const std::atomic<bool>& cancel) { return planner_.rollOut(arm, waypoints, other, cancel); });
  }

  bool inCollision(Arm arm, const JointArray& q, const JointArray& other) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return planner_.inCollision(arm, q, other);
  }

  double clearance(Arm arm, const JointArray& q, const JointArray& other) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return planner_.clearance(arm, q, other, kFarthest);
  }

  double edgeCost(Arm arm, const JointArray& a, const JointArray& b) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return planner_.edgeCost(arm, a, b);
  }

  JointArray home() const { return config_.arms.geometry.home; }

 private:
  static constexpr double kFarthest = 1.0;  // [m] no distance in the robot's workspace is larger

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
  return given.is_none() ? otherwise : plannableOf(given, what);
}

py::dict plan(Planner& self,
              const std::string& arm,
              const py::object& start,
              const py::object& goal,
              const py::object& other,
              std::uint64_t seed) {
  PlanRequest request;
  request.arm = armOf(arm);
  request.start = plannableOf(start, "start");
  request.other = jointsOr(other, self.home(), "other");
  const Numbers numbers = numbersOf(goal);
  PyErr_Clear();
  if (!numbers || numbers.ndim() != 1 || (numbers.size() != 3 && numbers.size() != 7))
    throw std::invalid_argument("goal: expected a tip position (3 numbers) or joints (7 numbers)");
  if (numbers.size() == 3) {
    request.goal = GoalKind::kTip;
    request.goal_W = arrayOf<Vec3>(goal, "goal");
  } else {
    request.goal = GoalKind::kJoints;
    request.goal_q = plannableOf(goal, "goal");
  }
  return describe(withoutLock([&] { return self.plan(request, seed); }));
}

/** judge(joints) of each row. Ctrl-C ends it within kRowsASignal rows. */
template <typename T, typename Judge>
py::array_t<T> ofEachRow(const py::object& joints, const Judge& judge) {
  constexpr py::ssize_t kRowsASignal = 1000;
  const Numbers rows = jointRows(joints);
  py::array_t<T> found(leading(rows, 1, {}));
  T* const values = found.mutable_data();
  const py::ssize_t count = found.size();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < count; ++i) {
    if (i % kRowsASignal == kRowsASignal - 1) runSignals();
    values[i] = judge(plannable(finiteRow(rows, i), "joints"));
  }
  return found;
}

py::array_t<bool> inCollision(Planner& self,
                              const std::string& arm,
                              const py::object& joints,
                              const py::object& other) {
  const JointArray there = jointsOr(other, self.home(), "other");
  return ofEachRow<bool>(joints, [&](const JointArray& q) { return self.inCollision(armOf(arm), q, there); });
}

py::array_t<double> clearance(Planner& self,
                              const std::string& arm,
                              const py::object& joints,
                              const py::object& other) {
  const JointArray there = jointsOr(other, self.home(), "other");
  return ofEachRow<double>(joints, [&](const JointArray& q) { return self.clearance(armOf(arm), q, there); });
}

py::dict rollOut(Planner& self, const std::string& arm, const py::object& waypoints, const py::object& other) {
  const Numbers rows = jointRows(waypoints);
  if (rows.ndim() != 2) throw std::invalid_argument("waypoints: expected an array of shape (n, 7)");
  std::vector<JointArray> path;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    path.push_back(plannable(finiteRow(rows, i), "waypoints"));
  const JointArray there = jointsOr(other, self.home(), "other");
  const planning::FollowedPath followed = withoutLock([&] { return self.rollOut(armOf(arm), path, there); });
  py::dict out;
  out["free"] = followed.free;
  out["failed_edge"] = followed.free ? py::object(py::none()) : py::cast(followed.failed_edge);
  out["arrival"] = Numbers(static_cast<py::ssize_t>(followed.arrival.size()), followed.arrival.data());
  out["clearance"] = followed.clearance;
  out["tracking_error"] = followed.tracking_error;
  out["duration"] = followed.duration;
  return out;
}

}  // namespace

void addPlanner(py::module_* module) {
  py::class_<Planner>(*module, "Planner")
      .def(py::init([](const std::string& exercise, const std::string& config) {
             SimulationOptions options;
             options.exercise = exercise;
             options.config = config;
             const Unlocked unlocked;
             return made<Planner>(options);
           }),
           py::arg("exercise"), py::arg("config"))
      .def("plan", &plan, doc("Planner.plan"), py::arg("arm"), py::arg("start"), py::arg("goal"),
           py::arg("other") = py::none(), py::arg("seed") = 1)
      .def("in_collision", &inCollision, doc("Planner.in_collision"), py::arg("arm"), py::arg("joints"),
           py::arg("other") = py::none())
      .def("clearance", &clearance, doc("Planner.clearance"), py::arg("arm"), py::arg("joints"),
           py::arg("other") = py::none())
      .def("roll_out", &rollOut, doc("Planner.roll_out"), py::arg("arm"), py::arg("waypoints"),
           py::arg("other") = py::none())
      .def(
          "edge_cost",
          [](Planner& self, const std::string& arm, const py::object& a, const py::object& b) {
            const JointArray from = plannableOf(a, "a"), to = plannableOf(b, "b");
            const Unlocked unlocked;
            return self.edgeCost(armOf(arm), from, to);
          },
          doc("Planner.edge_cost"), py::arg("arm"), py::arg("a"), py::arg("b"));
}

void addKinematics(py::module_* module) {
  py::class_<Kinematics>(*module, "Kinematics")
      .def(py::init([](const std::string& config) {
             const std::string root = config.empty() ? config::shareFolder() + "/config/trainer.yaml" : config;
             return made<Kinematics>(config::loadTrainerConfig(root).arms.geometry);
           }),
           py::arg("config") = "")
      .def("forward", &forwardOf, doc("Kinematics.forward"), py::arg("arm"), py::arg("joints"))
      .def("jacobian", &jacobianOf, doc("Kinematics.jacobian"), py::arg("arm"), py::arg("joints"))
      .def("inverse", &inverseOf, doc("Kinematics.inverse"), py::arg("arm"), py::arg("p"), py::arg("R"),
           py::arg("opening") = 0.0);
}

}  // namespace raven2_trainer::python
