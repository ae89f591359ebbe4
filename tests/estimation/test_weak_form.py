"""The start from the weak form of the equations is near, whatever the campaign holds."""

import dataclasses

import numpy as np
import pytest

from tests.reference import BENCH
from tests.rigs import lossy, synthetic_campaign
from tp_jax.estimation.modulating import bumps
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.weak_form import WeakForm

COLUMN = ("k", "c1", "M1")


def prepared(campaign, which=None, **options):
    if which is not None:
        recordings = tuple(campaign.recordings[i] for i in which)
        campaign = dataclasses.replace(campaign, recordings=recordings)
    return prepare_campaign(campaign, effects=(), **options)


def friction(get, v=2.0):
    """What the contact does at a middling speed: all that is known well of it."""
    return get("Tv") * v + get("Ts1") + get("Tst") * (1.0 - np.exp(-v * get("T0")))


@pytest.fixture(scope="module")
def campaign():
    return synthetic_campaign()


def test_near_the_truth(campaign):
    values = WeakForm(prepared(campaign)).start()
    for name, error in dict(k=0.01, A=0.02, B2=0.06, c1=0.06, M1=0.06).items():
        assert values.get(name) == pytest.approx(BENCH[name], rel=error), name
    assert friction(values.get) == pytest.approx(friction(BENCH.get), rel=0.08)
    assert abs(values.get("phase")) < 0.02
    assert abs(values.get("zero1")) < 0.01


def test_nearer_than_smoothed_accelerations(campaign):
    setting = prepared(campaign)
    weak, smoothed = WeakForm(setting).start(), initial_values(setting)
    for name in ("k", "B2", "c1", "M1"):
        off = [abs(np.log(v.get(name) / BENCH[name])) for v in (weak, smoothed)]
        assert off[0] < off[1], name


def test_noise_pulls_nothing_to_zero():
    for noise in (1e-3, 4e-3):
        values = WeakForm(prepared(synthetic_campaign(noise=noise))).start()
        assert values.get("k") == pytest.approx(BENCH["k"], rel=0.03)
        assert values.get("B2") == pytest.approx(BENCH["B2"], rel=0.15)


def test_only_forced_runs(campaign):
    values = WeakForm(prepared(campaign, (1, 2))).start()
    for name, error in dict(k=0.02, A=0.03, B2=0.1, c1=0.1, M1=0.15).items():
        assert values.get(name) == pytest.approx(BENCH[name], rel=error), name
    assert friction(values.get) == pytest.approx(friction(BENCH.get), rel=0.12)


def test_only_one_forced_run(campaign):
    values = WeakForm(prepared(campaign, (1,))).start()
    assert values.get("k") == pytest.approx(BENCH["k"], rel=0.15)
    assert values.get("A") == pytest.approx(BENCH["A"], rel=0.15)


def test_only_a_decay(campaign):
    setting = prepared(campaign, (0,))
    values = WeakForm(setting).start()
    assert "A" not in {u.name for u in setting.unknowns()}
    for name, error in dict(k=0.05, B2=0.15, M1=0.25).items():
        assert values.get(name) == pytest.approx(BENCH[name], rel=error), name


def test_a_rider_that_never_slides(campaign):
    # one body in effect: only k / (B1 + B2) is told, and how much friction was withstood
    decay = campaign.recordings[0]
    t = decay.t
    w = np.sqrt(BENCH["k"] / (BENCH["B1"] + BENCH["B2"]))
    rng = np.random.default_rng(0)
    phi1 = 0.3 * np.exp(-0.2 * t) * np.cos(w * t) + 1e-3 * rng.standard_normal(t.size)
    phi2 = 1e-3 * rng.standard_normal(t.size)
    stuck = dataclasses.replace(decay, phi1=phi1, phi2=phi2)
    setting = prepared(dataclasses.replace(campaign, recordings=(stuck,)))
    values = WeakForm(setting).start()
    B1, B2 = BENCH["B1"], values.get("B2")
    assert 0.05 * B1 < B2 < 2.0 * B1
    assert values.get("k") / (B1 + B2) == pytest.approx(w**2, rel=0.05)
    assert values.get("Ts1") > 0.9 * B2 * 0.3 * w**2


def test_what_is_known_stays(campaign):
    fix = {"k": 0.47, "Ts1": 0.012}
    values = WeakForm(prepared(campaign, fix=fix)).start()
    for name, value in fix.items():
        assert values.get(name) == value
    assert values.get("A") == pytest.approx(BENCH["A"], rel=0.1)
    assert values.get("Tst") < 0.5 * BENCH["Ts1"]


def test_the_printed_model_has_halves(campaign):
    newton = WeakForm(prepared(campaign)).start()
    paper = WeakForm(prepared(campaign, model="paper")).start()
    assert paper.get("reaction") == 2.0
    for name in ("B2", "Tv", "Ts1", "Tst"):
        assert paper.get(name) == pytest.approx(0.5 * newton.get(name), rel=0.02), name
    assert paper.get("k") == pytest.approx(newton.get("k"), rel=1e-3)


def test_bootstrap_samples_differ_and_repeat(campaign):
    weak = WeakForm(prepared(campaign))
    draws = [weak.start(T0=3.0, rng=np.random.default_rng(i)).get("k") for i in (1, 2, 1)]
    assert draws[0] == draws[2] != draws[1]
    np.testing.assert_allclose(draws, BENCH["k"], rtol=0.03)
    assert weak.start(T0=3.0).get("T0") == 3.0


def test_gaps_are_no_data(campaign):
    runs = [lossy(r, i, (1.1, 1.5)) for i, r in enumerate(campaign.recordings)]
    values = WeakForm(prepared(dataclasses.replace(campaign, recordings=tuple(runs)))).start()
    assert values.get("k") == pytest.approx(BENCH["k"], rel=0.02)


def test_bumps_integrate_by_parts(campaign):
    setting = prepared(campaign)
    for length in (0.08, 0.2):
        for w in list(bumps(setting.prepared, [0], length))[::7]:
            s = setting.prepared[0].t[w.span]
            s = s - s[0]
            # exactly for parabolas, whatever they stand on, and nearly for the rest
            for f, df, ddf in (
                (50.0 - s + 3.0 * s**2, 6.0 * s - 1.0, 6.0 + 0.0 * s),
                (np.sin(20.0 * s), 20.0 * np.cos(20.0 * s), -400.0 * np.sin(20.0 * s)),
            ):
                assert w.second @ f == pytest.approx(w.psi @ ddf, rel=1e-3)
                assert -(w.first @ f) == pytest.approx(w.psi @ df, rel=1e-3)
