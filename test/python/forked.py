"""Runs a script of ours in a separate process, as `/usr/bin/python3 SCRIPT ARGUMENTS` does, but with the modules that
the tests have already loaded: matplotlib alone takes half a second. At least one test of each script starts it plainly.
That test shows that the script finds its modules itself."""
import os
import runpy
import subprocess
import sys
import tempfile
import traceback


def _become(script, arguments, out, err):
    for number, file in ((0, open(os.devnull, "rb")), (1, out), (2, err)):
        os.dup2(file.fileno(), number)
    sys.stdin, sys.stdout, sys.stderr = open(0), open(1, "w"), open(2, "w")  # pytest replaced them
    sys.argv = [script, *arguments]
    sys.path.insert(0, os.path.dirname(os.path.realpath(script)))
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def run(script, *arguments):
    """Returns what subprocess.run() returns, with captured text."""
    arguments = [os.fspath(argument) for argument in arguments]
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        child = os.fork()
        if child == 0:
            code = 1
            try:
                code = _become(os.fspath(script), arguments, out, err)
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code & 0xFF)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        for file in (out, err):
            file.seek(0)
        return subprocess.CompletedProcess([script, *arguments], code, out.read(), err.read())
