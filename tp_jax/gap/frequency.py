"""Frequency of an effect that oscillates in time, sought between the points of its grid.

Over ten seconds a wave stays in step with another only if their frequencies differ by less than a
twentieth of a hertz, and a grid as fine as that would take a thousand columns. Within a window of
half a second, though, neighbours hardly differ, and over all windows one is the other, turned by
the phase that lies between them. So the gradients by waves at few frequencies, turned window by
window, are those at every frequency: a periodogram of the score (Lomb, 1976, Astrophysics and Space
Science 39, 447-462, for a sine in noise), in which each recording has a phase of its own.

The screen, and with it the test whether anything is there, keeps the grid; what is found here says
where a refit begins.
"""

import dataclasses
import logging

import numpy as np

from tp_jax.effects import Amplitude, Effect, Shape
from tp_jax.effects.contact_vibration import ContactVibration
from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.linearisation import Linearisation
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import DIRECTIONS, Problem
from tp_jax.estimation.window_states import warm_start_states
from tp_jax.gap.free_torques import probed_by
from tp_jax.gap.refit import removable
from tp_jax.gap.screen import Scored, Screen

log = logging.getLogger(__name__)

AT_ONCE = DIRECTIONS // 2  # waves, each with a cosine and a sine
APART = 0.5  # of one over a window's length: neighbours are off by a quarter turn at its ends
FINE = 0.25  # of one over the longest recording's length
TAKEN = 0.5  # of a gap, by another effect: what that leaves is looked at in the next round
PLAIN = 2.0  # standard deviations of a sum of squares of noise alone, above which that is said


class ContactWaves(Effect):
    """Vibrations of the contact at several frequencies, `D` apart from `W` on."""

    id = "contact_waves"
    location = hook = "contact"
    needs = ContactVibration.needs
    amplitudes = tuple(
        Amplitude(f"{name}{k}", "1", typical=0.2, per_recording=True)
        for k in range(AT_ONCE)
        for name in "ab"
    )
    shapes = (Shape("W", "Hz", (1.0,)), Shape("D", "Hz", (1.0,)))
    formula = "sum of contact_vibration at W + k D"

    def increment(self, m, W, D, **sizes):  # type: ignore[override]
        """See the class."""
        one, every = ContactVibration(), range(AT_ONCE)
        return sum(one.increment(m, sizes[f"a{k}"], sizes[f"b{k}"], W + k * D) for k in every)


def tuned(setting: PreparedCampaign, fit: Fit, seen: Screen) -> Screen:
    """The screen with a vibration of the contact at its likeliest frequency, if that is likelier.

    Not where another effect takes most of the gap: the waves need a program of their own, which
    is compiled once on a machine, and most campaigns never ask for it.

    Args:
        setting: the campaign. fit: that was screened. seen: its screen.
    """
    grid = [s for s in seen.scored if s.id == ContactVibration.id]
    others = max((s.drop for s in seen.scored if s.id != ContactVibration.id), default=0.0)
    gap = removable(fit)
    if not grid or (gap > PLAIN * np.sqrt(2.0 * fit.dof) and others > TAKEN * gap):
        return seen
    best = max(grid, key=lambda s: (s.drop, s.unbounded))
    found, drop = likeliest(setting, fit)
    if drop <= best.drop:
        return seen
    log.info("contact_vibration at %.4g Hz promises %.4g, on its grid %.4g", found, drop, best.drop)
    variant = dataclasses.replace(best.variant, shapes=(("W", found),))
    other = dataclasses.replace(best, variant=variant, drop=drop)
    scored: list[Scored] = [other if s is best else s for s in seen.scored]
    return dataclasses.replace(seen, scored=tuple(scored))


def likeliest(setting: PreparedCampaign, fit: Fit) -> tuple[float, float]:
    """Frequency [Hz] of a vibration of the contact, and the drop of the sum of squares it promises.

    Sought in the shortest windows, and seen in those of the fit, whose states take less of it. The
    drop is less by what the best of so many frequencies takes from noise alone: of n drops that
    are chi squares the largest is about 2 log n larger than one.
    """
    short = setting.problem(min(setting.horizons))
    states = warm_start_states(fit, short)
    seen = _Waves(fit, short, states, short.linearise(fit.values, states, ()))
    low, *_, high = ContactVibration.shapes[0].grid
    step = APART / short.windows.horizon
    length = max(setting.recordings[i].duration for i in setting.fitted)
    fine = FINE / length
    turns = fine * np.arange(-np.ceil(0.5 * step / fine), np.ceil(0.5 * step / fine) + 1.0)
    drops = [
        (first + k * step + turns, seen.drops(pair, turns))
        for first in np.arange(low, high, AT_ONCE * step)
        for k, pair in enumerate(seen.pairs(first, step))
    ]
    at, drop = (np.concatenate(each) for each in zip(*drops, strict=True))
    there = at[np.argmax(drop)] - (AT_ONCE // 2) * fine
    whole = _Waves(fit, fit.problem, fit.states, fit.linearisation)
    near = [float(whole.drops(pair, np.zeros(1))[0]) for pair in whole.pairs(there, fine)]
    best = int(np.argmax(near))
    return float(there + best * fine), near[best] - 2.0 * float(np.log(at.size * FINE))


def _drop(score: np.ndarray, own: float, odd: np.ndarray) -> np.ndarray:
    """Drops (n,) of the sum of squares by a cosine and a sine, as of complex numbers.

    With the score x + i y and the information [[own + p, q], [q, own - p]], odd = p + i q.
    """
    determinant = own**2 - np.abs(odd) ** 2
    numerator = own * np.abs(score) ** 2 - np.real(np.conj(odd) * score**2)
    known = determinant > 1e-9 * max(own**2, 1e-300)
    return np.where(known, numerator / np.where(known, determinant, 1.0), 0.0)


class _Waves:
    """Waves in the windows of a problem, by a program that has them and no effect."""

    def __init__(self, fit: Fit, of: Problem, states: np.ndarray, lin: Linearisation):
        self._problem, self._values = probed_by(of, fit.values, (ContactWaves(),))
        self._states, self._lin = states, lin
        w = of.windows
        spans = zip(w.recording, w.first, w.count, strict=True)
        self._middle = np.array([of.prepared[r].t[f : f + n].mean() for r, f, n in spans])

    def pairs(self, first: float, step: float) -> list[tuple[np.ndarray, np.ndarray]]:
        """Gradients (w, 2) by cosine and sine of each wave, from a frequency [Hz] on, and their
        information (w, 2, 2), the windows' states projected out."""
        name = ContactWaves.id
        slots = [f"{name}.{a.name}" for a in ContactWaves.amplitudes]
        values = self._values.replace({f"{name}.W": first, f"{name}.D": step})
        lin = self._lin
        jac = self._problem.linearise(values, self._states, slots).slots_jac
        left = eliminate(lin.r, lin.states_jac, jac)
        both = [slice(2 * k, 2 * k + 2) for k in range(AT_ONCE)]
        return [(left.g[:, pair], left.H[:, pair, pair]) for pair in both]

    def drops(self, pair: tuple[np.ndarray, np.ndarray], turns: np.ndarray) -> np.ndarray:
        """Drops (n,) of the sum of squares by waves whose frequency is off by so much [Hz] (n,)."""
        g, H = pair
        phase = np.exp(2j * np.pi * np.outer(self._middle, turns))
        score = (g[:, 0] + 1j * g[:, 1])[:, None] * phase
        own = 0.5 * (H[:, 0, 0] + H[:, 1, 1])
        odd = (0.5 * (H[:, 0, 0] - H[:, 1, 1]) + 1j * H[:, 0, 1])[:, None] * phase**2
        recording = self._problem.windows.recording
        return sum(
            (
                _drop(score[mine].sum(axis=0), own[mine].sum(), odd[mine].sum(axis=0))
                for mine in (recording == i for i in np.unique(recording))
            ),
            start=np.zeros(turns.size),
        )
