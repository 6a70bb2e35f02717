"""Tests the scripts of the trainee's page in Node.js: keys, gamepad, mouse, pedal and force arrows."""

import json
import math
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from station_parts import NO_BROWSER, run_page_script  # noqa: E402


def test_keys_that_the_browser_needs_move_no_arm():
    given = ["ControlLeft", "ControlRight", "AltLeft", "AltRight", "MetaLeft", "OSLeft", "Tab", "Enter", "NumpadEnter", "",
             "KeyK", "Space", "ShiftLeft", "Numpad0", "F2"]
    usable = run_page_script("input.js", f"console.log(JSON.stringify({json.dumps(given)}.map(isUsable)));")
    assert usable == [False] * 10 + [True] * 5
    stored = json.dumps({"pedal": "ControlLeft", "jaw": "KeyK"})
    keys = run_page_script("input.js", f"globalThis.localStorage = {{ getItem: () => {json.dumps(stored)} }};\n"
                                       "console.log(JSON.stringify(loadKeys()));")
    assert keys["pedal"] == "Space" and keys["jaw"] == "KeyK" and keys["arm"] == "KeyX"


@pytest.mark.parametrize("mappings, used, text", [
    (["", "standard"], "pad 1", "Gamepad: pad 1"), (["standard", ""], "pad 0", "Gamepad: pad 0"),
    ([""], None, "Gamepad not used"), ([], None, "")])
def test_a_gamepad_with_a_known_layout_comes_first(mappings, used, text):
    pads = [None, *({"connected": True, "id": f"pad {i}", "mapping": mapping, "axes": [], "buttons": []} for i, mapping in enumerate(mappings))]
    code = (f"Object.defineProperty(globalThis, 'navigator', {{ value: {{ getGamepads: () => {json.dumps(pads)} }}, configurable: true }});\n"
            "globalThis.window = globalThis; globalThis.addEventListener = () => {};\n"
            "const hands = new Hands({ addEventListener() {} }, {});\n"
            "const text = hands.gamepad(0.1); console.log(JSON.stringify([hands.pad ? hands.pad.id : null, text]));")
    found, said = run_page_script("input.js", code)
    assert found == used and said.startswith(text) and bool(said) == bool(text)


HANDS = """
const screen = { addEventListener() {} };
globalThis.window = { addEventListener() {} };
globalThis.document = { pointerLockElement: screen };
Object.defineProperty(globalThis, "navigator", { value: { getGamepads: () => [pad] }, configurable: true });
const pad = { connected: true, id: "pad", mapping: "standard", axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false, value: 0 })) };
const hands = new Hands(screen, {});
"""


@pytest.mark.parametrize("arm, other, stick, trigger, shoulder", [("gold", "green", 0, 6, 4), ("green", "gold", 2, 7, 5)])
def test_each_side_of_a_gamepad_moves_its_arm_alone(arm, other, stick, trigger, shoulder):
    """doc/station.md. A stick that is pushed away has a negative value in the browser's standard layout."""
    sent = run_page_script("input.js", HANDS + f"""
      pad.axes[{stick}] = 0.5; pad.axes[{stick} + 1] = -0.8; pad.buttons[{trigger}].value = 1; pad.buttons[{shoulder}].pressed = true;
      hands.gamepad(0.1); console.log(JSON.stringify(hands.take(0.1)));""")
    assert sent["pedal"] is True
    assert sent["arms"][arm]["move"] == pytest.approx([0.0125, 0.02, 0.0]) and sent["arms"][arm]["jaw"] == 0, "0.25 m/s at the stick's end"
    assert sent["arms"][other]["move"] == [0, 0, 0] and sent["arms"][other]["jaw"] > 0.5


@pytest.mark.parametrize("button, arm, other, up", [(12, "gold", "green", 1), (13, "gold", "green", -1), (3, "green", "gold", 1), (0, "green", "gold", -1)])
def test_buttons_of_a_gamepad_move_their_arm_up_and_down(button, arm, other, up):
    sent = run_page_script("input.js", HANDS + f"pad.buttons[{button}].pressed = true; hands.gamepad(0.1); console.log(JSON.stringify(hands.take(0.1)));")
    assert sent["arms"][arm]["move"] == pytest.approx([0, 0, 0.025 * up]) and sent["arms"][other]["move"] == pytest.approx([0, 0, 0])


@pytest.mark.parametrize("arm, other", [("gold", "green"), ("green", "gold")])
def test_mouse_and_its_left_button_are_of_the_chosen_arm_alone(arm, other):
    sent = run_page_script("input.js", HANDS + f"""
      hands.arm = "{arm}"; hands.button({{ button: 0 }}, true); hands.mouse({{ movementX: 5, movementY: 0 }});
      console.log(JSON.stringify(hands.take(0.1)));""")
    assert sent["arms"][arm]["jaw"] == 0 and sent["arms"][arm]["move"] == pytest.approx([0.005, 0, 0])
    assert sent["arms"][other]["jaw"] > 0.5 and sent["arms"][other]["move"] == [0, 0, 0]


@pytest.mark.parametrize("does, what, goes", [
    ("hands.mouse({ movementX: 5, movementY: 0 })", "move", [0, 0.005, 0]), ("hands.mouse({ movementX: 0, movementY: -5 })", "move", [0, 0, 0.005]),
    ("hands.wheel({ deltaY: -100, preventDefault() {} })", "move", [-0.012, 0, 0]),
    ("hands.turning = true; hands.mouse({ movementX: 5, movementY: 0 })", "turn", [0, 0, -0.02]),
    ("hands.turning = true; hands.mouse({ movementX: 0, movementY: -5 })", "turn", [0, 0.02, 0]),
    ("hands.turning = true; hands.wheel({ deltaY: -100, preventDefault() {} })", "turn", [-0.12, 0, 0]),
    ("hands.held.add('roll_right')", "turn", [-0.15, 0, 0]), ("hands.held.add('roll_left')", "turn", [0.15, 0, 0]),
    ("hands.speed = 2; hands.mouse({ movementX: 5, movementY: 0 })", "move", [0, 0.01, 0]), ("pad.axes[0] = 0.1; hands.gamepad(0.1)", "move", [0, 0, 0]),
    ("pad.axes[1] = -1; hands.gamepad(0.1)", "move", [-0.025, 0, 0]),
    ("hands.camera = true; hands.mouse({ movementX: 5, movementY: -5 })", "move", [0.005, 0, 0.005]),
    ("hands.camera = true; pad.axes[0] = 1; hands.gamepad(0.1)", "move", [0.025, 0, 0]),
    ("hands.look(null); hands.mouse({ movementX: 5, movementY: 0 })", "move", [0.005, 0, 0])])
def test_motion_follows_the_picture(does, what, goes):
    """The camera looks at the scene from the right: what is right in the picture is forward. The camera itself moves as if held."""
    sent = run_page_script("input.js", HANDS + f"""
      hands.look([[0, 1, 0], [0, 0, 1], [-1, 0, 0]]); {does};
      console.log(JSON.stringify(hands.take(0.1)));""")
    assert sent["arms"]["gold"][what] == pytest.approx(goes, abs=1e-12)


@pytest.mark.parametrize("held, chosen", [("gold", "green"), ("green", "gold")])
def test_the_left_button_opens_the_jaws_that_it_has_closed(held, chosen):
    """Even if the other arm is chosen meanwhile, whose jaws hold something."""
    jaws = run_page_script("input.js", HANDS + f"""
      hands.jaws.{chosen} = 0; hands.arm = "{held}"; hands.button({{ button: 0 }}, true);
      hands.arm = "{chosen}"; hands.button({{ button: 0 }}, false); console.log(JSON.stringify(hands.jaws));""")
    assert jaws[held] > 0.5 and jaws[chosen] == 0


# The trainee's page also needs a window, a lock of the mouse, sounds, and a clock, which `tick` moves.
OF_A_TRAINEE = """
let tick, tones = 0;
globalThis.Worker = class { set onmessage(run) { tick = run; } };
globalThis.window = Object.assign(new Node(), { isSecureContext: true });
globalThis.localStorage = { getItem: () => null };
globalThis.AudioContext = class {
  currentTime = 0;
  state = "running";
  async resume() {}
  createOscillator() { tones += 1; return { frequency: {}, connect: (node) => node, start() {}, stop() {} }; }
  createGain() { return { gain: {}, connect: (node) => node }; }
};
Object.defineProperty(globalThis, "navigator", { value: { getGamepads: () => [] }, configurable: true });
Object.assign(document, { hasFocus: () => true, pointerLockElement: null,
  exitPointerLock() { document.pointerLockElement = null; document.fire("pointerlockchange"); } });
let now = 1000;
Object.defineProperty(globalThis, "performance", { value: { now: () => now } });
element("gamepad").textContent = "No gamepad.";
for (const id of ["banner", "push-gold", "push-green"]) element(id).hidden = true;
"""
DRIVES = """
link.socket.onopen();
hear({ t: "hello", number: 7 });
hear({ t: "library", steps: {}, tracks: {} });
hear({ ...idle, phase: "running", choice: { driver: "browser" }, drives: 7 });
document.pointerLockElement = element("screen");
const pedal = (isDown) => window.heard[isDown ? "keydown" : "keyup"].forEach((run) => run({ code: "Space", preventDefault() {}, stopImmediatePropagation() {} }));
const later = (ms) => { now += ms; tick(); };
document.fire("click");
"""


def run_trainees_page(code):
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    modules = [(ROOT / "scripts/raven2_station/page" / name).read_text(encoding="utf-8") for name in ("link.js", "input.js", "trainee.js")]
    page = re.sub(r"(?m)^import .*$|^export ", "", "".join(modules))
    done = subprocess.run(["node", "--input-type=module"], input=NO_BROWSER.replace("asked", "requests") + OF_A_TRAINEE + page + DRIVES + code, capture_output=True, text=True,
                          check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_ticks_that_come_in_a_bunch_are_one_message_of_the_hands():
    sent = run_trainees_page("""
      pedal(true); requests.length = 0;
      later(16); tick(); tick(); later(16);
      console.log(JSON.stringify(requests.filter((a) => a.do === "hands").map((a) => a.with.pedal)));""")
    assert sent == [True, True]


@pytest.mark.parametrize("ends", ["link.socket.onclose();", 'hear({ ...idle, phase: "running", choice: { driver: "browser" }, hands_away: true });'])
def test_a_page_that_lost_the_hands_shows_no_pedal_and_gives_the_mouse_back(ends):
    shown = run_trainees_page(f"""
      hear({{ t: "mode", mode: "teleoperating", pedal: true, text: "The hands move the robot" }});
      pedal(true); later(16);
      const before = element("pedal").dataset.down;
      {ends}
      pedal(true); later(16);
      console.log(JSON.stringify([before, element("pedal").dataset.down, document.pointerLockElement, element("mode").textContent,
        element("drive").textContent, element("picture-note").textContent]));
      process.exit(0);""")
    is_cut = "onclose" in ends
    assert shown == ["yes", "no", None, "No connection" if is_cut else "The hands move the robot", "Take the hands",
                     "No connection to the station." if is_cut else "No picture comes from the trainer."]


@pytest.mark.parametrize("key, field", [("Space", "pedal"), ("KeyC", "camera")])
def test_a_key_that_was_held_as_the_page_lost_its_focus_is_up(key, field):
    """Its keyup goes to another window."""
    sent = run_trainees_page(f"""
      window.heard.keydown.forEach((run) => run({{ code: "{key}", preventDefault() {{}}, stopImmediatePropagation() {{}} }})); later(16);
      const before = requests.filter((a) => a.do === "hands").at(-1).with.{field};
      window.fire("blur"); requests.length = 0; later(16); later(16);
      console.log(JSON.stringify([before, requests.filter((a) => a.do === "hands").map((a) => a.with.{field}), hands.held.size]));""")
    assert sent == [True, [False, False], 0]


def test_a_page_that_heard_nothing_for_a_moment_goes_on_as_the_station_says():
    """For the station it is still the page that drives, and the station says so."""
    shown = run_trainees_page("""
      const state = { ...idle, phase: "running", choice: { driver: "browser" }, drives: 7 };
      link.isSilent = true; link.onOpen(false);
      const without = [drives, element("mode").textContent];
      requests.length = 0; hear({ t: "alive", level: 0, text: "" });
      const asks = requests.some((r) => r.do === "watch");
      hear({ t: "mode", mode: "pedal_up", pedal: false, text: "Ready: press the pedal" }); hear(state);
      console.log(JSON.stringify([without, asks, drives, element("mode").textContent, element("drive").textContent]));""")
    assert shown == [[False, "No connection"], True, True, "Ready: press the pedal", "Give the hands back"]


@pytest.mark.parametrize("arm, push, angle", [
    ("gold", [1, 0, 0], -90), ("gold", [0, 0, 1], 0), ("gold", [-1, 0, 0], 90), ("gold", [0, 0, -1], 180),
    ("green", [1, 0, 0], -90), ("green", [0, 0, 1], 180), ("green", [-1, 0, 0], 90), ("green", [0, 0, -1], 0)])
def test_an_arrow_points_where_the_hand_is_pushed(arm, push, angle):
    """core/frames.h: gold x up, z right; green x up, z left. In CSS a positive angle turns clockwise from the right."""
    turned, is_forced = run_trainees_page(f"""
      const rest = {{ gold: [0, 0, 0], green: [0, 0, 0] }};
      hear({{ t: "strips", force: {{ gold: 0, green: 0, {arm}: 2 }}, push: {{ ...rest, {arm}: {push} }} }});
      console.log(JSON.stringify([element("push-{arm}").style.transform, element("screen").classes.has("forced")]));""")
    found = math.degrees(float(re.search(r"rotate\((.*?)rad", turned)[1]))
    assert (found - angle) % 360 == pytest.approx(0, abs=1e-6) and is_forced


@pytest.mark.parametrize("newtons, sound, arrow, tones", [(0.49, True, False, 0), (0.5, True, True, 1), (2.0, False, True, 0)])
def test_a_force_shows_from_half_a_newton_and_sounds_unless_muted(newtons, sound, arrow, tones):
    found = run_trainees_page(f"""
      element("sound").checked = {json.dumps(sound)};
      hear({{ t: "strips", force: {{ gold: {newtons}, green: 0 }}, push: {{ gold: [{newtons}, 0, 0], green: [0, 0, 0] }} }});
      console.log(JSON.stringify([!element("push-gold").hidden, !element("push-green").hidden, element("screen").classes.has("forced"), tones]));""")
    assert found == [arrow, False, arrow, tones]


@pytest.mark.parametrize("mode, banner", [("stopped", "STOPPED"), ("paused", "PAUSED"), ("teleoperating", None)])
def test_stopped_and_paused_cover_the_pictures_edge(mode, banner):
    found = run_trainees_page(f"""
      hear({{ t: "mode", mode: "{mode}", pedal: false, text: "" }});
      console.log(JSON.stringify([element("banner").hidden ? null : element("banner").textContent, tones]));""")
    assert found == [banner, 1 if banner else 0]
