"""Effects that rigs share: pooled algebra against least squares on all data, and the verdicts."""

import dataclasses

import numpy as np
import pytest
from scipy import stats

from tests.shared_rigs import EFFECTS, NUISANCES, SAMPLES, Rig, fleet, scores_of
from tp_jax import _tails as tails
from tp_jax.gap.policy import POLICY
from tp_jax.gap.shared.pooling import agreement, cosine, pool
from tp_jax.gap.shared.scores import read, write
from tp_jax.gap.shared.selection import KIND, OWN, shared_effects
from tp_jax.gap.shared.table import shared_table
from tp_jax.model.inertia_units import per_inertia


def stacked(rigs, own=()):
    """All readings one below the other, and what each rig may explain by itself."""
    y = np.concatenate([rig.y for rig in rigs])
    X = np.concatenate([rig.X for rig in rigs])
    free = np.zeros((y.size, len(rigs) * (NUISANCES + len(own))))
    for i, rig in enumerate(rigs):
        columns = np.concatenate([rig.N, rig.X[:, list(own)]], axis=1)
        size = columns.shape[1]
        free[i * SAMPLES : (i + 1) * SAMPLES, i * size : (i + 1) * size] = columns
    return y, X, free


def least_squares(y, A):
    """Coefficients, sum of squares that is left, covariance."""
    x = np.linalg.lstsq(A, y, rcond=None)[0]
    return x, float(((y - A @ x) ** 2).sum()), np.linalg.inv(A.T @ A)


@pytest.mark.parametrize(("key", "columns"), [("b", [1]), ("two", [4, 5])])
def test_a_pooled_effect_is_that_of_least_squares_on_all_readings(key, columns):
    rigs = fleet(0, shared=(0.0, 0.2, 0.0, 0.0, 0.1, -0.1))
    y, X, free = stacked(rigs)
    _, before, _ = least_squares(y, free)
    x, after, covariance = least_squares(y, np.column_stack([X[:, columns], free]))
    found = pool(scores_of(rigs), (key, ()))
    q = len(columns)
    np.testing.assert_allclose(found.estimate, x[:q], rtol=1e-9)
    np.testing.assert_allclose(found.drop, before - after, rtol=1e-9)
    np.testing.assert_allclose(found.standard_errors, np.sqrt(np.diag(covariance)[:q]), rtol=1e-8)


def test_torques_of_a_rig_without_inertia_are_not_added_to_those_of_others():
    rigs = scores_of(fleet(0, shared=(0.0, 0.2, 0.0, 0.0, 0.1, -0.1)))
    converted = tuple(
        dataclasses.replace(v, amplitudes=tuple((n, per_inertia(u)) for n, u in v.amplitudes))
        for v in rigs[0].variants
    )
    odd = dataclasses.replace(rigs[0], variants=converted, score=1e3 * rigs[0].score)
    found, others = shared_effects([odd, *rigs[1:]]), shared_effects(rigs[1:])
    assert [e.pooled.key for e in found.effects] == [e.pooled.key for e in others.effects]
    for one, other in zip(found.effects, others.effects, strict=True):
        np.testing.assert_allclose(one.pooled.estimate, other.pooled.estimate)
    alike = [dataclasses.replace(rig, variants=converted) for rig in rigs]
    assert len(shared_effects(alike).effects) == len(shared_effects(rigs).effects) > 0


def test_others_of_the_kind_have_one_amplitude_and_a_rig_s_own_one_each():
    rigs = fleet(1, shared=(0.3, 0.2, 0.1, 0.0, 0.1, -0.1))
    y, X, free = stacked(rigs, own=[0])
    _, before, _ = least_squares(y, np.column_stack([X[:, [4, 5]], free]))
    x, after, _ = least_squares(y, np.column_stack([X[:, [1, 4, 5]], free]))
    found = pool(scores_of(rigs), ("b", ()), kinds=[("two", ())], owns=[("a", ())])
    np.testing.assert_allclose(found.estimate, x[:1], rtol=1e-9)
    np.testing.assert_allclose(found.others, x[1:3], rtol=1e-8)
    np.testing.assert_allclose(found.drop, before - after, rtol=1e-8)
    same = pool(scores_of(rigs, own=["a"]), ("b", ()), kinds=[("two", ())])
    np.testing.assert_allclose(same.drop, found.drop, rtol=1e-12)


def test_a_rig_s_own_cause_is_still_asked_for():
    rigs = fleet(2, shared=(0.3, 0, 0, 0, 0, 0))
    own = pool(scores_of(rigs, own=["a"]), ("a", ()))
    assert own.drop == pool(scores_of(rigs), ("a", ())).drop


def test_a_rig_s_own_cause_that_is_like_the_effect_takes_nothing_from_it():
    rigs = fleet(2, shared=(0, 0, 0.3, 0, 0, 0))  # `d` much resembles `c`, and `a` does not
    plain = pool(scores_of(rigs), ("c", ()))
    assert pool(scores_of(rigs, own=["d"]), ("c", ())).drop == plain.drop
    assert pool(scores_of(rigs, own=["a"]), ("c", ())).drop != plain.drop


def test_a_rig_that_an_effect_does_not_apply_to_is_left_out():
    rigs = fleet(3, n=6, shared=(0, 0.2, 0, 0, 0, 0))
    rigs[4].missing = ("b",)
    rest = [rig for i, rig in enumerate(rigs) if i != 4]
    scores = scores_of(rigs)
    found = pool(scores, ("b", ()))
    assert [part.rig for part in found.parts] == [0, 1, 2, 3, 5]
    np.testing.assert_allclose(found.drop, pool(scores_of(rest), ("b", ())).drop)
    rigs[0].missing = ("two",)  # one that is projected out
    y, X, free = stacked(rest)
    X[:SAMPLES, 4:] = 0.0
    x, _, _ = least_squares(y, np.column_stack([X[:, [1, 4, 5]], free]))
    found = pool(scores_of(rigs), ("b", ()), kinds=[("two", ())])
    np.testing.assert_allclose(found.estimate, x[:1], rtol=1e-8)


def test_a_misfit_rig_counts_for_less():
    rigs = fleet(4, n=3, shared=(0, 0.3, 0, 0, 0, 0))
    y, X, free = stacked(rigs)
    weight = np.repeat([1.0, 0.5, 1.0], SAMPLES)[:, None]
    x, _, _ = least_squares(y * weight[:, 0], np.column_stack([X[:, [1]], free]) * weight)
    scores = scores_of(rigs)
    variants = tuple(dataclasses.replace(v, dispersion=4.0) for v in scores[1].variants)
    scores[1] = dataclasses.replace(scores[1], variants=variants)
    np.testing.assert_allclose(pool(scores, ("b", ())).estimate, x[:1], rtol=1e-9)


def test_an_amplitude_stays_within_its_bounds():
    rigs = fleet(5, shared=(0, -0.3, 0, 0, 0, 0), limits=(0.0, np.inf))
    found = pool(scores_of(rigs), ("b", ()))
    assert found.estimate == 0.0
    assert found.drop == 0.0


def test_agreement_is_cochran_s():
    rigs = fleet(6, n=5, shared=(0, 0.2, 0, 0, 0, 0))
    rigs[2].y = rigs[2].y + 0.6 * rigs[2].X[:, 1]
    found = agreement(pool(scores_of(rigs), ("b", ())))
    single = [least_squares(rig.y, np.column_stack([rig.X[:, 1], rig.N])) for rig in rigs]
    b = np.array([x[0] for x, _, _ in single])
    w = np.array([1.0 / covariance[0, 0] for _, _, covariance in single])
    mean = (w @ b) / w.sum()
    q = w @ (b - mean) ** 2
    np.testing.assert_allclose(found.q, q, rtol=1e-8)
    assert found.dof == 4
    np.testing.assert_allclose(found.p, stats.chi2.sf(q, 4), rtol=1e-8)
    np.testing.assert_allclose(found.by_rig, b / mean, rtol=1e-8)
    np.testing.assert_allclose(found.p_by_rig, stats.chi2.sf(w * b**2, 1), rtol=1e-6)
    tau2 = (q - 4) / (w.sum() - (w**2).sum() / w.sum())
    np.testing.assert_allclose(found.spread, np.sqrt(tau2) / abs(mean), rtol=1e-8)


def test_directions_are_compared_on_all_rigs():
    rigs = fleet(7)
    _, X, free = stacked(rigs)
    left = X - free @ np.linalg.lstsq(free, X, rcond=None)[0]
    for a, b, columns in (("c", "d", ([2], [3])), ("a", "two", ([0], [4, 5]))):
        first, second = (np.linalg.qr(left[:, c])[0] for c in columns)
        expected = np.linalg.svd(first.T @ second, compute_uv=False)[0]
        np.testing.assert_allclose(cosine(scores_of(rigs), (a, ()), (b, ())), expected, rtol=1e-7)


def test_the_kind_s_effect_is_named_where_no_rig_shows_it_alone():
    amplitude = 2.4 / np.sqrt(SAMPLES)  # standard errors of one rig
    rigs = scores_of(fleet(8, n=12, shared=(0, amplitude, 0, 0, 0, 0)))
    found = shared_effects(rigs)
    (only,) = found.effects
    assert (only.pooled.key[0], only.verdict) == ("b", KIND)
    assert only.p < 0.001
    assert len(only.showing) < 6
    assert only.without.drop > 0.5 * only.pooled.drop
    low, high = only.pooled.estimate + np.outer((-3, 3), only.pooled.standard_errors)
    assert low < amplitude < high


def test_two_shared_effects_are_named_one_after_the_other():
    rigs = scores_of(fleet(9, n=10, shared=(0.4, 0, 0, 0, 0.3, 0.3)))
    found = shared_effects(rigs)
    assert {(e.pooled.key[0], e.verdict) for e in found.effects} == {("a", KIND), ("two", KIND)}


def test_effects_that_resemble_each_other_are_told():
    rigs = scores_of(fleet(10, n=6, shared=(0, 0, 0.4, 0, 0, 0)))
    (only,) = shared_effects(rigs).effects
    assert {only.pooled.key[0], *only.tied} == {"c", "d"}


def test_one_rig_s_effect_is_not_the_kind_s():
    rigs = fleet(11, n=8)
    rigs[3].y = rigs[3].y + 3.0 * rigs[3].X[:, 1]
    for own in ((), ("b",)):
        (only,) = shared_effects(
            [rig.scores(f"rig-{i}", own=own if i == 3 else ()) for i, rig in enumerate(rigs)]
        ).effects
        assert (only.pooled.key[0], only.verdict) == ("b", OWN)
        assert only.showing == (3,)
        assert only.largest == 3


def test_rigs_that_disagree_share_nothing():
    rng = np.random.default_rng(12)
    sizes = (1.5, 1.4, -0.9, 1.6, -1.0, 0.0, 1.3)
    rigs = [Rig(rng, (0, size, 0, 0, 0, 0)) for size in sizes]
    first = shared_effects(scores_of(rigs)).effects[0]
    assert (first.pooled.key[0], first.verdict) == ("b", OWN)
    assert first.differ
    assert 5 not in first.showing


def test_false_alarms_stay_below_the_level():
    alarms = sum(bool(shared_effects(scores_of(fleet(100 + i)), seed=i).effects) for i in range(60))
    assert alarms <= 4  # five or more of 60 at one in a hundred: once in a thousand


def test_grids_of_shapes_are_one_effect():
    rigs = scores_of(fleet(13, n=5, shared=(0, 0, 0.4, 0, 0, 0)))
    grid = [
        dataclasses.replace(
            rig,
            variants=tuple(
                dataclasses.replace(v, effect="c", shapes=(("n", float(v.first)),))
                if v.effect in "cd"
                else v
                for v in rig.variants
            ),
        )
        for rig in rigs
    ]
    found = shared_effects(grid)
    assert [e.pooled.key[0] for e in found.effects] == ["c"]
    assert len(found.candidates) == 4


def test_an_effect_of_two_rigs_is_not_asked():
    rigs = fleet(14, n=5, shared=(0, 0.5, 0, 0, 0, 0))
    for rig in rigs[2:]:
        rig.missing = ("b",)
    assert "b" not in {c.pooled.key[0] for c in shared_effects(scores_of(rigs)).candidates}


def test_the_table_is_plain_numbers():
    rigs = scores_of(fleet(15, n=6, shared=(0, 0.4, 0, 0, 0, 0)))
    table = shared_table(rigs, without=["rig-9"])
    assert table["reason"] is None
    assert table["left_out"] == ["rig-9"]
    (only,) = table["effects"]
    assert (only["effect"], only["verdict"], only["asked_of"]) == ("b", "kind", 6)
    size = only["amplitudes"]["p"]
    assert size["unit"] == "N m"
    assert size["ci95"][0] < 0.4 < size["ci95"][1]
    assert set(only["by_rig"]) == {rig.rig for rig in rigs}
    assert table["candidates"][0]["effect"] == "b"
    assert len(table["candidates"]) == len(EFFECTS)


@pytest.mark.parametrize("n", [0, 1, 2])
def test_few_rigs_are_told_so(n):
    table = shared_table(scores_of(fleet(16, n=n)))
    assert table["reason"].startswith("Effects that rigs share need at least 3 rigs")
    assert table["effects"] == table["candidates"] == []


def test_a_file_keeps_a_rig(tmp_path):
    scores = fleet(17)[0].scores("ä", own=["a"])
    for noise in (scores.noise, 2.0 * scores.noise):
        kept = dataclasses.replace(scores, noise=noise)
        write(tmp_path / "screen.npz", kept)
        again = read(tmp_path / "screen.npz")
        assert (again.rig, again.variants, again.own) == (kept.rig, kept.variants, kept.own)
        for name in ("score", "information", "noise", "limits"):
            np.testing.assert_array_equal(getattr(again, name), getattr(kept, name))
    assert [f.name for f in tmp_path.iterdir()] == ["screen.npz"]


def test_a_file_of_something_else_is_none(tmp_path):
    file = tmp_path / "screen.npz"
    assert read(file) is None
    write(file, fleet(18)[0].scores())
    whole = file.read_bytes()
    for part in (b"", b"PK", whole[: len(whole) // 2], b"\x00" * 100):
        file.write_bytes(part)
        assert read(file) is None
    np.savez(file, a=np.zeros(3))
    assert read(file) is None


@pytest.mark.parametrize("dof", [1, 2, 3, 10])
def test_the_logarithm_of_a_tail_goes_on_where_the_tail_underflows(dof):
    x = np.array([0.0, 0.1, 3.0, 50.0, 600.0])
    np.testing.assert_allclose(
        tails.log_chi_square(x, dof), stats.chi2.logsf(x, dof), rtol=1e-10, atol=1e-14
    )
    far = tails.log_chi_square(np.array([900.0, 950.0, 2000.0, 1e5]), dof)
    # the slope of the logarithm is nearly -1/2 there
    assert np.all(np.diff(far) < 0.0)
    np.testing.assert_allclose(far[-1], -5e4, rtol=2e-3)
    near = tails.log_chi_square(np.array([915.0, 925.0]), dof)
    assert -5.1 < near[1] - near[0] < -4.9


def test_policy_says_what_is_asked():
    assert POLICY.shared.rigs == 3
