"""For all tests of this folder."""
import os

# Our matrices are small. Otherwise each process that loads numpy starts a thread per core, at 0.1 s of processor time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
