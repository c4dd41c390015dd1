"""The rig kinds `spring-pull` and `force-drive`: a mass that a spring or a known force drives against friction."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sim.effects import catalogue
from sim.effects.effect import Effect
from sim.effects.friction.viscous import EFFECT as DAMPER
from sim.integration import drive
from sim.integration.simulate import simulate
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Rig
from sysid.experiment.known import Unknown
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.effect_terms import Values, values_of
from sysid.prediction.force_balance.predict import predict_balance
from sysid.prediction.force_balance.prepare import prepare_driven_mass
from sysid.prediction.force_balance.record import ROUNDING, ForceBalanceRecord
from sysid.prediction.model import Model
from sysid.prediction.prepared_record import PredictsChannels
from sysid.prediction.resampling import uniform
from sysid.prediction.rig_model import Channels, Effects, Noises, RigModel, RigParameters, Start
from sysid.prediction.sensors import sensed
from sysid.signals import GaussianFilter, NoiseSpectrum, filled

LEAST_ROWS = 200
"""Scored rows below which a mass is not read off a record."""


class _DrivenMass(RigModel):
    form = "force_balance"
    along_motion = True
    predict = staticmethod(predict_balance)

    def prepare(self, rig: Rig, records: Sequence[Record], noise: Noises, values: Values) -> list[ForceBalanceRecord]:
        prepared: list[ForceBalanceRecord] = []
        width, stiffness = None, values.get("rig.pull_stiffness")
        longest_step = max(record.step for record in records)
        for record in records:
            balance = prepare_driven_mass(
                self, record, noise, values["rig.mass"], stiffness, rig.input_hold, width, longest_step
            )
            width = balance.full_filter.width if balance.full_filter is not None else None
            prepared.append(balance)
        return prepared

    def shows(self, effect: Effect, records: Sequence[ForceBalanceRecord], channels: set[str]) -> bool:
        # The motion is too smooth for the course of a signal between the rows to matter.
        return not (effect.between_rows or effect.acts_on == "piezo" or "imposed_motion" in effect.needs)

    def with_nuisances(self, model: Model, records: Sequence[ForceBalanceRecord]) -> Model:
        """The model with the stretch of a rigid friction state free, below the position's noise: it sets how fast the
        friction reverses, which affects the force balance though it does not show in the position."""
        rigid = next((e for e in model.effects if e.friction_state is not None and e.friction_state.rigid), None)
        noises = [r.position_noise for r in records if r.reversals is not None]
        if rigid is None or not noises:
            return model
        key, least = f"{rigid.name}.stretch", rigid.parameter("stretch").low
        highest = max(*noises, 10.0 * least)
        start = max(0.05 * highest, least)
        unknown = Unknown(key, start, max(1e-4 * highest, least), highest, start)
        return replace(model, values={**model.values, key: start}, unknowns=(*model.unknowns, unknown))

    def simulate(self, rig: Rig, record: Record, effects: Effects, values: Values, start: Start | None) -> Channels:
        """mass x'' = force of spring or drive - friction; by default from rest, on a spring without force."""
        pull = record.channels.get("pull_position")
        start = start or Start(0.0 if pull is None else float(pull[0]))
        return simulate_driven_mass(rig, record.time, record.channels, effects, values, start)


class SpringPull(_DrivenMass):
    """Position of the end of a spring in, position of the mass or force of the spring out."""

    name = "spring-pull"

    def parameters(self, rig: Rig, records: Sequence[Record], noise: Noises) -> RigParameters:
        found = RigParameters(rig)
        stiffness = found.put("pull_stiffness", lambda: _guess_stiffness(records))
        found.put("mass", lambda: _guess_mass(self, records, stiffness, noise))
        if all({"position", "spring_force"} <= record.channels.keys() for record in records):
            # A dashpot beside the spring shows where its force and its stretch are both measured.
            step, duration = records[0].step, float(np.ptp(records[0].time))
            found.put_free("pull_damping", 0.0, (0.0, stiffness * duration), stiffness * step)
        return found

    def shows(self, effect: Effect, records: Sequence[ForceBalanceRecord], channels: set[str]) -> bool:
        # With one channel a gap is not distinguishable from a longer pull.
        both = {"position", "spring_force"} <= channels
        return super().shows(effect, records, channels) and effect.acts_on != "drive" and (both or not effect.opens_gap)

    def with_input_noise(self, records: Sequence[ForceBalanceRecord], noise: Noises) -> Noises:
        pull, like = noise.get("pull_position"), {"spring_force": records[0].pull_stiffness, "position": 1.0}
        if pull is None or pull.source == "given":
            return noise
        shown = (pull.value * factor / noise[name].value for name, factor in like.items() if name in noise)
        # Less than a hundredth of the variance of the balance is not attributed to the path.
        return noise if max(shown) > 0.1 else {name: one for name, one in noise.items() if name != "pull_position"}


class ForceDrive(_DrivenMass):
    """Drive force in, position or velocity of the mass out."""

    name = "force-drive"

    def parameters(self, rig: Rig, records: Sequence[Record], noise: Noises) -> RigParameters:
        found = RigParameters(rig)
        found.put("mass", lambda: _guess_mass(self, records, None, noise))
        return found

    def shows(self, effect: Effect, records: Sequence[ForceBalanceRecord], channels: set[str]) -> bool:
        if not super().shows(effect, records, channels):
            return False
        if effect.acts_on in ("drive", "sensor"):
            # What is constant is the same after any lag or gain.
            return effect.inverse is not None and not all(record.is_free for record in records)
        return not effect.opens_gap

    def with_input_noise(self, records: Sequence[ForceBalanceRecord], noise: Noises) -> Noises:
        known, motion = noise.get("drive_force"), noise.get("position")
        # Of a log that was filtered the motion near the highest frequency is not known.
        if known is None or known.source == "given" or motion is None or motion.filtered:
            return noise
        share = _sensor_share([record for record in records if record.role == "fit"])
        if share is None:
            return noise
        largest = max(float(np.max(np.abs(r.applied))) for r in records if r.applied is not None)
        value = max(float(np.sqrt(share)) * known.value, ROUNDING * largest)
        return {**noise, "drive_force": replace(known, value=value, filtered=False)}

    def sensor_places(self, channels: Sequence[str]) -> tuple[str | None, ...]:
        # How a command runs from row to row is the same for the whole log.
        return (None,)


def simulate_driven_mass(
    rig: Rig,
    time: np.ndarray,
    inputs: Mapping[str, np.ndarray],
    effects: Sequence[Effect],
    values: Values,
    at: Start,
    tolerance: float = 1e-7,
) -> dict[str, np.ndarray]:
    """Measured channels (n,) of a driven mass: position, velocity, and the force of the pulling spring."""
    kept = tuple(e for e in effects if e.acts_on != "sensor")
    finer, step = FINER if len(kept) < len(effects) else 1, float(time[1] - time[0])
    damping = values.get("rig.pull_damping", 0.0)
    laws = [values_of(e, values) for e in kept]
    if damping:
        kept, laws = (*kept, DAMPER), [*laws, DAMPER.values_type(damping)]
    run = simulate(
        catalogue.Model(kept, tuple(laws)),
        _drive(rig, time, inputs, values),
        time[0] + step / finer * np.arange(finer * (time.size - 1) + 1),
        mass=values["rig.mass"],
        position=at.position,
        velocity=at.velocity,
        bristle=at.bristle,
        travelled=at.travelled,
        contact_age=at.contact_age,
        load=inputs.get("normal_load", 1.0),
        temperature=inputs.get("temperature", 0.0),
        tolerance=tolerance,
        most_steps=MOST_STEPS_PER_ROW * time.size,
    )
    channels = {"position": run.position, "velocity": run.velocity}
    if "pull_position" in inputs:
        channels = {"position": run.position, "spring_force": run.drive - damping * run.velocity}
    return {name: signal[::finer] for name, signal in sensed(effects, values, channels, step / finer).items()}


FINER = 8
"""Instants per row at which a sensor's effect is evaluated: the motion is not linear from row to row."""

MOST_STEPS_PER_ROW = 200
"""Attempted steps per row, on average, after which an integration is given up."""


def _drive(rig: Rig, time: np.ndarray, inputs: Mapping[str, np.ndarray], values: Values) -> drive.Drive:
    if "pull_position" in inputs:
        pull, stiffness = inputs["pull_position"], values["rig.pull_stiffness"]
        lead = values.get("rig.pull_damping", 0.0) / stiffness
        return drive.pulled_spring(time, pull + lead * np.gradient(pull, time), stiffness)
    return (drive.force if rig.input_hold == "linear" else drive.held_force)(time, inputs["drive_force"])


def _guess_stiffness(records: Sequence[Record]) -> float:
    """Slope of spring force over stretch, where both are measured."""
    for record in records:
        c = record.channels
        if {"pull_position", "position", "spring_force"} <= set(c):
            stretch, force = c["pull_position"] - c["position"], c["spring_force"]
            ok = np.isfinite(stretch) & np.isfinite(force)
            if np.ptp(stretch[ok]) > 0:
                return abs(float(np.polyfit(stretch[ok], force[ok], 1)[0])) or 1.0
    raise InputError(
        f"{records[0].file}: without rig.known.pull_stiffness both 'position' and 'spring_force' must be recorded, "
        "since the stiffness is then read off them"
    )


UPPER_BAND = 0.7, 1.4
"""Widths, in steps, of two filters whose difference is the upper band."""

MODEL_ERROR, CERTAIN = 0.2, 3.0
"""Part of the force in the upper band that mass and friction may leave wrong, and standard deviations, by which the
share that a sensor adds must be below all of it."""

FEEDBACK_ROWS = 12
"""Last rows of the position to which a controller responds near the highest frequency."""

BLOCKS = 24
"""Blocks of a record, from whose scatter the standard deviation of a share follows."""


def _sensor_share(records: Sequence[ForceBalanceRecord]) -> float | None:
    """Part of the variance of a drive force's noise that a sensor adds; None if all of it may be.

    What a controller puts into a logged command moves the mass, and the balance r = F - m a is without it; the noise
    of a sensor is in r as it is in F. Near the highest frequency the share is the covariance of r and F over the
    variance of that noise (Soderstrom and Stoica, System Identification (1989), chapter 8 and section 10.4). Feedback
    of the position's noise lowers it: there a sensor adds what a regression on the last positions leaves.
    """
    squares, products, own, rests = [], [], [], []
    for record in records:
        position, force = record.raw_position, record.applied
        if record.is_free or record.stick_fraction is None or not record.redrawn:
            return None
        redrawn = record.redrawn[0]
        assert position is not None and force is not None and redrawn.applied is not None
        narrow, wide = (GaussianFilter(width * record.step, record.step, record.size) for width in UPPER_BAND)
        rows = np.flatnonzero(record.valid["drive_force"] & (record.stick_fraction <= 0.0))
        rest = narrow(force) - wide(force) - record.mass * (narrow(position, 2) - wide(position, 2))
        upper, drawn = (narrow(x) - wide(x) for x in (force, redrawn.applied - force))
        rest_of_feedback = _beside_feedback(force, position, redrawn.applied - force, rows)
        rests += [] if rest_of_feedback is None else [rest_of_feedback]
        for block in np.array_split(rows, BLOCKS):
            squares.append(float(upper[block] @ upper[block]))
            products.append(float(upper[block] @ rest[block]))
            own.append(float(drawn[block] @ drawn[block]))
    whole, noises = sum(squares), sum(own)
    if not noises > 0.0:
        return None
    share = sum(products) / noises
    std = float(np.linalg.norm(np.array(products) - share * np.array(own))) / noises
    if len(rests) == len(records):
        share, std = float(np.mean(rests)), 0.0
    certain = share + CERTAIN * std + MODEL_ERROR * whole / noises < 1.0
    return min(max(share, 0.0), 1.0) if certain else None


def _beside_feedback(force: np.ndarray, position: np.ndarray, noise: np.ndarray, rows: np.ndarray) -> float | None:
    """Part of the variance of `noise` that a force, (n,) each, contains in some rows (k,) beside its regression on the
    last positions; none where that explains no more than chance would. Fourth differences do not show the motion."""
    order = 4
    rows = rows[rows >= order + FEEDBACK_ROWS] - order
    force, position, noise = (np.diff(x, order) for x in (force, position, noise))
    # The force at a row has a part of the command of the next.
    rows = rows[rows < position.size - 1]
    before = np.column_stack([position[rows + 1 - k] for k in range(FEEDBACK_ROWS)])
    rest = force[rows] - before @ np.linalg.lstsq(before, force[rows])[0]
    whole, own, left = (float(x @ x) for x in (force[rows], noise[rows], rest))
    explains = whole - left > CERTAIN**2 * FEEDBACK_ROWS / max(rows.size, 1) * whole
    return left / own if explains and own > 0.0 else None


def _guess_mass(
    rig: PredictsChannels, records: Sequence[Record], stiffness: float | None, noise: Mapping[str, Noise]
) -> float:
    """Mass from the force balance: the force regressed on acceleration, one, and friction by speed, away from
    reversals; through a filter so wide that the acceleration is clear of its noise, and oscillations of the mass on its
    bristles, whose force is opposite to that of the inertia, are not seen."""
    # In a coast-down or free oscillation the drive force never changes.
    forces = [(r, r.channels.get("drive_force", np.arange(2))) for r in records if r.role == "fit"]
    driven = [r for r, force in forces if np.nanmax(force) > np.nanmin(force)]
    if not driven:
        raise InputError(
            f"{records[0].file}: column 'drive_force' does not change; without rig.known."
            f"{'inertia' if records[0].rotary else 'mass'} only the ratio of the forces to it is identifiable: give "
            "it, or a record that is driven"
        )
    mass = _largest_mass(driven[0], stiffness, noise)
    for _ in range(6):
        balance = prepare_driven_mass(rig, driven[0], noise, mass, stiffness)
        ok = balance.valid[balance.force_channel]
        if ok.sum() < LEAST_ROWS:
            # A filter as wide as this guess requires leaves nothing between the gaps.
            mass *= 0.1
            continue
        columns = np.column_stack(_regressors(balance))
        away = ok & (balance.axis.reversal_distance > np.quantile(balance.axis.reversal_distance[ok], NEAR_REVERSALS))
        solution, *_ = np.linalg.lstsq(columns[away], balance.force[away], rcond=None)
        return float(solution[0]) if solution[0] > 0 else mass
    return mass


NEAR_REVERSALS = 0.3
"""Share of the rows, nearest to a reversal, that are left out: there the force of bristles resembles an inertia."""

SPEEDS = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)
"""Quantiles of the speed between which the friction is linear in it."""


def _regressors(balance: ForceBalanceRecord) -> list[np.ndarray]:
    """Acceleration, one, and hat functions of the speed in the direction of motion, each (n,), all filtered."""
    assert balance.acceleration is not None and balance.full_filter is not None and balance.direction is not None
    speed = np.abs(balance.axis.velocity)
    knots = np.unique(np.quantile(speed, SPEEDS))
    hats = [np.interp(speed, knots, one) for one in np.eye(knots.size)]
    return [balance.acceleration, np.ones(speed.size), *(balance.full_filter(balance.direction * h) for h in hats)]


def _largest_mass(record: Record, stiffness: float | None, noise: Mapping[str, Noise]) -> float:
    """Mass that would need all of the force: its size over that of the acceleration, where that exceeds its noise. It
    sets the width of the filter of the first estimate."""
    _, step, channels, _ = uniform(record)
    found = _motion_and_force({name: filled(values)[0] for name, values in channels.items()}, stiffness, noise)
    if found is None:
        return 1.0
    position, force, sigma, spectrum = found
    width = step
    while width < position.size * step / 40.0:
        complementary_filter = GaussianFilter(width, step, position.size)
        acceleration = float(np.std(complementary_filter(position, 2)))
        if sigma * complementary_filter.noise_gain(2, spectrum) < 0.2 * acceleration:
            return float(np.std(force)) / acceleration
        width *= 2.0
    return 1.0


def _motion_and_force(
    channels: Mapping[str, np.ndarray], stiffness: float | None, noise: Mapping[str, Noise]
) -> tuple[np.ndarray, np.ndarray, float, NoiseSpectrum] | None:
    """Position and force (n,) of a driven mass, with deviation and spectrum of the position's noise; of a body pulled
    by a spring one of the two follows from the other."""
    position, pull = channels.get("position"), channels.get("pull_position")
    force = channels.get("drive_force" if stiffness is None else "spring_force")
    if pull is not None and stiffness is not None:
        if position is None and force is not None:
            known = noise["spring_force"]
            return pull - force / stiffness, force, known.value / stiffness, known.spectrum
        if position is not None and force is None:
            force = stiffness * (pull - position)
    if position is None or force is None:
        return None
    return position, force, noise["position"].value, noise["position"].spectrum
