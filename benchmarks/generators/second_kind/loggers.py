"""Loggers: noise of a channel at standstill, column names, units and time stamps, and the text of experiment.toml."""

import json
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .machines import Machine, log_uniform

NAMES = {
    "time": ("t", "Time", "Timestamp"),
    "position": ("x_stage", "Enc_Pos", "S1.ActPos", "ENCODER"),
    "velocity": ("v_act", "S1.ActVel"),
    "friction_force": ("Fx", "AI0", "LoadCell_1"),
    "spring_force": ("F_meas", "AI1", "LoadCell_2"),
    "drive_force": ("u_cmd", "MC_SetForce", "Iq_force"),
    "pull_position": ("Carriage", "S2.ActPos"),
    "normal_load": ("Fz", "Load"),
    "temperature": ("Pt100", "T_bearing"),
}
LINEAR = {"time": ("s", "ms"), "length": ("m", "mm", "um"), "force": ("N", "mN")}
ROTARY = {"time": ("s", "ms"), "length": ("rad", "deg", "mrad"), "force": ("N*m", "mN*m")}
IN_SI = {"ms": 1e-3, "mm": 1e-3, "um": 1e-6, "mN": 1e-3, "mN*m": 1e-3, "mrad": 1e-3, "deg": np.pi / 180.0}
KINDS = {
    "time": "time", "position": "length", "pull_position": "length", "tip_x": "length", "tip_y": "length",
    "velocity": "speed", "friction_force": "force", "spring_force": "force", "drive_force": "force",
    "normal_load": "load",
}  # fmt: skip


@dataclass(frozen=True)
class Logger:
    """How a case is logged: `lsb` and `hum` over the noise, `rho` of AR(1) noise, share of `outliers`, header style."""

    colour: str
    rho: float
    hum: float
    mains: float
    outliers: float
    lsb: float
    jitter: bool
    style: int
    few: bool
    extra_columns: int
    given: bool
    mass: str
    units: dict[str, str]
    names: dict[str, str]


def draw_logger(rng: np.random.Generator, m: Machine) -> Logger:
    """A logger for a machine."""

    def sometimes(share: float, value: float) -> float:
        return value if rng.random() < share else 0.0

    choices = ROTARY if m.rotary else LINEAR
    units: dict[str, str] = {}
    for name, kind in KINDS.items():
        if kind == "speed":
            units[name] = str(rng.choice(choices["length"])) + "/s"
        else:
            options = LINEAR["force"] if kind == "load" else choices[kind]
            units[name] = options[0] if rng.random() < 0.6 else str(rng.choice(options))
    return Logger(
        str(rng.choice(["white", "ar", "pink"], p=[0.6, 0.25, 0.15])), rng.uniform(0.4, 0.97),
        sometimes(0.2, rng.uniform(0.3, 0.7)), float(rng.choice([50.0, 60.0])),
        sometimes(0.15, log_uniform(rng, 2e-4, 2e-3)), sometimes(0.35, rng.uniform(0.5, 1.8)),
        m.rig in ("velocity-drive", "actuator-tip") and rng.random() < 0.2,
        int(rng.choice([0, 1, 2])), bool(rng.random() < 0.5), int(rng.choice([0, 0, 1, 2])), bool(rng.random() < 0.6),
        str(rng.choice(["known", "uncertain", "unknown"])) if m.rig == "force-drive" else "known",
        units, {name: str(rng.choice(options)) for name, options in NAMES.items()},
    )  # fmt: skip


def standstill(rng: np.random.Generator, n: int, how: Logger, rate: float, *, plain: bool = False) -> np.ndarray:
    """Noise (n,) of unit rms at standstill, outliers and hum included (`plain`: white alone); no counts."""
    white = rng.standard_normal(n + 500)
    if plain or how.colour == "white":
        y = white[500:]
    elif how.colour == "ar":
        y = np.asarray(lfilter([1.0], [1.0, -how.rho], white))[500:] * np.sqrt(1.0 - how.rho**2)
    else:
        spectrum = np.fft.rfft(white)
        f = np.arange(spectrum.size) / white.size
        knee = 0.02 + 0.2 * how.rho**2
        y = np.fft.irfft(spectrum * np.sqrt(1.0 + knee / np.maximum(f, 5.0 / white.size)), white.size)[500:]
        y = y / np.std(y)
    if plain:
        return y
    strange = rng.random(n) < how.outliers
    y = y + strange * rng.choice([-1, 1], n) * rng.uniform(5.0, 12.0, n)
    hum = how.hum * np.sqrt(2.0) * np.sin(2 * np.pi * how.mains * np.arange(n) / rate + rng.uniform(0.0, 6.0))
    return (y + hum) / np.sqrt(1.0 + how.outliers * 76.0 + how.hum**2)


def counted(y: np.ndarray, step: float) -> np.ndarray:
    """`y` in whole converter steps."""
    return step * np.round(y / step) if step else y


def logged_noise(
    rng: np.random.Generator, y: np.ndarray, sigma: float, how: Logger, rate: float, *, plain: bool = False
) -> np.ndarray:
    """A signal with noise and converter steps whose rms together is `sigma` at standstill."""
    lsb = 0.0 if plain else how.lsb
    rest = np.sqrt(max(1.0 - lsb**2 / 12.0, 0.2))
    return counted(y + sigma * rest * standstill(rng, y.size, how, rate, plain=plain), lsb * sigma)


Table = dict[str, tuple[str, np.ndarray]]
"""For each column its unit in SI and its values."""


def as_text(rng: np.random.Generator, columns: Table, how: Logger, m: Machine) -> str:
    """The CSV text of SI columns in the logger's units, order and names."""
    names = [name for name in columns if name != "time"]
    if how.style == 2:
        rng.shuffle(names)
    headers, values = [], []
    for name in ["time", *names]:
        unit, y = columns[name]
        chosen = how.units.get(name, unit)
        scale = IN_SI.get(chosen.removesuffix("/s"), 1.0)
        headers.append(how.names.get(name, name) if how.style == 2 else f"{name} [{chosen}]")
        values.append(y / scale)
    n = values[0].size
    if how.extra_columns:
        headers.append("humidity [%]")
        values.append(np.round(45.0 + 0.02 * rng.standard_normal(n), 3))
    if how.extra_columns > 1:
        headers.append("status")
        values.append(np.full(n, 3.0))
    form = ",".join(["%.10g"] * len(values))
    rows = "\n".join(form % row for row in zip(*(v.tolist() for v in values), strict=True))
    return ",".join(headers) + "\n" + rows + "\n"


def time_stamps(rng: np.random.Generator, m: Machine, how: Logger) -> np.ndarray:
    """Times (rows,) in s of the rows; uneven by 8 % of a step, rounded to a tenth of a millisecond, if so."""
    t = np.arange(m.rows) * m.step
    if not how.jitter:
        return t
    uneven = np.round(t + 0.08 * m.step * np.clip(rng.standard_normal(m.rows), -3.0, 3.0), 4)
    uneven[0] = 0.0
    return uneven if np.all(np.diff(uneven) > 0.0) else t


def _quantity(value: float, unit: str, digits: int = 6) -> str:
    return f'"{value:.{digits}g} {unit}"'


def known(rng: np.random.Generator, m: Machine, how: Logger) -> dict[str, str]:
    """What the user knows of the machine, as the file writes it."""
    if m.rig == "actuator-tip":
        return {
            "piezo_spacing": _quantity(m.spacing * 1e3, "mm"),
            "tip_height": _quantity(m.height * 1e3, "mm"),
            "bias_voltage": _quantity(m.bias, "V"),
        }
    name, unit = ("inertia", "kg*m^2") if m.rotary else ("mass", "kg")
    lines: dict[str, str] = {}
    if m.rig == "spring-pull" or (m.rig == "force-drive" and how.mass == "known"):
        lines[name] = _quantity(m.mass, unit)
    elif m.rig == "force-drive" and how.mass == "uncertain":
        said = m.mass * (1.0 + 0.01 * rng.standard_normal())
        lines[name] = f'"{said:.5g} +- {0.01 * said:.1g} {unit}"'
    if m.rig == "spring-pull":
        lines["pull_stiffness"] = _quantity(m.stiffness, "N*m/rad" if m.rotary else "N/m")
    return lines


def experiment(m: Machine, how: Logger, lines: dict[str, str], columns: Table, noise: dict[str, float]) -> str:
    """The text of experiment.toml."""
    text = ["schema = 1", "", "[rig]", f'kind = "{m.rig}"', "", "[rig.known]"]
    text += [f"{name} = {value}" for name, value in lines.items()]
    text += ["", "[model]", f"effects = {json.dumps(list(m.base))}"]
    for role in ("fit", "validate"):
        text += ["", "[[record]]", f'file = "{role}.csv"', f'role = "{role}"']
        if how.style == 2:
            own = {name: how.names[name] for name in columns if name in how.names}
            said = {name: how.units.get(name, columns[name][0]) for name in columns}
            text.append("columns = {" + ", ".join(f"{k} = {json.dumps(v)}" for k, v in own.items()) + "}")
            text.append("units = {" + ", ".join(f"{k} = {json.dumps(v)}" for k, v in said.items()) + "}")
    if how.given:
        text += ["", "[noise]"]
        text += [f"{name} = {_quantity(value, columns[name][0], 3)}" for name, value in noise.items()]
    return "\n".join(text) + "\n"
