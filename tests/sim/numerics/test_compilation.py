"""Compiled functions: which edits make them anew."""

import os
import subprocess
import sys

INNER = """\
from sim.numerics.compilation import INLINED, compile_function

def _law(x):
    return {factor} * x

law = compile_function(_law, **INLINED)
"""
OUTER = """\
from inner import law
from sim.numerics.compilation import compile_function

def _twice(x):
    return 2.0 * law(x)

twice = compile_function(_twice)
"""


def test_a_function_is_compiled_anew_when_one_that_it_calls_is_edited(tmp_path):
    (tmp_path / "outer.py").write_text(OUTER)
    answers = []
    for factor in (3.0, 5.0):
        (tmp_path / "inner.py").write_text(INNER.format(factor=factor))
        # The same time stamp and size: nothing but the text tells.
        os.utime(tmp_path / "inner.py", (1e9, 1e9))
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(tmp_path), os.getcwd()]),
            "STAGECAD_CACHE": str(tmp_path / "cache"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        run = [sys.executable, "-c", "from outer import twice; print(twice(1.0))"]
        answers.append(float(subprocess.run(run, env=environment, capture_output=True, text=True, check=True).stdout))
    assert answers == [6.0, 10.0]
