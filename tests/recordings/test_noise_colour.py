"""The colour of noise is found beside a real motion, and white noise stays white."""

from pathlib import Path

import numpy as np
import pytest
from scipy import linalg, signal, special

from tp_jax.recordings import Colour, Recording, noise_colour, noise_level, same_rate
from tp_jax.recordings.colour import first_order
from tp_jax.rig import BENCH, VirtualRig

RATE, DURATION, OMEGA = 250.0, 20.0, 11.0
PERIOD = 2.0 * np.pi / OMEGA
SIGMA = 1e-3
T = np.arange(round(DURATION * RATE) + 1) / RATE


@pytest.fixture(scope="module")
def motion() -> np.ndarray:
    """Both angles (n, 2) of a driven rig, friction and all."""
    return VirtualRig(BENCH).run(T, omega=OMEGA)


def noise(n: int, rho: float, white: float, seed: int) -> np.ndarray:
    """Of unit variance: a first-order filter's, and white."""
    rng = np.random.default_rng(seed)
    slow = signal.lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], rng.standard_normal(n + 500))[500:]
    return np.sqrt(1.0 - white) * slow + np.sqrt(white) * rng.standard_normal(n)


def run(t: np.ndarray, phi1: np.ndarray) -> Recording:
    return Recording(
        name="run.csv",
        label="run.csv",
        file=Path("run.csv"),
        t=t,
        phi1=phi1,
        phi2=None,
        drive=None,
        forced=True,
        omega=OMEGA,
        span=None,
        start=None,
        repeat=None,
        held_out=False,
        sha256="",
    )


def found(motion, rho: float, white: float, seed: int, runs: int = 3) -> Colour:
    readings = [
        run(T, motion[:, 0] + SIGMA * noise(T.size, rho, white, 10 * seed + i)) for i in range(runs)
    ]
    return noise_colour(readings, "phi1", PERIOD)


@pytest.mark.parametrize(("rho", "white"), [(0.5, 0.1), (0.7, 0.3), (0.8, 0.5)])
def test_both_parts_are_found_beside_a_motion(motion, rho, white):
    colours = [found(motion, rho, white, seed) for seed in range(6)]
    assert not any(c.is_white for c in colours)
    assert not any(c.of_residuals for c in colours)
    assert np.median([c.rho for c in colours]) == pytest.approx(rho, abs=0.07)
    assert np.median([c.white for c in colours]) == pytest.approx(white, abs=0.1)
    expected = first_order(rho, white).excess
    assert np.median([c.excess for c in colours]) == pytest.approx(expected, rel=0.1)


def test_level_times_excess_is_the_standard_deviation(motion):
    readings = motion[:, 0] + SIGMA * noise(T.size, 0.7, 0.3, 3)
    colour = noise_colour([run(T, readings)], "phi1", PERIOD)
    assert noise_level(T, readings) * colour.excess == pytest.approx(SIGMA, rel=0.15)


@pytest.mark.parametrize("seed", range(20))
def test_white_noise_stays_white(motion, seed):
    assert found(motion, 0.0, 1.0, seed).is_white


def test_nothing_is_slower_than_the_band_in_which_it_was_seen(motion):
    c = found(motion, 0.97, 0.3, 0)
    assert c.lowest == pytest.approx(5.0 / PERIOD)
    assert c.rho <= np.exp(-2.0 * np.pi * c.lowest / RATE) + 1e-12


def test_rounded_readings(motion):
    """Of a fifth of the noise it changes nothing; of white noise alone it makes no colour."""
    step = SIGMA / 5.0
    coloured = motion[:, 0] + SIGMA * noise(T.size, 0.7, 0.3, 5)
    c, rounded = (
        noise_colour([run(T, y)], "phi1", PERIOD)
        for y in (coloured, step * np.round(coloured / step))
    )
    assert rounded.rho == pytest.approx(c.rho, abs=0.03)
    assert rounded.white == pytest.approx(c.white, abs=0.03)
    coarse = 4.0 * SIGMA
    plain = motion[:, 0] + 0.3 * SIGMA * noise(T.size, 0.0, 1.0, 6)
    assert noise_colour([run(T, coarse * np.round(plain / coarse))], "phi1", PERIOD).is_white


def test_gaps(motion):
    """What is lost between two stretches is no jump of the noise; short stretches are left out."""
    kept = np.ones(T.size, dtype=bool)
    for begin in (700, 1900, 3300):
        kept[begin : begin + 60] = False
    rho = []
    for seed in range(6):
        y = motion[:, 0] + SIGMA * noise(T.size, 0.7, 0.3, 7 + seed)
        parts = noise_colour([run(T[kept], y[kept])], "phi1", PERIOD)
        assert not parts.is_white
        rho.append(parts.rho)
    assert np.median(rho) == pytest.approx(0.7, abs=0.07)
    kept[:] = True
    kept[100::100] = False  # no stretch has 128 samples
    assert noise_colour([run(T[kept], y[kept])], "phi1", PERIOD) == Colour()


def test_what_says_nothing_is_white(motion):
    y = motion[:, 0] + SIGMA * noise(T.size, 0.7, 0.3, 8)
    jitter = T + 0.4 / RATE * np.random.default_rng(0).uniform(-1.0, 1.0, T.size)
    assert noise_colour([run(jitter, y)], "phi1", PERIOD) == Colour()
    assert noise_colour([run(T[:100], y[:100])], "phi1", PERIOD) == Colour()
    assert noise_colour([run(T, np.full(T.size, 0.3))], "phi1", PERIOD) == Colour()
    assert noise_colour([run(T, y)], "phi2", PERIOD) == Colour()
    # ten samples a period: no band is left
    assert noise_colour([run(T[::14], y[::14])], "phi1", PERIOD) == Colour()


@pytest.mark.parametrize("n", [5, 40, 400])
@pytest.mark.parametrize(
    ("neighbours", "rho"),
    [(0.3, 0.3), (0.49, 0.7), (0.855, 0.95), (0.29, 0.97), (-0.345, 0.0), (-0.2, 0.5)],
)
def test_whitening_is_exact(neighbours, rho, n):
    """Also where the process is a moving average, or mostly white and slow besides."""
    c = Colour(neighbours, rho)
    own = linalg.toeplitz([1.0, *(neighbours * rho ** np.arange(n - 1))])
    W = c.whiten(np.eye(n))
    np.testing.assert_allclose(W @ own @ W.T, np.eye(n), atol=2e-6)
    assert np.allclose(W, np.tril(W))
    _, determinant = np.linalg.slogdet(own)
    assert c.log_determinant(n) == pytest.approx(determinant, abs=1e-4 * n)


def test_the_autoregression_that_is_reported_has_its_correlation():
    c = first_order(0.7, 0.3)
    assert c.correlation == pytest.approx([0.7 * 0.7**k for k in range(1, 11)])
    np.testing.assert_allclose(
        linalg.toeplitz([1.0, *c.correlation[:-1]]) @ c.ar, c.correlation, atol=1e-12
    )


@pytest.mark.parametrize("order", [2, 5, 8])
def test_differences_see_what_the_colour_says(order):
    rng = np.random.default_rng(order)
    e = rng.standard_normal(200_001)
    y = (e[1:] - 0.4 * e[:-1]) / np.sqrt(1.16)  # a moving average
    size = np.sqrt(float(special.binom(2 * order, order)))
    seen = np.diff(y, order).std() / size
    assert seen == pytest.approx(Colour(-0.4 / 1.16, 0.0).seen(order), rel=0.02)
    assert noise_level(np.arange(y.size) * 0.01, y, Colour(-0.4 / 1.16, 0.0)) == pytest.approx(
        1.0, rel=0.02
    )


def test_whitening_of_few_rows_and_of_many_columns():
    c = first_order(0.7, 0.3)
    x = np.random.default_rng(0).standard_normal((30, 3, 2))
    whole = c.whiten(x)
    np.testing.assert_allclose(c.whiten(x[:4]), whole[:4])  # fewer than the order
    np.testing.assert_allclose(c.whiten(x[:, 1, 1]), whole[:, 1, 1])
    assert Colour().whiten(x) is x


def test_a_mean_is_worse_known_than_of_white_noise():
    c = first_order(0.7, 0.3)
    n = 4000
    own = (1.0 - c.white) * c.rho ** np.arange(n)
    own[0] = 1.0
    variance = (own[0] + 2.0 * (own[1:] * (1.0 - np.arange(1, n) / n)).sum()) / n
    assert c.slow == pytest.approx(np.sqrt(variance * n), rel=0.01)
    assert Colour().slow == 1.0


def test_excess_is_what_high_differences_miss():
    """A tenth difference sees what is near the Nyquist frequency."""
    c = first_order(0.6, 0.2)
    y = noise(200_000, 0.6, 0.2, 0)
    seen = np.diff(y, 10).std() / np.sqrt(184756.0)  # binomial(20, 10)
    assert 1.0 / seen == pytest.approx(c.excess, rel=0.05)


def test_recordings_are_put_together_by_their_rate():
    def at(rate):
        t = np.arange(200) / rate
        return run(t, np.sin(t))

    runs = [at(r) for r in (60.0, 250.0, 61.0, 240.0, 25.0)]
    assert same_rate(runs) == [[1, 3], [2, 0], [4]]
    assert same_rate(runs[:1]) == [[0]]
