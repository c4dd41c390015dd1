"""A user's own effects: a Python file of under 20 lines beside the experiment, checked when it is loaded.

from sim import Effect, Parameter

def force(axis, p):
    return p.strength * axis.position**3

effect = Effect("cubic_spring", "spring that stiffens", force=force,
                parameters=[Parameter("strength", "N/m^3", 1.0, 0.0, 1e9, "stiffening", "assumed")])
"""

import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache, partial, wraps
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from sim.effects.catalogue import find, library, valid_name
from sim.effects.effect import Axis, Effect, Parameter
from stagecad.parameters.errors import InputError, at_place, nearest, require
from stagecad.parameters.input_file import read_input
from stagecad.parameters.own_code import line_of, told

ROWS = 7
ROUNDING = 1e-9
"""Relative rounding of a law of some hundred operations in double precision, far below the curvature of a shape."""
ACTS_ON = ("friction", "axis", "drive", "piezo", "sensor", "memory", "structure")


Accept = Callable[[Path, bytes], None]
"""Called with a file and its content before the content is run; it raises to prevent that."""


def load_custom(path: str | Path, accept: Accept = lambda path, data: None) -> list[Effect]:
    """The effects that a user's Python file declares at module level.

    Args:
        path: the file.
        accept: called before its content is run.

    Returns:
        Its effects, in the order of the file, with every law evaluated at its default for one instant and for a record.

    Raises:
        InputError: one line with the file, the line or effect, and what is wrong: it cannot be read, a syntax error, an
            error while it runs, no effect, a name that is taken, an unknown unit, a start outside its bounds, a law
            that raises, or whose value has the wrong shape or is not finite.
    """
    path = Path(path)
    data = _content(path)
    accept(path, data)
    return _declared(path, data)


def _declared(path: Path, data: bytes) -> list[Effect]:
    """The effects that a file with this content declares; the bytes themselves run, which were accepted."""
    module = _run(path, data)
    effects: list[Effect] = []
    for value in vars(module).values():
        if isinstance(value, Effect) and not any(value is effect for effect in effects):
            effects.append(value)
    require(effects, f"{path}: declares no effect; write 'effect = Effect(...)' at the file's top level")
    taken: set[str] = set()
    checked = []
    for effect in effects:
        require(effect.name not in taken, f"{path}: effect '{effect.name}': the file declares it twice; choose another")
        taken.add(effect.name)
        checked.append(replace(checked_effect(path, effect), origin=partial(_of_file, str(path), data)))
    return checked


@lru_cache(maxsize=16)
def _of_file(path: str, data: bytes, name: str) -> Effect:
    """The effect of this name that a file with this content declares: a pickled effect needs no file."""
    return find(name, _declared(Path(path), data))


def _in_memory(effect: Effect, name: str) -> Effect:
    """An effect that was declared in memory, checked again, under a name."""
    return find(name, [checked_effect(IN_MEMORY, effect)])


IN_MEMORY = Path("own effects")
"""Stands for the file of an effect that was declared in memory."""


def load_all_custom(sources: Sequence[str | Path | Effect], accept: Accept = lambda path, data: None) -> list[Effect]:
    """The effects of several files, and those declared in memory, together; `accept` is called before the content of
    each file is run.

    Raises:
        InputError: as `load_custom`, and when two sources declare the same name.
    """
    effects: dict[str, tuple[Path, Effect]] = {}
    for source in sources:
        path = IN_MEMORY if isinstance(source, Effect) else Path(source)
        for effect in [checked_effect(path, source)] if isinstance(source, Effect) else load_custom(path, accept):
            if effect.name in effects:
                raise InputError(f"{path}: effect '{effect.name}' is already declared in {effects[effect.name][0]}")
            effects[effect.name] = (path, effect)
    return [effect for _, effect in effects.values()]


def _content(path: Path) -> bytes:
    try:
        return read_input(path)
    except FileNotFoundError:
        folder = path.parent if path.parent.is_dir() else None
        near = nearest(path.name, [p.name for p in folder.glob("*.py")]) if folder and list(folder.glob("*.py")) else ""
        raise InputError(f"{path}: no such file{near}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _run(path: Path, data: bytes) -> ModuleType:
    module = ModuleType(path.stem)
    module.__file__ = str(path)
    try:
        exec(compile(data, str(path), "exec"), vars(module))
    except SyntaxError as error:
        line = f", line {error.lineno}" if error.lineno else ""
        raise InputError(f"{path}{line}: not valid Python: {error.msg}") from None
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise InputError(f"{path}{_failure(path, error)}") from None
    return module


def _failure(path: Path, error: BaseException) -> str:
    """Line and message of an error in a file."""
    line = line_of(path, error)
    hint = "; a law takes arrays: np.where(condition, a, b) in place of if" if "truth value" in str(error) else ""
    return f"{f', line {line}' if line else ''}: {told(error)}{hint}"


def checked_effect(path: Path, effect: Effect) -> Effect:
    """A user's own effect, its laws evaluated once; `path` names its source. Raises as `load_custom`."""
    where = f"{path}: effect '{effect.name}'"
    require(effect.name not in library(), f"{where}: a built-in effect has that name; choose another")
    if not isinstance(effect.name, str) or not valid_name(effect.name):
        raise InputError(f"{where}: the name must be lower-case letters, digits and underscores ('cubic_spring')")
    if effect.acts_on not in ACTS_ON:
        raise InputError(f"{where}: acts_on = {effect.acts_on!r}{nearest(str(effect.acts_on), ACTS_ON)}")
    names: set[str] = set()
    for parameter in effect.parameters:
        _check_parameter(where, parameter, names)
    laws = {kind: getattr(effect, kind) for kind in ("level", "factor", "force", "signal", "memory")}
    if effect.friction_state is None and not any(laws.values()):
        raise InputError(f"{where}: has no law; give one of level, factor, force, signal, memory")
    changed: dict[str, Any] = {}
    for kind in ("level", "factor", "force"):
        if laws[kind] is not None and _try_law(path, f"{where}: {kind}", laws[kind], effect):
            changed[kind] = _broadcast(laws[kind])
        if laws[kind] is not None:
            changed[kind] = _with_named_failure(path, f"{where}: {kind}", changed.get(kind, laws[kind]))
    slopes = dict(effect.slopes)
    for kind, law in slopes.items():
        allowed = [f"{of}.{by}" for of in ("level", "factor", "force") for by in ("position", "velocity", "time")]
        if kind not in allowed:
            raise InputError(f"{where}: slopes: no slope '{kind}'{nearest(str(kind), allowed)}")
        if _try_law(path, f"{where}: slope {kind}", law, effect):
            slopes[kind] = _broadcast(law)
    if effect.signal is not None:
        place, signal = f"{where}: signal", np.linspace(0.0, 1.0, ROWS)
        value = _number(place, _call(path, place, effect.signal, signal, 0.01, effect.values()))
        if value.shape != (ROWS,):
            raise InputError(f"{place}: gives shape {value.shape} for a signal of {ROWS} rows; must be ({ROWS},)")
        require(np.all(np.isfinite(value)), f"{place}: is not finite at the parameters' defaults")
        changed["signal"] = _with_named_failure(path, f"{where}: signal", effect.signal)
    parameters = [p if _is_amplitude(effect, p) else replace(p, role="shape") for p in effect.parameters]
    origin = partial(_in_memory, replace(effect, origin=None))
    return replace(effect, **changed, slopes=slopes, parameters=tuple(parameters), origin=origin)


def _is_amplitude(effect: Effect, parameter: Parameter) -> bool:
    """Whether a parameter may have its role: zero is within the bounds of an amplitude, and the laws are finite there
    and linear in it. One that was declared without a role need not be."""
    if parameter.role != "amplitude":
        return True
    if not parameter.low <= 0.0 <= parameter.high:
        return False
    step = parameter.default or min(1.0, parameter.high) or max(-1.0, parameter.low)
    record = _record()
    for law in filter(None, (effect.level, effect.factor, effect.force)):
        with np.errstate(all="ignore"), suppress(Exception):
            none, half, whole = (
                np.asarray(law(record, effect.values(**{parameter.name: part * step})), dtype=float)
                for part in (0.0, 0.5, 1.0)
            )
            size = np.abs([none, half, whole]).max(initial=0.0)
            if np.abs(none + whole - 2.0 * half).max(initial=0.0) <= ROUNDING * size:
                continue
        return False
    return True


def _check_parameter(where: str, parameter: Parameter, names: set[str]) -> None:
    from stagecad.parameters.units import unit_dimension

    if not isinstance(parameter, Parameter):
        raise InputError(f"{where}: parameters must hold Parameter(...), not {type(parameter).__name__}")
    at = f"{where}: parameter '{parameter.name}'"
    require(valid_name(str(parameter.name)), f"{at}: the name must be lower-case letters, digits and underscores")
    require(parameter.name not in names, f"{at}: is declared twice")
    names.add(parameter.name)
    if not isinstance(parameter.unit, str):
        kind = type(parameter.unit).__name__
        raise InputError(f"{at}: unit: must be text such as 'N/m' ('1' for a number without a unit), not {kind}")
    with at_place(f"{at}: unit"):
        unit_dimension(parameter.unit)
    values = (parameter.default, parameter.low, parameter.high)
    if not all(isinstance(value, int | float) for value in values):
        raise InputError(f"{at}: default, low and high must be numbers in {parameter.unit}, not {values}")
    if not parameter.low <= parameter.default <= parameter.high:
        raise InputError(
            f"{at}: start {parameter.default:g} is outside its bounds {parameter.low:g} to {parameter.high:g}"
        )
    require(abs(parameter.default) < float("inf"), f"{at}: start {parameter.default:g} is not a finite number")


def _record() -> Axis:
    t = np.arange(ROWS) * 0.01
    x = 1e-3 * np.sin(7.0 * t + 0.1)
    v = 7e-3 * np.cos(40.0 * t + 0.1)
    one = np.ones(ROWS)
    return Axis(t, x, v, -0.3 * x, 10.0 * one, 21.0 * one, 0.1 * t, abs(x), 7e-3 * t + 1e-6, np.sign(v))


def _call(path: Path, where: str, law: Callable[..., Any], *arguments: Any) -> Any:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return law(*arguments)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise InputError(f"{where}{_failure(path, error)}") from None


def _with_named_failure(path: Path, where: str, law: Callable[..., Any]) -> Callable[..., Any]:
    """The law; where it raises for a record, the error has the file, the effect and the line. In a simulation, which
    calls it at one instant, the integration adds the time and the state instead."""

    @wraps(law)
    def named(first: Any, *others: Any) -> Any:
        try:
            return law(first, *others)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            if isinstance(error, Exception) and isinstance(first, Axis) and isinstance(first.time, float):
                raise
            raise InputError(f"{where}{_failure(path, error)}") from error

    return named


def _try_law(path: Path, where: str, law: Callable[..., Any], effect: Effect) -> bool:
    """Evaluate a law for a record and for one instant; whether it returns one number for a record."""
    require(callable(law), f"{where}: must be a function of (axis, p), not {type(law).__name__}")
    record, p = _record(), effect.values()
    value = _number(where, _call(path, where, law, record, p))
    if value.shape not in ((), (ROWS,)):
        raise InputError(f"{where}: gives shape {value.shape} for a record of {ROWS} rows; must be ({ROWS},)")
    again = _number(where, _call(path, where, law, record, p))
    same = np.array_equal(value, again, equal_nan=True)
    require(
        same, f"{where}: gives other numbers for the same arguments; it must not be random, nor change its arguments"
    )
    instant = Axis(*[float(quantity[2]) for quantity in record])
    single = _number(where, _call(path, where, law, instant, p))
    require(single.shape == (), f"{where}: gives shape {single.shape} at one instant; must be one number")
    for values in (value, single):
        require(np.all(np.isfinite(values)), f"{where}: is not finite at the parameters' defaults")
    return value.shape == ()


def _number(where: str, value: Any) -> Any:
    require(value is not None, f"{where}: gives None; must give numbers (is its 'return' missing?)")
    require(not np.iscomplexobj(value), f"{where}: gives complex numbers; must give real ones")
    try:
        return np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{where}: gives {type(value).__name__}; must give numbers") from None


def _broadcast(law: Callable[[Axis, Any], Any]) -> Callable[[Axis, Any], Any]:
    @wraps(law)
    def full(axis: Axis, p: Any) -> Any:
        return law(axis, p) + 0.0 * axis.velocity

    return full
