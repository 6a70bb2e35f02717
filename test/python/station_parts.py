"""Helpers for the tests of the station's parts: a good choice, a supervisor with substitute programs, and page scripts in Node.js."""

import json
import pathlib
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import supervisor  # noqa: E402

GOOD = {"trainee": "ann", "exercise": "pick_hand_over_place", "hazard": "own", "driver": "expert", "link": "net_delay_2"}

PROGRAM = """#!/bin/sh
while [ $# -gt 0 ]; do [ "$1" = --output ] && mkdir -p "$2" && touch "$2/session.rlog"; shift; done
exec sleep 60
"""


def supervised(folder, known, program):
    """A supervisor whose programs are all `program`; the daemon's begins a log."""
    (folder / "programs").mkdir(parents=True)
    for name in ("virtual_raven", "master_console", "simulator"):
        (folder / "programs" / name).write_text(program)
        (folder / "programs" / name).chmod(0o755)
    return supervisor.Supervisor(folder / "programs", folder / "sessions", known, lambda: None, lambda trainee, stages: ([], 0))


def run_page_script(name, code):
    """A page's module and `code` in node. @return what it prints, read as JSON."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    module = (ROOT / "scripts/raven2_station/page" / name).read_text(encoding="utf-8")
    done = subprocess.run(["node", "--input-type=module"], input=module + code, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


# A browser that shows nothing: elements keep what they are given. Requests of the page go to `asked`.
NO_BROWSER = """
const elements = new Map();
class Node {
  constructor() {
    Object.assign(this, { value: "", textContent: "", className: "", hidden: false, checked: true, dataset: {}, style: {}, children: [], heard: {} });
    this.classes = new Set();
    this.classList = { toggle: (name, isOn) => this.classes[isOn ? "add" : "delete"](name), remove: (name) => this.classes.delete(name) };
  }
  get options() { return this.children.flatMap((child) => (child.children.length ? child.children : [child])); }
  addEventListener(what, run) { (this.heard[what] = this.heard[what] || []).push(run); }
  fire(what) { for (const run of this.heard[what] || []) run({ preventDefault() {} }); }
  focus() {}
  replaceChildren(...children) {
    this.children = children.filter(Boolean);
    if (!this.options.some((option) => option.value === this.value)) this.value = this.options[0]?.value ?? "";
  }
  append(...children) { this.children.push(...children); }
  setAttribute() {}
  getContext() { return {}; }
}
const element = (id) => { if (!elements.has(id)) elements.set(id, new Node()); return elements.get(id); };
const asked = [];
class WebSocket {
  static OPEN = 1;
  constructor() { this.readyState = 1; this.bufferedAmount = 0; }
  send(text) { asked.push(JSON.parse(text)); }
}
Object.assign(globalThis, { Node, WebSocket, location: { protocol: "http:", host: "" }, setInterval() {}, document: Object.assign(new Node(), {
  getElementById: element, createElement: () => new Node() }) });
const hear = (message) => link.socket.onmessage({ data: JSON.stringify(message) });
const answers = async (id, more) => { hear({ t: "reply", id, ok: true, text: "", more }); await new Promise((resolve) => setTimeout(resolve)); };
const idle = { t: "station", phase: "idle", trouble: "", session: null, replay: false, choice: null, last: null, drives: null,
  hands_away: false, foreign: false };
"""
