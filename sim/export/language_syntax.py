"""The step of a model in C, MATLAB and Modelica, translated from its Python source.

The source has functions of numbers with assignments, conditions, loops and returns, and the state as an array.
"""

import ast
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

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
    """Prints expressions and statements; what languages have in common."""

    and_, or_, not_ = "&&", "||", "!"
    functions: dict[str, str] = {}
    not_equal = "!="

    def expression(self, node: ast.expr) -> str:
        """An expression."""
        match node:
            case ast.Constant():
                return self.number(float(node.value))  # pyright: ignore[reportArgumentType]
            case ast.Name():
                return node.id
            case ast.Attribute(attr="pi"):
                return self.number(math.pi)
            case ast.Subscript():
                return self.entry(int(node.slice.value))  # type: ignore[attr-defined]
            case ast.BinOp(op=ast.Pow()):
                return self.power(self.expression(node.left), self.expression(node.right))
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
                return self.choice(*(self.expression(part) for part in (node.test, node.body, node.orelse)))
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
                return [indent + self.assign_many([self.expression(t) for t in targets.elts], self.expression(call))]
            case ast.Assign(targets=[target]):
                return [indent + self.assign(self.expression(target), self.expression(node.value))]
            case ast.Return(value=ast.Tuple() as values):
                return self.give([self.expression(value) for value in values.elts], indent)
            case ast.Return(value=ast.expr() as value):
                return self.give([self.expression(value)], indent)
            case ast.If():
                return self.branch(node, indent)
            case ast.While():
                return self.loop(self.expression(node.test), self.block(node.body, indent + self.step), indent)
        raise NotImplementedError(ast.unparse(node))

    step = "  "

    @abstractmethod
    def number(self, value: float) -> str: ...
    @abstractmethod
    def entry(self, index: int) -> str: ...
    @abstractmethod
    def power(self, base: str, exponent: str) -> str: ...
    @abstractmethod
    def choice(self, test: str, one: str, other: str) -> str: ...
    @abstractmethod
    def assign(self, target: str, value: str) -> str: ...
    @abstractmethod
    def assign_many(self, targets: Sequence[str], call: str) -> str: ...
    @abstractmethod
    def give(self, values: Sequence[str], indent: str) -> list[str]: ...
    @abstractmethod
    def branch(self, node: ast.If, indent: str) -> list[str]: ...
    @abstractmethod
    def loop(self, test: str, body: list[str], indent: str) -> list[str]: ...
    @abstractmethod
    def function(self, node: ast.FunctionDef) -> str:
        """A function with its head."""


class C(Language):
    """C99 without allocation; further results of a function go through pointers."""

    functions = {"abs": "fabs", "max": "fmax", "min": "fmin", "sign": "sign_of"}

    def number(self, value: float) -> str:
        return repr(value)

    def entry(self, index: int) -> str:
        return f"s[{index}]"

    def power(self, base: str, exponent: str) -> str:
        return f"pow({base}, {exponent})"

    def choice(self, test: str, one: str, other: str) -> str:
        return f"({test} ? {one} : {other})"

    def assign(self, target: str, value: str) -> str:
        return f"{target} = {value};"

    def assign_many(self, targets: Sequence[str], call: str) -> str:
        return f"{targets[0]} = {call[:-1]}, {', '.join(f'&{target}' for target in targets[1:])});"

    def give(self, values: Sequence[str], indent: str) -> list[str]:
        further = [f"{indent}*out{k} = {value};" for k, value in enumerate(values[1:], start=1)]
        return [*further, f"{indent}return {values[0]};"]

    def branch(self, node: ast.If, indent: str) -> list[str]:
        lines = [f"{indent}if ({self.expression(node.test)}) {{", *self.block(node.body, indent + self.step)]
        if node.orelse:
            lines += [f"{indent}}} else {{", *self.block(node.orelse, indent + self.step)]
        return [*lines, f"{indent}}}"]

    def loop(self, test: str, body: list[str], indent: str) -> list[str]:
        return [f"{indent}while ({test}) {{", *body, f"{indent}}}"]

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

    functions = {"abs": "abs"}
    not_, not_equal = "~", "~="

    def number(self, value: float) -> str:
        return repr(value)

    def entry(self, index: int) -> str:
        return f"s({index + 1})"

    def power(self, base: str, exponent: str) -> str:
        return f"({base})^({exponent})"

    def choice(self, test: str, one: str, other: str) -> str:
        return f"choose({test}, @() {one}, @() {other})"

    def assign(self, target: str, value: str) -> str:
        return f"{target} = {value};"

    def assign_many(self, targets: Sequence[str], call: str) -> str:
        return f"[{', '.join(targets)}] = {call};"

    def give(self, values: Sequence[str], indent: str) -> list[str]:
        return [*(f"{indent}out{k} = {value};" for k, value in enumerate(values)), f"{indent}return"]

    def branch(self, node: ast.If, indent: str) -> list[str]:
        lines = [f"{indent}if {self.expression(node.test)}", *self.block(node.body, indent + self.step)]
        if node.orelse:
            lines += [f"{indent}else", *self.block(node.orelse, indent + self.step)]
        return [*lines, f"{indent}end"]

    def loop(self, test: str, body: list[str], indent: str) -> list[str]:
        return [f"{indent}while {test}", *body, f"{indent}end"]

    def function(self, node: ast.FunctionDef) -> str:
        outputs = [f"out{k}" for k in range(outputs_of(node))]
        head = f"function [{', '.join(outputs)}] = {node.name}({', '.join(a.arg for a in node.args.args)})"
        return "\n".join([head, *self.block(node.body, "  "), "end"])


class Modelica(Language):
    """Functions of Modelica, with an algorithm each."""

    functions = {"log1p": "log1p_of", "expm1": "expm1_of", "sign": "sign_of", "max": "max", "min": "min"}
    and_, or_, not_, not_equal = "and", "or", "not ", "<>"

    def number(self, value: float) -> str:
        return repr(value)

    def entry(self, index: int) -> str:
        return f"s[{index + 1}]"

    def power(self, base: str, exponent: str) -> str:
        return f"({base})^({exponent})"

    def choice(self, test: str, one: str, other: str) -> str:
        return f"(if {test} then {one} else {other})"

    def assign(self, target: str, value: str) -> str:
        return f"{target} := {value};"

    def assign_many(self, targets: Sequence[str], call: str) -> str:
        return f"({', '.join(targets)}) := {call};"

    def give(self, values: Sequence[str], indent: str) -> list[str]:
        return [*(f"{indent}out{k} := {value};" for k, value in enumerate(values)), f"{indent}return;"]

    def branch(self, node: ast.If, indent: str) -> list[str]:
        lines = [f"{indent}if {self.expression(node.test)} then", *self.block(node.body, indent + self.step)]
        if node.orelse:
            lines += [f"{indent}else", *self.block(node.orelse, indent + self.step)]
        return [*lines, f"{indent}end if;"]

    def loop(self, test: str, body: list[str], indent: str) -> list[str]:
        return [f"{indent}while {test} loop", *body, f"{indent}end while;"]

    def function(self, node: ast.FunctionDef) -> str:
        name = self.functions.get(node.name, node.name)
        # An input of Modelica cannot be assigned: what the function changes is copied.
        changed = [a.arg for a in node.args.args if any(_stores(node, a.arg))]
        lines = [f"  input Real {a.arg}{'_in' if a.arg in changed else ''};" for a in node.args.args]
        lines += [f"  output Real out{k};" for k in range(outputs_of(node))]
        names = [*changed, *locals_of(node)]
        lines += ["protected", f"  Real {', '.join(names)};"] if names else []
        begin = [f"  {name_} := {name_}_in;" for name_ in changed]
        return "\n".join(
            [f"function {name}", *lines, "algorithm", *begin, *self.block(node.body, "  "), f"end {name};"]
        )


def _stores(function: ast.FunctionDef, name: str) -> list[Any]:
    return [n for n in ast.walk(function) if isinstance(n, ast.Name) and n.id == name and isinstance(n.ctx, ast.Store)]
