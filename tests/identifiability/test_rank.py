"""Structural identifiability is found, not written in: scale, Ts2, factor 2."""

import numpy as np
import pytest

from tests.reference import BENCH
from tp_jax.identifiability.design import UNKNOWNS, sine_design
from tp_jax.identifiability.rank import rank

TS = np.linspace(0.0, 2.0, 81)
DESIGNS = (sine_design(13.09, TS), sine_design(8.0, TS), sine_design(0.0, TS, release=1.2))
CENTRE = {n: BENCH.get(n) or 0.01 for n in UNKNOWNS} | {"reaction": 1.0}
SCALE = {n: 1.0 for n in ("B1", "B2", "k", "c1", "M1", "Tv", "Ts1", "Tst")}
TWICE = {n: 1.0 for n in ("B1", "k", "c1", "M1", "reaction")}


@pytest.fixture(scope="module")
def found():
    return rank(DESIGNS, CENTRE, UNKNOWNS, points=5, seed=1)


def test_nine_of_eleven(found):
    assert found.rank == 9
    assert (found.ranks == 9).all()
    assert found.gap > 1e6


def test_scale_and_ts2_are_found(found):
    directions = [dict(d.coefficients) for d in found.directions]
    assert {"Ts2": 1.0} in directions
    assert any(d == pytest.approx(SCALE, abs=1e-3) for d in directions)
    assert all(d.kind == "structural" for d in found.directions)


def test_what_is_seen_least_is_the_rise_of_the_contacts_friction(found):
    contact = [UNKNOWNS.index(n) for n in ("Tv", "Ts1", "Tst", "T0")]
    # at most points: a bearing that hardly rubs there is seen as little
    assert np.median(np.linalg.norm(found.weakest[:, contact], axis=1)) > 0.9


def test_the_printed_factor_is_one_more_free_direction():
    found = rank(DESIGNS, CENTRE, (*UNKNOWNS, "reaction"), points=3, seed=1)
    assert found.rank == 9
    table = np.array([[d.coefficients.get(n, 0.0) for n in found.names] for d in found.directions])
    assert len(table) == 3
    # B1, k, c1 and M1 as many times as large under a reaction as many times as large
    for expected in (SCALE, TWICE, {"Ts2": 1.0}):
        row = [expected.get(n, 0.0) for n in found.names]
        left = np.linalg.lstsq(table.T, np.array(row), rcond=None)[1]
        assert np.all(left < 1e-9), expected


def test_a_rider_that_never_slips_leaves_more_unseen():
    quiet = {**CENTRE, "A": 0.01}
    still = rank((sine_design(6.0, TS),), quiet, UNKNOWNS, points=1)
    moving = rank((sine_design(13.09, TS),), CENTRE, UNKNOWNS, points=1)
    # as large as an angle of the noise's size for a parameter twice as large
    seen = [(r.singular_values[0] > 1.0).sum() for r in (still, moving)]
    assert seen[0] < seen[1]


def test_a_centre_of_zero_is_refused():
    with pytest.raises(ValueError, match="Ts2 is 0"):
        rank(DESIGNS, {**CENTRE, "Ts2": 0.0}, UNKNOWNS, points=1)
