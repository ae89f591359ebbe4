"""Rounds of the choice: a cause that longer windows do without makes room for another."""

import pytest

from tests.standing_in import standing_in
from tp_jax.effects import catalogue
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap import choice
from tp_jax.gap.choice import Choice, Round, choose
from tp_jax.gap.directions import Variant
from tp_jax.gap.refit import Refit
from tp_jax.gap.screen import Screen
from tp_jax.gap.structure import Structure

SETTING = standing_in(PreparedCampaign)
NOTHING = standing_in(Structure, p=0.5)


def fitted(*ids, chi2_dof=9.0):
    variants = tuple(Variant(catalogue()[id], (), ()) for id in ids)
    return Refit(standing_in(Fit, chi2_dof=chi2_dof), variants)


def taken(id):
    nothing = standing_in(Fit)
    return Round(nothing, nothing, standing_in(Screen), NOTHING, {}, {}, id)


@pytest.fixture
def ended(monkeypatch):
    """Ends a choice of causes, of which longer windows need some, in which nothing is found."""
    monkeypatch.setattr(choice, "removable", lambda fit: 0.0)
    monkeypatch.setattr(choice, "misfits", lambda setting, fit: False)
    monkeypatch.setattr(choice, "polish", lambda setting, result: result)
    looks = []

    def looked_at(setting, current, sharp, seed):
        looks.append(current.ids)
        return current.fit, standing_in(Screen), NOTHING

    def end(begun, needed, longer):
        """Windows can be made longer while there is one in `longer`."""

        def longer_windows(setting, result):
            return longer.pop() if longer else result

        def pruned(setting, result, policy):
            return result if set(result.ids) == set(needed) else fitted(*needed)

        monkeypatch.setattr(choice, "looked_at", looked_at)
        monkeypatch.setattr(choice, "refit_longer_windows", longer_windows)
        monkeypatch.setattr(choice, "pruned", pruned)
        rounds = tuple(map(taken, begun.ids))
        so_far = Choice(standing_in(Fit), rounds, begun)
        return choose(SETTING, standing_in(Fit), 0, lambda *_: None, so_far=so_far), looks

    return end


BOTH = ("column_tilt", "column_cable")


def test_what_takes_the_place_of_a_cause_is_looked_for(ended):
    done, looks = ended(fitted(*BOTH), ("column_tilt",), [fitted(*BOTH)])
    assert looks == [BOTH, ("column_tilt",)]
    assert done.causes == ("column_tilt",)
    assert [r.taken for r in done.rounds] == ["column_tilt", None, None, None]


def test_causes_that_longer_windows_need_stay(ended):
    longest = fitted(*BOTH)
    done, looks = ended(fitted(*BOTH), BOTH, [longest])
    assert looks == [BOTH]
    assert done.final is longest


def test_nothing_left_is_not_looked_at_over_longer_windows(ended):
    begun = fitted(*BOTH, chi2_dof=1.0)
    done, looks = ended(begun, ("column_tilt",), [fitted(*BOTH)])
    assert looks == [BOTH]
    assert done.final is begun
