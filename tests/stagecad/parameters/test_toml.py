"""TOML of hostile shape, and messages with hostile content, are one line of bounded length."""

import pytest

from stagecad.parameters.errors import LONGEST, InputError
from stagecad.parameters.load import design_from_text
from stagecad.parameters.toml import load_toml
from workbench.cli import run


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
    with pytest.raises(InputError, match=said):
        load_toml(text, "f.toml")
    with pytest.raises(InputError):
        design_from_text(text, "f.toml")


def test_the_largest_integers_are_read() -> None:
    assert load_toml("a = -9223372036854775808\nb = 9223372036854775807", "f.toml")["a"] == -(2**63)


def test_a_message_is_one_printable_line_of_bounded_length() -> None:
    text = str(InputError("a\x1b[31m\n\tb\u202e" + "x" * 100_000 + " the end"))
    assert text.startswith(r"a\x1b[31m b\u202exxx") and text.endswith("the end")
    assert text.isprintable() and len(text) < LONGEST


@pytest.mark.parametrize("name", ["\x1b]0;owned\x07", "a\nb", "\u202e"])
def test_control_characters_never_reach_the_terminal(
    name: str, capsys: pytest.CaptureFixture[str], tmp_path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stage.toml").write_text(f'extends = "thesis"\n[stage]\nmaterial = {name!r}\n', "utf-8")
    for words in (["check"], ["compare", name], ["calc", name], [name], ["params", "--set", f"stage.{name}=1"]):
        assert run(words) == 2
        said = capsys.readouterr().err
        assert said.endswith("\n") and said[:-1].isprintable()
