"""A start from the data without derivatives of the data: the equations in their weak form.

An equation of motion is multiplied by a smooth bump psi that vanishes with its slope at both ends
of a short window, and integrated; by parts, derivatives of the angles become derivatives of psi:

    int psi phi'' = int psi'' phi,      int psi phi' = - int psi' phi.

The sum of (16a) and (16b) holds without the contact and is linear in B2, k, c1, M1 and the two
components of the drive; (16b) alone is linear in the contact's parameters but T0. So nobody needs
to guess. Readings stand among the regressors, where their noise would pull everything to zero; its
share of the normal equations is known and taken off (`compensated`).
"""

import functools

import numpy as np

from tp_jax.estimation.compensated import Rows
from tp_jax.estimation.layout import Values
from tp_jax.estimation.modulating import Bump, bumps
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.windows import Prepared
from tp_jax.model.pendulum import NEWTON_REACTION, PRINTED_REACTION
from tp_jax.recordings import Recording

COLUMN = 0.35  # length of a window, in periods of the column
CONTACT = 0.15  # shorter: the rider must slide throughout
FEW = 20  # windows of sliding, below which the contact is not fitted
MOVING = 0.02  # of the fastest: a rider slower than that may as well stick
T0_GRID = np.geomspace(0.3, 100.0, 16)
PRIOR_B2 = (0.4, 1.0)  # in units of B1, where the rider never moves on its own: mean and sd
LEAST = 0.01  # of the contact's friction: what is not there at all, small steps do not find again


class WeakForm:
    """The weak form of a campaign's equations, made once and solved for many resamples."""

    def __init__(self, setting: PreparedCampaign):
        self.setting = setting
        self.sigma = setting.sigma  # a median, which thousands of windows ask for
        self.period = 4.0 * setting.horizons[0]
        self.base = initial_values(setting)
        factor = PRINTED_REACTION if setting.model == "paper" else NEWTON_REACTION
        known = setting.fixed | {n: v for n, (v, _) in setting.prior_values.items()}
        # by the printed model the rider's numbers are halves of Newton's
        self.halved: dict[str, float] = dict.fromkeys(("B2", "Tv", "Ts1", "Tst"), factor)
        self.given = {n: v * self.halved.get(n, 1.0) for n, v in known.items()}

    @functools.cached_property
    def column(self) -> Rows:
        """B1 a1 + B2 (a1 + a2) + k (phi1 - f - zero) + M_L = 0."""
        s = self.setting
        sine = any(_sine(s.recordings[r]) for r in s.fitted)
        measured = any(s.recordings[r].measured_drive for r in s.fitted)
        names = ("k", "c1", "M1", *(("B2",) if s.rider else ()), *(("ks", "kc") if sine else ()))
        names += (*(("kg",) if measured else ()), "kz")
        A, b, noise, block = [], [], [], []
        for w in bumps(s.prepared, s.fitted, COLUMN * self.period):
            data, r = s.prepared[w.recording], s.recordings[w.recording]
            y1, y2 = data.y[w.span].T
            theta = r.omega * data.t[w.span] if _sine(r) else None
            terms = {
                "k": w.psi @ y1,
                "c1": -(w.first @ y1),
                "M1": w.psi @ _sign(data, w.span, 2),
                "B2": w.second @ (y1 + y2),
                "ks": 0.0 if theta is None else -(w.psi @ np.sin(theta)),
                "kc": 0.0 if theta is None else -(w.psi @ np.cos(theta)),
                "kg": 0.0 if r.drive is None else -(w.psi @ r.drive[w.span]),
                "kz": -w.psi.sum(),
            }
            A.append([terms[n] for n in names])
            b.append(-s.fixed["B1"] * (w.second @ y1))
            noise.append(self._noise(names, w))
            block.append(w.block)
        return Rows(names, *(np.array(x) for x in (A, b, noise, block)))

    def _noise(self, names: tuple[str, ...], w: Bump) -> np.ndarray:
        """Covariance of a row's noise: how that of each channel enters each term."""
        s, zero = self.setting, np.zeros_like(w.psi)
        first = {"k": w.psi, "c1": -w.first, "B2": w.second}
        one = np.stack([*(first.get(n, zero) for n in names), -s.fixed["B1"] * w.second])
        two = np.stack([*(w.second if n == "B2" else zero for n in names), zero])
        both = self.sigma[0] ** 2 * one @ one.T
        return (both + self.sigma[1] ** 2 * two @ two.T if s.rider else both)[:-1]

    @functools.cached_property
    def contact(self) -> tuple[list[tuple[Bump, np.ndarray, float]], float]:
        """Windows in which the rider slides all through: their bumps, velocities and
        int psi (a1 + a2); and the largest mean |a1| that it has withstood in one [rad/s^2]."""
        s = self.setting
        fastest = max(float(np.abs(s.prepared[r].smooth[:, 3]).max()) for r in s.fitted)
        sliding, withstood = [], 0.0
        for w in bumps(s.prepared, s.fitted, CONTACT * self.period, 0.75):
            data = s.prepared[w.recording]
            v, sd = data.smooth[w.span, 3], data.smooth_sd[w.span, 3]
            slides = np.abs(v) > np.maximum(sd, MOVING * fastest)
            if slides.all():
                sliding.append((w, v, float(w.second @ data.y[w.span].sum(axis=1))))
            elif not slides.any():
                mean = float(w.second @ data.y[w.span, 0]) / float(w.psi.sum())
                withstood = max(withstood, abs(mean))
        return sliding, withstood

    @functools.cached_property
    def blocks(self) -> int:
        """Seconds of the data."""
        column, (sliding, _) = self.column, self.contact
        last = int(column.block.max(initial=0))
        return 1 + max(last, max((w.block for w, _, _ in sliding), default=0))

    def start(self, *, T0: float | None = None, rng: np.random.Generator | None = None) -> Values:
        """All numbers of the campaign, the baseline's unknowns solved for.

        Args:
            T0: rate [s/rad] at which the contact's friction rises; the best of a grid if None.
            rng: draws a bootstrap sample of the data's seconds; all of the data if None.
        """
        times = np.ones(self.blocks)
        if rng is not None:
            share = np.full(self.blocks, 1.0 / self.blocks)
            times = rng.multinomial(self.blocks, share).astype(float)
        found = self._column(times)
        if self.setting.rider:
            found |= self._contact(times, found["B2"], T0)
        found = {n: v / self.halved.get(n, 1.0) for n, v in found.items()}
        return self.base.replace(found | self.setting.fixed)

    def _column(self, times: np.ndarray) -> dict[str, float]:
        s, B1 = self.setting, self.setting.fixed["B1"]
        mean, sd = PRIOR_B2
        known = {n: v for n, v in self.given.items() if n in self.column.names}
        positive = frozenset({"k", "c1", "M1", "B2"})
        v = self.column.solve(times, known, positive, {"B2": (mean * B1, sd * B1)})
        k = max(v["k"], 1e-6 * B1 * (2.0 * np.pi / self.period) ** 2)
        out = {"k": k, "c1": v["c1"], "M1": v["M1"]}
        if s.rider:
            out["B2"] = max(v["B2"], 1e-3 * B1)
        if "ks" in v:
            out["A"] = max(float(np.hypot(v["ks"], v["kc"])) / k, 1e-3)
            out["phase"] = float(np.arctan2(v["kc"], v["ks"]))
        if "kg" in v:
            out["gain"] = v["kg"] / k
        out["level" if "kg" in v else "zero1"] = v["kz"] / k
        return out

    def _contact(self, times: np.ndarray, B2: float, T0: float | None) -> dict[str, float]:
        """B2 (a1 + a2) + M_T = 0, where the rider slides."""
        sliding, withstood = self.contact
        given = {n: v for n, v in self.given.items() if n in ("Tv", "Ts1", "Tst", "T0")}
        if sum(times[w.block] > 0 for w, _, _ in sliding) < FEW:
            # The rider never slides, or hardly: its friction is what it has withstood, and where
            # it slides at all hardly more. The rest the data do not tell.
            Ts1 = max(B2 * withstood, 1e-9) * (1.1 if sliding else 1.5)
            found = {"Tv": 1e-3 * Ts1, "Ts1": Ts1, "Tst": 0.1 * Ts1, "T0": T0 or 4.0}
            return found | given
        rates = T0_GRID if T0 is None else np.array([T0])
        rates = np.array([given["T0"]]) if "T0" in given else rates
        best, out = np.inf, {}
        for rate in rates:
            rows = self._sliding(sliding, B2, float(rate), split="Ts1" in given or "Tst" in given)
            known = {n: v for n, v in given.items() if n in rows.names}
            x = rows.solve(times, known, frozenset(rows.names), {})
            cost = rows.misfit(times, x)
            if cost < best:
                best, out = cost, x | {"T0": float(rate)}
        if "plain" in out:
            out["Ts1"] = out.pop("plain") + out["Tst"]
        floor = LEAST * (out["Ts1"] + out["Tst"])
        return {n: max(v, floor) if n in ("Ts1", "Tst") else v for n, v in out.items()} | given

    def _sliding(self, sliding: list, B2: float, rate: float, *, split: bool) -> Rows:
        """Rows of the contact at one T0.

        Where neither is given, Ts1 = plain + Tst with both not negative: friction that all but
        vanishes at rest is as good in these rows as any, but sticks to nothing.
        """
        s = self.setting
        A, noise = [], np.zeros((len(sliding), 3, 4))
        for i, (w, v, _) in enumerate(sliding):
            sign = np.sign(v)
            plain = w.psi @ sign
            rising = w.psi @ (-sign * np.expm1(-rate * np.abs(v)))
            y2 = s.prepared[w.recording].y[w.span, 1]
            A.append([-(w.first @ y2), plain, rising if split else plain + rising])
            noise[i, 0, 0] = self.sigma[1] ** 2 * (w.first @ w.first)
        b = np.array([-B2 * inertia for _, _, inertia in sliding])
        block = np.array([w.block for w, _, _ in sliding])
        return Rows(("Tv", "Ts1" if split else "plain", "Tst"), np.array(A), b, noise, block)


def _sine(r: Recording) -> bool:
    return r.forced and r.omega is not None and not r.measured_drive


def _sign(data: Prepared, span: slice, component: int) -> np.ndarray:
    """Sign of a velocity, less than one where its noise leaves it open."""
    v, sd = data.smooth[span, component], data.smooth_sd[span, component]
    return v / np.sqrt(v**2 + (sd / 3.0) ** 2)
