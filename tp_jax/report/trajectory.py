"""One figure of one trajectory: `tp-jax simulate --plot`."""

from pathlib import Path
from typing import TYPE_CHECKING

from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.simulation.solve import Trajectory


def plot_trajectory(trajectory: "Trajectory", path: str | Path, title: str = "") -> None:
    """Draws the angles above and the rider's velocity against the column below, into a PNG.

    A single torsion pendulum has no rider: the column's own velocity stands below.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ModuleNotFoundError as missing:
        raise InputError(
            "Drawing needs matplotlib, which is not installed: pip install 'tp-jax[plots]'."
        ) from missing

    # a canvas of its own rather than pyplot: no window system and no global state
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    angles, velocity = figure.subplots(2, 1, sharex=True)

    angles.plot(trajectory.t, trajectory.phi1, color="C0", lw=1.0, label="φ1")
    if trajectory.phi2 is None:
        velocity.plot(trajectory.t, trajectory.omega1, color="C3", lw=1.0)
        velocity.set_ylabel("velocity φ̇1 [rad/s]")
    else:
        angles.plot(trajectory.t, trajectory.phi2, color="C1", lw=1.0, label="φ2")
        figure.legend(loc="outside upper right", ncols=2, frameon=False)
        # φ2 is counted from the column: its rate is the relative velocity already
        velocity.plot(trajectory.t, trajectory.omega2, color="C3", lw=1.0)
        velocity.set_ylabel("relative velocity φ̇2 [rad/s]")
    angles.set_ylabel("angle [rad]")
    velocity.set_xlabel("time [s]")
    for axes in (angles, velocity):
        axes.axhline(0.0, color="0.8", lw=0.8, zorder=0)
        axes.margins(x=0.0)
    if title:
        figure.suptitle(title)
    figure.savefig(path, format="png", dpi=150)
