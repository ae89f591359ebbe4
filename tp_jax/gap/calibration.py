"""Shapes that the calibration's error may have in the residuals, and how much of it stays there.

A wrong calibration puts an angle off by smooth shapes over that angle (`CalibrationError`). That
is not white, so it does not enter the weights of the samples, which stay those of the noise.
Instead every shape is an unknown with a prior: the screen re-optimises it with the parameters, so
that an effect is credited only with what no calibration error of a likely size could have done;
and the part that no parameter or window state absorbs is expected to be left by any model, so it
belongs to the floor.
"""

import dataclasses

import numpy as np

from tp_jax.estimation.elimination import eliminate
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.linearisation import Linearisation, spread
from tp_jax.estimation.linearisation import columns as slots_of
from tp_jax.estimation.normal_equations import scaled_inverse
from tp_jax.estimation.prepared_campaign import PreparedCampaign

NAMES = ("phi1", "phi2")


def columns(setting: PreparedCampaign, fit: Fit) -> np.ndarray:
    """Derivatives (w, m, q) of the residuals of a fit by the shapes' unknown numbers.

    One column per shape of each calibration, prior of mean 0 and standard deviation 1; rows as in
    `Linearisation`. q = 0 where no calibration's error is known.
    """
    windows, lin = fit.problem.windows, fit.linearisation
    nw, m = lin.r.shape
    every = [np.zeros((nw, m, 0))]
    for c, name in enumerate(NAMES):
        found = [r.calibration_error.get(name) for r in setting.recordings]
        for key, modes in {e.key: len(e.modes) for e in found if e is not None}.items():
            shapes = np.zeros((nw, m, modes))
            for w, i in enumerate(windows.recording):
                error, data = found[i], setting.prepared[i]
                if error is None or error.key != key or not lin.complete[w]:
                    continue
                first, count = windows.first[w], windows.count[w]
                rows, sd = slice(c, 2 * count, 2), data.smooth_sd[first]
                sigma = data.sigma[c]
                # at the model's readings, since noise in the shapes would go with the residuals'
                read = data.y[first : first + count, c] + sigma * lin.samples[w, rows]
                shapes[w, rows] = error.at(read).T / sigma
                start = data.smooth[first] + sd * lin.r[w, -4:]
                shapes[w, -4 + c] = error.at(start[[c]])[:, 0] / sd[c]
                slope = error.slope(start[[c]])[:, 0]
                shapes[w, -2 + c] = slope * start[2 + c] / sd[2 + c]
            fit.problem.whiten(shapes)
            every.append(shapes)
    return np.concatenate(every, axis=2)


@dataclasses.dataclass(frozen=True)
class Floor:
    """Errors of the recordings that even the right model leaves.

    Attributes:
        noise: channel -> standard deviation of the white noise [rad].
        calibration: channel -> rms [rad] that the calibration's error is expected to leave in
            held-out windows.
        parts: (q,) independent parts of the latter's mean square over channels [rad^2].
        misfit: (q,) independent parts of what it is expected to add to chi^2/dof of the fit.
    """

    noise: dict[str, float]
    calibration: dict[str, float]
    parts: np.ndarray
    misfit: np.ndarray

    @property
    def total(self) -> dict[str, float]:
        """Channel -> both together [rad]."""
        return {n: float(np.hypot(s, self.calibration[n])) for n, s in self.noise.items()}

    @property
    def known(self) -> bool:
        """True where anything is known of the calibration's error."""
        return self.parts.size > 0

    def draws(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """(n,) mean squares over channels [rad^2] that the calibration's error may leave."""
        return rng.standard_normal((n, self.parts.size)) ** 2 @ self.parts


def noise_alone(setting: PreparedCampaign) -> Floor:
    """The floor where nothing is known of the calibration's error."""
    none = np.zeros(0)
    noise = setting.held_out_noise
    return Floor(noise, dict.fromkeys(noise, 0.0), none, none)


def floor(setting: PreparedCampaign, fit: Fit, held_out: Fit) -> Floor:
    """The floor on held-out recordings under a fit, whose unknowns absorb part of the error.

    Args:
        setting: the campaign.
        fit: to the fitted recordings.
        held_out: its numbers on the held-out ones, where only window states are estimated.
    """
    shapes = columns(setting, fit)
    if not shapes.shape[2]:
        return noise_alone(setting)
    free = ~fit.at_bound
    unknowns = [u for u, f in zip(fit.unknowns, free, strict=True) if f]
    jac = np.concatenate([spread(fit.linearisation, unknowns), shapes], axis=2)
    elim = eliminate(fit.linearisation.r, fit.linearisation.states_jac, jac)
    nb = len(unknowns)
    # priors of the unknowns included
    inverse = scaled_inverse(fit.normal().part(free).information)
    follow = -inverse @ elim.H.sum(axis=0)[:nb, nb:]
    ones = np.ones((fit.problem.windows.n, 2))
    forms, _ = _left(fit.linearisation, jac, follow, ones)

    there = held_out.problem.linearise(held_out.values, held_out.states, slots_of(unknowns))
    jac = np.concatenate([spread(there, unknowns), columns(setting, held_out)], axis=2)
    unseen, count = _left(there, jac, follow, held_out.problem.sigma)
    used = count > 0
    square = np.zeros_like(unseen)
    square[used] = unseen[used] / count[used][:, None, None]
    return Floor(
        setting.held_out_noise,
        {n: float(np.sqrt(np.trace(square[NAMES.index(n)]))) for n in setting.noise},
        np.maximum(np.linalg.eigvalsh(square[used].mean(axis=0)), 0.0),
        np.maximum(np.linalg.eigvalsh(forms.sum(axis=0)), 0.0) / max(fit.dof, 1),
    )


def _left(
    lin: Linearisation, jac: np.ndarray, follow: np.ndarray, unit: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Computes what the shapes leave in the samples when window states and unknowns follow them.

    Args:
        lin: of some windows.
        jac: (w, m, u + q) by the unknowns and the shapes' numbers.
        follow: (u, q) how the unknowns follow those numbers.
        unit: (w, 2) by which residuals are multiplied.

    Returns:
        (2, q, q) sums of products by channel; (2,) samples less estimated states, as
        `HeldOut.samples`.
    """
    gain = eliminate(lin.r, lin.states_jac, jac).state_gain
    left = jac + lin.states_jac @ gain
    nb = len(follow)
    left = (left[..., nb:] + left[..., :nb] @ follow) * lin.valid[..., None]
    left = left[:, :-4].reshape(len(left), -1, 2, left.shape[2]) * unit[:, None, :, None]
    samples = lin.valid[:, :-4].reshape(len(left), -1, 2).sum(axis=1)
    count = np.maximum(samples - 2.0, 0.0).sum(axis=0)
    return np.einsum("wncq,wncr->cqr", left, left), count
