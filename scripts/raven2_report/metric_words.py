"""The metrics of score.json in a surgeon's words: title, what it is, and what to do about it. doc/scores.md."""

from raven2_report.text import is_number, number, times


class Words:
    """Of one metric. `said`: a headline for a count, with {times} in it; `advice`: what would make it better."""

    def __init__(self, title, meaning, advice, digits=1, said=""):
        self.title, self.meaning, self.advice, self.digits, self.said = title, meaning, advice, digits, said


ANSWER = Words("Answer to the hazard", "from the cue to the answer that was right", "", 2)  # a curve, and no metric
WORDS = {
    "time": Words("Time", "from the exercise's beginning to its end, without pauses and right answers to hazards",
                  "Plan the next grip while the hand still moves; do without detours."),
    "path": Words("Path length", "that both tool tips travelled together",
                  "Take straighter paths and fewer corrections."),
    "economy": Words("Economy of path", "planned length divided by the length travelled, of all that was carried; "
                     "1 is as short as the planner's path", "Take the shortest free path.", 2),
    "off_path": Words("Distance from the planned path, mean", "of the tip, while something was carried",
                      "Keep to the path that is shown."),
    "off_path_p95": Words("Distance from the planned path, 95 %", "19 of 20 samples were nearer than this",
                          "Keep to the path that is shown."),
    "idle": Words("At rest", "share of the time in which both tips moved by less than 1 mm/s",
                  "Decide on the next move before the last is over.", 2),
    "mean_jerk": Words("Jerk", "how abruptly the tips' speed changed",
                       "Begin and end movements gently.", 2),
    "sparc": Words("Smoothness (SPARC)", "evenness of the tips' motion; nearer to 0 is smoother",
                   "Move in few, whole strokes instead of many small ones.", 2),
    "stroke_sparc": Words("Smoothness of a stroke (SPARC)", "SPARC of each single movement; the median",
                          "Let each movement be one stroke.", 2),
    "ldlj": Words("Smoothness (LDLJ)", "jerk, whatever the pace; greater is smoother",
                  "Begin and end movements gently.", 2),
    "tremor": Words("Tremor", "of the tips between 6 and 14 Hz, root mean square of a second, the median of all",
                    "Rest the forearms; loosen the grip.", 0),
    "collisions": Words("Collisions", "touches of tools with towers, dome or each other that the exercise counts",
                        "Keep the shafts in view; give towers and dome a wider berth.", 0, "tools collided {times}"),
    "collision_time": Words("Time in collision", "of tools with all that is fixed and with each other",
                            "Back off at the first touch."),
    "wire_touches": Words("Wire touches", "of tools or objects with the wires",
                          "Slow down near the wires; turn the object along the wire before moving on.", 0,
                          "wires touched {times}"),
    "wire_time": Words("Time at the wires", "in which a tool or an object touched a wire",
                       "Back off at the first touch."),
    "drops": Words("Drops", "objects let go where they do not belong",
                   "Close the jaws fully, and wait for the other hand's grip before letting go.", 0, "dropped {times}"),
    "break_offs": Words("Broken off", "towers torn off their feet", "Lift straight up; do not pull sideways.", 0,
                        "a tower broken off {times}"),
    "out_of_order": Words("Out of order", "steps done too early", "Go by the exercise's order of steps.", 0,
                          "steps out of order {times}"),
    "wrong_arm": Words("Wrong arm", "objects taken by the arm that should not have",
                       "Take it with the arm that is asked for.",
                       0, "the wrong arm used {times}"),
    "peak_force": Words("Greatest force", "of the tools on what is fixed and on each other",
                        "Touch more gently; stop when something gives resistance."),
    "force_p95": Words("Force, 95 %", "19 of 20 moments with a force had less than this", "Touch more gently.", 2),
    "force_impulse": Words("Force by time", "the force added up over time", "Touch more gently and more briefly."),
    "force_above": Words("Time above the force limit", "in which the tools pressed harder than the limit",
                         "Back off as soon as the tool is loaded.", 2),
    "out_of_view": Words("Out of view", "time with a tool's tip outside the camera's picture",
                         "Move the camera before the tool leaves the picture."),
    "clutches": Words("Clutches", "pedal released and pressed again to bring the hand back",
                      "Use the whole reach of the hand before clutching.", 0, "clutched {times}"),
    "clutch_time": Words("Time clutching", "with the pedal up between two presses", "Bring the hand back quickly."),
    "engaged": Words("Pedal down", "share of the time", "Keep the pedal down while working.", 2),
    "camera_moves": Words("Camera moves", "presses of the camera's pedal", "Move the camera once, and far enough.", 0,
                          "camera moved {times}"),
    "camera_time": Words("Time moving the camera", "with the camera's pedal down",
                         "Move the camera once, and far enough."),
    "master_radius": Words("Reach of the hand", "smallest sphere that contains the hand's path, without clutching",
                           "Clutch before the hand gets to the edge of its reach."),
    "master_deviation": Words("Spread of the hand", "root mean square distance from its mean place",
                              "Clutch before the hand gets to the edge of its reach."),
    "bimanual": Words("Use of both hands", "time in motion of the less active hand divided by that of the other; 1 is both equally long",
                      "Let the resting hand get ready meanwhile.", 2),
    "speed_correlation": Words("Hands together", "whether both tips move: 1 together, 0 independently, -1 in turns",
                               "Let both hands work at the same time.", 2),
    "tracking": Words("Robot behind model", "mean distance of the robot's tip from the model's", "", 2),
}
GROUPS = (("efficiency", "Efficiency", "how directly the work was done"),
          ("safety", "Safety", "what was touched, dropped or pressed"),
          ("control", "Control", "how the hands, the pedal and the camera were used"))
FAILURES = {"time_limit": "the time limit was reached", "broke_off": "something broke off",
            "object_lost": "an object was lost out of reach", "mistakes": "more mistakes than the exercise allows",
            "given_up": "the attempt was given up"}
RESPONSES = {"pedal_up": "released the pedal", "hold_still": "held still", "slow": "slowed down",
             "retreat": "drew back", "stop": "pressed the emergency stop", "push_on": "pushed on"}
ANSWERS = {"pedal_up": "release the pedal", "hold_still": "hold still", "slow": "slow down", "retreat": "draw back",
           "stop": "press the emergency stop", "push_on": "push on"}
VERDICTS = {"right": "answered rightly", "late": "answered rightly, but late", "wrong": "answered wrongly",
            "none": "not answered"}
NOTHING_CAME = "there was nothing to feel or to see in time"
MISTAKES = {"wire_touch": "Wire touched", "collision": "Collision", "drop": "Dropped", "break_off": "Broken off",
            "out_of_order": "Out of order", "wrong_arm": "Wrong arm"}


def response(name):
    """`released the pedal`."""
    return RESPONSES.get(name, str(name).replace("_", " "))


def is_felt(hazard):
    """Whether a force was the cue of a hazard of score.json. Older scores have no `cue`: they judged by the force alone."""
    return is_number(hazard.get("cue_after_ms")) and hazard.get("cue", "force") == "force"


def why_unjudged(hazard):
    """Why a hazard of score.json is not judged; empty: it is judged (doc/scores.md)."""
    if hazard.get("verdict") == "coincidence":  # of older scores
        return "the hands had let go before anybody could react"
    if hazard.get("verdict") != "not_judged":
        return ""
    if not is_number(hazard.get("cue_after_ms")):
        return NOTHING_CAME
    early = hazard.get("coincidences")
    if any(isinstance(r, dict) and r.get("response") == "stop" for r in (early if isinstance(early, list) else [])):
        return "an emergency stop came before anybody could react"
    return "the recording ends, or was paused, before an answer could be seen"


def no_fault(unmerged):
    """Of a session in which no fault is known. unmerged: of Facts."""
    return ("No fault is known. Of a real robot's own faults a session knows only what merge_truth brought in."
            if unmerged else "No fault acted on the robot.")


def words_of(name):
    """Also of a metric that this program does not know."""
    known = ANSWER if name == "hazard_response" else WORDS.get(name)
    return known if known else Words(str(name).replace("_", " ").capitalize(), "", "", 2)


def meaning_of(name, score):
    """Meaning of the metric, with the session's own force limit."""
    limit = score.get("force_limit_N")
    if name == "force_above" and is_number(limit):
        return f"in which the tools pressed harder than {number(float(limit), 1, 'N')}"
    return words_of(name).meaning


def unit_of(metric):
    unit = metric.get("unit") or ""
    return {"-": "", "count": "", "um": "µm", "m/s^3": "m/s³", "Ns": "N s"}.get(unit, unit)


def limit_of(metric):
    """The limit as a text; whole numbers for counts."""
    limit = metric.get("limit")
    if not is_number(limit):
        return None
    if metric.get("unit") == "count":
        return int(limit // 1) if metric.get("better") == "lower" else -int(-limit // 1)
    return limit


def digits_of(name, metric):
    """Enough of them to distinguish the value from a limit that it misses."""
    digits = 1 if metric.get("unit") == "count" else words_of(name).digits
    value, limit = metric.get("value"), metric.get("limit")
    if is_number(value) and is_number(limit) and metric.get("unit") != "count":
        while digits < 6 and value != limit and f"{value:.{digits}f}" == f"{limit:.{digits}f}":
            digits += 1
    return digits


def figure(name, metric, value):
    """A value of that metric with its unit."""
    if not is_number(value):
        return "–"
    if metric.get("unit") == "count" and float(value).is_integer():
        return number(int(value))
    return number(float(value), digits_of(name, metric), unit_of(metric))


def said(name, metric):
    """`wires touched twice (limit 0)`, `time 92.1 s (limit 78.3 s)`."""
    known, limit = words_of(name), limit_of(metric)
    bound = "" if limit is None else f" (limit {figure(name, metric, limit)})"
    value = metric.get("value")
    if known.said and is_number(value):
        return known.said.format(times=times(round(value))) + bound
    return f"{known.title[0].lower()}{known.title[1:]} {figure(name, metric, value)}{bound}"
