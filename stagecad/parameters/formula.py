"""Formulas of a parameter file: `"=holder.diameter + 0.05 mm"`, read and evaluated with units.

A formula contains numbers with their units, ``pi``, keys of other parameters, ``+ - * / ^``, brackets, and the
functions of `FUNCTIONS`. It is parsed into a syntax tree, of which only these elements are accepted; no Python code is
run.
"""

import ast
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from stagecad.parameters.errors import InputError, nearest, require
from stagecad.parameters.units import (
    DIMENSIONLESS,
    SYMBOLS,
    Dimension,
    nearest_symbol,
    parse_quantity,
    si_unit,
    unit_dimension,
)

SIGN = "="
"""Begins a formula in the parameter file."""

_LONGEST = 1000
_ANGLE = unit_dimension("rad")
_KEY = re.compile(r"[A-Za-z_]\w*(?:\s*\.\s*[A-Za-z_]\w*)+")
_SYMBOL = r"(?:[A-Za-z]+|%)(?:\^-?[0-9]+)?"
_NUMBER = re.compile(r"(?<![\w.])(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_UNIT = re.compile(rf"\s*({_SYMBOL}(?:[*/]{_SYMBOL})*)")


@dataclass(frozen=True)
class Value:
    """A number in SI with its dimension."""

    si: float
    dimension: Dimension


_ONE = Value(1.0, DIMENSIONLESS)


def _same(values: tuple[Value, ...], what: str) -> Dimension:
    dimension = values[0].dimension
    for other in values[1:]:
        if other.dimension != dimension:
            raise InputError(f"{what} of {_unit_text(dimension)} and {_unit_text(other.dimension)}")
    return dimension


def _unit_text(dimension: Dimension) -> str:
    return f"a quantity in {si_unit(dimension)}" if dimension != DIMENSIONLESS else "a number without unit"


def _power(base: Value, exponent: Value) -> Value:
    if exponent.dimension != DIMENSIONLESS:
        raise InputError(f"the exponent is {_unit_text(exponent.dimension)}")
    power: Fraction | int = 1
    if base.dimension != DIMENSIONLESS:
        power = Fraction(exponent.si).limit_denominator(12)
        power = power.numerator if power.denominator == 1 else power
        if abs(float(power) - exponent.si) > 1e-12:
            raise InputError(f"{_unit_text(base.dimension)} to the power {exponent.si:g}")
    number = base.si**exponent.si
    require(not isinstance(number, complex), "a negative number to a broken power")
    return Value(number, tuple(part * power for part in base.dimension))


def _plain(name: str, wanted: str, allowed: tuple[Dimension, ...], gives: Dimension) -> Callable[..., Value]:
    """A function of `math` of one number, of a wanted quantity."""

    def apply(number: Value) -> Value:
        if number.dimension not in allowed:
            raise InputError(f"{wanted} is needed, not {_unit_text(number.dimension)}")
        return Value(getattr(math, name)(number.si), gives)

    return apply


def _rounding(function: Callable[[float], float]) -> Callable[..., Value]:
    def apply(number: Value, step: Value = _ONE) -> Value:
        dimension = _same((number, step), "rounding")
        # The small number keeps rounding errors of the quotient from costing a whole step.
        return Value(function(round(number.si / step.si, 9)) * step.si, dimension)

    return apply


Functions = Mapping[str, tuple[int, int, Callable[..., Value]]]

FUNCTIONS: dict[str, tuple[int, int, Callable[..., Value]]] = {
    "min": (1, 20, lambda *v: Value(min(x.si for x in v), _same(v, "min"))),
    "max": (1, 20, lambda *v: Value(max(x.si for x in v), _same(v, "max"))),
    "abs": (1, 1, lambda x: Value(abs(x.si), x.dimension)),
    "sqrt": (1, 1, lambda x: _power(x, Value(0.5, DIMENSIONLESS))),
    "floor": (1, 2, _rounding(math.floor)),
    "ceil": (1, 2, _rounding(math.ceil)),
    "round": (1, 2, _rounding(round)),
    **{
        name: (1, 1, _plain(name, "an angle", (_ANGLE, DIMENSIONLESS), DIMENSIONLESS)) for name in ("sin", "cos", "tan")
    },
    **{
        name: (1, 1, _plain(name, "a number without unit", (DIMENSIONLESS,), _ANGLE))
        for name in ("asin", "acos", "atan")
    },
}
"""Functions by name: least and greatest number of arguments, and the function. `floor(x, 0.5 mm)` rounds to a step."""


@dataclass(frozen=True)
class Formula:
    """A parsed formula."""

    text: str  # without the leading `=`
    keys: tuple[str, ...]  # parameters that it reads, in the order of their appearance
    _tree: ast.expr
    _constants: Mapping[str, Value]

    def __hash__(self) -> int:
        return hash(self.text)

    def value(self, parameter: Callable[[str], Value], unit: str, place: str) -> float:
        """The formula's value in SI.

        Args:
            parameter: value of another parameter by its key.
            unit: of the result; empty for a dimensionless one.
            place: file and key, for messages.

        Raises:
            InputError: units that do not match, or no finite value.
        """
        try:
            found = self.evaluate(parameter)
        except FormulaError as error:
            raise InputError(f"{place} = '{SIGN}{self.text}': {error}") from None
        except (OverflowError, ZeroDivisionError, ValueError, TypeError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{place} = '{SIGN}{self.text}': has no value ({error})") from None
        if found.dimension != unit_dimension(unit):
            wanted = f"'{unit}' or a multiple of it" if unit else "a number without unit"
            raise InputError(f"{place} = '{SIGN}{self.text}': is {_unit_text(found.dimension)}; wanted {wanted}")
        require(math.isfinite(found.si), f"{place} = '{SIGN}{self.text}': has no finite value")
        return found.si

    def evaluate(self, parameter: Callable[[str], Value], functions: Functions | None = None) -> Value:
        """The formula's value with its dimension, also of arrays (n,) as the numbers of `parameter`.

        Args:
            parameter: value of a parameter by its key.
            functions: in place of `FUNCTIONS`, for arrays.

        Raises:
            InputError: units that do not match.
        """
        return self._evaluate(self._tree, parameter, FUNCTIONS if functions is None else functions)

    def _evaluate(self, node: ast.expr, parameter: Callable[[str], Value], functions: Functions) -> Value:
        if isinstance(node, ast.Name):
            return self._constants.get(node.id) or _named(parameter, self.keys[int(node.id[1:])])
        if isinstance(node, ast.UnaryOp):
            operand = self._evaluate(node.operand, parameter, functions)
            return operand if isinstance(node.op, ast.UAdd) else Value(-operand.si, operand.dimension)
        if isinstance(node, ast.Call):
            assert isinstance(node.func, ast.Name)
            arguments = (self._evaluate(item, parameter, functions) for item in node.args)
            return _named(functions[node.func.id][2], *arguments)
        assert isinstance(node, ast.BinOp)
        return _named(
            _OPERATORS[type(node.op)],
            self._evaluate(node.left, parameter, functions),
            self._evaluate(node.right, parameter, functions),
        )


class FormulaError(InputError):
    """What is wrong with a formula, without its place."""


def _named(function: Callable[..., Value], *values: Value | str) -> Value:
    try:
        return function(*values)
    except InputError as error:
        raise FormulaError(str(error)) from None


_OPERATORS: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: lambda a, b: Value(a.si + b.si, _same((a, b), "a sum")),
    ast.Sub: lambda a, b: Value(a.si - b.si, _same((a, b), "a difference")),
    ast.Mult: lambda a, b: Value(a.si * b.si, tuple(x + y for x, y in zip(a.dimension, b.dimension))),
    ast.Div: lambda a, b: Value(a.si / b.si, tuple(x - y for x, y in zip(a.dimension, b.dimension))),
    ast.Pow: _power,
}


def is_formula(value: object) -> bool:
    """Whether a value of a parameter file is a formula."""
    return isinstance(value, str) and value.lstrip().startswith(SIGN)


@cache
def parse_formula(written: str) -> Formula:
    """Read a formula with its leading `=`.

    Raises:
        FormulaError: what is wrong, without file and key.
    """
    text = " ".join(written.strip().removeprefix(SIGN).split())
    if not text or len(text) > _LONGEST or not text.isprintable():
        raise FormulaError("is not a formula; write one like '=holder.diameter + 0.05 mm'")
    keys: list[str] = []
    constants: dict[str, Value] = {}
    source, position = "", 0
    while position < len(text):
        if match := _KEY.match(text, position):
            key = re.sub(r"\s", "", match[0])
            if key not in keys:
                keys.append(key)
            source += f" k{keys.index(key)} "
            position = match.end()
        elif match := _NUMBER.match(text, position):
            unit = _unit_at(text, match.end())
            source, position = f"{source} q{len(constants)} ", match.end() + len(unit)
            constants[f"q{len(constants)}"] = _named(_quantity, match[0], unit.strip())
        elif match := re.compile(r"[A-Za-z_]\w*").match(text, position):
            if match[0] == "pi":
                constants["pi"] = Value(math.pi, DIMENSIONLESS)
            elif match[0] not in FUNCTIONS:
                raise FormulaError(
                    f"'{match[0]}' is neither a parameter TABLE.NAME nor a function{nearest(match[0], FUNCTIONS)}"
                )
            source, position = source + match[0], match.end()
        else:
            source, position = source + ("**" if text[position] == "^" else text[position]), position + 1
    try:
        tree = ast.parse(source.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise FormulaError("is not a formula; write numbers with units, keys, + - * / ^ and brackets") from None
    try:
        _accept(tree)
    except RecursionError:
        raise FormulaError("is nested too deeply") from None
    return Formula(text, tuple(keys), tree, constants)


def _unit_at(text: str, position: int) -> str:
    """The unit that begins at a place, with the space before it; as many factors as are unit symbols."""
    match = _UNIT.match(text, position)
    if match is None:
        return ""
    found = ""
    for factor in re.finditer(rf"\s*[*/]?({_SYMBOL})", match[0]):
        symbol, _, power = factor[1].partition("^")
        after = text[position + factor.end() : position + factor.end() + 1]
        if symbol in SYMBOLS and power and after == ".":
            raise FormulaError(f"the exponent of a unit is a whole number; write (2 {symbol})^0.5")
        if symbol not in SYMBOLS or re.match(r"[\w.(]", after):
            break
        found = text[position : position + factor.end()]
    if not found:
        word = match[1]
        if not re.match(r"[\w.(]", text[match.end() : match.end() + 1]) and word.split("^")[0] not in FUNCTIONS:
            raise FormulaError(f"unknown unit '{word}'; did you mean '{nearest_symbol(word)}'?")
    return found


def _quantity(number: str, unit: str) -> Value:
    return Value(parse_quantity(f"{number} {unit}", unit), unit_dimension(unit))


def _accept(node: ast.expr) -> None:
    """Refuse every element of Python that is not an element of a formula."""
    if isinstance(node, ast.Name):
        if node.id in FUNCTIONS:
            raise FormulaError(f"the function '{node.id}' needs its arguments in brackets")
        return None
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        return _accept(node.operand)
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        _accept(node.left)
        return _accept(node.right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS:
        low, high, _ = FUNCTIONS[node.func.id]
        if node.keywords or not low <= len(node.args) <= high:
            wanted = f"{low}" if low == high else f"{low} to {high}"
            raise FormulaError(f"the function '{node.func.id}' takes {wanted} arguments, not {len(node.args)}")
        for item in node.args:
            _accept(item)
        return None
    raise FormulaError("is not a formula; write numbers with units, keys, + - * / ^ and brackets")
