"""Sessions of the real programs, with threads and sockets, are simulated again from their logs."""

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time

from stack import PROGRAMS, ROOT, Stack, await_run_level, effort

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402

SECONDS = effort(4, 60)
PEDAL_DOWN = 3
LEAST_SPEED = 5.0  # x real time


def resimulate(session, *arguments):
    """(exit code, output, CPU seconds)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([os.path.join(PROGRAMS, "resimulate"), session, *arguments], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=300, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode, done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start(stack, *arguments):
    """Starts robot, daemon and console. Returns when the surgeon's pedal is down."""
    stack.start_robot()
    stack.start_daemon(*arguments)
    stack.start_console()
    await_run_level(stack.state_port, PEDAL_DOWN)


def test_a_session_of_real_threads_gives_the_same_bits_again_faster_than_it_went():
    # The hazard comes soon. The next pedal-down also comes soon: it ends the pause that SIGSTOP causes.
    soon = {"faults/sudden_jump": lambda s: s["faults"][0]["start"].update(first_tick=effort(500, 8000)),
            "console": {"clutch_every": effort(1.0, 7.0)}}
    with Stack(configure=soon) as stack:
        start(stack, "--duration", SECONDS, "--hazard", "sudden_jump")
        daemon = stack.processes["simulator"]
        time.sleep(1.0)
        daemon.send_signal(signal.SIGSTOP)  # over 250 ms late, the daemon gives up simulated time and logs it
        time.sleep(0.4)
        daemon.send_signal(signal.SIGCONT)
        assert daemon.wait(SECONDS + 60) == 0, stack.log_text("simulator")
        assert stack.metrics()["timing"]["physics"]["time_slips"] >= 1
        assert stack.metrics()["records_dropped"] == 0
        assert stack.metrics()["faults"], "the hazard acted"
        stack.stop("master_console")
        received, applied, rejected = map(int, re.search(r"forces: (\d+) received = (\d+) applied \+ (\d+) rejected",
                                                         stack.log_text("master_console")).groups())
        assert received == applied + rejected and 0 < received <= stack.metrics()["packets"]["daemon_to_console"]["sent"]
        log = raven2_session.Session(stack.output).log
        # A time slip of either loop pauses the exercise. Both loops may slip before the same tick.
        slips = [stack.metrics()["timing"][loop]["time_slips"] for loop in ("physics", "haptic")]
        assert max(slips) <= log.ticks["slipped"].sum() <= sum(slips)

        code, output, cpu = resimulate(stack.output)
        ticks = len(log.ticks)
        print(f"{ticks} ticks again in {cpu:.2f} s of CPU: {ticks / 1000 / cpu:.1f} x real time\n{output}")
        assert code == 0 and f"equal: {ticks:,}".replace(",", "") in output, output
        assert "warning" not in output, "the same build"
        known, unknown = map(int, re.search(r"(\d+) forces, and (\d+) of which", output).groups())
        assert known > 0.5 * (known + unknown), output
        assert ticks / 1000 / cpu >= LEAST_SPEED


def test_a_killed_session_is_simulated_again_up_to_its_last_tick():
    with Stack() as stack:
        start(stack, "--hazard", "none")
        time.sleep(0.5)
        stack.stop("simulator", sign=signal.SIGKILL)
        code, output, _ = resimulate(stack.output)
        assert code == 0 and "equal" in output, output


def test_a_changed_configuration_and_another_build_are_named():
    with Stack() as stack:
        done = subprocess.run([os.path.join(PROGRAMS, "simulate"), "--config", stack.config, "--seconds", "0.5",
                               "--homing", "quick", "--output", stack.output], capture_output=True, text=True,
                              check=False)
        assert done.returncode == 0, done.stderr
        with open(os.path.join(stack.output, "meta.json"), encoding="utf-8") as file:
            meta = json.load(file)
        assert {"sources", "compiler", "processor", "libode", "libm"} <= set(meta["build"])
        meta["build"]["libode"] = "libode.so.8 0123456789abcdef"
        with open(os.path.join(stack.output, "meta.json"), "w", encoding="utf-8") as file:
            json.dump(meta, file)
        again = os.path.join(stack.folder, "again")
        code, output, _ = resimulate(stack.output, "--output", again)
        assert code == 0 and "warning: another libode" in output, output
        assert resimulate(again)[0] == 0

        with open(os.path.join(stack.output, "configuration", "config", "model.yaml"), "a", encoding="utf-8") as file:
            file.write("# changed\n")
        code, output, _ = resimulate(stack.output)
        assert code == 1 and "model.yaml (changed)" in output, output
