"""Laws that nobody wrote down: what ranks them."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from tests.standing_in import standing_in
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import learned
from tp_jax.gap.choice import Choice, Round
from tp_jax.gap.learned import log_evidence
from tp_jax.gap.refit import Refit

RNG = np.random.default_rng(3)
SETTING = standing_in(PreparedCampaign)


def test_log_evidence_is_a_ratio_of_densities():
    """Readings with Gaussian amplitudes, against readings of noise alone."""
    columns = RNG.normal(size=(40, 5))
    sd = 1.0 / np.arange(1, 6)
    y = columns @ (sd * RNG.normal(size=5)) + RNG.normal(size=40)
    with_them = stats.multivariate_normal(cov=np.eye(40) + (columns * sd**2) @ columns.T)
    expected = with_them.logpdf(y) - stats.norm.logpdf(y).sum()
    score, V = -columns.T @ y, columns.T @ columns
    found = log_evidence(score, V, np.diag(1.0 / sd**2))
    assert found == pytest.approx(expected, rel=1e-9)


def test_columns_that_say_nothing_have_no_evidence():
    found = log_evidence(np.zeros(3), np.zeros((3, 3)), np.eye(3))
    assert found == pytest.approx(0.0, abs=1e-12)


def test_twelve_numbers_are_charged_for_what_they_could_have_taken():
    """Of noise alone, a curve takes twelve variances and has less evidence than nothing."""
    V = np.diag(np.full(12, 1e4))
    found = [log_evidence(100.0 * RNG.normal(size=12), V, np.eye(12)) for _ in range(50)]
    assert max(found) < 0.0


def test_the_choice_goes_on_where_a_law_is_refused(monkeypatch):
    """With the refits of the first round, which are not done a second time."""
    calls, answers = [], []
    formulas, a_law = standing_in(Choice), standing_in(Choice)
    begun = standing_in(Choice, rounds=(standing_in(Round, searched=None),))

    def choose(setting, baseline, seed, progress, known, elsewhere):
        calls.append(elsewhere)
        answers.append(elsewhere(begun))
        return formulas if answers[-1] is None else answers[-1]

    monkeypatch.setattr(learned, "choose", choose)
    monkeypatch.setattr(learned, "with_supports", lambda setting, fit: setting)
    monkeypatch.setattr(learned, "_alone", lambda *args: ["a law"])
    setting = standing_in(PreparedCampaign, layout=SimpleNamespace(learned={"x"}))
    for accepted in (None, a_law):
        monkeypatch.setattr(learned, "_first_accepted", lambda *args, a=accepted: a)
        found = learned.choose_or_learn(setting, standing_in(Fit), 0, lambda *_: None)
        assert found is (accepted or formulas)
    assert answers == [None, a_law]
    assert len(calls) == 2


class Left(Fit):
    """A fit, as far as one asks what it leaves beyond the noise."""

    dof, chi2_dof = 1000, 1.0

    def __init__(self, beyond):
        r = np.zeros((1, 6))
        r[0, 0] = np.sqrt(self.dof + beyond)
        self.linearisation = SimpleNamespace(r=r)


@pytest.mark.parametrize(("left", "asked"), [(100.0, False), (900.0, False), (2000.0, True)])
def test_a_formula_that_takes_nearly_all_is_not_replaced(left, asked, monkeypatch):
    """Of a gap of 100,000 a hundredth may be the smoothing's, though it is far above the noise."""
    calls = []
    monkeypatch.setattr(learned, "polish", lambda setting, result: result)
    monkeypatch.setattr(learned, "_tried", lambda *args: calls.append(args) or [])
    best = standing_in(Refit, fit=Left(left), ids=("spring_hardening",))
    seen = SimpleNamespace(scored=(), pair=lambda: None)
    searched = Left(100_000.0)
    r = standing_in(Round, refits={"a": best}, searched=searched, before=searched, screen=seen)
    assert learned._alone(SETTING, r, lambda *_: None, None, []) == []
    assert bool(calls) == asked


@pytest.mark.parametrize(("pair", "least"), [(3000.0, 1486.0), (1000.0, 600.0)])
def test_two_formulas_that_promise_more_are_asked_before_a_law(pair, least, monkeypatch):
    """The best one promises 1,200; of what the pair does, a charge for the choice is taken off."""
    asked = []
    monkeypatch.setattr(learned, "polish", lambda setting, result: result)
    monkeypatch.setattr(learned, "_tried", lambda *args: asked.append(args[-2]) or [])
    one = SimpleNamespace(drop=1200.0, variant=SimpleNamespace(unknowns=("a",)))
    two = SimpleNamespace(drop=10.0, variant=SimpleNamespace(unknowns=("a", "b")))
    seen = SimpleNamespace(scored=(one, two), pair=lambda: (one, two, pair))
    searched = Left(100_000.0)
    best = standing_in(Refit, fit=Left(2000.0), ids=("spring_asymmetry",))
    r = standing_in(Round, refits={"a": best}, searched=searched, before=searched, screen=seen)
    assert learned._alone(SETTING, r, lambda *_: None, None, []) == []
    assert asked == [least]


def round_of(*drops, p=0.5):
    """A round that screened formulas with these falls of the sum of squares."""
    seen = SimpleNamespace(scored=[SimpleNamespace(drop=d) for d in drops])
    structure = SimpleNamespace(p=p)
    return standing_in(
        Round, before=Left(500.0), searched=standing_in(Fit), screen=seen, structure=structure
    )


@pytest.mark.parametrize(
    ("causes", "p", "asked"),
    [
        ((), 0.001, False),  # nothing was taken: there is no patch to replace
        (("sensor2_drift",), 0.5, False),  # one formula, and nothing is left
        (("sensor2_drift",), 0.001, True),
        (("sensor2_drift", "spring_relaxation"), 0.5, True),
    ],
)
def test_one_law_is_asked_for_in_the_place_of_several_formulas(causes, p, asked, monkeypatch):
    """Though what they leave is less than chance leaves of the noise of so many samples."""
    least = []
    monkeypatch.setattr(learned, "with_supports", lambda setting, fit: setting)
    monkeypatch.setattr(learned, "_tried", lambda *args: least.append(args[-1]) or [])
    setting = standing_in(PreparedCampaign, layout=SimpleNamespace(learned=True))
    rounds = (round_of(300.0, 40.0, p=0.001), round_of(20.0, p=p))
    final = standing_in(Refit, fit=Left(40.0), ids=causes)
    choice = standing_in(Choice, rounds=rounds, final=final, structure=rounds[-1].structure)
    monkeypatch.setattr(learned, "unexplained", lambda setting, choice: False)
    assert learned.learn(setting, choice, 0, lambda *_: None) is choice
    assert least == ([150.0] if asked else [])  # more evidence than the best formula's


class Ending(Left):
    """The same, of a fit that has come to its end or not."""

    problem = SimpleNamespace(programs=SimpleNamespace(add=lambda ids: None))

    def __init__(self, beyond, converged=True):
        super().__init__(beyond)
        self.converged = converged


def standing_law(monkeypatch, fit):
    """One law that is screened, and refitted to a fit; the calls of refits and of polishes."""
    refits, polishes = [], []
    law = SimpleNamespace(id="spring.d")
    monkeypatch.setattr(
        learned, "screen", lambda *_, **__: SimpleNamespace(scored=[SimpleNamespace(id="spring.d")])
    )
    monkeypatch.setattr(learned, "_evidence", lambda fit, scored: 100.0)
    monkeypatch.setattr(learned, "left_out_cost", lambda fit: np.zeros(6))
    monkeypatch.setattr(learned, "blocks_of", lambda fit, setting: np.arange(6))
    result = standing_in(Refit, fit=fit, ids=(law.id,))
    monkeypatch.setattr(learned, "_refitted", lambda *_: refits.append("refitted") or result)
    monkeypatch.setattr(learned, "polish", lambda setting, r, n: polishes.append(n) or r)
    return refits, polishes


def tried(base, trials, most):
    setting = standing_in(PreparedCampaign, layout=SimpleNamespace(effects=()))
    r = standing_in(Round, before=base.fit)
    return learned._tried(setting, r, base, lambda *_: None, None, trials, 1, 0.0, most)


def test_a_law_is_refitted_once_from_one_fit(monkeypatch):
    """Once to stand alone, and again after formulas; it took 40 of 110 seconds twice."""
    refits, _ = standing_law(monkeypatch, Ending(50_000.0))
    base, trials = standing_in(Refit, fit=Ending(100_000.0), ids=()), []
    first = tried(base, trials, np.inf)
    second = tried(base, trials, np.inf)
    assert refits == ["refitted"]
    assert first[0].result is second[0].result
    tried(standing_in(Refit, fit=Ending(90_000.0), ids=()), trials, np.inf)
    assert len(refits) == 2


@pytest.mark.parametrize(("left", "polished"), [(50_000.0, []), (10_000.0, [learned.FURTHER])])
def test_a_law_that_leaves_more_than_formulas_is_not_polished_to_its_end(
    left, polished, monkeypatch
):
    """Three minutes went for it on a rig of 60,000 samples."""
    _, polishes = standing_law(monkeypatch, Ending(left, converged=False))
    tried(standing_in(Refit, fit=Ending(100_000.0), ids=()), [], 20_000.0)
    assert polishes == polished
