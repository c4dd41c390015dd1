"""Benchmarks. Linear algebra has one thread, as in the commands of the program."""

import os

from stagecad.blas_threads import use_one_thread

use_one_thread(os.environ)
