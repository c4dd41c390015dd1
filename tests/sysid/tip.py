"""A tip on two piezos, made up by the test."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tests.experiments import write_rig

SPACING, HEIGHT, BIAS, GAIN, TIP_NOISE = 0.046, 0.02, 75.0, 1.1e-7, 2e-9
KNOWN = {"piezo_spacing": f"{SPACING} m", "tip_height": f"{HEIGHT} m", "bias_voltage": f"{BIAS} V"}


def tip_record(time: np.ndarray, drives: Any, moved: Any, noise: Any = (0.0, 0.0)) -> dict[str, np.ndarray]:
    """Columns of a record.

    Args:
        time: s, (n,).
        drives: voltages less their bias, V, (2, n).
        moved: displacements of the piezos, m, (2, n).
        noise: of the tip, m, (2, n).
    """
    columns = {"time": time, "voltage_1": BIAS + drives[0], "voltage_2": BIAS + drives[1]}
    return columns | {
        "tip_x": -HEIGHT / SPACING * (moved[1] - moved[0]) + noise[0],
        "tip_y": 0.5 * (moved[0] + moved[1]) + noise[1],
    }


def write_tip(folder: Path, records: Mapping[str, Mapping[str, np.ndarray]], noise: float = TIP_NOISE) -> Path:
    """Write an experiment of such records with the `noise` of the tip, m."""
    stated = {"tip_x": noise, "tip_y": noise}
    return write_rig(folder, "actuator-tip", records, known=KNOWN, noise=stated)
