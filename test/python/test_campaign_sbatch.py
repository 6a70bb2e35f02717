"""scripts/campaign.sbatch, without Slurm: which shard of how many a task makes."""
import os
import pathlib
import subprocess

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "campaign.sbatch"


def task(tmp_path, *arguments, number="2", cpus=None):
    """Runs the script with `echo` in place of run_campaign, to print the arguments."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("SLURM_")}
    environment["RAVEN2_RUN_CAMPAIGN"] = "echo"
    if number is not None:
        environment["SLURM_ARRAY_TASK_ID"] = number
    if cpus:
        environment["SLURM_CPUS_PER_TASK"] = cpus
    done = subprocess.run(["bash", str(SCRIPT), *map(str, arguments)], env=environment, capture_output=True, text=True,
                          check=False, timeout=60, cwd=tmp_path)
    return done.returncode, done.stdout.split(), done.stderr


def test_the_shard_is_the_task_s_of_as_many_as_are_named(tmp_path):
    code, said, _ = task(tmp_path, "safecomp15", 7, tmp_path / "out", 16, cpus="3")
    assert code == 0
    assert said == ["safecomp15", "--seed", "7", "--jobs", "3", "--shard", "2/16", "--resume", "--output",
                    str(tmp_path / "out" / "shard-2")]
    assert (tmp_path / "out").is_dir()


def test_what_is_no_task_of_so_many_shards_is_refused(tmp_path):
    out = tmp_path / "out"
    assert "task 17 of 16 shards" in task(tmp_path, "c", 1, out, 16, number="17")[2]
    assert "3 arguments" in task(tmp_path, "c", 1, out)[2]
    assert 'N is "0"' in task(tmp_path, "c", 1, out, 0)[2]
    assert 'N is "many"' in task(tmp_path, "c", 1, out, "many")[2]
    for number in (None, "0", ""):
        code, said, error = task(tmp_path, "c", 1, out, 16, number=number)
        assert code == 2 and not said and "not a task of a job array" in error
    assert not out.exists()
