"""A rig whose bearing has a law that no formula at hand gives: found, drawn, predicted."""

import dataclasses
import json

import numpy as np
import pytest

from tests.rigs import synthetic_campaign
from tp_jax.cli.output import json_text
from tp_jax.effects import AnyLaw, catalogue
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.gap import visited
from tp_jax.gap.assemble import assemble
from tp_jax.gap.choice import choose
from tp_jax.gap.learned import _on_windows_of, choose_or_learn, learn
from tp_jax.gap.policy import POLICY
from tp_jax.gap.predict import predict
from tp_jax.gap.probability import cause_probabilities
from tp_jax.gap.visited import inside_of_others, share_outside
from tp_jax.recordings import hold_out

LAW = "bearing_dry.phi1"
A, B, N = 0.5, 0.2, 3.0


def law(x):
    """Factor of the bearing's dry friction."""
    return 1.0 + A * np.cos(N * x) + B * np.sin(N * x)


def silent(stage, fraction):
    """Reports to nobody."""


@pytest.fixture(scope="module")
def found():
    """Setting, choice and result; the catalogue is an effect of a sensor."""
    hidden = {"a": A, "b": B, "n": N}
    campaign = hold_out(synthetic_campaign(effect="bearing_position", hidden=hidden))
    effects = [catalogue()["sensor1_nonlinearity"], AnyLaw()]
    setting = prepare_campaign(campaign, effects=effects)
    baseline = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    choice = choose_or_learn(setting, baseline, 0, silent)
    return setting, choice, json.loads(json_text(assemble(setting, choice, 0).to_dict()))


def test_the_law_is_named_and_the_gap_is_gone(found):
    _, choice, result = found
    assert choice.baseline.chi2_dof > 2.0
    assert choice.final.fit.chi2_dof < 1.1
    assert result["verdict"] == "explained"
    assert [(c["effect"], c["kind"]) for c in result["causes"]] == [(LAW, "learned")]
    assert result["gap"]["shrink"] > 0.95


def test_no_second_formula_is_sought_before_it(found):
    _, choice, _ = found
    first, end = choice.rounds
    assert set(first.refits) == {"sensor1_nonlinearity", LAW}
    assert first.taken == LAW
    assert end.taken is None


def test_what_the_law_took_counts_once(found):
    """Nothing is left, so that the round after it has no hypotheses to be likely."""
    setting, choice, _ = found
    alone = dataclasses.replace(choice, rounds=choice.rounds[:1])
    assert cause_probabilities(choice, setting) == cause_probabilities(alone, setting)


def test_it_is_named_too_once_formulas_have_done_what_they_can(found):
    setting, choice, _ = found
    formulas = choose(setting, choice.rounds[0].searched, 0, silent)
    assert LAW not in formulas.causes
    late = learn(setting, formulas, 0, silent)
    assert late.causes == (LAW,)
    assert late.final.fit.chi2_dof == pytest.approx(choice.final.fit.chi2_dof, rel=1e-3)


def test_the_curve_is_that_of_the_rig(found):
    """As a part of its mean over what was visited, which is the friction's own number."""
    (cause,) = found[2]["causes"]
    curve = cause["curve"]
    x, y, band = np.array(curve["x"]), np.array(curve["y"]), np.array(curve["ci95"])
    edges, share = np.array(curve["visited"]["edges"]), np.array(curve["visited"]["share"])
    assert share.sum() == pytest.approx(1.0)
    middle = 0.5 * (edges[1:] + edges[:-1])
    true = law(x) / (share @ law(middle)) - 1.0
    often = np.interp(x, middle, share) > 0.5 / share.size
    off = np.abs(true - y)[often]
    assert np.median(off) < 0.05
    assert (off < np.maximum(np.ptp(band, axis=1)[often], 0.05)).mean() > 0.9


def test_what_was_only_looked_at_is_neither_candidate_nor_twin(found):
    _, choice, result = found
    refitted = set(choice.rounds[0].refits)
    named = {row["effect"] for row in result["candidates"]}
    assert {name for name in named if "." in name} == refitted - set(catalogue())
    assert all(set(pair) <= refitted for pair in result["confused_with"] if "." in "".join(pair))
    assert not any("." in name for name in result["minimum_detectable"])


def test_a_prediction_needs_the_result_alone(found):
    run = predict(found[2], omega=10.0, duration=1.0, rate=100.0)
    assert np.isfinite(run.phi1).all()


def test_formulas_and_laws_are_compared_on_the_same_windows(found):
    setting, choice, _ = found
    longer = choice.rounds[0].searched
    assert _on_windows_of(setting, choice.final, choice.final.fit) is choice.final
    short = setting.problem(setting.horizons[0])
    (variant,) = choice.final.variants
    moved = _on_windows_of(setting, choice.final, dataclasses.replace(longer, problem=short))
    assert moved.fit.problem.windows.n == short.windows.n
    assert moved.fit.chi2_dof == pytest.approx(1.0, abs=0.2)
    assert share_outside(setting, moved.fit, variant) == 0.0


def test_a_run_that_goes_further_than_all_others_is_not_held_out(found, monkeypatch):
    """The decay begins at 1.2 rad, which no forced run reaches, and is soon back among them."""
    setting, choice, _ = found
    learning = dataclasses.replace(POLICY.learning, elsewhere=0.0)
    monkeypatch.setattr(visited, "POLICY", dataclasses.replace(POLICY, learning=learning))

    def held(*which):
        recordings = tuple(
            dataclasses.replace(r, held_out=i in which) for i, r in enumerate(setting.recordings)
        )
        return dataclasses.replace(setting, recordings=recordings)

    swings = [np.ptp(r.phi1) for r in setting.recordings]
    assert np.argmax(swings) == 0
    assert inside_of_others(held(2), choice.final) is None
    assert inside_of_others(held(0), choice.final) in (1, 2)
    assert inside_of_others(held(0, 1), choice.final) is None  # nothing is left to fit
    assert inside_of_others(held(0), dataclasses.replace(choice.final, variants=())) is None
