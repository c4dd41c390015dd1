"""What a case is drawn as: the plan, the rig with its numbers, and what is given to a record before an effect acts."""

from dataclasses import dataclass, field, replace

import numpy as np

from .axis import AxisTruth
from .hidden import HIDDEN, Hidden
from .motions import Motion
from .nuisance import Nuisance, draw_nuisance
from .tip import TipTruth


@dataclass(frozen=True)
class Plan:
    """What to make. `effects` is empty for nothing hidden, one name, or two; `level` a key of LEVELS.

    With `same_form` a hidden Stribeck curve is a Gaussian, as a model library writes it, in place of a Lorentzian.
    """

    rig: str
    effects: tuple[str, ...] = ()
    level: str = "strong"
    nuisance: str = "plain"
    hard: bool = False
    idle: bool | None = None
    rows: int = 20000
    same_form: bool = False


@dataclass(frozen=True)
class Rig:
    """A rig with its true numbers, its noise, and what its records carry."""

    plan: Plan
    base: tuple[str, ...]
    numbers: dict
    how: Nuisance
    radius: float | None
    axis: AxisTruth = field(default_factory=AxisTruth)
    tip: TipTruth = field(default_factory=TipTruth)
    noise_force: float = 0.0
    noise_position: float = 0.0
    channels: tuple[str, ...] = ()
    channel_seed: int = 0


@dataclass(frozen=True)
class Record:
    """What is given to a record before the effect acts: motion, channels, and the random events of its own."""

    motion: Motion | None
    voltage: tuple[np.ndarray, np.ndarray] | None
    load: np.ndarray
    temperature: np.ndarray
    seed: int


def _draw_base(rng: np.random.Generator, plan: Plan, hidden: list[Hidden]) -> tuple[str, ...]:
    if plan.rig == "actuator-tip":
        return ()
    for entry in hidden:
        if entry.base is not None:
            base = entry.base
            if entry.name == "quadratic_drag" and rng.random() < 0.3:
                base = (*base, "stribeck")
            names = {other.name for other in hidden}
            return tuple(name for name in base if name not in names)
    u = rng.random()
    if u < 0.12:
        return ("coulomb",)
    return ("coulomb", "viscous") if u < 0.75 else ("coulomb", "viscous", "stribeck")


def draw_rig(rng: np.random.Generator, plan: Plan) -> Rig:
    """A rig for the plan, every number of it drawn."""
    hidden = [HIDDEN[name] for name in plan.effects]
    base = _draw_base(rng, plan, hidden)
    how = draw_nuisance(rng, plan.rig, plan.nuisance, hard=plan.hard)
    coulomb = float(np.exp(rng.uniform(np.log(0.6), np.log(4.0))))
    rotary = plan.rig != "actuator-tip" and (
        any(entry.rotary_only for entry in hidden) or (plan.hard and rng.random() < 0.35)
    )
    radius = float(rng.uniform(0.016, 0.03)) if rotary else None
    names = set(plan.effects)
    axis = AxisTruth(
        mass=float(np.exp(rng.uniform(np.log(0.45), np.log(2.5)))),
        pull_stiffness=float(np.exp(rng.uniform(np.log(1500), np.log(5500)))),
        coulomb=coulomb,
        viscous=float(np.exp(rng.uniform(np.log(3), np.log(20)))) if "viscous" in base else 0.0,
        stribeck=coulomb * float(rng.uniform(0.15, 0.4)) if "stribeck" in base else 0.0,
        stribeck_velocity=float(np.exp(rng.uniform(np.log(1.5e-3), np.log(8e-3)))),
        gravity_radius=radius or 0.023,
        presliding=float(np.exp(rng.uniform(np.log(1e-5), np.log(8e-5)))) if "presliding" in base else 0.0,
    )
    if "coulomb" in names:
        axis = axis._replace(coulomb=0.0)
    force = coulomb * float(np.exp(rng.uniform(np.log(0.0012), np.log(0.006))))
    position = {"spring-pull": 2e-7, "force-drive": 5e-7}.get(plan.rig, 0.0)
    tip = TipTruth(
        gain=float(rng.uniform(3.5e-8, 5.5e-8)),
        offset_x=float(rng.normal(0, 2e-7)),
        offset_y=float(rng.normal(0, 2e-7)),
    )
    if plan.rig == "actuator-tip":
        position = float(rng.uniform(5e-9, 1.3e-8))
    needed = [entry.needs for entry in hidden if entry.needs]
    idle = plan.idle
    channels = []
    for name, need in (("normal_load", "load"), ("temperature", "temperature")):
        wanted = idle if idle is not None else bool(rng.random() < 0.42)
        if need in needed or (wanted and plan.rig != "actuator-tip"):
            channels.append(name)
    floor = {"velocity-drive": force, "spring-pull": force}.get(plan.rig, position)
    if how.few_columns and (names & {"backlash", "sensor_lag", "sensor_delay", "sensor_quantisation"}):
        how = replace(how, few_columns=False)
    if plan.rig == "force-drive" and any(key.startswith("sensor_") for key in names):
        how = replace(how, few_columns=False)
    return Rig(
        plan, base, {"coulomb": coulomb, "noise": floor}, how, radius, axis, tip, force, position, tuple(channels)
    )
