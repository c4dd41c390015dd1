"""The wheel as a user has it: installed beside its dependencies, without the source, in an empty folder."""

import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from stagecad import __version__
from tests.docs.scripts import script

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("wheel")]

ROOT = Path(__file__).parents[2]
NOT_SOURCE = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the programs of an environment with the wheel and the dependencies that are installed here."""
    made = tmp_path_factory.mktemp("wheel")
    source = shutil.copytree(ROOT, made / "source", ignore=NOT_SOURCE)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    built = subprocess.run([*pip, "wheel", "--no-deps", "-w", made, source], capture_output=True, text=True)
    if "Could not find a version that satisfies the requirement setuptools" in built.stderr:
        pytest.skip("no setuptools to build with")
    assert built.returncode == 0, built.stderr
    shutil.rmtree(source)
    environment = made / "environment"
    venv.create(environment, symlinks=True)
    (packages,) = environment.glob("lib/python*/site-packages")
    # As plain lines: the finder of an editable installation there does not run.
    places = [place for place in sys.path if Path(place).name == "site-packages"]
    (packages / "dependencies.pth").write_text("\n".join(places) + "\n", "utf-8")
    (wheel,) = made.glob("stagecad-*.whl")
    target = ["--python", environment / "bin" / "python"]
    subprocess.run([*pip, *target, "install", "--no-deps", "--force-reinstall", wheel], check=True, capture_output=True)
    return environment / "bin"


def _printed(programs: Path, folder: Path, *words: str) -> str:
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run([programs / words[0], *words[1:]], cwd=folder, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_program_is_that_of_the_wheel_and_has_its_examples(programs: Path, tmp_path: Path) -> None:
    file = _printed(programs, tmp_path, "python", "-c", "import stagecad; print(stagecad.__file__)")
    assert Path(file.strip()).is_relative_to(programs.parent)
    assert __version__ in _printed(programs, tmp_path, "stagecad", "--version")
    _printed(programs, tmp_path, "stagecad", "new", "example", "own_rig")
    assert (tmp_path / "own_rig" / "experiment.toml").is_file()
    _printed(programs, tmp_path, "stagecad", "look", "own_rig")


def test_the_documentation_is_built_from_the_wheel(programs: Path, tmp_path: Path) -> None:
    _printed(programs, tmp_path, "stagecad", "docs", "--no-serve")
    assert "stagecad" in (tmp_path / "build" / "docs" / "html" / "index.html").read_text("utf-8")


def test_the_tutorial_works_in_an_empty_folder(programs: Path, tmp_path: Path, monkeypatch) -> None:
    # The commands of a page are those beside the Python that runs them.
    monkeypatch.setattr(sys, "executable", str(programs / "python"))
    monkeypatch.delenv("PYTHONPATH", raising=False)
    text = (ROOT / "docs" / "tutorial.md").read_text("utf-8")
    assert script("refresh").refreshed(text, tmp_path) == text
