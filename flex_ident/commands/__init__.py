"""The command line."""

import os

# Before numpy is loaded: the core works on all cores itself, and the threads of BLAS would only spin beside it.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
