"""A stage pushed by a tip, in code of its own: plain Euler steps, laws that share nothing with the program's.

Pads: rigid, they take away what speed they can. Contact: spring and dashpot that yield, or do not. Stacks: Bouc-Wen.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np

SPACING, HEIGHT, BIAS, GAIN, MASS = 0.046, 0.02, 75.0, 1.1e-7, 3.0
STIFFNESS, DAMPING = 8e6, 400.0
SAMPLE, STEP = 5e-4, 1e-5
NOISE = 2e-9


@dataclass(frozen=True)
class Truth:
    """What the rig does.

    Args:
        pad_force: N.
        slip: most that the contact holds at rest, N; infinite: it never slips.
        load_exponent: of what the contact holds, in its load.
        press: how far the tip is pressed in at the bias, m.
        mismatch: of the second stack's gain.
        hysteresis: part of the stretch.
    """

    pad_force: float = 1.5
    slip: float = math.inf
    load_exponent: float = 0.0
    press: float = 4e-6
    mismatch: float = 0.0
    hysteresis: float = 0.0


def voltages(seconds: float, seed: int, lift: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, and two voltages: leans of many sizes and speeds, the tip raised and lowered by `lift` volts besides."""
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds / SAMPLE)) * SAMPLE
    lean = np.zeros(time.size)
    for frequency in (1.3, 3.1, 7.7, 14.0):
        lean += random.uniform(5.0, 12.0) * np.sin(2 * np.pi * frequency * time + random.uniform(0.0, 6.0))
    lean = (lean - lean[0]) * np.minimum(time / 0.1, 1.0)
    up = lift * np.sin(2 * np.pi * 4.3 * time + random.uniform(0.0, 6.0)) * np.minimum(time / 0.1, 1.0)
    return time, BIAS + up - lean, BIAS + up + lean


def _stretched(volts: np.ndarray, gain: float, hysteresis: float) -> list[float]:
    """Bouc-Wen: h' = u' (1 - |h|/w) where it grows, u' where it falls."""
    out, h = [], 0.0
    width = 12.0
    before = float(volts[0])
    for u in volts.tolist():
        du = u - before
        before = u
        h += du * (1.0 - abs(h) / width) if h * du > 0.0 else du
        out.append(gain * (u - BIAS - hysteresis * h))
    return out


def motion(truth: Truth, time: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Position of the stage at the samples, m."""
    fine = np.arange(0.0, time[-1] + 0.5 * STEP, STEP)
    d1 = np.array(_stretched(np.interp(fine, time, first), GAIN, truth.hysteresis))
    d2 = np.array(_stretched(np.interp(fine, time, second), GAIN * (1.0 + truth.mismatch), truth.hysteresis))
    return np.interp(time, fine, _pushed(d1, d2, truth.pad_force, truth.slip, truth.load_exponent, truth.press))


@numba.njit
def _pushed(
    d1: np.ndarray, d2: np.ndarray, pad_force: float, slip: float, load_exponent: float, press: float
) -> np.ndarray:
    """Position at every step, m."""
    x = v = pull = 0.0
    lost = pad_force / MASS * STEP
    along = -HEIGHT / SPACING * (d2[0] - d1[0])
    out = np.empty(d1.size)
    for i in range(d1.size):
        tip = -HEIGHT / SPACING * (d2[i] - d1[i])
        load = max(1.0 + 0.5 * (d1[i] + d2[i]) / press, 0.0)
        most = slip * load**load_exponent if load > 0.0 else 0.0
        slide = tip - along - v * STEP
        along = tip
        pull += STIFFNESS * slide
        held = min(max(pull + DAMPING * slide / STEP, -most), most)
        pull = min(max(pull, -most), most)
        free = v + held / MASS * STEP
        v = math.copysign(max(abs(free) - lost, 0.0), free)
        x += v * STEP
        out[i] = x
    return out


def write_experiment(folder: Path, truth: Truth, effects: list[str], lift: float = 0.0) -> Path:
    """An experiment folder with two records to fit and one to hold out; returns the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for k, role in enumerate(("fit", "fit", "validate")):
        time, first, second = voltages(1.5, 11 + k, lift)
        x = motion(truth, time, first, second) + NOISE * np.random.default_rng(k).standard_normal(time.size)
        rows = np.column_stack([time, first, second, x])
        name = f"run_{k}.csv"
        header = "time [s],voltage_1 [V],voltage_2 [V],position [m]"
        np.savetxt(folder / name, rows, delimiter=",", header=header, comments="", fmt="%.10g")
        entries.append(f'[[record]]\nfile = "{name}"\nrole = "{role}"\n')
    press = f'press = "{truth.press} m"\n' if lift else ""
    known = (
        f'mass = "{MASS} kg"\npiezo_spacing = "{SPACING} m"\ntip_height = "{HEIGHT} m"\nbias_voltage = "{BIAS} V"\n'
        f'contact_stiffness = "{STIFFNESS} N/m"\n'
        f'piezo_gain = "{GAIN} +- {0.02 * GAIN} m/V"\n'
    )
    listed = ", ".join(f'"{name}"' for name in effects)
    (folder / "experiment.toml").write_text(
        f'schema = 1\n\n[rig]\nkind = "friction-drive"\n\n[rig.known]\n{known}{press}\n'
        f"[model]\neffects = [{listed}]\n\n" + "\n".join(entries) + f'\n[noise]\nposition = "{NOISE} m"\n'
    )
    return folder
