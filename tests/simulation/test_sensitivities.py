"""Derivatives of whole runs against the variational equations, and when they are to be doubted."""

import importlib

import numpy as np
import pytest

from tests.reference import BENCH, reference
from tests.simulation.test_runs import Dahl
from tests.simulation.variational import double, single_with_bristle, variational
from tp_jax.effects import Applied
from tp_jax.model import Bearing, LinearSpring, SineDrive, SingleTorsionPendulum, presets
from tp_jax.simulation import sensitivities, simulate
from tp_jax.simulation.sensitivities import BASE, STATE

module = importlib.import_module("tp_jax.simulation.sensitivities")  # the function has its name

# As many times and directions in all tests of the double pendulum, so that one program serves them.
TS = np.linspace(0.0, 0.5, 26)
NAMES = tuple(name.rsplit(".")[-1] for name in BASE)
REST = (0.0, 0.0, 0.0, 0.0)
SLIDING = (0.1, 0.0, 8.0, -12.0)


def derive(p, y0=REST, ts=TS, by=None, tolerance=1e-8, **more):
    model = presets.double_pendulum(**p)
    return sensitivities(model, ts, np.array(y0), by=by, tolerance=tolerance, **more)


def errors(found, expected):
    """Of every direction, relative to its largest value."""
    difference = np.stack([found.phi1, found.phi2], axis=1) - expected[:, :2]
    size = np.abs(expected[:, :2]).max(axis=(0, 1))
    return np.abs(difference).max(axis=(0, 1)) / size


@pytest.fixture
def traces(monkeypatch):
    """How often the engine is traced."""
    count = []

    def counted(*args, **more):
        count.append(1)
        return integrate(*args, **more)

    integrate = module.integrate
    monkeypatch.setattr(module, "integrate", counted)
    return count


CASES = {
    "rest, 1e3": (BENCH | dict(eps=1e3), REST),
    "rest, 5e4": (BENCH, REST),
    "sliding, 1e3": (BENCH | dict(eps=1e3), SLIDING),
    "sliding, 5e4": (BENCH, SLIDING),
}


@pytest.fixture(scope="module", params=CASES)
def case(request):
    p, y0 = CASES[request.param]
    return request.param, derive(p, y0), *variational(double, p, NAMES, TS, y0)


def test_the_motion(case):
    name, found, y, _ = case
    p, y0 = CASES[name]
    np.testing.assert_allclose(y[:, :2], reference(p, TS, y0)[:, :2], rtol=0.0, atol=1e-8)
    for i, phi in enumerate(found.motion[1:3]):
        np.testing.assert_allclose(phi, y[:, i], rtol=0.0, atol=3e-8)
    # through sticking, sliding and reversals of both
    v1, v2 = y[:, 2:].T
    assert (v1[1:] * v1[:-1] < 0.0).any()
    assert (v2[1:] * v2[:-1] < 0.0).any()
    assert (np.abs(v2) < 2.0 / p["eps"]).any()
    assert (np.abs(v2) > 1.0).any()


def test_every_direction(case):
    name, found, _, expected = case
    assert found.names == (*STATE, *BASE)
    assert found.phi1.shape == found.phi2.shape == (*TS.shape, 14)
    wrong = errors(found, expected)
    # Held by friction from the start, a velocity is forgotten within microseconds, and what
    # is left of it, 1e-5 s, is the one thing not known to three digits.
    forgotten = np.isin(found.names, ["omega1(0)", "omega2(0)"]) & (name == "rest, 5e4")
    assert (wrong[~forgotten] < 1e-3).all(), dict(zip(found.names, wrong, strict=True))
    size = np.abs(expected[:, :2]).max(axis=(0, 1))
    assert (size[forgotten] < 1e-4).all()
    assert (wrong[forgotten] * size[forgotten] < 1e-5).all()


def test_a_plain_run_is_reliable(case):
    name, found, _, expected = case
    forgotten = np.isin(found.names, ["omega1(0)", "omega2(0)"]) & (name == "rest, 5e4")
    assert found.reliable[~forgotten].all()
    assert 1.0 <= found.growth < 10.0
    # The estimate says where the error is large. It counts what the steps do to angles, not to
    # velocities in a reversal, so that it is up to a hundred times too small.
    wrong = errors(found, expected)
    assert (found.error[forgotten] > 0.01).all()
    assert (found.error[~forgotten] < 0.01).all()
    assert (wrong < 300.0 * found.error + 1e-9).all()


def test_what_is_forgotten_at_once_is_flagged():
    # at a coarse tolerance nothing is right of what a held body remembers of its first velocity
    found = derive(BENCH, tolerance=1e-6)
    _, expected = variational(double, BENCH, NAMES, TS, REST)
    wrong = errors(found, expected)
    assert [n for n, r in zip(found.names, found.reliable, strict=True) if not r] == [*STATE[2:]]
    assert (wrong[2:4] > 0.1).all()
    assert (wrong[found.reliable] < 1e-2).all()


def test_finer_tolerances_are_better():
    p, y0 = CASES["sliding, 1e3"]
    _, expected = variational(double, p, NAMES, TS, y0)
    wrong = [errors(derive(p, y0, tolerance=tol), expected).max() for tol in (1e-5, 1e-7, 1e-9)]
    assert wrong[0] > 5.0 * wrong[1] > 25.0 * wrong[2]
    assert wrong[2] < 1e-6


def test_directions_are_data(traces):
    p, y0 = CASES["sliding, 5e4"]
    whole = derive(p, y0)
    traces.clear()  # of the first call, where no other test has compiled it
    backwards = derive(p, y0, by=BASE[::-1])
    assert backwards.names == (*STATE, *BASE[::-1])
    for a, b in ((backwards.phi1, whole.phi1), (backwards.phi2, whole.phi2)):
        np.testing.assert_allclose(a[:, 4:], b[:, :3:-1], rtol=1e-9, atol=1e-15)
    # other numbers than the paper's unknowns, and one of them twice
    more = ("drive.omega", "reaction", "B2", "B2", *BASE[4:])
    found = derive(p, y0, by=more)
    names = ("omega", "reaction", "B2", "B2", *NAMES[4:])
    _, expected = variational(double, p, names, TS, y0)
    assert (errors(found, expected)[4:] < 1e-3).all()
    assert not traces


def test_numbers_that_do_nothing():
    # Ts2 acts on no motion, the sensors' zeros on none either
    found = derive(BENCH, SLIDING, by=("contact.Ts2", "sensors.zero1", *BASE[2:]))
    np.testing.assert_array_equal(found.phi1[:, 4:6], 0.0)
    np.testing.assert_array_equal(found.phi2[:, 4:6], 0.0)
    assert found.reliable.all()


def test_times_and_bounds_are_data(traces):
    found = derive(BENCH, SLIDING, ts=1.0 + 0.5 * TS, tolerance=1e-7, max_steps=50_000)
    assert np.isfinite(found.phi1).all()
    assert not traces


# The rider under a Stribeck drop, coming to rest: a little slower and it sticks, a little faster
# and it slips through. Found by a scan of its first velocity.
WEAKENING = BENCH | dict(Tst=-1.2e-2, T0=40.0)
GRAZING = (-0.003, 0.22, 3.6, -4.6949)


def test_a_grazing_run_is_flagged():
    found = derive(WEAKENING, GRAZING)
    assert found.growth > 1e3
    assert not found.reliable.any()
    # and rightly: a change of the start far below any measurement's is another motion
    here = reference(WEAKENING, TS, GRAZING, rtol=1e-12, atol=1e-13)
    step = 2e-4
    there = reference(WEAKENING, TS, (*GRAZING[:3], GRAZING[3] + step), rtol=1e-12, atol=1e-13)
    foreseen = np.abs(found.phi2[:, 3]).max() * step
    assert np.abs(here - there)[:, 1].max() < 0.5 * foreseen


@pytest.mark.parametrize("aside", [-0.5, 0.5])
def test_a_run_beside_it_is_not(aside):
    found = derive(WEAKENING, (*GRAZING[:3], GRAZING[3] + aside))
    assert found.growth < 100.0
    assert found.reliable.all()


def test_a_horizon_beyond_prediction_is_flagged():
    # a spring that pushes: whatever is disturbed grows as exp(t sqrt(k/B1)) or nearly so
    p = BENCH | dict(k=-0.45, c1=0.0, M1=0.0, Tv=0.0, Ts1=0.0, Tst=0.0)
    rate = np.sqrt(0.45 / BENCH["B1"])
    for span, known in ((0.25, True), (0.5, False)):
        found = derive(p, ts=TS * span / TS[-1])
        assert found.growth == pytest.approx(np.cosh(rate * span), rel=1e-5)
        assert found.reliable.all() == found.reliable.any() == known


@pytest.mark.parametrize("change", [dict(max_steps=64), dict(k=np.nan)])
def test_a_run_that_is_given_up_is_not_relied_upon(change):
    bound = {name: change[name] for name in change if name == "max_steps"}
    found = derive(BENCH | {n: v for n, v in change.items() if n not in bound}, SLIDING, **bound)
    assert not found.reliable.any()
    assert found.phi1[-1, 0] == np.inf
    assert found.motion.phi1[-1] == np.inf


def test_the_run_is_that_of_simulate(case):
    name, found, *_ = case
    p, y0 = CASES[name]
    plain = simulate(presets.double_pendulum(**p), TS, np.array(y0), tolerance=1e-8)
    for a, b in zip(found.motion, plain, strict=True):
        np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-11)


@pytest.mark.slow
def test_many_at_once_are_what_each_is_alone():
    k, starts = np.array([0.4, 0.45, 0.5]), np.array(SLIDING) * np.array([[1.0], [0.5], [-1.0]])
    many = presets.double_pendulum(**BENCH | {"k": k})
    found = sensitivities(many, TS, starts, tolerance=1e-8)
    assert found.phi1.shape == found.phi2.shape == (3, TS.size, len(STATE) + len(BASE))
    assert found.motion.phi1.shape == (3, TS.size)
    assert found.growth.shape == (3,)
    for i in range(3):
        alone = derive(BENCH | {"k": k[i]}, starts[i])
        for a, b in ((found.phi1[i], alone.phi1), (found.phi2[i], alone.phi2)):
            np.testing.assert_allclose(a, b, rtol=1e-7, atol=1e-9 * np.abs(b).max())
        np.testing.assert_allclose(found.motion.omega2[i], alone.motion.omega2, atol=1e-9)
        np.testing.assert_array_equal(found.reliable[i], alone.reliable)
        assert found.growth[i] == pytest.approx(alone.growth, rel=1e-6)
    with pytest.raises(ValueError, match="equally many"):
        sensitivities(many, TS, starts[:2])


def test_states_of_effects_and_a_column_alone():
    p = BENCH | dict(a=0.7, z0=0.03)
    y0 = np.array([0.3, 0.0, -2.0, 0.0, 0.01])
    effect = Applied(Dahl(), {"a": np.array(p["a"]), "z0": np.array(p["z0"])})
    model = SingleTorsionPendulum(
        drive=SineDrive(A=p["A"], omega=p["omega"]),
        spring=LinearSpring(p["k"]),
        bearing=Bearing(p["c1"], p["M1"], p["eps"]),
        B1=p["B1"],
        terms=(effect,),
    )
    by = ("terms.0.values.a", "terms.0.values.z0", "bearing.M1", "B1")
    found = sensitivities(model, TS, y0, by=by, tolerance=1e-8)
    assert found.names == (*STATE, "state 4", *by)
    y, expected = variational(single_with_bristle, p, ("a", "z0", "M1", "B1"), TS, y0)
    np.testing.assert_allclose(found.motion.phi1, y[:, 0], rtol=0.0, atol=3e-8)
    moved = np.array([0, 2, 4, 5, 6, 7, 8])  # there is no rider to be elsewhere
    size = np.abs(expected[:, 0]).max(axis=0)[moved]
    wrong = np.abs(found.phi1 - expected[:, 0])[:, moved].max(axis=0) / size
    assert (wrong < 1e-3).all(), wrong
    assert found.reliable[moved].all()
    np.testing.assert_array_equal(found.phi1[:, [1, 3]], 0.0)


def test_a_number_the_model_does_not_have():
    with pytest.raises(ValueError, match=r"names 'contact.nothing', .* it has drive.A, .*\.$"):
        derive(BENCH, by=["B1", "contact.nothing"])


def test_a_start_that_does_not_fit():
    with pytest.raises(ValueError, match="Argument `y0` must have shape"):
        derive(BENCH, np.zeros(5))


def test_a_single_pendulum_leaves_out_the_contact():
    model = SingleTorsionPendulum(
        drive=SineDrive(A=0.1, omega=5.0),
        spring=LinearSpring(0.45),
        bearing=Bearing(1e-3, 0, 1e3),
        B1=1.2e-3,
    )
    with pytest.raises(ValueError, match=r"'B2'.* it has (?!.*contact)"):
        sensitivities(model, TS, by=["B2"])
