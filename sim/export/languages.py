"""The files of an exported model: Python, C, MATLAB, Modelica, a table of steady sliding.

The step of a model in C, MATLAB and Modelica is translated from its Python source, which has functions of numbers with
assignments, conditions, loops and returns, and the state as an array."""

import ast
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from sim.export.program import ForceFunction, Program

_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_COMPARE = {ast.Gt: ">", ast.Lt: "<", ast.GtE: ">=", ast.LtE: "<=", ast.Eq: "==", ast.NotEq: "!="}


def locals_of(function: ast.FunctionDef) -> list[str]:
    """Names that a function assigns, without its arguments, in order."""
    arguments = {argument.arg for argument in function.args.args}
    names: dict[str, None] = {}
    for node in ast.walk(function):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id not in arguments:
            names[node.id] = None
    return list(names)


def outputs_of(function: ast.FunctionDef) -> int:
    """Number of values that a function returns."""
    returned = [node.value for node in ast.walk(function) if isinstance(node, ast.Return)]
    return max(len(value.elts) if isinstance(value, ast.Tuple) else 1 for value in returned)


class Language(ABC):
    """Prints expressions and statements: what languages have in common, in the words of each (those of MATLAB here)."""

    and_, or_, not_, not_equal = "&&", "||", "~", "~="
    functions: dict[str, str] = {}
    helpers: dict[str, str] = {}
    """Functions that the language lacks, of x."""
    entry, first = "s({})", 1
    """An entry of the state, and the number of the first one."""
    power, choice = "({})^({})", "choose({}, @() {}, @() {})"
    assign, assign_many, give = "{} = {};", "[{}] = {};", "return"
    if_, else_, end_if = "if {}", "else", "end"
    while_, end_while = "while {}", "end"

    def expression(self, node: ast.expr) -> str:
        """An expression."""
        match node:
            case ast.Constant():
                return repr(float(node.value))  # pyright: ignore[reportArgumentType]
            case ast.Name():
                return node.id
            case ast.Attribute(attr="pi"):
                return repr(math.pi)
            case ast.Subscript():
                return self.entry.format(int(node.slice.value) + self.first)  # type: ignore[attr-defined]
            case ast.BinOp(op=ast.Pow()):
                return self.power.format(self.expression(node.left), self.expression(node.right))
            case ast.BinOp():
                return f"({self.expression(node.left)} {_BINARY[type(node.op)]} {self.expression(node.right)})"
            case ast.UnaryOp(op=ast.Not()):
                return f"{self.not_}({self.expression(node.operand)})"
            case ast.UnaryOp():
                return f"(-{self.expression(node.operand)})"
            case ast.Compare():
                pairs = zip([node.left, *node.comparators], node.ops, node.comparators)
                parts = [f"{self.expression(a)} {self.compare(op)} {self.expression(b)}" for a, op, b in pairs]
                return "(" + f" {self.and_} ".join(parts) + ")"
            case ast.BoolOp():
                word = self.and_ if isinstance(node.op, ast.And) else self.or_
                return "(" + f" {word} ".join(self.expression(value) for value in node.values) + ")"
            case ast.IfExp():
                return self.choice.format(*(self.expression(part) for part in (node.test, node.body, node.orelse)))
            case ast.Call():
                name = ast.unparse(node.func).removeprefix("math.")
                return f"{self.functions.get(name, name)}({', '.join(self.expression(a) for a in node.args)})"
        raise NotImplementedError(ast.unparse(node))

    def compare(self, operator: ast.cmpop) -> str:
        """A sign of comparison."""
        return self.not_equal if isinstance(operator, ast.NotEq) else _COMPARE[type(operator)]

    def block(self, body: Sequence[ast.stmt], indent: str) -> list[str]:
        """Statements."""
        return [line for statement in body for line in self.statement(statement, indent)]

    def statement(self, node: ast.stmt, indent: str) -> list[str]:
        """One statement as lines."""
        match node:
            case ast.Assign(targets=[ast.Tuple() as targets], value=ast.Call() as call):
                return [indent + self.results_of([self.expression(t) for t in targets.elts], self.expression(call))]
            case ast.Assign(targets=[target]):
                return [indent + self.assign.format(self.expression(target), self.expression(node.value))]
            case ast.Return(value=ast.expr() as value):
                values = value.elts if isinstance(value, ast.Tuple) else [value]
                return [indent + line for line in self.returned([self.expression(one) for one in values])]
            case ast.If():
                inner = indent + "  "
                lines = [indent + self.if_.format(self.expression(node.test)), *self.block(node.body, inner)]
                lines += [indent + self.else_, *self.block(node.orelse, inner)] if node.orelse else []
                return [*lines, indent + self.end_if]
            case ast.While():
                head, body = self.while_.format(self.expression(node.test)), self.block(node.body, indent + "  ")
                return [indent + head, *body, indent + self.end_while]
        raise NotImplementedError(ast.unparse(node))

    def results_of(self, targets: Sequence[str], call: str) -> str:
        """Assignment of the results of a call."""
        return self.assign_many.format(", ".join(targets), call)

    def returned(self, values: Sequence[str]) -> list[str]:
        """The end of a function of these results."""
        return [*(self.assign.format(f"out{k}", value) for k, value in enumerate(values)), self.give]

    @abstractmethod
    def function(self, node: ast.FunctionDef) -> str:
        """A function with its head."""


class C(Language):
    """C99 without allocation; further results of a function go through pointers."""

    functions = {"abs": "fabs", "max": "fmax", "min": "fmin", "sign": "sign_of"}
    not_, not_equal, entry, first = "!", "!=", "s[{}]", 0
    power, choice = "pow({}, {})", "({} ? {} : {})"
    if_, else_, end_if = "if ({}) {{", "} else {", "}"
    while_, end_while = "while ({}) {{", "}"

    def results_of(self, targets: Sequence[str], call: str) -> str:
        return f"{targets[0]} = {call[:-1]}, {', '.join(f'&{target}' for target in targets[1:])});"

    def returned(self, values: Sequence[str]) -> list[str]:
        return [*(f"*out{k} = {value};" for k, value in enumerate(values[1:], start=1)), f"return {values[0]};"]

    def function(self, node: ast.FunctionDef) -> str:
        arguments = [f"double {argument.arg}" for argument in node.args.args]
        arguments += [f"double *out{k}" for k in range(1, outputs_of(node))]
        names = locals_of(node)
        declared = [f"  double {', '.join(f'{name} = 0.0' for name in names)};"] if names else []
        name = self.functions.get(node.name, node.name)
        head = f"static double {name}({', '.join(arguments) or 'void'}) {{"
        return "\n".join([head, *declared, *self.block(node.body, "  "), "}"])


class Matlab(Language):
    """MATLAB (and Octave); the state is returned beside the force."""

    def function(self, node: ast.FunctionDef) -> str:
        outputs = [f"out{k}" for k in range(outputs_of(node))]
        head = f"function [{', '.join(outputs)}] = {node.name}({', '.join(a.arg for a in node.args.args)})"
        return "\n".join([head, *self.block(node.body, "  "), "end"])


class Modelica(Language):
    """Functions of Modelica, with an algorithm each."""

    helpers = {
        "log1p": "log(1 + x)",
        "expm1": "exp(x) - 1",
        "asinh": "(if x < 0 then -1 else 1) * log(abs(x) + sqrt(x^2 + 1))",
        "acosh": "log(x + sqrt(x^2 - 1))",
        "atanh": "log((1 + x) / (1 - x)) / 2",
    }
    functions = {name: f"{name}_of" for name in ("sign", *helpers)}
    and_, or_, not_, not_equal, entry = "and", "or", "not ", "<>", "s[{}]"
    choice = "(if {} then {} else {})"
    assign, assign_many, give = "{} := {};", "({}) := {};", "return;"
    if_, end_if, while_, end_while = "if {} then", "end if;", "while {} loop", "end while;"

    def function(self, node: ast.FunctionDef) -> str:
        name = self.functions.get(node.name, node.name)
        # An input of Modelica cannot be assigned: what the function changes is copied.
        stored = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        changed = [a.arg for a in node.args.args if a.arg in stored]
        lines = [f"  input Real {a.arg}{'_in' if a.arg in changed else ''};" for a in node.args.args]
        lines += [f"  output Real out{k};" for k in range(outputs_of(node))]
        names = [*changed, *locals_of(node)]
        lines += ["protected", f"  Real {', '.join(names)};"] if names else []
        begin = [f"  {name_} := {name_}_in;" for name_ in changed]
        return "\n".join(
            [f"function {name}", *lines, "algorithm", *begin, *self.block(node.body, "  "), f"end {name};"]
        )


ARGUMENTS = ("dt", "position", "velocity", "acceleration", "load", "temperature")
SIGNS = (
    "The force opposes the motion: it is positive where it acts against positive velocity.",
    "mass * acceleration = drive force - force. SI units; on a rotary axis rad for m, N*m for N, kg*m^2 for kg.",
    "Call start once, then step once per sample: dt is the time since the sample before.",
    "load (N) and temperature (degC) matter only to effects that depend on them.",
)


@dataclass(frozen=True)
class Exported:
    """What is written."""

    program: Program  # the step
    mass: float  # kg; zero where it is not known
    about: tuple[str, ...]  # lines on the origin of the model

    @property
    def comments(self) -> list[str]:
        """Lines at the head of each file."""
        left = [f"Left out: {line}." for line in self.program.left_out]
        states = [f"state {k}: {meaning}" for k, meaning in enumerate(self.program.states)]
        return [*self.about, "", *SIGNS, *left, "", *states]

    def check(self) -> tuple[list[list[float]], list[float]]:
        """Inputs of a self-test, rows of `ARGUMENTS`, and the force that the program gives, N."""
        time = np.arange(60) * 1e-3
        position = 2e-4 * np.sin(2 * np.pi * 18.0 * time) * time / time[-1]
        velocity = np.gradient(position, time)
        acceleration = np.gradient(velocity, time)
        load, temperature = 10.0 + np.cos(40.0 * time), 20.0 + 50.0 * time
        force = ForceFunction(self.program.source)(time, position, velocity, load, temperature)
        steps = np.diff(time, prepend=time[0])
        return np.column_stack([steps, position, velocity, acceleration, load, temperature]).tolist(), force.tolist()


PRINTERS: dict[str, type[Language]] = {"c": C, "matlab": Matlab, "modelica": Modelica}
SUFFIXES = {"python": ("py",), "c": ("h", "c"), "matlab": ("m",), "modelica": ("mo",)}
"""Files of a language, `templates/model.SUFFIX.jinja`."""


def files_of(exported: Exported, language: str) -> dict[str, str]:
    """Text by file name."""
    name = exported.program.name
    if language == "table":
        return {f"{name}.csv": _table(exported)}
    words = words_of(exported, language)
    return {f"{name}.{suffix}": filled(f"model.{suffix}", words) for suffix in SUFFIXES[language]}


def filled(template: str, words: dict[str, Any]) -> str:
    """A file from its template."""
    environment = Environment(
        loader=PackageLoader("sim.export"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["commented"] = lambda lines, sign: "\n".join(f"{sign} {line}".rstrip() for line in lines)
    return environment.get_template(f"{template}.jinja").render(words)


def words_of(exported: Exported, language: str) -> dict[str, Any]:
    """What the templates of a language are filled with: the program, translated, and its self-test."""
    program, (rows, force) = exported.program, exported.check()
    words: dict[str, Any] = {"name": program.name, "program": program, "mass": exported.mass, "arguments": [*ARGUMENTS]}
    words |= {"comments": exported.comments, "rows": rows, "force": force}
    if language in PRINTERS:
        printer, tree = PRINTERS[language](), ast.parse(program.source).body
        functions = {node.name: node for node in tree if isinstance(node, ast.FunctionDef)}
        step = functions["step"]
        assigned = {n.id for n in ast.walk(step) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        words |= {
            "functions": [printer.function(one) for name, one in functions.items() if name not in ("start", "step")],
            "helpers": printer.helpers,
            "body": printer.block(step.body, "  "),
            "locals": locals_of(step),
            "changed": [name for name in ("position", "velocity") if name in assigned],
            "doubles": ", ".join(f"double {argument}" for argument in ARGUMENTS),
            "table": [(*row, f) for row, f in zip(rows, force)],
        }
    return words


def _table(exported: Exported) -> str:
    """Force over velocity in steady sliding from rest at position zero, both directions."""
    force = ForceFunction(exported.program.source)
    speeds = np.geomspace(1e-6, 1.0, 61)
    rows = [f"# {line}".rstrip() for line in exported.comments] + ["velocity [m/s],force [N]"]
    for velocity in (*-speeds[::-1], *speeds):
        time = np.linspace(0.0, 0.02 / abs(velocity), 400)
        value = float(force(time, velocity * time, np.full(400, velocity))[-1])
        rows.append(f"{velocity:.9g},{value:.9g}")
    return "\n".join(rows) + "\n"
