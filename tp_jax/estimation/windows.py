"""Recordings cut into windows: the samples of each, and its state's prior from the data alone."""

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from tp_jax.model.dahl import play_along
from tp_jax.recordings import Recording
from tp_jax.recordings.colour import Colour
from tp_jax.recordings.gaps import stretches
from tp_jax.recordings.smooth import at_rest, local_polynomial

#: Smoothed readings share samples with the window they start, so their weight is reduced: the
#: prior only has to hold what the window cannot tell (the velocity of a stuck rider).
PRIOR_INFLATION = 3.0

#: Standard errors of a smoothed angle within which a body at rest seems to wander.
NOISE_OF_PATH = 2.0


@dataclasses.dataclass(frozen=True)
class Prepared:
    """One recording, ready to be cut.

    t: (n,) s; y: (n, 2) rad, zeros where a channel is missing; channels: (2,) bool;
    smooth: (n, 4) smoothed readings and their rates; smooth_sd: (n, 4);
    pieces: (n - 1, 4) cubic coefficients of the measured drive, or None;
    path: (n, 4) as `smooth`, its angles without what is noise (`play_along`); `smooth` if empty;
    sigma: (2,) noise of each channel [rad], 1 where it is missing; colour: of that noise.
    """

    t: np.ndarray
    y: np.ndarray
    channels: np.ndarray
    smooth: np.ndarray
    smooth_sd: np.ndarray
    pieces: np.ndarray | None
    path: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 4)))
    sigma: np.ndarray = dataclasses.field(default_factory=lambda: np.ones(2))
    colour: tuple[Colour, Colour] = (Colour(), Colour())

    def __post_init__(self):
        if not self.path.size:
            object.__setattr__(self, "path", self.smooth)


def prepare(
    recording: Recording,
    sigma: np.ndarray,
    width: int,
    colour: tuple[Colour, Colour] = (Colour(), Colour()),
) -> Prepared:
    """Smooths a recording once.

    Args:
        recording: the recording. sigma: (2,) noise by channel [rad].
        width: samples of the smoothing window.
        colour: of each channel's noise.
    """
    n = recording.t.size
    y = np.zeros((n, 2))
    smooth = np.zeros((n, 4))
    sd = np.ones((n, 4))
    channels = np.array([True, recording.phi2 is not None])
    for c, values in enumerate((recording.phi1, recording.phi2)):
        if values is None:
            continue
        y[:, c] = values
        fit = local_polynomial(recording.t, values, sigma[c] * colour[c].slow, width)
        smooth[:, c], smooth[:, 2 + c] = fit.value, fit.first
        # Between two gaps there may be too few samples for a rate. It is then known to be like the
        # others: without that the velocity of a stuck rider goes anywhere, and the fit stalls.
        unknown = np.isinf(fit.first_error)
        rate = np.sqrt(np.mean((fit.first**2 + fit.first_error**2)[~unknown]))
        sd[:, c], sd[:, 2 + c] = fit.value_error, np.where(unknown, rate, fit.first_error)
        # Under coloured noise the rate of a body that stuck seems far from zero: the window that
        # starts there is given a push that explains noise, always the same way against friction,
        # and laws of friction near rest seem wrong. Under white noise that push is small, and a
        # prior as tight as a rest's would hold the state in the kink of the friction.
        if colour[c].is_white:
            continue
        still = at_rest(recording.t, values, sigma[c] * colour[c].slow, width)
        rests = still.rests & ~unknown
        smooth[rests, c], smooth[rests, 2 + c] = still.value[rests], 0.0
        sd[rests, c], sd[rests, 2 + c] = still.value_error[rests], still.rate_error[rests]
    path = smooth.copy()
    for c in np.flatnonzero(channels):
        error = float(np.median(sd[:, c]))
        path[:, c] = play_along(smooth[:, c], NOISE_OF_PATH * error)
    return Prepared(
        recording.t,
        y,
        channels,
        smooth,
        sd * PRIOR_INFLATION,
        pieces_of(recording),
        path,
        np.where(channels, sigma, 1.0),
        colour,
    )


def pieces_of(recording: Recording) -> np.ndarray | None:
    """Cubic coefficients (n - 1, 4) of a measured drive between the samples; None without one.

    The piece across a gap is a guess that only free runs meet: no window lies there, and a few
    samples beside it the spline is that of the whole.
    """
    return None if recording.drive is None else CubicSpline(recording.t, recording.drive).c.T


def read_later(t: np.ndarray, pieces: np.ndarray, late: float) -> np.ndarray:
    """Pieces (n - 1, 4) of a curve that is read `late` seconds later.

    The curve at the samples' times and `late`, joined anew: in error by (omega h)^4 / 200 of a
    sine's amplitude for samples h apart. Beyond its ends it goes on straight.

    Args:
        t: (n,) times of the samples [s].
        pieces: (n - 1, 4) cubic coefficients between them, highest power first.
        late: how much later [s].
    """
    if not late:
        return pieces
    curve = PPoly(pieces.T, t)
    at = np.clip(t + late, t[0], t[-1])
    return CubicSpline(t, curve(at) + curve(at, 1) * (t + late - at)).c.T


@dataclasses.dataclass(frozen=True)
class Windows:
    """Windows of several recordings: recording index, first sample and sample count, each (w,)."""

    recording: np.ndarray
    first: np.ndarray
    count: np.ndarray
    horizon: float

    @property
    def n(self) -> int:
        """Number of windows."""
        return self.recording.size


def cut(prepared: Sequence[Prepared], horizon: float, minimum: int = 8) -> Windows:
    """Cuts recordings into windows of about `horizon` seconds.

    Each sample belongs to exactly one window, and no window reaches across a gap. Windows of one
    stretch between gaps have equal counts up to one sample, at least `minimum`; a stretch that is
    shorter is one short window.
    """
    recording, first, count = [], [], []
    for r, data in enumerate(prepared):
        step = float(np.median(np.diff(data.t)))
        size = max(minimum, round(horizon / step))
        for part in stretches(data.t):
            n = part.stop - part.start
            pieces = max(1, round(n / size))
            edges = part.start + np.linspace(0, n, pieces + 1).round().astype(int)
            recording += [r] * pieces
            first += list(edges[:-1])
            count += list(np.diff(edges))
    return Windows(np.array(recording), np.array(first), np.array(count), horizon)
