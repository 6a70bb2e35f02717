"""The committed URDFs and meshes are what their parametric source gives."""

import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_committed_description_equals_the_generated_one():
    result = subprocess.run([ROOT / "scripts/generate_description", "--check"], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
