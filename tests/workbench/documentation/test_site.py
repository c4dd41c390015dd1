"""The documentation: pages in the contents, links that lead somewhere, reference pages of all names and commands."""

import re
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path

import pytest

import stagecad
from stagecad.parameters.errors import InputError
from workbench.cli.dispatch import COMMANDS
from workbench.cli.dispatch import stagecad as group
from workbench.documentation.site import (
    GROUPS,
    build_site,
    commands_page,
    contents,
    documentation_server,
    parameters_page,
    site_links,
)

pytest.importorskip("sphinx")
pytest.importorskip("myst_nb")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site as the command builds it; a link to nowhere ends the command with status 2."""
    out = tmp_path_factory.mktemp("documentation")
    command = [sys.executable, "-m", "workbench.cli", "docs", "--no-serve", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out / "docs" / "html"


def test_every_page_is_built_and_linked_from_the_first(site: Path) -> None:
    first = (site / "index.html").read_text("utf-8")
    docs = Path(__file__).resolve().parents[3] / "docs"
    pages = [page.relative_to(docs) for page in (*docs.rglob("*.md"), *docs.rglob("*.ipynb"))]
    assert len(pages) > 15
    for page in pages:
        html = page.with_suffix(".html").as_posix()
        assert (site / html).is_file() and (f'href="{html}"' in first or html == "index.html"), html


def test_the_pages_ask_for_nothing_from_outside(site: Path) -> None:
    asked = re.compile(r'(?:src|<link[^>]*href)="(https?:)?//[^"]*"')
    for page in site.rglob("*.html"):
        assert not asked.search(page.read_text("utf-8")), page.name


def test_the_reference_has_every_name_with_its_members(site: Path) -> None:
    assert sorted(name for names in GROUPS.values() for name in names) == list(stagecad.__all__)
    page = (site / "reference_python.html").read_text("utf-8")
    for name in stagecad.__all__:
        assert f'id="stagecad.{name}"' in page, name
    for member in ("Experiment.from_dataframes", "Comparison.residuals", "Diagnosis.ranking", "Ladder.plot"):
        assert f'id="stagecad.{member}"' in page, member


def test_reference_pages_of_commands_and_parameters() -> None:
    page = commands_page(group)
    for name in COMMANDS:
        assert f"\n## stagecad {name}\n" in page
    assert "`--no-solids`" in page or "--solids / --no-solids" in page
    assert "| `stage.thickness` | 12 mm |" in parameters_page()


def test_a_link_to_nowhere_is_an_error(site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    docs = tmp_path / "root" / "docs"
    docs.mkdir(parents=True)
    (tmp_path / "root" / "examples").mkdir()
    (tmp_path / "root" / "examples" / "README.md").write_text("# Examples\n", "utf-8")
    (tmp_path / "root" / "README.md").write_text("# Program\n", "utf-8")
    (docs / "index.md").write_text("# Documentation\n\nSee [this](#nowhere).\n", "utf-8")
    monkeypatch.setattr("workbench.documentation.site.ROOT", tmp_path / "root")
    monkeypatch.setattr("workbench.documentation.site.CONTENTS", {"Start": ("readme", "examples")})
    with pytest.raises(InputError, match="nowhere"):
        build_site(tmp_path / "out", {})
    with pytest.raises(InputError, match="page 'readme' of the contents does not exist"):
        contents(set())


@pytest.mark.parametrize(
    ("text", "link"),
    [
        ("[tutorial](docs/tutorial.md#a)", "[tutorial](tutorial.md#a)"),
        ("[up](../README.md#b)", "[up](readme.md#b)"),
        ("[own](examples/own_effect)", "own (`examples/own_effect`)"),
        ("![p](docs/images/p.png)", "![p](images/p.png)"),
        ("[web](https://example.org)", "[web](https://example.org)"),
    ],
)
def test_links_are_those_of_the_site(text: str, link: str) -> None:
    assert site_links(text) == link


def test_the_server_answers_on_this_machine_alone(site: Path) -> None:
    with documentation_server(site, 0) as server:
        assert server.server_address[0] == "127.0.0.1"
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        with urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/index.html") as answer:
            assert b"stagecad" in answer.read()
        with pytest.raises(InputError, match="choose another"):
            documentation_server(site, server.server_port)
        server.shutdown()
        thread.join()
