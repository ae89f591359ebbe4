"""What is fitted again beside a candidate does not depend on the candidate."""

import pytest

from tests.standing_in import standing_in
from tp_jax import effects
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.layout import Unknown, Values
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.estimation.problem import Problem
from tp_jax.gap import refit
from tp_jax.gap.directions import Variant
from tp_jax.gap.refit import Refit


def variant(id: str) -> Variant:
    effect = effects.get(id)
    return Variant(effect, tuple((s.name, s.grid[0]) for s in effect.shapes), ())


@pytest.mark.parametrize(
    ("ids", "freed"),
    [
        (["bearing_drag"], set()),
        (["bearing_presliding"], {"bearing_presliding.z0"}),
        (["bearing_presliding", "bearing_drag"], {"bearing_presliding.z0"}),
        (
            ["bearing_presliding", "column_cable"],
            {"bearing_presliding.z0", "column_cable.z0"},
        ),
    ],
)
def test_the_shape_of_an_earlier_cause_is_fitted_beside_every_candidate(ids, freed, monkeypatch):
    asked = []

    def again(before, values, unknowns, *_):
        asked.extend(unknowns)
        return before

    monkeypatch.setattr(refit, "_again", again)
    monkeypatch.setattr(refit, "coarse_drop", lambda before: 0.2)
    values = standing_in(Values, get=lambda name, recording=None: 0.1)
    fit = standing_in(Fit, problem=standing_in(Problem), values=values, unknowns=(), priors=())
    trial = Refit(fit, tuple(variant(id) for id in ids))
    refit.refit_shape_constants(standing_in(PreparedCampaign, bounds={}), fit, trial)
    assert set(asked) == {Unknown(name) for name in freed}
