"""The documentation: pages in the contents, links that lead somewhere, reference pages of all names and commands."""

import re
import shutil
import threading
import urllib.request
from pathlib import Path

import pytest

import stagecad
from tests.docs.scripts import script
from tests.process_state import PROGRAM, python
from tests.refusals import refused
from workbench.cli.dispatch import COMMANDS
from workbench.cli.dispatch import stagecad as group
from workbench.operations.site import build_site, documentation_server

pytest.importorskip("sphinx")
pytest.importorskip("myst_nb")

DOCS = Path(__file__).resolve().parents[3] / "docs"
conf = script("conf")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site as the command builds it; a link to nowhere ends the command with status 2. Of the whole site: a small
    one with faults is built by another test, and `tests/docs` follows the links and runs the commands of every page."""
    out = tmp_path_factory.mktemp("documentation")
    python(*PROGRAM, "docs", "--no-serve", "--out", out)
    return out / "docs" / "html"


@pytest.mark.slow
def test_every_page_is_linked_and_styled_asks_for_nothing_and_has_every_name(site: Path) -> None:
    first = (site / "index.html").read_text("utf-8")
    pages = [page.relative_to(DOCS) for page in (*DOCS.rglob("*.md"), *DOCS.rglob("*.ipynb"))]
    assert len(pages) > 15
    for page in pages:
        html = page.with_suffix(".html").as_posix()
        assert (site / html).is_file() and (f'href="{html}"' in first or html == "index.html"), html
    asked = re.compile(r'(?:src|<link[^>]*href)="(https?:)?//[^"]*"')
    for page in site.rglob("*.html"):
        assert not asked.search(page.read_text("utf-8")), page.name
    assert "stagecad.png" in (site / "index.html").read_text("utf-8")
    for page in site.glob("*/*.html"):
        assert "overflow-x: auto" in page.read_text("utf-8"), page.name
    page = (site / "reference_python.html").read_text("utf-8")
    for name in stagecad.__all__:
        assert f'id="stagecad.{name}"' in page, name
    for member in ("Experiment.from_dataframes", "Comparison.residuals", "Diagnosis.ranking", "Ladder.plot"):
        assert f'id="stagecad.{member}"' in page, member


def test_what_a_user_looks_up_first_stands_under_how_to_and_tables_of_notebooks_stay_in_their_column() -> None:
    assert {"records", "rig_kinds", "design_changes", "export"} <= set(conf.CONTENTS["How to"])
    context = {"metatags": "<meta>"}
    conf.add_to_head(None, "index", "page.html", context, None)
    assert context["metatags"].startswith("<meta>") and ".output { overflow-x: auto; }" in context["metatags"]
    assert (DOCS / "index.md").read_text("utf-8").index("images/stagecad.png") < 100


def test_reference_pages_of_commands_and_parameters() -> None:
    assert sorted(name for names in conf.GROUPS.values() for name in names) == list(stagecad.__all__)
    page = conf.commands_page(group)
    for name in COMMANDS:
        assert f"\n## stagecad {name}\n" in page
    assert "`--no-solids`" in page or "--solids / --no-solids" in page
    assert "| `stage.thickness` | 12 mm |" in conf.parameters_page()


@pytest.mark.slow
def test_a_link_to_nowhere_and_a_page_that_is_not_there_are_errors(tmp_path: Path) -> None:
    root = tmp_path / "root"
    for folder in ("docs", "examples"):
        (root / folder).mkdir(parents=True)
        (root / folder / "README.md").write_text("# Examples\n", "utf-8")
    (root / "README.md").write_text("# Program\n", "utf-8")
    (root / "docs" / "index.md").write_text("# Documentation\n\nSee [this](#nowhere).\n", "utf-8")
    shutil.copyfile(DOCS / "conf.py", root / "docs" / "conf.py")
    refused("faults in", build_site, tmp_path / "out", root)
    log = (tmp_path / "out" / "warnings.txt").read_text("utf-8")
    assert "nowhere" in log and "tutorial" in log


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
    assert conf.site_links(text) == link


def test_the_server_answers_on_this_machine_alone(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("stagecad")
    with documentation_server(tmp_path, 0) as server:
        assert server.server_address[0] == "127.0.0.1"
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        with urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}/index.html") as answer:
            assert b"stagecad" in answer.read()
        refused("choose another", documentation_server, tmp_path, server.server_port)
        server.shutdown()
        thread.join()
