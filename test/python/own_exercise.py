"""An exercise for tests. Scripted strokes about the middle of the FRS scene complete its steps."""


def exercise(name, steps, metrics, drill=None):
    """Returns the exercise's file. @param steps (name, arm, dwell [s]): each keeps that arm's tip near the middle for
    the dwell time."""
    lines = "".join(f"      - {{name: {step}, until: [{{tip_near: middle, arm: {arm}, within: 0.3}}], dwell: {dwell}}}\n"
                    for step, arm, dwell in steps)
    return f"""
name: {name}
title: Both hands about the middle
number: 99
source: a test
skills: []
scene: frs_trainer
time_limit: 60.0
begin: {{pedal: down}}
sets: {{}}
tracks:
  - name: both
    steps:
{lines}watch: []
targets: []
metrics: {metrics}
""" + (f"drill: {drill}\n" if drill else "")
