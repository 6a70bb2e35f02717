"""States in words, as the pages show them."""

ROBOT = {"E-STOP": "The robot is stopped (E-STOP).", "INIT": "The robot is homing.", "PEDAL_UP": "The robot is ready, its brakes hold.",
         "PEDAL_DN": "The robot moves, its brakes are off.", "no robot": "No robot is connected."}

SEVERITIES = ["high", "medium", "low", "none"]
_SEVERITY = {"H1-2": "high", "H-2": "high", "H1-1": "high", "H1-3": "medium", "H-3": "medium"}

MODES = {
    "waiting": "Waiting for the robot", "pedal_up": "Ready: press the pedal", "teleoperating": "The hands move the robot",
    "planning": "Planning a path", "tracking": "The model follows the plan", "stopped": "STOPPED", "paused": "PAUSED: press the pedal",
    "choosing": "The hands show the goal", "armed": "Plan ready: press the pedal", "executing": "Executing the plan",
    "simulating": "The hands move the model alone", "simulation_held": "Model alone: press the pedal", "trial": "Virtual trial",
    "trial_held": "Virtual trial: press the pedal", "trial_ready": "Virtual trial recorded", "returning": "The model returns to the robot",
    "replaying": "Replay of a session", "camera_moving": "The hands move the camera"}
DISENGAGED = {"pedal_up": "Ready; robot disengaged", "teleoperating": "The hands move the model; robot disengaged"}

STATUSES = {"none": "no exercise", "waiting": "not begun", "running": "running", "done": "done", "failed": "failed"}
FAILURES = {"time_limit": "the time limit is over", "broke_off": "a tower broke off", "object_lost": "an object was lost",
            "mistakes": "too many mistakes", "given_up": "given up"}
MISTAKES = {"wire_touch": "wire touched", "collision": "collision", "drop": "dropped", "out_of_order": "wrong order",
            "wrong_arm": "wrong arm", "break_off": "tower broken off"}

_SILENT = "The trainer did not answer. Try again."
PLANNING_ANSWERS = {
    "none": _SILENT, "accepted": "Done.", "not_now": "Not possible now. Wait until the arms rest and the pedal is up.",
    "no_plan": "There is no plan: press Plan first.", "moved": "An arm has moved since the plan was made: press Plan again.",
    "no_robot": "The robot is not homed, not connected or disengaged. Wait until it is ready, then try again.",
    "robot_cannot_follow": "The robot itself would leave the path. Move the arm, then press Plan again."}
PLAN_STATUSES = {
    "none": _SILENT, "success": "The plan is ready: press Execute.",
    "start_in_collision": "No plan: the arm touches something. Move it away, then press Plan again.",
    "goal_unreachable": "No plan: the arm cannot reach the goal of the configuration.",
    "goal_in_collision": "No plan: at the goal the arm would touch something.",
    "no_path": "No plan: the planner found no free path. Move the arm, then press Plan again.",
    "cancelled": "The plan was cancelled by Cancel, by the pedal or by a newer plan.",
    "dynamics_infeasible": "No plan: on each path the simulated arm touches something or lags too far.",
    "time_limit": "No plan within the time limit. Move the arm, then press Plan again.",
    "invalid_start": "No plan: a joint of the arm is outside its limits. Move the arm, then press Plan again.",
    "failed": "No plan: the planner has an error. Its message is in station_logs/simulator.log."}
ANSWERS = {**PLAN_STATUSES, **PLANNING_ANSWERS, "no answer": _SILENT,
           "accepted; the planner is still ending": "Done. The planner needs a moment to end."}
CLUMSY = {"beside": "misses the place", "breaker": "tears a tower off", "dropper": "drops things",
          "shaky": "has shaking hands", "slow": "works too slowly", "toucher": "touches the wires"}
STOPPED = "Stopped. Release the pedal, then press Clear the stop. If that is refused, press Stop and next attempt."
CLEAR_FIRST = "The pedal is down. When the surgeon has released it, press Clear the stop again, or press Stop session."
ROBOT_STOPPED = "The robot itself is stopped (E-STOP). Press its start button, or Stop and next attempt."
MODEL_STOPPED = "The stop cannot be cleared: the simulation has stopped. Press Stop and next attempt."
NO_EXERCISE = "This session has no exercise: there is nothing to restart."
NO_PLAN = "There was no plan."
NO_START = "The virtual robot does not offer its start button. Press Stop and next attempt."
REAL_START = "No virtual robot runs. Press the start button at the robot."
TRIAL_ANSWERS = {
    "moved": "The robot is not where the trial began. Move it there, then repeat the trial.",
    "no_plan": "In this trial nothing moved: press Delete trial, then Begin trial."}
_IDLE = ("waiting", "pedal_up", "teleoperating", "stopped", "paused")  # neither a trial nor a simulation
NOT_NOW = {  # request: (modes, its answer in these)
    "end-simulation": (_IDLE, "The model does not move alone: there is nothing to end."),
    "repeat-trial": (("trial", "trial_held"), "Release the pedal and press End trial first."),
    **dict.fromkeys(("end-trial", "discard-trial"), (_IDLE, "There is no trial: press Begin trial first."))}

PROBLEMS = {  # of the trainer's states
    "physics loop": "This computer is too slow for the simulation.", "haptic loop": "This computer is too slow for the forces.",
    "queues": "Data was lost inside the trainer.", "real time": "Motion may be uneven: the programs have no real-time priority.",
    "master to daemon link": "The motion of the hands does not arrive as it should.",
    "master left": "The left hand device does not work as it should.", "master right": "The right hand device does not work as it should.",
    "crtk": "Commands of a CRTK client do not arrive, or an arm has a fault.",
    "pedals to daemon link": "The pedals do not arrive as they should.", "robot": "The robot does not answer as it should.",
    "robot to daemon link": "The robot's data does not arrive as it should.", "daemon to robot link": "The robot does not get all motion.",
    "forces to console": "The hands do not get all forces.", "recorder": "The session is not recorded completely.",
    "live picture": "The picture is smaller or slower than it should be.", "real camera": "No picture comes from the real camera."}
ADVICE = {
    "physics loop": "Close other programs on this computer.", "haptic loop": "Close other programs on this computer.",
    "real time": "Start the station as root, or type scripts/doctor.",
    "master to daemon link": "Check that the hand device, its driver or the page that drives is connected.",
    "pedals to daemon link": "Check the pedals and their driver.",
    "robot to daemon link": "Check the robot's computer and the network.", "robot": "Switch the robot on, or press Stop and next attempt.",
    "daemon to robot link": "Check the robot's computer and the network.", "forces to console": "Check the console.",
    "recorder": "Free disk space, or record to a faster disk.", "queues": "Close other programs on this computer.",
    "live picture": "Close other programs on this computer.", "crtk": "Check the client.",
    "master left": "Check the device and its driver.", "master right": "Check the device and its driver.",
    "real camera": "Check the camera and its driver."}


CAUSES = [  # name of a state, a part of its message, sentences: used instead of PROBLEMS and ADVICE
    ("live picture", "failed", "There is no picture. The reason is in station_logs/simulator.log."),
    ("robot", "refuses our", "The robot's program refuses a part of the session. Its own messages say why."),
    ("robot", "version", "The robot's program is of another version. Use the same version on both computers."),
    ("master to daemon link", "packets", "Most packets of the hands are refused: they do not have the form that this session expects.")]


def severity(classes):
    """Of a hazard, by the classes of the hazard analysis (doc/hazards.md)."""
    found = [_SEVERITY.get(name, "low") for name in classes]
    return min(found, key=SEVERITIES.index) if found else "none"


def _name(value):
    """YAML 1.1 reads a step named off as false."""
    return {False: "off", True: "on"}.get(value, str(value)).replace("_", " ")


def steps(exercise):
    return [f"{_name(track['name'])}: {_name(step['name'])}" for track in exercise.get("tracks", [])
            for step in track.get("steps", [])]


def is_demonstration(driver):
    """Whether a simulated surgeon moves the arms. training.launch adds the link: expert-over-wan."""
    return driver.split("-over-")[0].split(":")[0] in ("expert", "clumsy", "scripted")


def mode(name, engaged=True):
    """@param engaged: the robot gets the surgeon's motion."""
    texts = MODES if engaged else {**MODES, **DISENGAGED}
    return texts.get(name, name.replace("_", " "))


def robot(message):
    """Of its status on /diagnostics, which begins with the run level."""
    return next((text for level, text in ROBOT.items() if message.startswith(level)), "The robot is refused.")


def answer(text):
    """The trainer's one word, or its message, as a sentence."""
    return ANSWERS.get(text) or sentence(text or "done")


def clear_refused(mode, pedal, robot_is_stopped):
    """Why the emergency stop was not cleared."""
    if mode != "stopped":
        return "Nothing is stopped."
    return CLEAR_FIRST if pedal else ROBOT_STOPPED if robot_is_stopped else MODEL_STOPPED


def injected(text, is_up):
    return f"{text}; the pedal is up, so it may pass unnoticed" if is_up else text


def sentence(text):
    """With a capital and a full stop."""
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")


def mistake(name):
    return MISTAKES.get(name, name.replace("_", " "))


def exercise(status, failure):
    text = STATUSES.get(status, status)
    return f"{text}: {FAILURES.get(failure, failure.replace('_', ' '))}" if status == "failed" and failure else text


def health(statuses):
    """@param statuses: [(name, level 0 to 3, message)]. @return (level, sentences: green, or the worst and its remedy; the trainer's words)."""
    worst = max(statuses, key=lambda status: status[1], default=None)
    if worst is None:
        return 2, "The trainer does not answer. If this lasts, press Stop session.", ""
    name, level, message = worst
    if level == 0:
        return 0, "Everything works.", ""
    exact = [sentences for state, part, sentences in CAUSES if state == name and part in message]
    usual = " ".join(filter(None, (PROBLEMS.get(name, "Something does not work as it should."), ADVICE.get(name, ""))))
    return level, next(iter(exact), usual), f"{name}: {message}"
