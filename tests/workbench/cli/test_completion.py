"""Completion of commands, as a shell asks for it."""

import os
import subprocess
import sys


def _asked(instruction: str, line: str = "") -> subprocess.CompletedProcess[str]:
    words = {"_STAGECAD_COMPLETE": f"bash_{instruction}", "COMP_WORDS": line, "COMP_CWORD": "1"}
    # The name of the variable follows from that of the program.
    program = "import sys; from workbench.cli.main import main; sys.argv[0] = 'stagecad'; sys.exit(main())"
    return subprocess.run([sys.executable, "-c", program], env={**os.environ, **words}, capture_output=True, text=True)


def test_a_word_is_completed_without_a_message() -> None:
    done = _asked("complete", "stagecad dia")
    assert done.stdout.split() == ["plain,diagnose"] and done.stderr == "" and done.returncode == 0
    script = _asked("source")
    assert "stagecad" in script.stdout and script.stderr == ""
