"""The step of a model as a Python module without imports but `math`, from which the other languages are translated.

    force = sum of the effects' forces + friction state model(level),    level = (sum of levels) * (product of factors)

The laws are the ones of the effects, taken from their source.
"""

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sim.effects.effect import Axis, Effect
from sim.numerics import steps
from stagecad.parameters.errors import InputError

FIXED = {
    "position before, m": "position",
    "time, s": "0.0",
    "distance travelled, m": "0.0",
    "direction of the last motion": "1.0",
    "distance since the last reversal, m": "0.0",
    "friction level before, N": "0.0",
}
"""What every model remembers, in this order: the state begins with it."""
_ANGLES = ("sin", "cos", "tan", "sinh", "cosh", "tanh")
_FUNCTIONS = {
    **{name: f"math.{name}" for name in ("exp", "expm1", "log", "log1p", "log10", "sqrt")},
    **{name: f"math.{name}" for name in _ANGLES},
    **{f"{arc}{name}": f"math.a{name}" for name in _ANGLES for arc in ("a", "arc")},
    **dict.fromkeys(("abs", "absolute", "fabs"), "abs"),
    "maximum": "max",
    "minimum": "min",
    **{name: name for name in ("float", "sign", "where", "power")},
}
"""Functions of numpy and math that every language has."""

HELPERS = """
def sign(x):
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0
"""


@dataclass
class Program:
    """The step of a model as Python source."""

    name: str  # of the model
    parameters: dict[str, float] = field(default_factory=dict)  # value by name in the program
    comments: dict[str, str] = field(default_factory=dict)  # text behind each parameter
    functions: dict[str, str] = field(default_factory=dict)  # source of each function, in order of definition
    states: list[str] = field(default_factory=list)  # meaning of each entry of the state
    # value of each at the first row, in terms of its position and velocity
    starts: list[str] = field(default_factory=list)
    body: list[str] = field(default_factory=list)  # lines of the step
    left_out: list[str] = field(default_factory=list)  # effects that are no force on the axis, and where they act

    def state(self, meaning: str, start: str = "0.0") -> str:
        """A further entry of the state, as written in the step; `start` is its value at the first row."""
        self.states.append(meaning)
        self.starts.append(start)
        return f"s[{len(self.states) - 1}]"

    def add(self, function: Callable[..., Any]) -> str:
        """A function of `steps` with those that it calls; its name in the program."""
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
        for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
            if isinstance(call.func, ast.Name) and hasattr(steps, call.func.id) and call.func.id != function.__name__:
                self.add(getattr(steps, call.func.id))
        bare = _bare(tree.body[0])
        bare.decorator_list = []
        self.functions.setdefault(function.__name__, ast.unparse(bare))
        return function.__name__

    @property
    def source(self) -> str:
        """The module as Python source."""
        values = "\n".join(
            f"{name} = {value!r}  # {self.comments.get(name, '')}".rstrip(" #")
            for name, value in self.parameters.items()
        )
        step = "\n".join(f"    {line}" for line in self.body)
        functions = "\n\n\n".join([HELPERS.strip(), *self.functions.values()])
        start = ", ".join(self.starts)
        return (
            f"import math\n\n{values}\n\n\n{functions}\n\n\n"
            f"def start(position, velocity):\n    return [{start}]\n\n\n"
            f"def step(s, dt, position, velocity, acceleration, load, temperature):\n{step}\n"
        )


def program_of(
    name: str, effects: Sequence[Effect], values: Mapping[str, float], comments: Mapping[str, str]
) -> Program:
    """The step of a model of `values` (SI, by `effect.parameter`) and effects of which at most one has a friction state
    model; `comments` has a text for each parameter."""
    program = Program(name)
    for meaning, start in FIXED.items():
        program.state(meaning, start)
    kept = []
    for effect in effects:
        if effect.acts_on in ("drive", "piezo", "sensor") or effect.is_mode:
            program.left_out.append(f"{effect.name}: acts on the {effect.acts_on}, not on the force")
            continue
        kept.append(effect)
        for parameter in effect.parameters:
            key = _name(f"{effect.name}_{parameter.name}")
            program.parameters[key] = float(values.get(f"{effect.name}.{parameter.name}", parameter.default))
            meaning = f"{parameter.unit}: {parameter.meaning}"
            program.comments[key] = comments.get(f"{effect.name}.{parameter.name}", meaning)
    program.body = [
        "dx = position - s[0]",
        "s[0] = position",
        "s[1] = s[1] + dt",
        "s[2] = s[2] + abs(dx)",
        "direction = sign(velocity) if velocity != 0.0 else s[3]",
        "s[4] = abs(dx) if direction != s[3] else s[4] + abs(dx)",
        "s[3] = direction",
        "time = s[1]",
        "travelled = s[2]",
        "reversal_distance = s[4]",
        "contact_age = 0.0",
    ]
    for effect in kept:
        _remember(program, effect)
    levels = [_call(program, effect, "level", effect.level) for effect in kept if effect.level is not None]
    factors = [_call(program, effect, "factor", effect.factor) for effect in kept if effect.factor is not None]
    program.body.append(f"level = {' + '.join(levels) or '0.0'}")
    program.body += [f"level = level * {factor}" for factor in factors]
    program.body.append("force = 0.0")
    for effect in kept:
        if effect.parallel_element is not None:
            raise InputError(f"export: effect '{effect.name}' is a history of the contact; it cannot be exported")
        if effect.force is not None:
            program.body.append(f"force = force + {_call(program, effect, 'force', effect.force)}")
    for effect in kept:
        if effect.friction_state is not None:
            _friction(program, effect)
    program.body += ["s[5] = level", "return force"]
    return program


def _name(text: str) -> str:
    return "".join(character if character.isalnum() else "_" for character in text)


def _remember(program: Program, effect: Effect) -> None:
    """What an effect of memory changes of the axis, before the laws are evaluated."""
    if effect.memory is None:
        return
    name, lines = _name(effect.name), program.body
    if effect.friction_state is not None and effect.friction_state.ages:
        program.add(steps.age_step)
        program.add(steps.rate_and_state_step)
        state, held = program.state("age of the contacts, s"), program.state("force by which they slip, N")
        lines += [
            f"fresh = {name}_force * (1.0 + {name}_evolution * math.log(1.0 + {name}_velocity * {state}"
            f" / {name}_memory_length))",
            f"kept, z = rate_and_state_step({held}, dx, dt, fresh, {name}_stiffness, {name}_direct, {name}_velocity)",
            f"{state} = age_step({state}, abs(dx - (kept - {held}) / {name}_stiffness), dt, {name}_memory_length)",
            f"{held} = kept",
            f"contact_age = {state}",
        ]
    elif any(parameter.name == "memory_length" for parameter in effect.parameters):
        program.add(steps.age_step)
        state = program.state("age of the contacts, s")
        lines += [f"{state} = age_step({state}, abs(dx), dt, {name}_memory_length)", f"contact_age = {state}"]
    elif any(parameter.name == "gap" for parameter in effect.parameters):
        program.add(steps.play_step)
        state = program.state("position behind the play, m", "position")
        lines += [
            f"behind = {state}",
            f"{state} = play_step({state}, position, 0.5 * {name}_gap)",
            f"dx = {state} - behind",
            f"position = {state}",
            "velocity = velocity if dx != 0.0 else 0.0",
        ]
    elif any(parameter.name == "time_constant" for parameter in effect.parameters):
        program.add(steps.lag_step)
        output, before = (
            program.state("lagged velocity, m/s", "velocity"),
            program.state("velocity before, m/s", "velocity"),
        )
        lines += [
            f"{output} = lag_step({output}, {before}, velocity, dt, {name}_time_constant)",
            f"{before} = velocity",
            f"velocity = {output}",
        ]
    else:
        raise InputError(f"export: effect '{effect.name}' needs a history of the motion; it cannot be exported")


def _friction(program: Program, effect: Effect) -> None:
    """The friction state model: its state, its step, its force."""
    model, name = effect.friction_state, _name(effect.name)
    if model.springs is not None:
        values = effect.values(**{p.name: program.parameters[f"{name}_{p.name}"] for p in effect.parameters})
        elements = model.springs(values)
        program.add(steps.element_step)
        for k, (stiffness, weight) in enumerate(zip(elements.stiffness, elements.weights, strict=True), start=1):
            state = program.state(f"force of element {k}, N")
            program.body += [
                f"{state} = element_step({state}, dx, level, {float(stiffness)!r}, {float(weight)!r})",
                f"force = force + {state}",
            ]
        return
    step = getattr(steps, f"{model.name}_step", None)
    if step is None:
        raise InputError(f"export: effect '{effect.name}': its friction state model has no step; it cannot be exported")
    state = program.state(steps.STATES.get(step.__name__, "force of the bristles, N"))
    known = {"z": state, "v": "velocity", "before": "s[5]", "speed": f"{name}_velocity"}
    known |= {argument: argument for argument in ("dx", "dt", "level")}
    arguments = [known.get(argument, f"{name}_{argument}") for argument in inspect.signature(step).parameters]
    program.add(step)
    program.body += [
        f"z, friction = {step.__name__}({', '.join(arguments)})",
        f"{state} = z",
        "force = force + friction",
    ]


def _call(program: Program, effect: Effect, kind: str, law: Callable[..., Any]) -> str:
    """The call of a law; its function is added to the program."""
    name = f"law_of_{_name(effect.name)}_{kind}"
    try:
        law = inspect.unwrap(law)  # of a user's own effect, which is called with the place of its failure
        tree = ast.parse(textwrap.dedent(inspect.getsource(law)))
        laws = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.Lambda)]
        if not laws or (isinstance(laws[0], ast.Lambda) and len(laws) > 1):
            raise _NotArithmetic("one lambda of several in its lines; write it with def")
        translated = _Law(law.__globals__, effect, *(argument.arg for argument in laws[0].args.args))
        stated = [ast.Return(laws[0].body)] if isinstance(laws[0], ast.Lambda) else _bare(laws[0]).body
        body = [translated.visit(statement) for statement in stated]
    except (OSError, TypeError, SyntaxError, _NotArithmetic) as error:
        middle = "a lambda in the middle of a statement; write it with def"
        reason = f" ({middle if isinstance(error, SyntaxError) else error})"
        raise InputError(
            f"export: the {kind} of effect '{effect.name}' is not arithmetic{reason}; it cannot be exported"
        ) from None
    fields = [axis for axis in Axis._fields if axis in translated.fields]
    values = [p.name for p in effect.parameters if p.name in translated.values]
    header = ", ".join([*fields, *(f"p_{value}" for value in values)])
    text = "\n".join(
        f"    {line}" for statement in body for line in ast.unparse(ast.fix_missing_locations(statement)).splitlines()
    )
    program.functions[name] = f"def {name}({header}):\n{text}"
    return f"{name}({', '.join([*fields, *(f'{_name(effect.name)}_{value}' for value in values)])})"


def _bare(function: Any) -> Any:
    """A function without docstring and annotations."""
    if ast.get_docstring(function) is not None:
        function.body = function.body[1:]
    function.returns = None
    for argument in function.args.args:
        argument.annotation = None
    return function


class _NotArithmetic(Exception):  # noqa: N818
    """A law that uses more than arithmetic, conditions and functions of one number."""


class _Law(ast.NodeTransformer):
    """The body of a law with its quantities and parameters as plain names."""

    def __init__(self, names: Mapping[str, Any], effect: Effect, axis: str, p: str) -> None:
        self.names, self.effect, self.axis, self.p = names, effect, axis, p
        self.fields: set[str] = set()
        self.values: set[str] = set()

    def visit_Attribute(self, node: ast.Attribute) -> Any:
        """`axis.velocity`, `p.force`, `np.pi`."""
        if isinstance(node.value, ast.Name):
            if node.value.id == self.axis and node.attr in Axis._fields:
                self.fields.add(node.attr)
                return ast.Name(node.attr, ast.Load())
            if node.value.id == self.p and any(parameter.name == node.attr for parameter in self.effect.parameters):
                self.values.add(node.attr)
                return ast.Name(f"p_{node.attr}", ast.Load())
            if node.attr == "pi":
                return ast.Constant(math.pi)
        raise _NotArithmetic(ast.unparse(node))

    def visit_Call(self, node: ast.Call) -> Any:
        """A function of one or two numbers."""
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name not in _FUNCTIONS or node.keywords:
            raise _NotArithmetic(ast.unparse(node))
        arguments = [self.visit(argument) for argument in node.args]
        if name == "where":
            return ast.IfExp(*arguments)
        if name == "power":
            return ast.BinOp(arguments[0], ast.Pow(), arguments[1])
        function: Any = ast.parse(_FUNCTIONS[name], mode="eval").body
        return arguments[0] if name == "float" else ast.Call(function, arguments, [])

    def visit_Name(self, node: ast.Name) -> Any:
        """A local name, or a number of the module."""
        value = self.names.get(node.id)
        if isinstance(node.ctx, ast.Load) and isinstance(value, int | float) and not isinstance(value, bool):
            return ast.Constant(float(value))
        return node

    def generic_visit(self, node: ast.AST) -> Any:
        """Every other part, if it is arithmetic, an assignment, a condition or a return."""
        allowed = (ast.expr_context, ast.operator, ast.unaryop, ast.cmpop, ast.boolop, ast.Assign, ast.Return, ast.If)
        allowed += (ast.BinOp, ast.UnaryOp, ast.Compare, ast.BoolOp, ast.IfExp, ast.Constant, ast.AugAssign)
        if not isinstance(node, allowed):
            raise _NotArithmetic(type(node).__name__.lower())
        return super().generic_visit(node)


@dataclass(frozen=True)
class ForceFunction:
    """Force of a model along a motion, N, as the exported step computes it."""

    source: str = field(repr=False)  # of the Python module

    def __call__(
        self,
        time: np.ndarray,
        position: np.ndarray,
        velocity: np.ndarray | None = None,
        load: np.ndarray | float = 0.0,
        temperature: np.ndarray | float = 20.0,
    ) -> np.ndarray:
        """Force (n,) that opposes the motion, N, from unloaded contacts at the first row.

        Args:
            time: s, (n,), increasing.
            position: m, (n,).
            velocity: m/s, (n,); by differences of the position where left out.
            load: normal load, N, (n,) or one value.
            temperature: degC, (n,) or one value.
        """
        namespace: dict[str, Any] = {}
        exec(compile(self.source, "exported model", "exec"), namespace)
        time, position = np.asarray(time, float), np.asarray(position, float)
        speed = np.gradient(position, time) if velocity is None else np.asarray(velocity, float)
        loads, heat = (np.broadcast_to(np.asarray(value, float), time.shape) for value in (load, temperature))
        acceleration = np.gradient(speed, time)
        state = namespace["start"](float(position[0]), float(speed[0]))
        steps_ = np.diff(time, prepend=time[0])
        rows = zip(
            steps_.tolist(), position.tolist(), speed.tolist(), acceleration.tolist(), loads.tolist(), heat.tolist()
        )
        return np.array([namespace["step"](state, *row) for row in rows])
