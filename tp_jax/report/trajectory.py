"""One figure of one trajectory: `tp-jax simulate --plot`."""

from pathlib import Path
from typing import TYPE_CHECKING

from tp_jax.report import style

if TYPE_CHECKING:
    from tp_jax.simulation.solve import Trajectory

_WIDTH, _HEIGHT = 8.0, 5.0


def plot_trajectory(trajectory: "Trajectory", path: str | Path, title: str = "") -> None:
    """Draws the angles above and the rider's velocity against the column below, into a PNG or SVG.

    A single torsion pendulum has no rider: the column's own velocity stands below.
    """
    figure = style.new_figure(_WIDTH, _HEIGHT, fitted=True)
    angles, velocity = figure.subplots(2, 1, sharex=True)

    t = trajectory.t
    angles.plot(t, trajectory.phi1, color=style.MUTED, lw=1.0, label="φ1, the column")
    if trajectory.phi2 is None:
        velocity.plot(t, trajectory.omega1, color=style.MUTED, lw=1.0)
        velocity.set_ylabel("velocity φ̇1 [rad/s]")
    else:
        angles.plot(t, trajectory.phi2, color=style.AFTER, lw=1.0, label="φ2, the rider")
        # φ2 is counted from the column: its rate is the relative velocity already
        velocity.plot(t, trajectory.omega2, color=style.AFTER, lw=1.0)
        velocity.set_ylabel("relative velocity φ̇2 [rad/s]")
        style.legend(figure, angles)
    angles.set_ylabel("angle [rad]")
    velocity.set_xlabel("time [s]")
    for axes in (angles, velocity):
        style.dress(axes)
        axes.margins(x=0.0)
    if title:
        style.title(angles, title)
    kind = "svg" if Path(path).suffix.lower() == ".svg" else "png"
    figure.savefig(path, format=kind, dpi=style.PIXELS, facecolor="white")
