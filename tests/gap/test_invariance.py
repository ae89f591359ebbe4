"""What says nothing of the rig changes nothing: units of mass, signs, clocks, names and order.

Not whole diagnoses but what they rest on: the baseline's misfit and what every effect would take.
"""

import dataclasses

import numpy as np
import pytest

import tp_jax as tp
from tp_jax.estimation.prepared_campaign import prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.gap.detectability import minimum_detectable
from tp_jax.gap.screen import screen
from tp_jax.rig import make_campaign

# A drive that turns too fast is ahead from when the clock of the file began, as its phase has it;
# and the two amplitudes of a vibration of unknown phase have bounds each of its own.
BY_THE_CLOCK = {"drive_frequency", "contact_vibration"}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Three runs of a rig with two hidden effects, with its inertias."""
    folder = tmp_path_factory.mktemp("invariance") / "rig"
    hidden = {"contact_stribeck": 0.25, "column_tilt": (1e-3, 5e-4)}
    make_campaign(folder, effects=hidden, runs=3, duration=3.0, rate=200.0, seed=1)
    return tp.load_campaign(folder)


def seen(campaign):
    """Baseline and screen."""
    setting = prepare_campaign(campaign)
    fit = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    return fit, screen(fit, setting, states=False)  # those with states take programs of their own


@pytest.fixture(scope="module")
def before(campaign):
    return seen(campaign)


def with_recordings(campaign, change):
    return dataclasses.replace(campaign, recordings=tuple(map(change, campaign.recordings)))


def without_inertia(campaign):
    return dataclasses.replace(campaign, B1=None)


def heavier(campaign):
    return dataclasses.replace(campaign, B1=1000.0 * campaign.B1)


def mirrored(campaign):
    return with_recordings(campaign, lambda r: dataclasses.replace(r, phi1=-r.phi1, phi2=-r.phi2))


def later(campaign):
    """By whole turns of the drive, which had its phase when the clock of the file began."""

    def shifted(r):
        turn = 2.0 * np.pi / r.omega if r.forced else 0.7
        return dataclasses.replace(r, t=r.t + 5.0 * turn)

    return with_recordings(campaign, shifted)


def renamed_and_reordered(campaign):
    other = with_recordings(
        campaign, lambda r: dataclasses.replace(r, name=f"z{r.name[::-1]}", label=r.name[::-1])
    )
    return dataclasses.replace(other, recordings=other.recordings[::-1])


@pytest.mark.parametrize(
    ("change", "scale"),
    [
        (without_inertia, None),
        (heavier, 1000.0),
        (mirrored, 1.0),
        (later, 1.0),
        (renamed_and_reordered, 1.0),
    ],
)
def test_misfit_and_what_effects_would_take(campaign, before, change, scale):
    scale = 1.0 / campaign.B1 if scale is None else scale
    (fit, known), (other, found) = before, seen(change(campaign))
    assert other.chi2_dof == pytest.approx(fit.chi2_dof, rel=1e-4)
    assert found.not_applicable.keys() == known.not_applicable.keys()
    mine = {(s.id, s.variant.shapes): s for s in known.scored}
    assert {(s.id, s.variant.shapes) for s in found.scored} == set(mine)
    apart = BY_THE_CLOCK if change is later else set()
    for s in (s for s in found.scored if s.id not in apart):
        was = mine[s.id, s.variant.shapes]
        # a hundredth of what one amplitude takes of noise is nothing
        assert s.drop == pytest.approx(was.drop, rel=3e-3, abs=0.01), s.id
        assert s.unbounded == pytest.approx(was.unbounded, rel=3e-3, abs=0.01), s.id
        # what differs between recordings is told from the last of them, which is now another
        if s.variant.effect.relative and change is renamed_and_reordered:
            continue
        torque = "N m" in s.variant.effect.amplitudes[0].unit
        size = minimum_detectable(s, 41, fit.chi2_dof)
        known_size = minimum_detectable(was, 41, fit.chi2_dof)
        assert (size is None) == (known_size is None), s.id
        if size is not None:
            unit = scale if torque else 1.0
            assert size == pytest.approx(unit * known_size, rel=3e-3), s.id

    def ranking(screen):
        return [s.id for s in screen.best() if s.drop > 1.0 and s.id not in apart]

    assert ranking(found) == ranking(known)
    pair, other_pair = known.pair(), found.pair()
    assert [s.id for s in pair[:2]] == [s.id for s in other_pair[:2]]
    assert other_pair[2] == pytest.approx(pair[2], rel=3e-3)


def test_amplitudes_go_with_the_inertia_as_their_unit_says(campaign, before):
    _, known = before
    _, found = seen(heavier(campaign))
    for s, was in zip(found.best(), known.best(), strict=True):
        assert s.id == was.id
        if was.drop < 1.0:
            continue
        units = {s.variant.effect.qualified(a.name): a.unit for a in s.variant.effect.amplitudes}
        scale = [1000.0 if "N m" in units[u.name] else 1.0 for u in s.variant.unknowns]
        expected = np.multiply(scale, was.estimate)
        np.testing.assert_allclose(
            s.estimate, expected, rtol=1e-2, atol=3e-3 * np.abs(expected).max()
        )
