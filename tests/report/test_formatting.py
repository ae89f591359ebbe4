"""Numbers as people read them."""

import pytest

from tp_jax.report import formatting as f


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.58, "0.580"),
        (52.0, "52.0"),
        (123.4, "123"),
        (1234.0, "1,230"),
        (0.0, "0"),
        (-0.4, "−0.400"),
        (9.999, "10.0"),
        (0.0012, "0.00120"),
        (1.23e-5, "1.23 × 10⁻⁵"),
        (4e9, "4.00 × 10⁹"),
        (None, "–"),
        (float("nan"), "–"),
        ("x", "–"),
        (True, "–"),
    ],
)
def test_number(value, text):
    assert f.number(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.98, "98 %"),
        (0.997, "99.7 %"),
        (1.0, "100 %"),
        (-0.4, "−40 %"),
        (-0.001, "0 %"),
        (0.994, "99 %"),
        (None, "–"),
    ],
)
def test_percent(value, text):
    assert f.percent(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.97, "97 %"), (1.0, "> 99 %"), (0.999, "> 99 %"), (1e-9, "< 1 %"), (None, "–")],
)
def test_probability_is_never_certain(value, text):
    assert f.probability(value) == text


@pytest.mark.parametrize(
    ("value", "ci95", "expected"),
    [
        (0.45, [0.44, 0.46], ("0.450", "0.440 to 0.460")),
        (0.45023, [0.45019, 0.45027], ("0.450230", "0.450190 to 0.450270")),
        (0.58, None, ("0.580", "")),
        (None, [1.0, 2.0], ("–", "1.00 to 2.00")),
        (2.2e-5, [2.1e-5, 2.3e-5], ("2.20 × 10⁻⁵", "2.10 to 2.30 × 10⁻⁵")),
        (-0.1, [-0.3, 0.1], ("−0.100", "−0.300 to 0.100")),
        (1.0, [1.0, 1.0], ("1.00", "1.00 to 1.00")),
        (0.0, [0.0, 0.0], ("0.00", "0.00 to 0.00")),
        (1.0, [None, 2.0], ("1.00", "")),
    ],
)
def test_estimates_show_the_width_of_their_interval(value, ci95, expected):
    assert f.estimate(value, ci95) == expected


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ([0.052, 0.0014, None], ["52.0 mrad", "1.40 mrad", "–"]),
        ([1.5, 0.001], ["1.50 rad", "0.00100 rad"]),
        ([4e-5], ["40.0 µrad"]),
        ([None], ["–"]),
        ([0.0], ["0 mrad"]),
    ],
)
def test_angles_share_one_unit(values, texts):
    assert f.angles(values) == texts


def test_units_and_times():
    assert f.with_unit(2.0, "kg m^2") == "2.00 kg m²"
    assert f.with_unit(0.1, "1") == "0.100"
    assert f.with_unit(0.1, None) == "0.100"
    assert f.duration(12.34) == "12.3 s"
    assert f.duration(250) == "4 min 10 s"
    assert f.duration(7300) == "2 h 1 min"
    assert f.p_value(1e-9) == "p < 0.001"
    assert f.p_value(0.4123) == "p = 0.41"
