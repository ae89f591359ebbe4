"""Which chosen effects are named: likely ones, whose size is not zero."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from tests.standing_in import standing_in
from tp_jax.effects import catalogue
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown
from tp_jax.estimation.normal_equations import NormalEquations
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import acceptance
from tp_jax.gap.acceptance import has_size, is_worse, least_probable, with_ties
from tp_jax.gap.backward import wald
from tp_jax.gap.choice import Choice, Round
from tp_jax.gap.directions import Variant
from tp_jax.gap.refit import Refit
from tp_jax.results.diagnosis import Errors

SETTING = standing_in(PreparedCampaign)


@dataclasses.dataclass
class Numbers:
    """A fit's unknowns, their values, errors that belong together, and blocks' degrees of freedom.

    at_bound: which of the unknowns are held.
    """

    names: list[str]
    sizes: list[float]
    sd: list[float]
    correlation: float
    dof: float
    at_bound: np.ndarray

    @property
    def unknowns(self):
        return [SimpleNamespace(name=name, recording=None) for name in self.names]

    @property
    def values(self):
        own = dict(zip(self.names, self.sizes, strict=True))
        return SimpleNamespace(pick=lambda us: np.array([own[u.name] for u in us]))

    def covariance(self):
        """Of those that are not held."""
        related = np.where(np.eye(len(self.names)) > 0.0, 1.0, self.correlation)
        every = np.linalg.inv(np.outer(self.sd, self.sd) * related)
        free = np.ix_(~self.at_bound, ~self.at_bound)
        out = np.zeros_like(every)
        out[free] = np.linalg.inv(every[free])
        return out, np.full(len(self.names), self.dof)


def result(*ids, fit=None):
    variants = tuple(Variant(catalogue()[id], (), ()) for id in ids)
    return standing_in(Refit, variants=variants, fit=fit, ids=ids)


@pytest.fixture
def sized(monkeypatch):
    """Asks for the size of an effect with given amplitudes."""
    monkeypatch.setattr(acceptance, "covariance", lambda fit, setting: fit.covariance())

    def ask(id, *sizes, sd, correlation=0.0, dof=np.inf, bound=(), names=("a", "b")):
        names = [f"{id}.{a}" for a in names[: len(sizes)]]
        held = np.array([name in bound for name in names], bool)
        fit = Numbers(names, list(sizes), list(sd), correlation, dof, held)
        return has_size(SETTING, result(id, fit=fit), id)

    return ask


@pytest.mark.parametrize(
    ("size", "how", "there"),
    [
        (0.2, {}, True),
        (-0.2, {}, True),
        (0.1, {}, False),
        (0.2, {"dof": 2.0}, False),  # a few blocks' scatter
        (0.0, {"bound": ["bearing_drag.a"]}, False),
    ],
)
def test_a_size_is_an_interval_without_zero(sized, size, how, there):
    assert sized("bearing_drag", size, sd=[0.08], **how) == there


@pytest.mark.parametrize(("rise", "there"), [(900.0, True), (2.0, False)])
def test_a_size_at_its_upper_bound_is_asked_by_what_it_takes(sized, monkeypatch, rise, there):
    """Dahl's law at a = 1 is pure bristles, the strongest there is."""
    monkeypatch.setattr(acceptance, "wald", lambda result, variant: rise)
    bound = ["bearing_presliding.a"]
    assert sized("bearing_presliding", 1.0, sd=[0.01], bound=bound) is there


def test_no_shape_takes_what_an_amplitude_at_its_bound_does():
    """A stiffness at its bound and the turn after which the cable slips, beside a friction."""
    effect = catalogue()["column_cable"]
    a, z0, friction = (Unknown(n) for n in ("column_cable.a", "column_cable.z0", "M1"))
    related = np.array([[1.0, -0.99, 0.6], [-0.99, 1.0, 0.0], [0.6, 0.0, 1.0]])
    normal = NormalEquations(np.zeros(3), 25.0 * related, np.zeros(3))
    fit = standing_in(
        Fit,
        unknowns=(a, z0, friction),
        chi2_dof=1.0,
        normal=lambda: normal,
        values=SimpleNamespace(pick=lambda us: np.array([2.0 for _ in us])),
    )
    variant = standing_in(Variant, effect=effect, unknowns=(a,))
    # of the friction's column .8**2 of its own is left
    assert wald(Refit(fit, (variant,)), variant) == pytest.approx(2.0**2 * 25.0 * 0.8**2)


def test_two_amplitudes_are_asked_together(sized):
    assert sized("column_tilt", 0.01, 0.3, sd=[0.1, 0.1])
    assert not sized("column_tilt", 0.1, 0.1, sd=[0.1, 0.1])
    # each may be nothing alone where both cannot be
    assert sized("column_tilt", 0.15, 0.15, sd=[0.1, 0.1], correlation=-0.9)
    assert not sized("column_tilt", 0.15, 0.15, sd=[0.1, 0.1], correlation=0.9)


def test_a_size_that_another_shape_would_double_is_a_size(sized):
    """A cable's stiffness and the turn after which it slips: their product is known well."""
    names = ("a", "z0")
    assert sized("column_cable", 0.6, 0.04, sd=[0.5, 0.03], correlation=-0.99, names=names)
    assert not sized("column_cable", 0.6, 0.04, sd=[0.5, 0.03], names=names)


def test_amplitudes_of_recordings_have_no_size_of_the_campaign(sized):
    assert sized("contact_repeatability", sd=[])


def test_ties_count_together(monkeypatch):
    groups = [["column_tilt", "spring_asymmetry"], ["column_tilt", "clock_skew", "bearing_drag"]]
    monkeypatch.setattr(acceptance, "tied", lambda setting, choice: groups)
    p = {"column_tilt": 0.4, "spring_asymmetry": 0.3, "clock_skew": 0.2, "bearing_drag": 0.05}
    choice = standing_in(Choice, causes=("column_tilt",))
    # a group counts as one, with three members at most
    assert with_ties(SETTING, choice, "column_tilt", p) == pytest.approx(0.9)
    assert with_ties(SETTING, choice, "spring_asymmetry", p) == pytest.approx(0.7)
    assert least_probable(SETTING, choice, p) == pytest.approx(0.9)
    assert least_probable(SETTING, standing_in(Choice, causes=()), p) == 1.0


def test_worse_is_worse_in_windows_or_in_a_free_run():
    before = Errors(1.0, 2.0)
    assert not is_worse(before, Errors(1.01, 2.0))
    assert is_worse(before, Errors(1.1, 1.0))
    assert is_worse(before, Errors(0.5, 2.1))
    assert is_worse(before, Errors(0.5, None))
    assert not is_worse(Errors(1.0, None), Errors(0.9, 9.0))


BEFORE = {id: standing_in(Fit) for id in ("drive_frequency", "clock_skew", "sensor1_nonlinearity")}
"""Fits to which an effect was added."""


def taken(*ids):
    """A round that added the last of these effects to the others."""
    return standing_in(
        Round, searched=BEFORE[ids[-1]], refits={ids[-1]: result(*ids)}, taken=ids[-1]
    )


@pytest.mark.parametrize(
    ("first", "fitted_again"), [("drive_frequency", False), ("clock_skew", True)]
)
def test_a_last_cause_is_held_against_the_causes_that_stand_beside_it(
    monkeypatch, first, fitted_again
):
    """Not against one that a rival has replaced since: that one was named in the end."""
    rounds = (taken(first), taken(first, "sensor1_nonlinearity"))
    found = result("drive_frequency", "sensor1_nonlinearity")
    again = result("drive_frequency", fit=standing_in(Fit))
    sharpened = []

    def sharp(setting, result):
        sharpened.append(result)
        return result

    def worse(setting, before, *_):
        assert sharpened[-1] is before  # both have the friction of the final model
        return True

    monkeypatch.setattr(acceptance, "_predicts_worse", worse)
    monkeypatch.setattr(acceptance, "without", lambda setting, result, gone: again)
    monkeypatch.setattr(acceptance, "polish", lambda setting, result: result)
    monkeypatch.setattr(acceptance, "refit_with_sharp_friction", sharp)
    ending = lambda choice, final: standing_in(Choice, rounds=rounds, final=final)  # noqa: E731
    monkeypatch.setattr(Choice, "ending", ending)
    begun = standing_in(Choice, rounds=rounds, final=found)
    choice, dropped = acceptance.without_harm(SETTING, begun, 1.0)
    assert dropped == ("sensor1_nonlinearity",)
    assert [v.effect.id for v in choice.final.variants] == ["drive_frequency"]
    assert choice.final.fit is (again.fit if fitted_again else BEFORE["sensor1_nonlinearity"])
