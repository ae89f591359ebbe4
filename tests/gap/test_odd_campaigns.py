"""Campaigns that are legal and unusual: rates, lengths and drives that differ."""

import dataclasses
import importlib
from types import SimpleNamespace

import numpy as np
import pytest

import tp_jax as tp
from tests.rigs import synthetic_campaign, synthetic_values
from tests.standing_in import standing_in
from tp_jax.effects import catalogue
from tp_jax.errors import InputError
from tp_jax.estimation.assemble import fit_record
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.placement import place
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.estimation.windows import Windows
from tp_jax.gap.applicability import check_known, check_predictable, why_not
from tp_jax.gap.choice import choose
from tp_jax.gap.free_run import start_state
from tp_jax.gap.held_out import (
    FLOOR_ERROR,
    HeldOut,
    evaluate,
    expected_elsewhere,
    floor_error,
    shrink,
    squares,
)
from tp_jax.gap.relative import centred
from tp_jax.recordings import hold_out


def campaign_of(*changes: dict) -> tp.Campaign:
    """The synthetic campaign (a decay, 13.09 and 17 rad/s) with its recordings changed."""
    campaign = synthetic_campaign()
    runs = [
        dataclasses.replace(r, **change)
        for r, change in zip(campaign.recordings, changes, strict=True)
    ]
    return dataclasses.replace(campaign, recordings=tuple(runs))


def carried_over(values, setting):
    """Numbers with what is expected of the held-out recordings."""
    return expected_elsewhere(values, setting, setting.fitted, setting.held_out)


def resampled(recording, rate: float) -> dict:
    t = np.arange(round(recording.duration * rate) + 1) / rate
    return {
        "t": t,
        "phi1": np.interp(t, recording.t, recording.phi1),
        "phi2": np.interp(t, recording.t, recording.phi2),
    }


def test_a_held_out_run_of_ten_times_the_rate():
    """Its first window has more samples than any that was planned for."""
    fast = resampled(synthetic_campaign().recordings[1], 2500.0)
    setting = prepare_campaign(campaign_of({}, fast | {"held_out": True}, {}), effects=())
    found = start_state(setting, synthetic_values(setting), 1, 0.75)
    np.testing.assert_allclose(found[:2], 0.0, atol=5e-3)


def test_a_window_that_is_in_no_lane_is_said_to_be():
    with pytest.raises(ValueError, match="1500 samples"):
        place(Windows(np.array([0]), np.array([0]), np.array([1500]), 1.0), np.ones(1), 1024, 8)


def test_each_recording_is_smoothed_by_its_own_rate():
    """A window of as many samples would span a whole period of the slow one."""
    slow = resampled(synthetic_campaign().recordings[1], 50.0)
    setting = prepare_campaign(campaign_of({}, slow, {}), effects=())
    alone = prepare_campaign(campaign_of({}, {}, {}), effects=())
    assert setting.widths[1] < setting.widths[0] == setting.widths[2] == alone.widths[1]
    error = setting.prepared[1].smooth[:, 0] - slow["phi1"]
    assert np.abs(error).max() < 5e-3


def test_one_short_run_does_not_shorten_the_windows_of_all():
    campaign = synthetic_campaign()
    runs = (campaign.recordings[0].cut(0.0, 0.3), *campaign.recordings[1:])
    short = dataclasses.replace(campaign, recordings=runs)
    assert prepare_campaign(short, effects=()).horizons[-1] > 0.5


def test_the_parts_of_a_cut_recording_share_the_clock_of_drifts():
    campaign = synthetic_campaign()
    one = dataclasses.replace(campaign, recordings=campaign.recordings[1:2])
    setting = prepare_campaign(hold_out(one), effects=())
    values = initial_values(setting)
    for name, wanted in (("drift_middle", 1.5), ("drift_rate", 1.0 / 3.0)):
        row = values.table[values.layout.index[name]]
        np.testing.assert_allclose(row, wanted)
    record = fit_record(values, (), [r.label for r in setting.recordings])
    assert list(record["drift"].values()) == [pytest.approx([1.5, 1.0 / 3.0])] * 2


@pytest.mark.parametrize("drive", ["commanded", "measured"])
def test_a_drive_of_which_nothing_is_known(drive):
    meter = {} if drive == "commanded" else {"drive": np.zeros(751), "omega": None}
    held = meter | {"held_out": True}
    check_predictable(prepare_campaign(campaign_of({}, meter, held), effects=()))
    setting = prepare_campaign(campaign_of({}, held, held), effects=())
    with pytest.raises(InputError, match=f"run-13.csv.*no recording.*a {drive} drive"):
        check_predictable(setting)


def test_a_clock_is_not_asked_about_where_a_drive_is_read_by_it():
    """Its readings have the recorder's own times, whatever that clock does."""
    skew = catalogue()["clock_skew"]
    assert why_not(skew, prepare_campaign(synthetic_campaign(), effects=[skew])) is None
    r = synthetic_campaign().recordings[2]
    read = {"omega": None, "drive": np.sin(17.0 * r.t)}
    mixed = prepare_campaign(campaign_of({}, {}, read), effects=[skew])
    assert "no drive is measured" in why_not(skew, mixed)


def test_an_effect_that_was_ruled_out_is_not_asked_about():
    base, tilt = catalogue()["base_compliance"], catalogue()["column_tilt"]
    setting = prepare_campaign(synthetic_campaign(), effects=[base, tilt], without=["column_tilt"])
    assert why_not(base, setting) is None
    assert why_not(tilt, setting) == "Left out, as was asked for."
    check_known(["column_tilt", "bearing_dry.phi1"])
    with pytest.raises(InputError, match=r"no effect .colum_tilt. .*did you mean column_tilt"):
        check_known(["colum_tilt"])
    with pytest.raises(InputError, match="`tp-jax effects` lists them"):
        tp.diagnose(synthetic_campaign(), without=["zzz"])


@pytest.mark.parametrize(("recordings", "begun"), [(2, 1), (3, 2)])
def test_another_recording_is_held_out_where_there_is_one(recordings, begun, monkeypatch):
    """Of two a part is held out: a diagnosis begun anew would be the same once more."""
    module, calls = importlib.import_module("tp_jax.gap.diagnosis"), []

    def chosen(*args, **options):
        calls.append(args)
        return None, SimpleNamespace(final=None)

    def enough(*args):
        raise InputError("Enough.")

    monkeypatch.setattr(module, "_chosen", chosen)
    monkeypatch.setattr(module, "inside_of_others", lambda *args: 0)
    monkeypatch.setattr(module, "assemble", enough)
    campaign = synthetic_campaign()
    few = dataclasses.replace(campaign, recordings=campaign.recordings[:recordings])
    with pytest.raises(InputError, match="Enough"):
        module.examine(few)
    assert len(calls) == begun


def test_a_gap_of_which_every_formula_was_ruled_out():
    campaign = hold_out(synthetic_campaign(effect="spring_asymmetry", hidden={"a": 0.3}))
    effects = [catalogue()["spring_asymmetry"]]
    setting = prepare_campaign(campaign, effects=effects, without=["spring_asymmetry"])
    baseline = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    assert baseline.chi2_dof > 2.0
    choice = choose(setting, baseline, 0, lambda stage, part: None)
    assert choice.causes == ()
    assert len(choice.rounds) == 1


def test_a_base_faster_than_a_decays_samples():
    slow = [resampled(r, 6.0) for r in synthetic_campaign().recordings]
    decays = [{"forced": False, "omega": None}] * 3
    base = catalogue()["base_compliance"]
    assert why_not(base, prepare_campaign(campaign_of(*decays), effects=[base])) is None
    coarse = [a | b for a, b in zip(slow, decays, strict=True)]
    assert "faster" in why_not(base, prepare_campaign(campaign_of(*coarse), effects=[base]))


def held_out(squares, complete: bool = True) -> HeldOut:
    squares = np.asarray(squares, dtype=float)
    return HeldOut(squares, np.full(squares.shape, 100.0), standing_in(Fit), complete)


def shrunk(before, after):
    setting = standing_in(
        PreparedCampaign,
        fitted=[0],
        recordings=[SimpleNamespace(n=250_000)],
        held_out_noise={"phi1": 1e-3, "phi2": 1e-3},
    )
    return shrink(setting, before, after, 0)


def test_what_cannot_be_integrated_is_no_small_error():
    large, small = np.full((8, 2), 1e-2), np.full((8, 2), 1e-4)
    assert shrunk(held_out(large), held_out(small)).ci95 is not None
    for before, after in ((True, False), (False, True)):
        found = shrunk(held_out(large, before), held_out(small, after))
        assert (found.value, found.ci95, found.significant) == (None, None, True)


def test_windows_that_cannot_be_integrated_are_not_counted():
    r = np.full((3, 8 + 4), 2.0)
    r[1] = 0.0  # as a linearisation has it
    complete = np.array([True, False, True])
    valid = np.ones((3, 12), dtype=bool)
    lin = SimpleNamespace(samples=r[:, :-4], valid=valid, complete=complete)
    problem = SimpleNamespace(sigma=np.full((3, 2), 1e-3), coloured=False)
    found = squares(standing_in(Fit, linearisation=lin, problem=problem))
    assert not found.complete
    # four samples a channel less two estimated states
    assert found.mean_square() == pytest.approx(2.0 * (2e-3) ** 2)
    lin.complete = np.zeros(3, dtype=bool)
    none = squares(standing_in(Fit, linearisation=lin, problem=problem))
    assert np.isnan(none.mean_square())


def test_few_windows_promise_little():
    rng = np.random.default_rng(0)
    before, after = 1e-2 * rng.uniform(0.5, 1.5, (8, 2)), 1e-3 * rng.uniform(0.5, 1.5, (8, 2))
    widths = []
    for n in (8, 3):
        low, high = shrunk(held_out(before[:n]), held_out(after[:n])).ci95
        widths.append(high - low)
    assert widths[1] > 2.0 * widths[0]
    alone = shrunk(held_out(before[:1]), held_out(after[:1]))
    assert alone.value is not None
    assert alone.ci95 is None


def test_the_noise_of_few_samples_is_known_less_well():
    def of(n):
        recordings = [SimpleNamespace(n=n)]
        return floor_error(standing_in(PreparedCampaign, fitted=[0], recordings=recordings))

    assert of(15_000) == FLOOR_ERROR
    assert of(500) == pytest.approx(0.13, abs=0.01)


def test_a_motor_at_rest_says_nothing_of_its_speed():
    campaign = campaign_of({}, {}, {"held_out": True})
    setting = prepare_campaign(campaign, effects=[catalogue()["drive_frequency"]])
    values = initial_values(setting).replace({"drive_frequency.a": [0.0, 0.1, 0.0]})
    assert carried_over(values, setting).get("drive_frequency.a", 2) == 0.1


def test_a_drive_that_is_off_by_chance_says_little_of_the_next_run():
    campaign = synthetic_campaign()
    runs = [dataclasses.replace(campaign.recordings[1], label=f"{i}") for i in range(5)]
    runs[4] = dataclasses.replace(runs[4], held_out=True)
    campaign = dataclasses.replace(campaign, recordings=tuple(runs))
    setting = prepare_campaign(campaign, effects=[catalogue()["drive_frequency"]])

    def expected(*a):
        values = initial_values(setting).replace({"drive_frequency.a": [*a, 0.0]})
        return carried_over(values, setting).get("drive_frequency.a", 4)

    assert expected(0.1, 0.1, 0.1, 0.1) == pytest.approx(0.1)
    assert expected(0.11, 0.09, 0.1, 0.1) == pytest.approx(0.1, rel=0.01)
    assert expected(0.1, -0.1, 0.08, -0.06) == 0.0


def test_a_vibration_of_another_phase_in_each_run_says_nothing_of_the_next():
    effect = catalogue()["contact_vibration"]
    setting = prepare_campaign(campaign_of({}, {}, {"held_out": True}), effects=[effect])
    values = initial_values(setting).replace({"contact_vibration.a": [0.1, -0.08, 0.0]})
    values = values.replace({"contact_vibration.b": [0.1, 0.101, 0.0]})
    there = carried_over(values, setting)
    assert there.get("contact_vibration.a", 2) == 0.0
    assert there.get("contact_vibration.b", 2) == pytest.approx(0.1, rel=0.01)


def test_a_friction_of_another_size_in_each_run_is_their_mean_in_the_next():
    """The last fitted run's amplitude is held at zero: what runs have in common is the size's."""
    effect = catalogue()["contact_repeatability"]
    setting = prepare_campaign(campaign_of({}, {}, {"held_out": True}), effects=[effect])
    values = initial_values(setting).replace({"contact_repeatability.a": [0.1, 0.0, 0.0]})
    there = carried_over(values, setting)
    assert there.get("contact_repeatability.a", 2) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("id", "others"),
    [
        # the mean of 1.2 and 1 is expected, and it is 1
        ("contact_repeatability", [0.2, 0.0, 0.0]),
        # the one other motor ran fast, this one runs as it was told
        ("drive_frequency", [0.0, 0.05, 0.0]),
        ("contact_vibration", [0.4, 0.4, 0.0]),
    ],
)
def test_a_run_whose_size_is_off_by_the_usual_scatter_is_no_misfit(id, others):
    effect = catalogue()[id]
    setting = prepare_campaign(campaign_of({}, {}, {"held_out": True}), effects=[effect])
    name = f"{id}.a"
    values = synthetic_values(setting).replace({name: others})
    found = evaluate(setting, values, 0.75, [effect])
    assert found.fit.values.get(name, 2) == pytest.approx(0.0, abs=0.01)
    assert np.sqrt(found.mean_square()) == pytest.approx(1e-3, rel=0.1)
    fixed = evaluate(setting, values, 0.75)
    assert np.sqrt(fixed.mean_square()) > 1.5e-3


def test_beside_another_effect_of_the_place_they_are_told_about_the_last_one():
    """What a Stribeck drop takes is a part of the friction, and would change with it."""
    every = [catalogue()[id] for id in ("contact_repeatability", "contact_stribeck")]
    setting = prepare_campaign(campaign_of({}, {}, {}), effects=every)
    values = synthetic_values(setting).replace({"contact_repeatability.a": [0.3, -0.1, 0.0]})
    assert centred(values, every, setting.fitted) is values
    assert centred(values, every[:1], setting.fitted) is not values


def test_relative_amplitudes_are_told_about_their_mean():
    effect = catalogue()["contact_repeatability"]
    setting = prepare_campaign(campaign_of({}, {}, {}), effects=[effect])
    values = synthetic_values(setting).replace({"contact_repeatability.a": [0.3, -0.1, 0.0]})
    told = centred(values, [effect], setting.fitted)
    a, same = (v.table[v.layout.index["contact_repeatability.a"]] for v in (told, values))
    assert a.sum() == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(
        told.get("Ts1") * (1.0 + a), values.get("Ts1") * (1.0 + same), rtol=1e-12
    )
