"""Small figures of what each effect of the catalogue does to a run of the bench."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

import tp_jax as tp
from tp_jax._config import enable_compilation_cache
from tp_jax.effects import Applied, Effect
from tp_jax.model.drive import PiecewiseCubicDrive
from tp_jax.report import style
from tp_jax.report.formatting import angle_unit, unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DURATION, RATE = 6.0, 200.0  # s, Hz
CLOSE = 0.96  # s at the end, two periods of the drive
WIDTH, HEIGHT = 6.6, 1.75


class Trace(NamedTuple):
    """Change by an effect of its typical size: readings with it minus readings without.

    t (n,) s; phi1, phi2 (n,) rad; size: its amplitudes in words.
    """

    t: np.ndarray
    phi1: np.ndarray
    phi2: np.ndarray
    size: str


def traces() -> dict[str, Trace]:
    """The trace of each effect by id, all from one sweep.

    One pendulum carries all effects; in each run one of them has its typical size and the others
    are null. So one program serves the whole catalogue.
    """
    import jax

    enable_compilation_cache()
    catalogue = list(tp.effects.catalogue().values())
    bench = tp.presets.values("bench")
    ts = np.linspace(0.0, DURATION, round(DURATION * RATE) + 1)

    def with_effects(which):
        terms = tuple(Applied(e, _values(e, which == i)) for i, e in enumerate(catalogue))
        model = tp.presets.double_pendulum(**bench, terms=terms)
        return _drifting(model)

    # the last run has none of them
    models = jax.vmap(with_effects)(np.arange(len(catalogue) + 1))
    ran = tp.sweep(models, ts)
    states = np.stack([ran.phi1, ran.phi2, ran.omega1, ran.omega2])
    own = np.zeros((models.n_states - 4, *states.shape[1:]))  # no sensor looks at them
    states = np.concatenate([states, own])
    read = jax.vmap(lambda model, y: model.readings(ts, tuple(y)), in_axes=(0, 1))
    y1, y2 = (np.asarray(y) for y in read(models, states))
    found = {
        effect.id: Trace(ts, y1[i] - y1[-1], y2[i] - y2[-1], _size(effect))
        for i, effect in enumerate(catalogue)
    }
    return found | {e.id: _of_measured(e, bench, ts) for e in catalogue if e.reads_later}


def _of_measured(effect: Effect, bench: dict[str, float], ts: np.ndarray) -> Trace:
    """The trace of an effect that a commanded sine has not: the same sine, measured."""
    import dataclasses

    fine = np.linspace(-1.0, DURATION + 1.0, 4001)
    reading = CubicSpline(fine, bench["A"] * np.sin(bench["omega"] * fine)).c
    runs = []
    for present in (1.0, 0.0):
        terms = (Applied(effect, _values(effect, present)),)
        model = tp.presets.double_pendulum(**bench, terms=terms)
        drive = PiecewiseCubicDrive(1.0, 0.0, fine, reading)
        runs.append(tp.simulate(dataclasses.replace(model, drive=drive), ts))
    late, plain = runs
    change = [np.asarray(a - b) for a, b in zip(late[1:3], plain[1:3], strict=True)]
    return Trace(ts, *change, _size(effect))


def picture(trace: Trace) -> "Figure":
    """The whole run on the left, its last two periods on the right."""
    name, factor = angle_unit([np.abs(trace.phi1).max(), np.abs(trace.phi2).max()])
    figure = style.new_figure(WIDTH, HEIGHT)
    whole, close = figure.subplots(1, 2, sharey=True, width_ratios=[1.6, 1.0])
    for axes, begin in ((whole, 0.0), (close, DURATION - CLOSE)):
        style.dress(axes)
        part = trace.t >= begin
        axes.plot(trace.t[part], factor * trace.phi1[part], color=style.BEFORE, lw=1.0, label="φ1")
        axes.plot(trace.t[part], factor * trace.phi2[part], color=style.AFTER, lw=1.0, label="φ2")
        axes.margins(x=0.0)
        axes.set_xlabel("time [s]")
    whole.set_ylabel(f"change [{name}]")
    style.legend(figure, whole)
    return figure


def _values(effect: Effect, present: Any) -> dict[str, Any]:
    """Its numbers: the first amplitude of its typical size where present, the others null."""
    first, *others = effect.amplitudes
    numbers: dict[str, Any] = {first.name: present * first.typical}
    numbers |= {a.name: 0.0 * present for a in others}
    return numbers | {s.name: s.grid[len(s.grid) // 2] + 0.0 * present for s in effect.shapes}


def _size(effect: Effect) -> str:
    first = effect.amplitudes[0]
    said = [(first.name, first.typical, first.unit)]
    said += [(s.name, s.grid[len(s.grid) // 2], s.unit) for s in effect.shapes]
    return ", ".join(f"{name} = {value:.2g} {unit(of)}".rstrip() for name, value, of in said)


def _drifting(model: Any) -> Any:
    """The pendulum with the clock on which drifts run set to the run."""
    import dataclasses

    return dataclasses.replace(model, drift=(0.5 * DURATION, 1.0 / DURATION))
