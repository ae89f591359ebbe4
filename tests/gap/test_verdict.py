"""The verdict, by what it rests on."""

import pytest

from tp_jax.gap.held_out import Shrink
from tp_jax.gap.verdict import both, verdict

GONE, MOSTLY, PARTLY, NONE = (
    Shrink(0.9999, (0.9995, 1.0), True), Shrink(0.95, (0.92, 0.97), True),
    Shrink(0.9, (0.8, 0.95), True), Shrink(None, None, False),
)  # fmt: skip


@pytest.mark.parametrize(
    ("p", "p_after", "excess", "causes", "shrink", "word"),
    [
        (0.4, 0.4, 0.5, 0, NONE, "no_gap"),
        (0.4, 0.4, 0.5, 1, GONE, "no_gap"),
        (0.4, 0.4, 3.5, 0, NONE, "unknown"),  # misfit beyond the noise that no effect sees
        (0.001, 0.4, 9.0, 1, MOSTLY, "explained"),
        (0.001, 0.4, 9.0, 0, MOSTLY, "unknown"),
        (0.001, 0.4, 9.0, 1, PARTLY, "unknown"),
        (0.001, 0.4, 0.1, 1, NONE, "unknown"),
        (0.001, 0.001, 9.0, 1, MOSTLY, "unknown"),  # a wrong cause takes most of it
        (0.001, 0.001, 9.0, 1, GONE, "explained"),  # what stays is next to nothing
    ],
)  # fmt: skip
def test_word(p, p_after, excess, causes, shrink, word):
    assert verdict(p, p_after, excess, causes, shrink) == word


def test_either_test_of_structure_is_enough():
    assert both(0.3, 0.4) == pytest.approx(0.6)
    assert both(0.001, 1.0) == pytest.approx(0.002)
    assert both(1.0, 0.001) == pytest.approx(0.002)
    assert both(1.0, 0.7) == 1.0
