"""Checks of a machine of the user's own: those of the folder `checks`, which every machine may have, and its chains."""

from designcalc.checks.chain import Chain, link_of
from designcalc.checks.run import Subjects
from stagecad.parameters.design import Design
from stagecad.parameters.formula import is_formula, parse_formula
from stagecad.parameters.machine_declaration import declared_number

STEP = 1e-6
"""Change of a dimension for its coefficient in a chain, m (rad)."""


def chains(design: Design) -> tuple[Chain, ...]:
    """The tolerance chains of the table `[machine.chains]`."""
    declaration = design.machine.declaration
    return tuple(_chain(design, name, text) for name, text in declaration.chains.items()) if declaration else ()


def _chain(design: Design, name: str, text: str) -> Chain:
    """A chain from the formula of its distance, linear about the nominal dimensions."""

    def distance(key: str, shift: float) -> float:
        return 1e-3 * declared_number(text, "mm", f"{design.file}: machine.chains.{name}", design, key, shift)

    keys = dict.fromkeys(parse_formula(text).keys) if is_formula(text) else ()
    links = [link_of(design, key, (distance(key, STEP) - distance(key, -STEP)) / (2 * STEP)) for key in keys]
    return Chain(name, tuple(links), distance("", 0.0) - sum(link.coefficient * link.nominal for link in links))


SUBJECTS = Subjects(checks={}, chains=chains)
