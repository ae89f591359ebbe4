"""The row of slots, and the numbers in it."""

import numpy as np
import pytest

from tests.rigs import OMEGAS, bench_values, whole_layout
from tp_jax.effects import catalogue
from tp_jax.estimation.layout import Layout, Unknown
from tp_jax.estimation.linearisation import columns
from tp_jax.model import DoubleTorsionPendulum, SingleTorsionPendulum

UNKNOWNS = (
    Unknown("k"),
    Unknown("Ts1"),
    Unknown("zero2", 0),
    Unknown("zero2", 1),
    Unknown("drive_frequency.a", 1),
    Unknown("column_tilt.b"),
)


def test_put_and_pick_are_inverse():
    x = np.random.default_rng(0).normal(size=len(UNKNOWNS))
    before = bench_values()
    after = before.put(UNKNOWNS, x)
    np.testing.assert_array_equal(after.pick(UNKNOWNS), x)
    np.testing.assert_array_equal(before.table, bench_values().table)  # itself unchanged
    back = after.put(UNKNOWNS, before.pick(UNKNOWNS))
    np.testing.assert_array_equal(back.table, before.table)


def test_put_reaches_one_recording_or_all():
    values = bench_values().put(UNKNOWNS, np.arange(1.0, 7.0))
    assert [values.get("k", r) for r in (0, 1)] == [1.0, 1.0]
    assert [values.get("zero2", r) for r in (0, 1)] == [3.0, 4.0]
    assert [values.get("drive_frequency.a", r) for r in (0, 1)] == [0.0, 5.0]
    assert values.recordings([1]).get("zero2") == 4.0
    with pytest.raises(ValueError, match="zip"):
        values.put(UNKNOWNS, np.zeros(2))


def test_by_name():
    values = bench_values().replace({"omega": (1.0, 2.0), "k": 0.5})
    table = values.to_dict()
    assert table["omega"] == [1.0, 2.0]
    assert table["k"] == 0.5
    assert bench_values().to_dict()["omega"] == list(OMEGAS)
    # shape constants start in the middle of their grid
    assert table["contact_stribeck.vs"] in catalogue()["contact_stribeck"].shapes[0].grid


def test_slots():
    layout = whole_layout()
    names = [p.name for p in layout.parameters]
    assert len(set(names)) == len(names)
    bare = [p.name for p in Layout(layout.kind, ()).parameters]
    assert names[: len(bare)] == bare
    amplitudes = [names[i] for i in layout.amplitudes(frozenset(catalogue()))]
    assert amplitudes == [e.qualified(a.name) for e in layout.effects for a in e.amplitudes]
    assert columns(UNKNOWNS) == ("k", "Ts1", "zero2", "drive_frequency.a", "column_tilt.b")


@pytest.mark.parametrize(
    ("kind", "model"), [("double", DoubleTorsionPendulum), ("single", SingleTorsionPendulum)]
)
def test_model_of_the_slots(kind, model):
    layout = Layout(kind, ())
    table = bench_values().table[: len(layout.parameters), 0]
    pendulum = layout.model(tuple(table))
    assert isinstance(pendulum, model)
    assert pendulum.B1 == table[layout.index["B1"]]
    assert pendulum.drive.amplitude == table[layout.index["A"]]
