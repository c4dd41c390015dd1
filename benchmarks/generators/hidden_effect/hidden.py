"""Which effects a rig can hide: parameters drawn at full size, those among them that scale, and every right answer."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

VELOCITY, SPRING, SERVO, TIP = "velocity-drive", "spring-pull", "force-drive", "actuator-tip"
AXIS = (VELOCITY, SPRING, SERVO)


@dataclass(frozen=True)
class Draw:
    """One draw of an effect. `scaled` vanish with it (factor between `least` and `limit`); `fixed` are its shape.

    Keys: of AxisTruth or TipTruth, `sensor.NAME` of SensorTruth, `time.KIND` of unlisted things that happen in time.
    """

    scaled: dict[str, float]
    fixed: dict[str, float] = field(default_factory=dict)
    limit: float = 8.0
    least: float = 0.0


Drawer = Callable[[np.random.Generator, dict], Draw]


@dataclass(frozen=True)
class Hidden:
    """An effect to hide: where it can show, how it is drawn (from a generator and the rig's numbers), what is right."""

    name: str
    rigs: tuple[str, ...]
    draw: Drawer
    accept: tuple[str, ...]
    where: tuple[str, ...] = ()
    needs: str = ""
    base: tuple[str, ...] | None = None
    rotary_only: bool = False

    @property
    def unlisted(self) -> bool:
        return self.accept == ("unexplained",)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


HIDDEN: dict[str, Hidden] = {}


def _listed(name: str, rigs: tuple[str, ...], draw: Drawer, *also: str, **more) -> None:
    HIDDEN[name] = Hidden(name, rigs, draw, (name, *also), **more)


def _unlisted(name: str, rigs: tuple[str, ...], draw: Drawer, *where: str) -> None:
    HIDDEN["UNKNOWN_" + name] = Hidden("UNKNOWN_" + name, rigs, draw, ("unexplained",), where)


_listed("coulomb", AXIS, lambda r, b: Draw({"coulomb": b["coulomb"]}, limit=1.0, least=1.0), base=("viscous",))
_listed("viscous", AXIS, lambda r, b: Draw({"viscous": _log(r, 4, 40)}), base=("coulomb",))
_listed(
    "stribeck",
    AXIS,
    lambda r, b: Draw(
        {"stribeck": b["coulomb"] * _uniform(r, 0.15, 0.5)},
        {"stribeck_velocity": _log(r, 1e-3, 1e-2), "stribeck_lorentzian": 1.0},
    ),
    base=("coulomb", "viscous"),
)
_listed(
    "presliding",
    AXIS,
    lambda r, b: Draw({"presliding": (width := _log(r, 3e-6, 6e-5))}, limit=6.0, least=2e-6 / width),
)
_listed(
    "frictional_lag",
    (VELOCITY, SERVO, SPRING),
    lambda r, b: Draw({"stribeck_delay": _log(r, 4e-3, 0.03)}, limit=5.0),
    base=("coulomb", "viscous", "stribeck"),
)
_listed(
    "dwell_strengthening",
    AXIS,
    lambda r, b: Draw(
        {"dwell": b["coulomb"] * _uniform(r, 0.03, 0.12)},
        {"dwell_time": _log(r, 0.005, 0.1), "dwell_distance": _log(r, 1e-5, 1.5e-4)},
        limit=3.0,
    ),
)
_listed(
    "direction_asymmetry",
    AXIS,
    lambda r, b: Draw({"asymmetry": _sign(r) * _uniform(r, 0.05, 0.25)}, limit=3.0),
    "constant_bias",
)
_listed(
    "constant_bias",
    AXIS,
    lambda r, b: Draw({"bias": _sign(r) * b["coulomb"] * _uniform(r, 0.05, 0.25)}, limit=3.0),
    "direction_asymmetry",
)
_listed(
    "position_dependent_friction",
    AXIS,
    lambda r, b: Draw(
        {"position_wave": _uniform(r, 0.08, 0.3)},
        {"position_pitch": _log(r, 1.5e-3, 0.025), "position_phase": _uniform(r, 0, 6.28)},
        limit=2.5,
    ),
)
_listed(
    "load_dependent_friction",
    AXIS,
    lambda r, b: Draw({"load_share": _uniform(r, 0.6, 1.5)}, limit=1.3),
    needs="load",
)
_listed(
    "temperature_dependent_friction",
    AXIS,
    lambda r, b: Draw({"temperature_rate": _uniform(r, 0.012, 0.04)}, limit=3.0),
    needs="temperature",
)
_listed(
    "run_in",
    (VELOCITY, SERVO, SPRING),
    lambda r, b: Draw({"run_in": _uniform(r, 0.15, 0.5)}, {"run_in_distance": _log(r, 0.01, 0.1)}, limit=2.5),
)
_listed("quadratic_drag", AXIS, lambda r, b: Draw({"quadratic": _log(r, 300, 3000)}), base=("coulomb", "viscous"))
_listed("cable_spring", AXIS, lambda r, b: Draw({"spring": _log(r, 8, 80)}))
_listed(
    "magnetic_cogging",
    AXIS,
    lambda r, b: Draw(
        {"cogging": b["coulomb"] * _uniform(r, 0.05, 0.25)},
        {"cogging_pitch": _log(r, 8e-4, 8e-3), "cogging_phase": _uniform(r, 0, 6.28)},
        limit=3.0,
    ),
)
_listed(
    "gravity_torque",
    AXIS,
    lambda r, b: Draw({"gravity": _sign(r) * b["coulomb"] * _uniform(r, 0.2, 0.8)}, limit=3.0),
    rotary_only=True,
)
_listed("backlash", (SPRING,), lambda r, b: Draw({"backlash": _log(r, 2e-5, 3e-4)}))
_listed(
    "flexible_mode",
    (SERVO, SPRING, TIP),
    lambda r, b: Draw(
        {"flexible_share": _uniform(r, 0.05, 0.3)},
        {"flexible_frequency": _log(r, 25, 110), "flexible_damping": _log(r, 0.01, 0.05)},
        limit=2.5,
    ),
)
_listed(
    "bristle_damping",
    (VELOCITY,),
    lambda r, b: Draw({"bristle_damping": _log(r, 30, 300)}, limit=20.0),
    base=("presliding", "viscous"),
)
_listed("drive_lag", (SERVO, TIP), lambda r, b: Draw({"drive_lag": _log(r, 2e-3, 0.02)}, limit=3.0), "sensor_lag")
_listed("drive_delay", (SERVO, TIP), lambda r, b: Draw({"drive_delay": _log(r, 2e-3, 0.02)}, limit=3.0), "sensor_delay")
_listed("piezo_hysteresis", (TIP,), lambda r, b: Draw({"hysteresis": _uniform(r, 0.2, 0.7)}, limit=2.5))
_listed(
    "piezo_creep",
    (TIP,),
    lambda r, b: Draw({"creep": _uniform(r, 0.03, 0.15)}, {"creep_time": _log(r, 0.4, 3.0)}),
)
_listed("gain_mismatch", (TIP,), lambda r, b: Draw({"mismatch": _sign(r) * _uniform(r, 0.02, 0.12)}, limit=4.0))
_listed(
    "sensor_lag",
    (VELOCITY, SPRING, TIP),
    lambda r, b: Draw({"sensor.lag": _log(r, 2e-3, 0.02)}, limit=3.0),
    "drive_lag",
)
_listed(
    "sensor_delay",
    (VELOCITY, SPRING, TIP),
    lambda r, b: Draw({"sensor.delay": _log(r, 2e-3, 0.02)}, limit=3.0),
    "drive_delay",
)
_listed(
    "sensor_nonlinearity",
    (TIP, SPRING, VELOCITY),
    lambda r, b: Draw({"sensor.bend": _uniform(r, 0.02, 0.1)}, {"sensor.lean": _uniform(r, -1.5, 1.5)}, limit=2.5),
)
_listed(
    "sensor_drift",
    (TIP, VELOCITY, SPRING),
    lambda r, b: Draw(
        {"sensor.drift": _sign(r) * _uniform(r, 0.03, 0.2)}, {"sensor.drift_power": _uniform(r, 0.6, 1.3)}
    ),
)
_listed(
    "sensor_quantisation",
    (*AXIS, TIP),
    lambda r, b: Draw({"sensor.step": b["noise"] * _log(r, 15, 60)}, limit=6.0),
)

_unlisted(
    "event",
    (*AXIS, TIP),
    lambda r, b: Draw({f"time.{r.choice(['step', 'bump', 'level'])}": _uniform(r, 0.15, 0.4)}),
    "time",
)
_unlisted("cubic_spring", AXIS, lambda r, b: Draw({"cubic": b["coulomb"] * _uniform(r, 2e4, 1e6)}), "position")
_unlisted(
    "floor_vibration", (*AXIS, TIP), lambda r, b: Draw({"time.vibration": _uniform(r, 0.05, 0.3)}), "frequency", "time"
)
_unlisted("texture", AXIS, lambda r, b: Draw({"texture": _uniform(r, 0.04, 0.1)}, limit=2.0), "position")
_unlisted("wander", (*AXIS, TIP), lambda r, b: Draw({"time.wander": _uniform(r, 0.05, 0.2)}), "time", "frequency")
_unlisted("sticking", AXIS, lambda r, b: Draw({"time.sticking": _uniform(r, 0.15, 0.5)}), "time")
