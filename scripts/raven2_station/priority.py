"""Motion that arrives late is not smooth: both processes of the station run before ordinary programs, and after real-time threads."""

import os

PRIORITY = 1  # of SCHED_FIFO; the trainer's real-time threads have 70 to 80 (config/runtime.yaml)


def come_first(children_too):
    """This thread, and the threads and programs that it starts from now on only if `children_too`.

    @return empty, or why the system refuses it: everything works, but motion waits for other programs.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | (0 if children_too else os.SCHED_RESET_ON_FORK), os.sched_param(PRIORITY))
        return ""
    except OSError as error:
        return f"SCHED_FIFO {PRIORITY} is refused ({error.strerror}): motion from a page may be uneven while other programs run"
