"""Rows that are missing among rounded times: all are found, in few operations."""

import numpy as np
import pytest

from tp_jax.recordings import rounding
from tp_jax.recordings.rounding import made_even


def over_all_the_rest(part: np.ndarray, spacing: float, slack: float) -> list[int]:
    """Cuts of a part by their definition: from each on, all that is left is looked over."""
    rest, at, cuts = part - spacing * np.arange(part.size), 0, []
    while True:
        wide = np.maximum.accumulate(rest[at:]) - np.minimum.accumulate(rest[at:])
        beyond = np.flatnonzero(wide > 1.0 + slack)
        if not beyond.size:
            return cuts
        at += int(beyond[0])
        cuts.append(at)


@pytest.mark.parametrize("seed", range(20))
def test_cuts_are_those_of_the_definition(seed):
    random = np.random.default_rng(seed)
    n, spacing = int(random.integers(50, 3000)), float(random.uniform(0.2, 5.0))
    rows = np.sort(random.choice(2 * n if seed % 2 else n + 9, n, replace=False))
    v = np.rint(spacing * rows + random.uniform(0.0, seed % 4, n))
    middle = n // 3
    parts, edges = [v[:middle], v[middle:]], [0, middle, n]
    right = sorted(
        {
            middle,
            *over_all_the_rest(parts[0], spacing, 0.02),
            *(middle + cut for cut in over_all_the_rest(parts[1], spacing, 0.02)),
        }
    )
    found = rounding._where_rows_miss(parts, edges, spacing, 0.02)
    assert found is not None
    assert found.tolist() == right
    # as many pieces as there are may be left, and no fewer
    assert rounding._where_rows_miss(parts, edges, spacing, 0.02, len(right) + 1) is not None
    if len(right) > 1:
        assert rounding._where_rows_miss(parts, edges, spacing, 0.02, len(right)) is None


class Counted:
    """A ufunc that counts the numbers it accumulates."""

    def __init__(self, ufunc: np.ufunc) -> None:
        self.ufunc, self.numbers = ufunc, 0

    def __call__(self, *given):
        return self.ufunc(*given)

    def accumulate(self, array: np.ndarray) -> np.ndarray:
        self.numbers += array.size
        assert self.numbers < 1e7, "far more numbers were looked over than there are"
        return self.ufunc.accumulate(array)


class CountingNumPy:
    """NumPy with two ufuncs that count."""

    def __init__(self) -> None:
        self.maximum, self.minimum = Counted(np.maximum), Counted(np.minimum)

    def __getattr__(self, name: str):
        return getattr(np, name)


def jittery(n: int) -> np.ndarray:
    """Times at which a busy computer took readings, in whole milliseconds."""
    random = np.random.default_rng(0)
    return np.round(np.cumsum(4.4e-3 + random.uniform(-1e-3, 1e-3, n)), 3)


def test_times_that_tremble_are_looked_over_a_few_times_only(monkeypatch):
    counting = CountingNumPy()
    monkeypatch.setattr(rounding, "np", counting)
    t = jittery(100_000)
    assert made_even(t, np.zeros(t.size - 1, dtype=bool)) is None
    assert 0 < counting.maximum.numbers < 10 * t.size


def test_without_a_bound_they_are_looked_over_a_few_times_too(monkeypatch):
    counting = CountingNumPy()
    monkeypatch.setattr(rounding, "np", counting)
    t = jittery(100_000)
    v = np.rint(1e3 * (t - t[0]))
    cuts = rounding._where_rows_miss([v], [0, v.size], 4.4, 0.02)
    assert cuts is not None
    assert cuts.size > 5000
    assert counting.maximum.numbers < 50 * t.size
