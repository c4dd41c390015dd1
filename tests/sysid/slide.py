"""A slide driven back and forth for a few seconds, its friction force made up by the test: the smallest experiment."""

from pathlib import Path

import numpy as np

from sysid.prediction.problem import Problem, load_problem

NOISE = 0.01
STEP = 1e-3
TIME = np.arange(2500) * STEP
VELOCITY = 0.02 * np.sin(2 * np.pi * TIME) + 0.01 * np.sin(2 * np.pi * 3.1 * TIME)
POSITION = np.cumsum(VELOCITY) * STEP
SIGN = np.sign(VELOCITY)


def slide(
    folder: Path,
    force: np.ndarray,
    effects: str,
    parameters: str = "",
    *,
    held_out: bool = False,
    noise: np.ndarray | float = NOISE,
    extra: dict[str, np.ndarray] | None = None,
) -> Problem:
    """Write the experiment into `folder` and load it.

    Args:
        folder: made where it is missing.
        force: friction force without noise, N, (n,).
        effects: of the model, as they stand in the file's list.
        parameters: `[model.parameters]` as text.
        held_out: write the same motion with other noise as a held-out record; else the end of the record is held out.
        noise: standard deviation of the noise put on the force, N, (n,) or one number; `NOISE` is what the file says.
        extra: further columns by header, or others in place of `TIME`, `POSITION` and `VELOCITY`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(3)
    records = ["fit", "validate"] if held_out else ["fit"]
    columns = {"time [s]": TIME, "position [m]": POSITION, "velocity [m/s]": VELOCITY, **(extra or {})}
    for name in records:
        table = np.column_stack([*columns.values(), force + noise * rng.standard_normal(force.size)])
        np.savetxt(
            folder / f"{name}.csv", table, "%.9g", ",", header=",".join([*columns, "friction_force [N]"]), comments=""
        )
    listed = "".join(f'[[record]]\nfile = "{name}.csv"\nrole = "{name}"\n' for name in records)
    (folder / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = [{effects}]\n{parameters}\n{listed}'
        f'[noise]\nfriction_force = "{NOISE} N"\n'
    )
    return load_problem(folder)
