"""The library of config/faults contains the whole list of published hazards, and doc/hazards.md agrees with the files.

LIST restates the 58 rows of the list independently of the files: names, injections of Alemzadeh et al., SAFECOMP 2015
("Inj. n"), MAUDE reports and how sure their link is. TABLE_1 restates the three rows of Table 1 of Li et al. 2017.
"""

import json
import os
import pathlib
import re
import subprocess

import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
DESCRIBE = ROOT / "scripts/describe_hazards"
FAULT_VARIABLES = (pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) /
                   "devel/lib/raven2_trainer/fault_variables")
needs_program = pytest.mark.skipif(not FAULT_VARIABLES.exists(), reason="fault_variables is not built")

# row: names, injections, MAUDE reports, link
LIST = {
    1: (["jump_shoulder_const_dac"], [], ["1590517"], "table"),
    2: (["surgeon_cmd_clean_sim"], [], ["2120175"], "similar"),
    3: (["net_offset_stuck"], [1], ["2663924"], "table"),
    4: (["net_offset_burst"], [2], ["2120175"], "table"),
    5: (["pedal_stuck_up"], [3], ["3293519"], "table"),
    6: (["pedal_stuck_down"], [4], [], "none"),
    7: (["pedal_chatter"], [5], [], "none"),
    8: (["ik_jpos_garbage"], [6], [], "none"),
    9: (["coupling_garbage"], [7, 8], [], "none"),
    10: (["pd_tau_stuck"], [9], [], "none"),
    11: (["pd_tau_flip"], [10], [], "none"),
    12: (["dac_minus1000"], [11], ["1077464"], "similar"),
    13: (["encoder_dead"], [12], ["2916352"], "similar"),
    14: (["vel_stuck_homing"], [13], ["3093014"], "similar"),
    15: (["vel_flip_homing"], [14, 15], [], "none"),
    16: (["fk_coupling"], [16], [], "none"),
    17: (["fk_vel"], [17], [], "none"),
    18: (["fk_pos"], [18], [], "none"),
    19: (["fk_ori"], [19], [], "none"),
    20: ([f"state_machine_forced_{n}" for n in range(4)], [20, 21, 22, 23], [], "none"),
    21: (["usb_no_board"], [24], ["2663924", "3275500"], "table"),
    22: (["usb_wrong_count"], [25, 26], [], "none"),
    23: (["usb_garbage"], [27], [], "none"),
    24: (["plc_inputs_zero"], [28], [], "none"),
    25: (["plc_inputs_flip"], [29], [], "none"),
    26: (["put_usb_board_count"], [30, 31, 32], [], "none"),
    27: (["put_usb_board_index"], [33], [], "none"),
    28: (["put_usb_cmd_random"], [34], ["1590517", "2120175"], "table"),
    29: (["put_usb_outputs"], [35, 36], [], "none"),
    30: ([f"plc_out_surgeon_mode_{n}" for n in range(2)], [37, 38], [], "none"),
    31: ([f"plc_out_runlevel_{n}" for n in range(4)], [39, 40, 41, 42], [], "none"),
    32: ([f"plc_out_initialized_{n}" for n in range(2)], [43, 44], [], "none"),
    33: (["plc_state_bogus"], [45], [], "none"),
    34: (["attack_distance_add"], [], ["2816230"], "similar"),
    35: (["attack_shoulder_dac"], [], [], "none"),
    36: (["attack_dac_add"], [], [], "none"),
    37: (["packet_skip"], [], ["2663924"], "similar"),
    38: (["packet_delay"], [], [], "none"),
    39: (["sequence_parity_pedal"], [], [], "none"),
    40: (["pos_out_of_range"], [], [], "none"),
    41: (["dac_full_range"], [], [], "none"),
    42: (["net_delay_3"], [], ["3283230"], "similar"),
    43: (["net_delay_2"], [], [], "none"),
    44: (["net_delay_1"], [], [], "none"),
    45: ([f"net_loss_{n}" for n in (10, 30, 50)], [], [], "none"),
    46: ([f"comm_loss_{n}" for n in (10, 30, 50)], [], ["2663924"], "similar"),
    47: (["grasper_runaway"], [], [], "none"),
    48: (["cartesian_offset"], [], [], "none"),
    49: (["wire_hijack"], [], [], "none"),
    50: (["e_stop_flood"], [], [], "none"),
    51: (["intent_scale"], [], [], "none"),
    52: (["intent_reorder_delay"], [], [], "none"),
    53: (["plc_watchdog_stop"], [], ["2916352"], "similar"),
    54: (["master_sluggish"], [], ["3283230"], "table"),
    55: (["instrument_stuck_then_jump"], [], ["1590517"], "table"),
    56: (["guided_exchange_overshoot"], [], ["1961862"], "table"),
    57: (["video_freeze", "video_loss"], [], [], "none"),
    58: (["encoder_pot_mismatch"], [], ["3093014"], "table"),
}
# Table 1 of Li et al. 2017: number, name, site of the injection, MAUDE reports, a word of the right response
TABLE_1 = [
    (1, "unavailable_recoverable", "network_layer", ["3293519"], "restart"),
    (2, "unavailable_permanent", "get_usb_packet", ["2663924", "3275500"], "convert"),
    (3, "sudden_jump", "put_usb_packet", ["1590517", "2120175"], "release the pedal"),
]
# Kinds, triggers and hosts that no scenario of the library uses, and the reason.
UNUSED_KINDS = {
    "none": "is no fault",
    "sign_flip": "no source injected it; for a user's own, as a force of the wrong sign or the wrong eye's picture",
    "duplicate": "the robot drops a repeated packet (raven2.md 1.5): nothing to train",
    "replay": "no row of the list replays",
    "crash": "for tests of containment; the list's crash is that of put_usb_board_count",
    "hang": "for tests of containment; no row of the list names a place where it hung",
}
UNUSED_TRIGGERS = {
    "hand": "the library starts alike in every run; start_hazard arms any of it at a chosen moment",
    "tissue_distance": "depends on the exercise, and the list's rows on none",
    "target_distance": "depends on the exercise, and the list's rows on none",
    "step": "depends on the exercise, and the list's rows on none",
}
UNUSED_HOSTS = {}
MIN_FUNCTIONS, MIN_LOCATIONS = 13, 25  # of Alemzadeh et al., SAFECOMP 2015
JARGON = re.compile(r"_|\b(dac|jpos|mpos|mvel|tau|packets?|ticks?|plc|usb|itp|api|inverse kinematics|sequence)\b", re.I)


@pytest.fixture(scope="module")
def library():
    """Scenarios by name."""
    scenarios = [yaml.safe_load(path.read_text()) for path in (ROOT / "config/faults").glob("*.yaml")]
    return {scenario["name"]: scenario for scenario in scenarios}


@pytest.fixture(scope="module")
def known():
    return json.loads(subprocess.run([FAULT_VARIABLES], check=True, capture_output=True).stdout)


def faults_of(library):
    return [fault for scenario in library.values() for fault in scenario["faults"]]


def injections(source):
    """Numbers of "Inj. 7-8" or "Inj. 9"."""
    found = re.findall(r"Inj\. (\d+)(?:-(\d+))?", source)
    return [n for first, last in found for n in range(int(first), int(last or first) + 1)]


def test_every_row_of_the_list_is_there_and_nothing_else_has_its_numbers(library):
    expected = {number: [name] for number, name, *_ in TABLE_1}
    expected.update({100 + row: names for row, (names, *_) in LIST.items()})
    found = {}
    for name, scenario in library.items():
        if scenario["number"] != 0:  # 0 means that the hazard is not in the list
            found.setdefault(scenario["number"], []).append(name)
    assert {number: sorted(names) for number, names in found.items()} == expected
    assert sorted(LIST) == list(range(1, 59))


def test_every_injection_of_safecomp_is_in_its_rows(library):
    for row, (names, numbers, *_) in LIST.items():
        for name in names:
            assert injections(library[name]["source"]) == numbers, name
    assert sum((numbers for _, numbers, *_ in LIST.values()), []) == list(range(1, 46))
    for _, name, *_ in TABLE_1:
        assert injections(library[name]["source"]) == [], name


def test_reports_are_those_of_the_list_and_links_are_not_made_surer(library):
    for names, _, reports, link in LIST.values():
        for name in names:
            assert (library[name]["maude"], library[name]["maude_link"]) == (reports, link), name


def test_table_1_comes_first_and_says_what_the_paper_says(library):
    first = sorted((s for s in library.values() if s["number"] != 0), key=lambda s: s["number"])[:3]
    assert [s["name"] for s in first] == [name for _, name, *_ in TABLE_1]
    for (_, name, site, reports, response) in TABLE_1:
        scenario = library[name]
        assert [f["site"] for f in scenario["faults"]] == [site]
        assert (scenario["maude"], scenario["maude_link"]) == (reports, "table")
        assert response in scenario["response"].lower(), name


def test_only_events_without_a_published_injection_are_of_our_design(library):
    ours = sorted(name for name, scenario in library.items() if scenario["basis"] == "design" and scenario["number"] != 0)
    assert ours == sorted(name for row in range(54, 59) for name in LIST[row][0])


def test_the_sudden_jump_is_the_papers(library):
    for name, dac in (("sudden_jump", 800), ("jump_shoulder_const_dac", 0)):
        [fault] = library[name]["faults"]
        assert (fault["variable"], fault["kind"], fault["channel"], fault["value"]) == ("dac", "stuck_at", "shoulder", dac)
        assert fault["start"] == {"trigger": "pedal_down", "first_tick": 8000}
        assert (fault["duration_ticks"], fault["period_ticks"]) == (300, 8000)


def test_the_simulator_gets_the_clean_stream(library):
    assert {f["host"] for f in library["surgeon_cmd_clean_sim"]["faults"]} == {"relay"}
    for row in range(42, 47):
        for name in LIST[row][0]:
            assert [(f["host"], f["kind"], f["value"]) for f in library[name]["faults"]] == [("relay", "impair", name)]
    for row in range(3, 8):  # after the robot's own recvfrom
        for name in LIST[row][0]:
            assert [(f["host"], f["site"]) for f in library[name]["faults"]] == [("robot", "network_layer")], name


def test_functions_and_locations_are_at_least_those_of_safecomp(library):
    rows = [f for row in range(3, 34) for name in LIST[row][0] for f in library[name]["faults"]]
    assert len({f["site"] for f in rows}) == MIN_FUNCTIONS
    faults = faults_of(library)
    assert len({f["site"] for f in faults}) >= MIN_FUNCTIONS
    assert len({(f["site"], f["variable"]) for f in faults}) >= MIN_LOCATIONS


@needs_program
@pytest.mark.parametrize("what, unused", [("kinds", UNUSED_KINDS), ("hosts", UNUSED_HOSTS)])
def test_every_kind_and_host_is_used_or_said_to_be_not(library, known, what, unused):
    used = {fault[what[:-1]] for fault in faults_of(library)}
    assert used | set(unused) == set(known[what])
    assert not used & set(unused)


@needs_program
def test_every_trigger_is_used_or_said_to_be_not(library, known):
    used = {fault["start"]["trigger"] for fault in faults_of(library)}
    assert used | set(UNUSED_TRIGGERS) == set(known["triggers"])
    assert not used & set(UNUSED_TRIGGERS)


def test_what_a_clinician_reads_is_in_plain_words(library):
    for name, scenario in library.items():
        for key in ("title", "expected", "response"):
            text = scenario[key]
            assert not JARGON.search(text), f"{name}: {key}: {JARGON.search(text).group()}"
            assert len(text) <= 400, f"{name}: {key}"
        assert scenario["response"].endswith("."), name


def measured():
    """Rows of the table of scripts/measure_hazards in doc/hazards.md: {name: (force [N], robot at the end)}."""
    page = (ROOT / "doc/hazards.md").read_text()
    rows = re.findall(r"(?m)^\| `(\w+)` \|(?: [^|]* \|){4} ([0-9.]+) \| ([^|]*) \|$", page)
    return {name: (float(newton), end) for name, newton, end in rows}


def test_the_page_tells_what_every_scenario_did_here(library):
    assert list(measured()) == sorted(library)


def test_what_the_hand_felt_here_stands_under_what_you_will_feel(library):
    for name, (newton, _) in measured().items():
        if newton > 0.0:
            assert re.search(r"\b(force|push)", library[name]["expected"]), f"{name}: {newton} N are not mentioned"


def test_a_stop_that_came_here_stands_under_what_you_will_see(library):
    for name, (_, end) in measured().items():
        if "E-STOP" in end:
            told = re.search(r"robot (may )?stops?\b|emergency stop|stand still", library[name]["expected"])
            assert told, f"{name}: {end}"


def test_every_file_says_where_its_values_come_from():
    for path in (ROOT / "config/faults").glob("*.yaml"):
        lines = path.read_text().splitlines()
        assert lines[0].startswith("# "), path.name
        for line in lines:
            if re.match(r"\s+(value|low|high|ramp_ticks|start|duration_ticks|period_ticks|half_period_ticks):", line):
                assert "  # " in line, f"{path.name}: {line}"
            assert len(line) <= 120, f"{path.name}: {line}"


@needs_program
@pytest.mark.parametrize("part", ["library", "variables"])
def test_the_page_is_what_the_files_give(part):
    done = subprocess.run([DESCRIBE, "--check", part], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
