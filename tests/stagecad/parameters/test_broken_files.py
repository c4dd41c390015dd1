"""Parameter files with one mistake each, TOML of hostile shape, and the line that tells what it is."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from stagecad.parameters.errors import LONGEST, InputError
from stagecad.parameters.file import packaged_text
from stagecad.parameters.input_file import load_toml
from stagecad.parameters.load import design_from_text, load_design
from tests.reference.tables import cases
from tests.refusals import refused
from workbench.cli import run

LENGTH = 'length = {value = "230 mm", tolerance = "X", origin = "assumed: drive surface longer'


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert old in text, f"the packaged file has no {old!r} any more"
        return text.replace(old, new, 1)

    return change


def length(entry: str) -> Callable[[str], str]:
    """The stage's length entry replaced."""
    return lambda text: re.sub(r'(?m)^length = \{value = "230 mm".*$', lambda _: entry, text, count=1)


def head(line: str) -> Callable[[str], str]:
    return lambda text: f"{line}\n{text}"


TABLE = "broken_parameter_files"
BROKEN: list[tuple[str, Callable[[str], str], str]] = [
    *((name, length(entry), line) for name, entry, line in cases(TABLE, "length")),
    *((name, swap(old, new), line) for name, old, new, line in cases(TABLE, "swapped")),
    *((name, head(first), line) for name, first, line in cases(TABLE, "first_line")),
    ("empty file", lambda text: "", r"stage.material is missing"),
    ("table twice", lambda text: text + "\n[stage]\nlength = '1 mm'\n", r"line \d+: '\[stage\]' is given twice"),
]


@pytest.mark.parametrize(("change", "line"), [pytest.param(c, m, id=i) for i, c, m in BROKEN])
def test_one_line_names_file_key_and_what_is_right(change: Callable[[str], str], line: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(change(packaged_text()), "utf-8")
    with pytest.raises(InputError) as caught:
        load_design(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    assert re.search(line, message), message
    assert message.isprintable()


def test_files_that_are_no_text(tmp_path: Path) -> None:
    refused(r"none.toml: no such parameter file", load_design, tmp_path / "none.toml")
    refused(r"is a folder, not a parameter file", load_design, tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"[stage]\nlength = '\xff\xfe'\n")
    refused(r"binary.toml: line 2: not UTF-8", load_design, binary)
    nested = tmp_path / "nested.toml"
    nested.write_text("a = " + "[" * 5000, "utf-8")
    refused(r"nested.toml: ", load_design, nested)


@pytest.mark.parametrize(("override", "line"), cases(TABLE, "overrides"))
def test_bad_overrides(override: str, line: str) -> None:
    with pytest.raises(InputError, match=line) as caught:
        load_design(None, [override])
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = " + "9" * 5000, "has a whole number of thousands of digits"),
        ("[t]\na = " + "9" * 400, "t.a: is a whole number of more than 64 bits"),
        ("[t]\na = 9223372036854775808", "t.a: is a whole number of more than 64 bits"),
        ("a = [[1, 99999999999999999999]]", "a: is a whole number of more than 64 bits"),
        ("[" + "a." * 1200 + "a]\nb = 1", "is nested too deeply"),
        ("a = " + "[" * 5000 + "]" * 5000, "has tables nested too deeply"),
    ],
)
def test_a_document_beyond_the_limits(text: str, said: str) -> None:
    refused(said, load_toml, text, "f.toml")
    with pytest.raises(InputError):
        design_from_text(text, "f.toml")


def test_messages_are_one_bounded_line_and_the_largest_integers_are_read() -> None:
    assert load_toml("a = -9223372036854775808\nb = 9223372036854775807", "f.toml")["a"] == -(2**63)
    text = str(InputError("a\x1b[31m\n\tb\u202e" + "x" * 100_000 + " the end"))
    assert text.startswith(r"a\x1b[31m b\u202exxx") and text.endswith("the end")
    assert text.isprintable() and len(text) < LONGEST


@pytest.mark.parametrize("name", ["\x1b]0;owned\x07", "a\nb", "\u202e"])
def test_control_characters_never_reach_the_terminal(name: str, capsys, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stage.toml").write_text(f'extends = "thesis"\n[stage]\nmaterial = {name!r}\n', "utf-8")
    for words in (["check"], ["compare", name], ["calc", name], [name], ["params", "--set", f"stage.{name}=1"]):
        assert run(words) == 2
        said = capsys.readouterr().err
        assert said.endswith("\n") and said[:-1].isprintable()
