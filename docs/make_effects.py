"""Write effects.md, the page of every effect, from the declarations: python docs/make_effects.py."""

from __future__ import annotations

from pathlib import Path

from sim.effects.catalogue import library
from sim.effects.effect import Effect, Parameter
from stagecad.parameters.atomic import atomic_write_text

PAGE = Path(__file__).parent / "effects.md"
HEAD = """\
# The library of physical effects

Made from the declarations in the folders of `sim/effects/` by `python docs/make_effects.py`; `stagecad effects NAME`
prints the same for one effect, `stagecad effects NAME --json` for a script. A name selects a variant with `:`
(`stribeck:rational`), a measured channel with `@` (`sensor_lag@position`). An effect of your own is declared the same
way: see [the tutorial](tutorial.md#7-an-effect-of-your-own). The figures are drawn by `python
docs/make_effect_figures.py` for one synthetic record, with values at which the effect is clearly visible.

Friction effects act on one friction level: `level = (sum of levels) * (product of factors)`, and one friction state
model turns the level into a force. Forces have the sign of friction: positive where they oppose
positive motion. Units are those of a linear axis; a rotary axis has rad for m, N*m for N, and so on.

| effect | acts on | meaning |
| --- | --- | --- |
"""
TABLE_HEAD = (
    "| parameter | unit | default | bounds | role | meaning | source of default and bounds |",
    "| --- | --- | --- | --- | --- | --- | --- |",
)


def page() -> str:
    """The page as Markdown."""
    effects = list(library().values())
    rows = [f"| [`{e.name}`](#{_anchor(e)}) | {_where(e)} | {_cell(e.meaning)} |\n" for e in effects]
    return HEAD + "".join(rows) + "".join(f"\n{_section(e)}" for e in effects)


def _anchor(effect: Effect) -> str:
    return effect.name.replace("@", "").replace(":", "")


def _where(effect: Effect) -> str:
    return f"{effect.acts_on} (state model)" if effect.friction_state is not None else effect.acts_on


def _section(effect: Effect) -> str:
    lines = [f"## {effect.name}", "", f"{_sentence(effect.meaning)}", ""]
    if effect.equation:
        lines += [f"    {line.strip()}" for line in effect.equation.splitlines()]
        lines.append("")
    if (PAGE.parent / "effects" / f"{effect.name}.svg").is_file():
        lines += [f"![{effect.name} in a measurement](effects/{effect.name}.svg)", ""]
    facts = [
        ("Dissipation", effect.energy),
        ("Signature", _sentence(effect.shows) if effect.shows else ""),
        ("Residual depends on", ", ".join(effect.coordinates)),
        ("Requires", ", ".join(effect.needs)),
        ("Source", effect.source),
    ]
    lines += [f"- {label}: {text}" for label, text in facts if text]
    lines.append("")
    if effect.parameters:
        lines += [*TABLE_HEAD, *[_row(p) for p in effect.parameters], ""]
    for variant in effect.variants:
        lines += [*_variant(variant, effect), ""]
    return "\n".join(lines)


def _variant(variant: Effect, effect: Effect) -> list[str]:
    """A variant: its law, and those of its parameters that differ from the first law's."""
    own = [p for p in variant.parameters if p not in effect.parameters]
    lines = [f"**Variant `{variant.name}`**: {_sentence(variant.meaning)}", ""]
    lines += [*[f"    {line.strip()}" for line in variant.equation.splitlines()], "", f"- Source: {variant.source}"]
    return [*lines, "", *TABLE_HEAD, *[_row(p) for p in own]] if own else lines


def _row(p: Parameter) -> str:
    role = f"{p.role}, held" if p.fixed else p.role
    cells = (f"`{p.name}`", p.unit, f"{p.default:g}", f"{p.low:g} to {p.high:g}", role, p.meaning, p.source)
    return "| " + " | ".join(_cell(cell) for cell in cells) + " |"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _sentence(text: str) -> str:
    text = text[:1].upper() + text[1:]
    return text if text.endswith(".") else f"{text}."


if __name__ == "__main__":
    atomic_write_text(PAGE, page())
