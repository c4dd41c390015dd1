"""The folder that the page works in: its parameter files and experiments, and nothing outside it."""

import os
import posixpath
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError, nearest, require
from stagecad.parameters.input_file import read_input
from workbench.operations.design import Design
from workbench.operations.measurement.experiment import named_files, results_key
from workbench.operations.measurement.new_experiment import record_suffix

EXPERIMENT = "experiment.toml"
DEPTH = 3
"""Folders below the project in which experiments are looked for."""
LONGEST_PATH, LONGEST_NAME = 1000, 255
"""Largest number of characters of a path, and of bytes of a name in it."""
SKIPPED = ("ladder", "node_modules", "sections")

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")


@dataclass(frozen=True)
class Project:
    """What the page may read and write."""

    folder: Path  # of the project; nothing outside it is read or written
    out: Path  # folder of results, in `folder` unless it is absolute
    params: Path | None = None  # the parameter file; None is the packaged design
    trust: bool = False  # whether the code of experiments with effects of their own may be run

    def __post_init__(self) -> None:
        for path in (self.results, self.state, self.state / "jobs", self.state / "machine.json"):
            self.require_own(path)

    def require_own(self, path: Path) -> None:
        """Refuse a place of results that a link leads out of the folder."""
        if not self.out.is_absolute() and not path.resolve().is_relative_to(self.folder.resolve()):
            raise InputError(f"{path}: is a link that leads out of the folder; name the place by --out")

    @property
    def results(self) -> Path:
        """Folder of results: `--out`."""
        return self.folder / self.out

    def results_of(self, experiment: Path) -> Path:
        """Folder of the results of an experiment."""
        return self.results / results_key(self.results, experiment, self.folder)

    @property
    def state(self) -> Path:
        """Folder of jobs and of the state of the page."""
        return self.results / "workbench"

    def stated_design(self) -> Design | None:
        """The design of `--params`, whose values an experiment may state as `"design"`; None: the packaged one."""
        return None if self.params is None else Design(self.params.resolve(), rules=False)

    def inside(self, path: str) -> Path:
        """A path of the project as given by the page."""
        parts = Path(path).parts
        if os.path.isabs(path) or "\\" in path or "\0" in path or any(part.startswith(".") for part in parts):
            raise InputError(f"{path[:200]!r}: a path inside the project is required, like rig/fit.csv")
        if len(path) > LONGEST_PATH or any(len(part.encode()) > LONGEST_NAME for part in parts):
            raise InputError(f"{path[:60]!r}...: is too long for a path")
        target, folder = (self.folder / path).resolve(), self.folder.resolve()
        require(target == folder or folder in target.parents, f"{path!r}: lies outside the project's folder")
        return target

    def experiment_folder(self, name: str) -> Path:
        """Folder of an experiment by its path in the project."""
        folder = self.inside(name)
        if not self.inside(f"{name}/{EXPERIMENT}").is_file():
            raise InputError(f"{name}: no experiment{nearest(name, [one['name'] for one in self.experiments()])}")
        return folder

    def experiment(self, name: str) -> Path:
        """Folder of an experiment all of whose files are in the project, and whose code, if it has any, may be run."""
        folder = self.experiment_folder(name)
        records, code = named_files(folder)
        for file in (*records, "ladder"):
            # A record may be beside the folder of its experiment.
            self.inside(file if os.path.isabs(file) else posixpath.normpath(f"{name}/{file}"))
            inside = (folder / file).resolve().is_relative_to(self.folder.resolve())
            require(inside, f"{name}/{file}: lies outside the project's folder")
        for rung in (folder / "ladder").glob("*"):
            self.inside(f"{name}/ladder/{rung.name}")
        self.require_own(self.results_of(folder))
        if code and not self.trust:
            raise InputError(
                f"{name}/{EXPERIMENT}: [model] custom names Python code; only 'stagecad workbench --trust' runs it"
            )
        return folder

    def experiments(self) -> list[dict[str, Any]]:
        """Experiments in the project, by path."""
        found = []
        for path in self._files(EXPERIMENT):
            folder = path.parent
            rungs = len(list((folder / "ladder").glob("[0-9]*.json")))
            name = folder.relative_to(self.folder).as_posix()
            found.append({"name": name, "rungs": max(rungs - 1, 0), "changed": path.stat().st_mtime})
        return found

    def records(self) -> list[str]:
        """Record files directly in the project's folder, of which an experiment can be made."""
        named = (path for path in sorted(self.folder.glob("*")) if _NAME.fullmatch(path.name))
        return [path.name for path in named if path.is_file() and record_suffix(path.name)]

    @property
    def begins_with(self) -> str:
        """The view of what the folder holds: of experiments or records, else of parameter files; empty without any."""
        if self.experiments() or self.records():
            return "measurement"
        return "machine" if self.params is not None or self.parameter_files() else ""

    def parameter_files(self) -> list[str]:
        """Parameter files directly in the project's folder: TOML with a table of parameters."""
        found = []
        for path in sorted(self.folder.glob("*.toml")):
            if path.name in ("pyproject.toml", EXPERIMENT):
                continue
            try:
                text = read_input(self.inside(path.name)).decode("utf-8", errors="replace")
            except (OSError, InputError):  # a pipe, or a link that leads out of the folder
                continue
            if re.search(r"^\s*(extends\s*=|\[(stage|actuator|friction|bearing_way|teeth|pads|preload)\b)", text, re.M):
                found.append(path.name)
        return found

    def new_parameter_file(self, name: str) -> Path:
        """A parameter file to be written directly in the project's folder, which must not exist."""
        name = plain_name(name.removesuffix(".toml")) + ".toml"
        target = self.inside(name)
        require(not target.exists(), f"{name}: is there already; choose another name")
        return target

    def _files(self, name: str) -> list[Path]:
        found: list[Path] = []
        # Without following links: a project folder may hold anything.
        for root, folders, files in os.walk(self.folder):
            depth = len(Path(root).relative_to(self.folder).parts)
            shown = [one for one in folders if one not in SKIPPED and not one.startswith((".", "_"))]
            state = self.state.resolve()
            folders[:] = sorted(one for one in shown if depth < DEPTH and (Path(root) / one).resolve() != state)
            if name in files and depth > 0:
                found.append(Path(root) / name)
        return found


def plain_name(name: str) -> str:
    """A name of a file or folder: letters, digits, `_`, `-` and `.`."""
    if not _NAME.fullmatch(name) or ".." in name:
        raise InputError(f"{name!r}: a name of letters, digits, '_', '-' and '.' is required, at most 64 long")
    return name
