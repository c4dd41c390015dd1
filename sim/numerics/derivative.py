"""Exact derivatives of a law from its source: the text of a function that gives one, to be compiled like the law.

Laws are short: arithmetic, a few functions, and branches. Each assigned name gets a partner, its derivative; each
returned value is replaced by its own. A branch is differentiated as it stands, so at a kink the derivative is that of
the side the law itself takes.

Source: Griewank and Walther, Evaluating Derivatives, 2nd ed. (2008), section 3.1: the tangent of each statement.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable
from typing import Any

_PARTNER = "d_"

# f(u): derivative by u, as text in {u}.
_RULES = {
    "exp": "np.exp({u})",
    "expm1": "np.exp({u})",
    "log": "1.0 / ({u})",
    "log1p": "1.0 / (1.0 + ({u}))",
    "sin": "np.cos({u})",
    "cos": "-np.sin({u})",
    "sqrt": "0.5 / np.sqrt({u})",
    "tanh": "1.0 - np.tanh({u}) ** 2",
    "abs": "np.sign({u})",
    "fabs": "np.sign({u})",
}
_FLAT = {"sign", "floor", "round"}


class NotDifferentiableError(ValueError):
    """A law is written with something that is not known here."""


def derivative_text(law: Callable[..., Any], variable: tuple[str, str], name: str) -> str | None:
    """Text of a function `name`, with the arguments of `law`, that gives its derivative by an attribute of an argument.

    Args:
        law: a function of plain Python.
        variable: argument and attribute, such as `("p", "velocity")`.
        name: of the new function.

    Returns:
        The text, which needs the names of the law's own module, and `np`; None where the derivative is zero throughout.

    Raises:
        NotDifferentiableError: the source is not to be had, or has something that is not known here.
    """
    try:
        source = textwrap.dedent(inspect.getsource(law))
        function = ast.parse(source).body[0]
    except (OSError, TypeError, SyntaxError) as error:
        raise NotDifferentiableError(f"no source: {error}") from error
    if not isinstance(function, ast.FunctionDef):
        raise NotDifferentiableError("not a function with a name")
    tangent = _Tangent(variable)
    body = tangent.statements(function.body)
    if not tangent.moved:
        return None
    arguments = ", ".join(a.arg for a in function.args.args)
    return f"def {name}({arguments}):\n" + textwrap.indent("\n".join(body), "    ") + "\n"


class _Tangent:
    """Statements with their tangents; `moved` once a returned value depends on the variable."""

    def __init__(self, variable: tuple[str, str]) -> None:
        self.variable = variable
        self.known: set[str] = set()
        self.moved = False

    def statements(self, body: list[ast.stmt]) -> list[str]:
        lines: list[str] = []
        for statement in body:
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
                continue
            if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
                lines += self._assign(statement.targets[0], statement.value)
            elif isinstance(statement, ast.Return) and statement.value is not None:
                lines.append(f"return {self._returned(statement.value)}")
            elif isinstance(statement, ast.If):
                lines.append(f"if {ast.unparse(statement.test)}:")
                lines += ["    " + line for line in self.statements(statement.body)]
                if statement.orelse:
                    lines.append("else:")
                    lines += ["    " + line for line in self.statements(statement.orelse)]
            else:
                raise NotDifferentiableError(f"a statement such as '{ast.unparse(statement)}'")
        return lines

    def _assign(self, target: ast.expr, value: ast.expr) -> list[str]:
        if isinstance(target, ast.Name):
            # The partner first: the value may use the name that it replaces.
            line = f"{_PARTNER}{target.id} = {self.of(value) or '0.0'}"
            self.known.add(target.id)
            return [line, f"{target.id} = {ast.unparse(value)}"]
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            return [line for a, b in zip(target.elts, value.elts) for line in self._assign(a, b)]
        raise NotDifferentiableError(f"an assignment to '{ast.unparse(target)}'")

    def _returned(self, value: ast.expr) -> str:
        parts = value.elts if isinstance(value, ast.Tuple) else [value]
        slopes = [self.of(part) for part in parts]
        self.moved = self.moved or any(slope is not None for slope in slopes)
        return ", ".join(slope or "0.0" for slope in slopes)

    def of(self, node: ast.expr) -> str | None:
        """Derivative of an expression, as text; None for zero."""
        if isinstance(node, ast.Constant):
            return None
        if isinstance(node, ast.Attribute):
            is_variable = isinstance(node.value, ast.Name) and (node.value.id, node.attr) == self.variable
            return "1.0" if is_variable else None
        if isinstance(node, ast.Name):
            if node.id == self.variable[0]:
                raise NotDifferentiableError(f"'{node.id}' handed on whole")
            return f"{_PARTNER}{node.id}" if node.id in self.known else None
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            inner = self.of(node.operand)
            return None if inner is None else (f"(-({inner}))" if isinstance(node.op, ast.USub) else inner)
        if isinstance(node, ast.BinOp):
            return self._binary(node)
        if isinstance(node, ast.Call):
            return self._call(node)
        if isinstance(node, ast.IfExp):
            a, b = self.of(node.body), self.of(node.orelse)
            if a is None and b is None:
                return None
            return f"(({a or '0.0'}) if {ast.unparse(node.test)} else ({b or '0.0'}))"
        if isinstance(node, (ast.Compare, ast.BoolOp)):
            return None
        raise NotDifferentiableError(f"'{ast.unparse(node)}'")

    def _binary(self, node: ast.BinOp) -> str | None:
        u, v = f"({ast.unparse(node.left)})", f"({ast.unparse(node.right)})"
        du, dv = self.of(node.left), self.of(node.right)
        if du is None and dv is None:
            return None
        if isinstance(node.op, (ast.Add, ast.Sub)):
            sign = "+" if isinstance(node.op, ast.Add) else "-"
            return f"(({du or '0.0'}) {sign} ({dv or '0.0'}))"
        if isinstance(node.op, ast.Mult):
            return " + ".join(f"({d}) * {w}" for d, w in ((du, v), (dv, u)) if d is not None).join("()")
        if isinstance(node.op, ast.Div):
            if dv is None:
                return f"(({du}) / {v})"
            return f"((({du or '0.0'}) - {u} / {v} * ({dv})) / {v})"
        if isinstance(node.op, ast.Pow):
            parts = []
            if du is not None:
                # The small number keeps 0 ** (v - 1) finite; where u is zero the slope of a power above one is zero.
                base = u if isinstance(node.right, ast.Constant) else f"({u} + 1e-300)"
                parts.append(f"{v} * {base} ** ({v} - 1) * ({du})")
            if dv is not None:
                parts.append(f"{u} ** {v} * np.log({u} + 1e-300) * ({dv})")
            return " + ".join(parts).join("()")
        raise NotDifferentiableError(f"'{ast.unparse(node)}'")

    def _call(self, node: ast.Call) -> str | None:
        slopes = [self.of(argument) for argument in node.args]
        if all(slope is None for slope in slopes):
            return None
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        arguments = [ast.unparse(argument) for argument in node.args]
        if name in _FLAT:
            return None
        if name in ("max", "min", "maximum", "minimum") and len(node.args) == 2:
            a, b = arguments
            first = f"({a}) >= ({b})" if name.startswith("max") else f"({a}) <= ({b})"
            return f"(({slopes[0] or '0.0'}) if {first} else ({slopes[1] or '0.0'}))"
        if name in _RULES and len(node.args) == 1:
            return f"({_RULES[name].format(u=arguments[0])} * ({slopes[0]}))"
        raise NotDifferentiableError(f"the function '{name}'")
