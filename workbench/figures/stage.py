"""Figures of the studies of the driven stage."""

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np

from sim.stage.studies import coupling, ellipse, fine_motion, hunting, planar, positioning, tip_motion, travel_map
from sim.stage.studies.speed import HALF, HEIGHTS, LAWS, SpeedStudy
from workbench.figures.plot import GREY, INK, Plot, new_plot, styled

TRAVEL_INK = ("#1b4f72", "#b03a2e", "#1e8449", "#d68910", "#6c3483", "#17a2b8", "#795548", "#e84393")
LIFTED_TEXT = "a pad leaves its way"
LAW_TEXT = {"stopping": "X f: stops each turn", "coasting": "2 X f: coasts", "apex": "π X f: apex only"}


def stage_figures(studies: Mapping[str, Any]) -> dict[str, Plot]:
    """One figure for each study, by the name of its file."""
    return {f"stage_{name}": _STUDIES[name](study) for name, study in studies.items()}


@styled
def steps_figure(study: fine_motion.StepStudy) -> Plot:
    """Staircases: stage and tip in time."""
    figure, axes = new_plot(1, len(study.staircases), 3.7 * len(study.staircases), 3.4)
    for panel, (name, stairs) in zip(axes[0], study.staircases.items()):
        run = stairs.run
        panel.plot(run.time, run.apex(0)[:, 0] * 1e9, color=GREY, linewidth=0.7, label="apex of the tip")
        panel.plot(run.time, run.position[:, 0] * 1e9, color=INK[0], linewidth=0.9, label="stage")
        panel.set(xlabel="time (s)", ylabel="x (nm)")
        size = "one count" if name == "1_count" else name.replace("nm", " nm")
        asked, made = stairs.commanded_step * 1e9, stairs.mean_step * 1e9
        panel.set_title(f"{size} ({asked:.3g} nm commanded): {made:.3g} nm a step")
    axes[0, 0].legend(loc="lower center")
    figure.suptitle(f"Steps with the tip at rest on the stage; springs in series transmit {study.static:.2f} of it")
    return figure


@styled
def speed_figure(study: SpeedStudy) -> Plot:
    """Speed, and speed over X f with the three laws, against frequency."""
    figure, axes = new_plot(2, 1, 7.2, 7.0, sharex=True)
    speed, ratio = axes[:, 0]
    f = study.frequencies
    for law, factor in LAWS.items():
        predicted = factor * study.travel * f * 1e3
        speed.plot(f, predicted, color=GREY, linewidth=0.8, linestyle="--")
        name, end = LAW_TEXT[law].partition(":")[0], (f[-1], predicted[-1])
        speed.annotate(name, end, (5, 0), textcoords="offset points", va="center", color=GREY)
        ratio.axhline(factor, color=GREY, linewidth=0.8, linestyle="--")
        ratio.annotate(LAW_TEXT[law], (1.01, factor), xycoords=("axes fraction", "data"), va="center", color=GREY)
    for ink, height in zip(INK, study.points):
        label = f"{height} ({HEIGHTS[height]:+.1f})" if HEIGHTS[height] else f"{height} (0)"
        speed.plot(f, np.maximum(study.speed(height), 1e-6) * 1e3, "o-", color=ink, markersize=3, label=label)
        ratio.plot(f, study.ratio(height), "o-", color=ink, markersize=3)
        lifts = np.array([point.lifted_share > travel_map.LIFTED for point in study.points[height]])
        ratio.plot(f[lifts], study.ratio(height)[lifts], "o", color="white", markeredgecolor=ink, markersize=6)
        changing = ~study.is_steady(height)
        ratio.plot(f[changing], study.ratio(height)[changing], "x", color=ink, markersize=9)
    again = np.array([point.velocity[0] for point in study.again])
    speed.plot(f, np.maximum(again, 1e-6) * 1e3, ":", color=GREY, label=f"{HALF}, begun slower")
    speed.set(ylabel="speed (mm/s)", xscale="log", yscale="log")
    speed.legend(title="apex at mid-stroke over the surface,\nin half heights of the ellipse", loc="upper left")
    ratio.set(ylabel="speed / (X f), X as the tip moves", xlabel="frequency (Hz)", ylim=(0.0, 3.5))
    ratio.legend(handles=_marks(), loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.0, ncols=2)
    figure.suptitle(f"Lasting speed against frequency, X = {study.travel * 1e6:.1f} µm commanded")
    return figure


@styled
def travel_map_figure(study: travel_map.TravelMap) -> Plot:
    """Maps of pads and tip off over travel and height, and the share of the load that tips the stage over."""
    figure, axes = new_plot(1, 3, 12.6, 3.9)
    lifted, off, share = axes[0]
    x, z = study.positions * 1e3, study.heights * 1e6
    for panel, values, title in (
        (lifted, study.lifted, "a pad is off its way (part of the time)"),
        (off, study.tip_off, "the tip is off the stage (part of the time)"),
    ):
        shown = panel.pcolormesh(x, z, values, cmap="cividis", vmin=0.0, vmax=1.0, shading="nearest")
        panel.grid(False)
        panel.set(xlabel="position of the stage (mm)", ylabel="height of the apex at mid-stroke (µm)", title=title)
        figure.colorbar(shown, ax=panel)
    share.plot(x, study.limit, color=GREY, label="moments about the pads' edge")
    share.plot(x, study.pushed, "o", color=INK[0], markersize=4, label="pushed up slowly: first pad lifts")
    share.plot(x, study.load_share.max(axis=0), "^", color=INK[1], markersize=4, label="largest load of a drive")
    share.set(xlabel="position of the stage (mm)", ylabel="tip force / (weight + preload)", title="tip-over")
    share.legend(loc="upper right", fontsize=7)
    share.set_ylim(0.0, 1.3 * share.dataLim.ymax)
    figure.suptitle("Lift-off and tip-over over the travel")
    return figure


@styled
def ellipse_figure(study: ellipse.EllipseSearch) -> Plot:
    """Ellipses, and speed over phase and height."""
    figure, axes = new_plot(1, 2, 11.2, 4.2)
    paths, speeds = axes[0]
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    for ink, phase, path in zip(TRAVEL_INK, study.phases, study.ellipses):
        paths.plot(
            -path.along * np.cos(angle) * 1e6,
            path.normal * np.sin(angle) * 1e6,
            color=ink,
            label=f"{np.degrees(phase):.0f}°",
        )
    paths.set_aspect("equal", "datalim")
    paths.set(xlabel="x (µm)", ylabel="y, up (µm)", title="commanded paths")
    paths.legend(title="phase", fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for ink, height, speed, lifted, steady in zip(
        TRAVEL_INK, study.heights, study.speed, study.lifted, study.is_steady
    ):
        degrees = np.degrees(study.phases)
        speeds.plot(degrees, speed * 1e3, "o-", color=ink, markersize=3, label=f"{height:+.2f}")
        lifts = lifted > travel_map.LIFTED
        speeds.plot(degrees[lifts], speed[lifts] * 1e3, "o", color="white", markeredgecolor=ink, markersize=6)
        speeds.plot(degrees[~steady], speed[~steady] * 1e3, "x", color=ink, markersize=9)
    speeds.set(xlabel="phase (°)", ylabel="speed (mm/s)", title="steady speed")
    # Outside the axes: for another design the curves may be anywhere.
    shown = [*speeds.get_legend_handles_labels()[0], *_marks()]
    title = "apex at mid-stroke\nover the surface, in\nhalf heights"
    speeds.legend(handles=shown, title=title, fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.suptitle(f"Speed by phase and height of the ellipse at {study.frequency:.0f} Hz")
    return figure


@styled
def coupling_figure(study: coupling.CouplingStudy) -> Plot:
    """Motion across the travel and yaw, with each fault, against the motion along it."""
    figure, axes = new_plot(1, 3, 12.0, 4.0)
    along, across, yaw = axes[0]
    for ink, (name, run) in zip(TRAVEL_INK, study.runs.items()):
        x, y, turn = run.position.T
        # An actuator off the centre line goes along and across as designed: dashed, so that both are seen.
        line: dict[str, Any] = {"color": ink, "linestyle": (0, (4, 3)) if coupling.FAULTS[name].offset else "-"}
        along.plot(run.time * 1e3, x * 1e3, **line)
        across.plot(x * 1e3, y * 1e6, label=coupling.FAULTS[name].text, **line)
        yaw.plot(x * 1e3, turn * 1e6, **line)
    along.set(xlabel="time (ms)", ylabel="x (mm)", title="along")
    across.set(xlabel="x (mm)", ylabel="y (µm)", title="across")
    yaw.set(xlabel="x (mm)", ylabel="yaw (µrad)", title="yaw")
    figure.legend(loc="outside lower center", ncols=3, fontsize=7)
    figure.suptitle("Cross-coupling from rest, one actuator, guided by the magnetic teeth")
    return figure


@styled
def planar_figure(study: planar.PlanarStudy) -> Plot:
    """Tracks in the plane, and errors of direction."""
    figure, axes = new_plot(1, 3, 12.0, 4.2)
    first = next(iter(study.runs))
    within = list(study.runs)[1]
    for panel, drive in zip(axes[0, :2], (first, within)):
        for direction, run in zip(study.directions, study.runs[drive]):
            reach = float(np.hypot(*run.position[-1, :2]))
            panel.plot([0.0, reach * np.cos(direction) * 1e3], [0.0, reach * np.sin(direction) * 1e3], color="#cccccc")
            panel.plot(run.position[:, 0] * 1e3, run.position[:, 1] * 1e3, color=INK[0])
        panel.set_aspect("equal", "datalim")
        panel.set(xlabel="x (mm)", ylabel="y (mm)", title=f"at {study.frequencies[drive]:.0f} Hz, in step")
    errors = axes[0, 2]
    for ink, drive in zip(INK, study.runs):
        thirds = "thirds" in drive
        label = f"{study.frequencies[drive]:.0f} Hz" + (", in thirds" if thirds else ", in step")
        found = np.degrees(study.directions), np.degrees(study.direction_errors(drive))
        errors.plot(*found, "x:" if thirds else "o-", color=ink, markersize=4, label=label)
    errors.set(xlabel="commanded direction (°)", ylabel="error (°)", title="error of direction")
    errors.set_xticks(np.arange(0.0, 361.0, 60.0))
    figure.legend(loc="outside lower right", ncols=3, fontsize=7)
    figure.suptitle("Three actuators, no guide: starts from rest (grey: as commanded)")
    return figure


@styled
def positioning_figure(study: positioning.PositioningStudy) -> Plot:
    """Moves in time and the size of their errors, and the tracked sines."""
    columns = len(study.moves) + 2
    figure, axes = new_plot(2, columns, 3.9 * columns, 6.0, sharex="col")
    for column, (ink, (name, move)) in enumerate(zip(cycle(INK), study.moves.items())):
        run = move.run
        axes[0, column].plot(run.time, run.position[:, 0] * 1e3, color=ink)
        axes[0, column].axhline(move.target * 1e3, color=GREY, linewidth=0.8)
        axes[0, column].set_title(positioning.LOOPS[name].text)
        axes[1, column].semilogy(run.time, np.maximum(np.abs(move.error), 1e-11) * 1e9, color=ink, linewidth=0.8)
        axes[1, column].axhline(10.0, color=GREY, linewidth=0.8, linestyle="--")
        axes[1, column].set_xlabel("time (s)")
        if move.taken_over is not None:
            axes[1, column].axvline(move.taken_over, color=GREY, linewidth=0.8)
            axes[1, column].annotate(
                "fine", (move.taken_over, 2e5), xytext=(3, 0), textcoords="offset points", color=GREY, fontsize=8
            )
    for panel, first in zip(axes[:, 1:-2].T.flat, cycle(axes[:, 0])):
        panel.sharey(first)
        panel.tick_params(labelleft=False)
    axes[0, 0].set_ylabel("x (mm)")
    axes[1, 0].set_ylabel("true error (nm); dashed: 10 nm")
    for place, title, followed in ((-2, "a tracked sine", study.tracked), (-1, "a short move", study.moved)):
        for ink, (name, one) in zip(TRAVEL_INK, followed.items()):
            look: dict[str, Any] = {"color": ink, "linewidth": 0.8, "label": name if place == -1 else None}
            axes[0, place].plot(one.time, (one.wanted - one.error) * 1e9, color=ink, linewidth=0.8)
            axes[1, place].plot(one.time, one.error * 1e9, **look)
        axes[0, place].set(ylabel="x (nm)", title=f"{title}, by feedforward")
        axes[1, place].set(xlabel="time (s)", ylabel="true error (nm)")
    figure.legend(loc="outside lower right", ncols=5, fontsize=7)
    figure.suptitle("Coarse run, fine settling, and tracking")
    return figure


@styled
def hunting_figure(study: hunting.HuntingStudy) -> Plot:
    """Errors about the target, and what the loop puts out."""
    figure, axes = new_plot(2, len(study.holds), 3.0 * len(study.holds), 5.4)
    largest = 1.1e6 * max(
        float(np.abs(held.error).max()) for name, held in study.holds.items() if hunting.HOLDS[name].moves != "lean"
    )
    for column, (ink, (name, held)) in enumerate(zip(TRAVEL_INK, study.holds.items())):
        t = held.run.time
        fine = hunting.HOLDS[name].moves == "lean"
        late = t > 0.95 * t[-1] if fine else np.full(t.size, True)
        scale, unit = (1e9, "nm") if fine else (1e6, "µm")
        axes[0, column].plot(t[late], held.error[late] * scale, color=ink, linewidth=0.8)
        axes[0, column].set_title(hunting.HOLDS[name].text, fontsize=8)
        axes[0, column].set_ylabel(f"error ({unit})")
        if not fine:
            axes[0, column].set_ylim(-largest, largest)
            axes[1, column].set_ylim(-1.1, 1.1)
        axes[1, column].plot(t[late], held.output[late] * (1e6 if fine else 1.0), color=ink, linewidth=0.8)
        axes[1, column].set(xlabel="time (s)", ylabel="loop's output: lean (µm)" if fine else "loop's output (1)")
    figure.suptitle("Holding a target: sticking, hunting, and oscillation on the contact")
    return figure


@styled
def tip_motion_figure(study: tip_motion.TipMotions) -> Plot:
    """Commanded paths, speed over power, and ripple over the work of slip of the best motions of the tip."""
    figure, axes = new_plot(1, 3, 13.0, 4.6)
    paths, powers, wear = axes[0]
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    inks = [*TRAVEL_INK[:5], *TRAVEL_INK[1:5]]
    for ink, (name, motion) in zip(inks, study.motions.items(), strict=True):
        look: dict[str, Any] = {"color": ink, "label": name.replace("_", " ")}
        along, up = motion.path.at(turn)
        paths.plot(along * 1e6, (up + motion.height) * 1e6, linestyle="--" if "sinusoid" in name else "-", **look)
        look |= {"linestyle": "", "marker": "s" if "sinusoid" in name else "o"}
        powers.plot(motion.power, motion.speed * 1e3, **look)
        wear.plot(motion.slip_work, motion.steady.ripple * 1e3, **look)
    paths.axhline(0.0, color=GREY, linewidth=0.8)
    paths.set(xlabel="along (µm)", ylabel="over the drive surface (µm)", title="commanded paths")
    powers.set(xlabel="heat of the stacks and mechanical power (W)", ylabel="speed (mm/s)", title="speed")
    wear.set(xlabel="work of slip per travel (N)", ylabel="ripple of the speed (mm/s rms)", title="wear and ripple")
    figure.legend(*paths.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=7)
    figure.suptitle(f"Motions of the tip within the limits of amplifier and stacks, {study.frequency:.0f} Hz")
    return figure


def _marks() -> list[Any]:
    """Legend entries of lifted pads and of what still changes."""
    from matplotlib.lines import Line2D

    ring: dict[str, Any] = {"marker": "o", "markersize": 6, "color": "white", "markeredgecolor": GREY}
    cross: dict[str, Any] = {"marker": "x", "markersize": 7, "color": GREY}
    entries = {LIFTED_TEXT: ring, "still changing, or uneven": cross}
    return [Line2D([], [], linestyle="", label=label, **look) for label, look in entries.items()]


_STUDIES = {
    "steps": steps_figure,
    "speed": speed_figure,
    "travel_map": travel_map_figure,
    "ellipse": ellipse_figure,
    "coupling": coupling_figure,
    "planar": planar_figure,
    "positioning": positioning_figure,
    "hunting": hunting_figure,
    "tip_motion": tip_motion_figure,
}
