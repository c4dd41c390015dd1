"""Run every command that a page shows, and put what it prints under it: python docs/refresh.py [--check] PAGE.md...

A page shows commands in fenced blocks marked `console`: a line `$ COMMAND`, then its output. A block marked
`toml title=FILE` or `python title=FILE` is written to FILE before the commands after it run. All commands of a page run
in one empty folder, in the order of the page. With `--check` nothing is written: differences are printed, and the exit
status is 1 when there are any.
"""

from __future__ import annotations

import argparse
import difflib
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_text

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"^```(?P<kind>console|\w+ title=(?P<file>\S+))\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)


def refreshed(text: str, folder: Path) -> str:
    """The page with the output of its commands as it is now, run in `folder`."""

    def renew(block: re.Match[str]) -> str:
        if block["file"]:
            file = folder / block["file"]
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block["body"], encoding="utf-8")
            return block[0]
        lines = []
        for line in block["body"].splitlines():
            if line.startswith("$ "):
                lines += [line, *output_of(line[2:], folder)]
        return "```console\n" + "\n".join(lines) + "\n```"

    return BLOCK.sub(renew, text)


def output_of(command: str, folder: Path) -> list[str]:
    """Lines that a shell command prints in `folder`, ends of lines trimmed; `examples` stands beside it."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    done = subprocess.run(
        ["bash", "-c", command], cwd=folder, env={**os.environ, "PATH": path}, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, encoding="utf-8", check=False,
    )  # fmt: skip
    if "Traceback (most recent call last)" in done.stdout:
        raise SystemExit(f"a fault of the program, not a page to write down: {command}\n{done.stdout}")
    return [line.rstrip() for line in done.stdout.splitlines()]


def refresh(page: Path) -> tuple[str, str]:
    """The page as it is, and as it should be."""
    text = page.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "examples").symlink_to(ROOT / "examples")
        return text, refreshed(text, folder)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", type=Path, nargs="+")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    status = 0
    for page in given.pages:
        old, new = refresh(page)
        if old == new:
            continue
        if given.check:
            lines = difflib.unified_diff(old.splitlines(), new.splitlines(), f"{page}", f"{page}, now", lineterm="")
            sys.stdout.write("\n".join(lines) + "\n")
            status = 1
        else:
            atomic_write_text(page, new)
    return status


if __name__ == "__main__":
    sys.exit(main())
