"""Processes of a benchmark."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from stagecad.processes import end_with_parent


def process_pool(jobs: int) -> ProcessPoolExecutor:
    """A pool of new processes, which end with this one, however it ends."""
    return ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=end_with_parent)
