"""The choice of the next run, a function of plain numbers."""

import dataclasses

import pytest

from tp_jax.gap.next_run import (
    NOTHING,
    Finding,
    Forecast,
    Limits,
    Next,
    Run,
    Stop,
    allowed,
    finding_of,
    first_run,
    next_run,
    runs_to_compare,
    worth,
)
from tp_jax.gap.policy import POLICY
from tp_jax.results.diagnosis import DiagnosisRecord

POLICY = POLICY.explore
ANY = Limits()
MADE = [Run(release=0.6), Run(omega=8.0), Run(omega=16.0)]
UNDECIDED = Finding(
    "unknown",
    (("a", 0.6),),
    "a",
    0.6,
    {"b": 0.3, "c": 0.1},
    (
        Forecast(Run(omega=6.0), 0.3, {"b": 1.0, "c": 30.0}),
        Forecast(Run(omega=12.0), 0.8, {"b": 5.0, "c": 0.0}),
        Forecast(Run(omega=18.0), 1.4, {"b": 9.0, "c": 9.0}),
        Forecast(Run(release=0.4), None, {"b": 90.0, "c": 90.0}),
    ),
)


def chosen(finding=UNDECIDED, limits=ANY, made=MADE, most=8, duration=10.0):
    return next_run(finding, limits, made, most, duration)


def test_the_run_that_tells_most_is_next():
    step = chosen()
    assert isinstance(step, Next)
    assert step.forecast.run == Run(omega=18.0)


@pytest.mark.parametrize(
    ("limits", "omega"),
    [(Limits(1.0), 12.0), (Limits(0.4), 6.0), (Limits(omega=(5.0, 15.0)), 12.0)],
)
def test_limits_hold(limits, omega):
    step = chosen(limits=limits)
    assert step.forecast.run == Run(omega=omega)
    for forecast in UNDECIDED.forecasts:
        if allowed(forecast, limits) and limits.angle is not None:
            assert forecast.largest <= limits.angle


def test_a_run_that_cannot_be_predicted_is_never_next():
    assert not allowed(UNDECIDED.forecasts[3], ANY)


def test_a_kind_of_run_that_the_rig_cannot_make_is_never_next():
    drive, decay = Forecast(Run(omega=6.0), 0.1), Forecast(Run(release=0.2), 0.1)
    assert [allowed(f, Limits(drives=False)) for f in (drive, decay)] == [False, True]
    assert [allowed(f, Limits(releases=False)) for f in (drive, decay)] == [True, False]


def test_more_than_enough_does_not_count():
    one = Forecast(Run(omega=1.0), 0.1, {"b": 100.0, "c": 0.0})
    both = Forecast(Run(omega=2.0), 0.1, {"b": 6.0, "c": 6.0})
    rivals = {"b": 0.5, "c": 0.5}
    assert worth(both, rivals) > worth(one, rivals)
    assert worth(one, {}) == 0.0


@pytest.mark.parametrize(
    ("change", "most", "reason", "words"),
    [
        ({"causes": (("a", 0.96),)}, 8, "cause", "a, with probability 0.96; something"),
        (
            {"verdict": "no_gap", "causes": (), "first": None, "rivals": {}},
            3,  # all that may be made
            "nothing_left",
            "does not explain",
        ),
        ({}, 3, "runs", "--runs"),
    ],
)
def test_reasons_to_stop(change, most, reason, words):
    step = chosen(dataclasses.replace(UNDECIDED, **change), most=most)
    assert isinstance(step, Stop)
    assert step.reason == reason
    assert words in step.sentence


def test_a_cause_that_leaves_nothing_is_told_alone():
    sure = dataclasses.replace(UNDECIDED, verdict="explained", causes=(("a", 0.9999),))
    assert chosen(sure).sentence == "The cause is a, with probability above 0.999."


def test_the_limit_that_would_help_is_advised():
    # the only run within the limit tells too little
    dull = dataclasses.replace(
        UNDECIDED,
        forecasts=(
            Forecast(Run(omega=6.0), 0.3, {"b": 0.1}),
            Forecast(Run(omega=12.0), 0.9, {"b": 5.0}),
        ),
    )
    step = chosen(dull, Limits(0.5))
    assert step.reason == "indistinguishable"
    assert "cannot" not in step.sentence
    assert "No run within the limits can tell a from b and c" in step.sentence
    assert "--limit 1 " in step.sentence
    assert "drive at 12 rad/s" in step.sentence


def test_a_limit_is_advised_that_is_enough():
    forecasts = (Forecast(Run(omega=6.0), 0.3, {}), Forecast(Run(omega=12.0), 0.94, {"b": 5.0}))
    finding = dataclasses.replace(UNDECIDED, forecasts=forecasts)
    step = chosen(finding, Limits(1.0))
    assert isinstance(step, Stop)
    assert "with --limit 1.1 " in step.sentence
    assert isinstance(chosen(finding, Limits(1.1)), Next)


def test_a_run_that_tells_one_rival_comes_before_one_that_hints_at_another():
    forecasts = (
        Forecast(Run(omega=6.0), 0.3, {"b": 2.5}),
        Forecast(Run(omega=12.0), 0.9, {"c": 10.0}),
    )
    finding = dataclasses.replace(UNDECIDED, rivals={"b": 0.3, "c": 0.05}, forecasts=forecasts)
    step = chosen(finding, Limits(1.5))
    assert isinstance(step, Next)
    assert step.forecast.run == Run(omega=12.0)


def test_a_longer_run_is_advised():
    dull = dataclasses.replace(UNDECIDED, forecasts=(Forecast(Run(omega=6.0), 0.3, {"b": 1.0}),))
    assert "--duration 30" in chosen(dull).sentence
    dull = dataclasses.replace(UNDECIDED, forecasts=(Forecast(Run(omega=6.0), 0.3, {"b": 0.01}),))
    assert "measurement of another kind" in chosen(dull).sentence


def test_runs_that_tell_only_together_are_made_while_there_are_enough_to_make():
    hints = [Forecast(Run(omega=w), 0.3, {"b": 1.2, "c": 1.1}) for w in (6.0, 9.0, 12.0)]
    finding = dataclasses.replace(UNDECIDED, forecasts=tuple(hints))
    assert isinstance(chosen(finding, most=6), Next)
    assert chosen(finding, most=5).reason == "indistinguishable"
    # a little against each rival is nothing against any
    split = [Forecast(Run(omega=6.0), 0.3, {"b": 2.0}), Forecast(Run(omega=9.0), 0.3, {"c": 2.0})]
    finding = dataclasses.replace(UNDECIDED, forecasts=tuple(split))
    assert chosen(finding, most=8).reason == "indistinguishable"


def test_a_limit_that_no_run_keeps_is_told():
    step = chosen(limits=Limits(0.1))
    assert step.reason == "indistinguishable"
    assert "drive at 6 rad/s, is predicted to reach 0.3 rad" in step.sentence


def test_first_runs_survey():
    """A decay, then drives far from each other; "no gap" is not believed before."""
    forecasts = (
        *(Forecast(Run(omega=w), 0.5) for w in (6.0, 9.0, 12.0, 15.0, 18.0)),
        Forecast(Run(release=0.5), 0.5),
    )
    nothing = Finding("no_gap", forecasts=forecasts)
    made = [Run(release=0.6)]
    for omega in (12.0, 6.0, 18.0, 9.0):
        step = chosen(nothing, made=made)
        assert step.forecast.run == Run(omega=omega)
        made.append(step.forecast.run)
    assert chosen(nothing, made=made).reason == "nothing_left"
    assert chosen(nothing, made=[Run(omega=9.0)]).forecast.run == Run(release=0.5)


def test_the_first_run_keeps_the_limit():
    assert first_run(ANY) == Run(release=POLICY.first_release)
    assert first_run(Limits(0.3)).release < 0.15  # a rider that slips goes twice as far
    assert first_run(Limits(0.3, (5.0, 20.0), releases=False)) == Run(omega=5.0)
    with pytest.raises(ValueError, match="range"):
        first_run(Limits(releases=False))


def test_runs_to_compare():
    runs = runs_to_compare(16.0, ANY)
    omegas = [run.omega for run in runs if run.omega is not None]
    assert len(omegas) == POLICY.frequencies
    assert min(omegas) == pytest.approx(POLICY.slowest * 16.0)
    assert max(omegas) == pytest.approx(POLICY.fastest * 16.0)
    assert len(runs) == POLICY.frequencies + POLICY.releases
    own = runs_to_compare(16.0, Limits(0.15, (5.0, 7.0)))
    assert all(5.0 <= run.omega <= 7.0 for run in own if run.omega is not None)
    assert min(run.release for run in own if run.release is not None) < 0.15
    assert runs_to_compare(16.0, Limits(omega=(5.0, 5.0)))[0].omega == 5.0
    assert all(run.omega is None for run in runs_to_compare(16.0, Limits(drives=False)))


def diagnosis(causes, candidates, confused=(), verdict="unknown"):
    return DiagnosisRecord.read(
        {
            "verdict": verdict,
            "confused_with": [list(group) for group in confused],
            "causes": [{"effect": id, "probability": p} for id, p in causes],
            "candidates": [
                {"effect": id, "probability": p, "applicable": p is not None}
                for id, p in candidates
            ],
        }
    )


def test_rivals_of_an_accepted_cause():
    found = finding_of(
        diagnosis(
            [("a", 0.7)],
            [("a", 0.7), ("b", 0.2), ("c", 0.001), ("d", 0.002), ("e", None)],
            [("a", "d")],
        )
    )
    assert (found.first, found.probability) == ("a", 0.7)
    assert found.rivals == {"b": 0.2, "d": 0.002}


def test_a_candidate_has_the_model_as_it_is_for_a_rival():
    found = finding_of(diagnosis([], [("a", 0.4), ("b", 0.05)]))
    assert (found.causes, found.first) == ((), "a")
    assert list(found.rivals) == [NOTHING, "b"]
    assert found.rivals[NOTHING] == pytest.approx(0.55)


def test_without_a_gap_or_a_likely_candidate_there_is_no_rival():
    assert finding_of(diagnosis([], [("a", 0.4)], verdict="no_gap")).first is None
    assert finding_of(diagnosis([], [("a", 0.001)])).rivals == {}
