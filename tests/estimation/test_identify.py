"""`identify` finds what made the recordings, from anywhere, and says how sure that is."""

import dataclasses
import json

import numpy as np
import optimistix as optx
import pytest

import tp_jax as tp
from tests.reference import BENCH
from tests.rigs import synthetic_campaign
from tp_jax.cli.output import json_text
from tp_jax.estimation import multistart
from tp_jax.estimation.methods import METHODS, described
from tp_jax.model.parameters import SHARPEST_EPS
from tp_jax.results.encoding import schema_of
from tp_jax.results.identification import IdentificationRecord
from tp_jax.schemas.checking import check

FIX = {"T0": 4.0}  # three seconds do not tell it


@pytest.fixture(scope="module")
def campaign():
    return synthetic_campaign()


@pytest.fixture(scope="module")
def found(campaign):
    return tp.identify(campaign, starts=5, fix=FIX)


def test_the_rig_is_found(found):
    for name in ("k", "A", "B2", "c1", "M1"):
        p = found.to_dict()["parameters"][name]
        assert p["value"] == pytest.approx(BENCH[name], rel=0.03), name
        assert p["identifiable"], name
        low, high = p["ci95"]
        assert low < p["value"] < high
    assert found.to_dict()["chi2_dof"] == pytest.approx(1.0, abs=0.1)
    assert found.parameters["T0"] == 4.0


def test_the_result_is_as_agreed(found):
    result = json.loads(json_text(found.to_dict()))
    check(result, schema_of(IdentificationRecord), "it")
    assert IdentificationRecord.read(result).to_dict() == result
    assert result["schema"] == "tp-jax/identify/1"
    assert {
        "model",
        "method",
        "parameters",
        "objective",
        "chi2_dof",
        "noise_floor",
        "starts",
        "success",
        "warnings",
        "provenance",
    } <= set(result)
    assert len(result["starts"]) == 5
    for start in result["starts"]:
        assert set(start) == {"objective", "converged", "evaluations", "message"}
        assert isinstance(start["evaluations"], int)
    success = result["success"]
    assert success["of"] == 5
    assert success["reached"] == sum(
        s["objective"] - result["objective"] <= 1.0 for s in result["starts"]
    )
    assert success["ci95"][0] < success["reached"] / 5 <= success["ci95"][1]
    assert success["expected_evaluations"] > 0.0
    assert result["noise_floor"]["phi1"] == pytest.approx(1e-3, rel=0.1)
    assert result["parameters"]["B1"] == {
        "value": BENCH["B1"],
        "unit": "kg m^2",
        "ci95": None,
        "identifiable": True,
    }
    assert ["Ts2"] in [w["parameters"] for w in result["warnings"]]


def test_far_starts_find_it_too(found):
    assert found.to_dict()["success"]["reached"] >= 4
    assert "of 5 starts reached the best" in found.summary()


def test_what_is_found_has_sharp_friction(found):
    assert found.to_dict()["provenance"]["eps"] == SHARPEST_EPS
    assert found.fit.values.get("eps1") == found.fit.values.get("eps2") == SHARPEST_EPS


def test_same_seed_same_result(campaign, found):
    again = tp.identify(campaign, starts=5, fix=FIX)
    results = [each.to_dict() for each in (again, found)]
    for result in results:
        assert result["provenance"].pop("wall_s") >= 0.0
    assert json_text(results[0]) == json_text(results[1])


def test_going_on_gives_the_same(campaign, found, tmp_path, monkeypatch):
    path = tmp_path / "starts.json"
    near = multistart._near
    calls = []

    def stopping(*args):
        calls.append(args)
        if len(calls) == 5:
            raise KeyboardInterrupt
        return near(*args)

    monkeypatch.setattr(multistart, "_near", stopping)
    with pytest.raises(multistart.Interrupted, match="after 4 of 5 starts"):
        tp.identify(campaign, starts=5, fix=FIX, checkpoint=path)
    with pytest.raises(tp.InputError, match="differs in fixed parameters"):
        tp.identify(campaign, starts=5, checkpoint=path, resume=True)
    with pytest.raises(tp.InputError, match="differs in seed"):
        tp.identify(campaign, starts=5, fix=FIX, seed=1, checkpoint=path, resume=True)
    result = tp.identify(campaign, starts=5, fix=FIX, checkpoint=path, resume=True).to_dict()
    assert len(calls) == 6
    first = found.to_dict()
    for each in (result, first):
        del each["provenance"]["wall_s"]
    assert json_text(result) == json_text(first)


def test_noise_with_the_fit(campaign, found):
    # one channel noisier than smoothness tells: every other sample moved the same way
    soiled = [
        dataclasses.replace(r, phi1=r.phi1 + 1.5e-3 * np.sign(np.sin(2e2 * r.t)))
        for r in campaign.recordings
    ]
    noisy = dataclasses.replace(campaign, recordings=tuple(soiled))
    plain = tp.identify(noisy, fix=FIX)
    fitted = tp.identify(noisy, fix=FIX, noise="fit")
    assert plain.to_dict()["chi2_dof"] > 1.05 or plain.to_dict()["noise_floor"]["phi1"] > 1.5e-3
    assert fitted.to_dict()["chi2_dof"] == pytest.approx(1.0, abs=0.02)
    assert fitted.to_dict()["noise_floor"]["phi1"] == pytest.approx(1.8e-3, rel=0.1)
    assert fitted.to_dict()["noise_floor"]["phi2"] == pytest.approx(1e-3, rel=0.1)


def test_nelder_mead_goes_down(campaign):
    result = tp.identify(campaign, method="nelder-mead", starts=2, iterations=4, fix=FIX).to_dict()
    assert result["objective_kind"] == "free-run"
    assert 0.0 < result["objective"] < 1e-2
    assert result["starts"][0]["evaluations"] > 10
    assert result["provenance"]["eps"] == SHARPEST_EPS
    assert not result["starts"][0]["converged"]
    assert "not_converged" in [w["code"] for w in result["warnings"]]


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({"fix": {"x": 1.0}}, "no parameter 'x'"),
        ({"fix": {"B2": 0.0}}, "above zero"),
        ({"fix": {"k": 0.0}}, "above zero"),
        ({"fix": {"M1": -1.0}}, "zero or more"),
        ({"fix": {"k": 1.0}, "bound": {"k": (0.1, 2.0)}}, "fixed and bounded"),
        ({"bound": {"k": (2.0, 1.0)}}, "must rise"),
        ({"bound": {"Tst": (-1.0, 1.0)}}, "must not be negative"),
        ({"method": "magic"}, "no method 'magic'"),
        pytest.param({"objective": "beauty"}, "no objective", marks=pytest.mark.unchecked),
        ({"method": "nelder-mead", "objective": "windows"}, "choose objective free-run"),
        ({"starts": 0}, "one start or more"),
        pytest.param({"loss": "l2"}, "no loss", marks=pytest.mark.unchecked),
        pytest.param({"noise": "none"}, "from the data or the fit", marks=pytest.mark.unchecked),
        ({"noise": "fit", "loss": "huber"}, "from the data"),
        pytest.param({"sampling": "grid"}, "no sampling", marks=pytest.mark.unchecked),
        ({"resume": True}, "must be named"),
    ],
)
def test_what_cannot_be_is_told_in_a_sentence(campaign, options, part):
    with pytest.raises(tp.InputError, match=part) as told:
        tp.identify(campaign, **options)
    assert str(told.value).endswith(".")


def test_a_solver_of_ones_own(campaign, found):
    class Mine(optx.LevenbergMarquardt):
        """As anyone may bring one along."""

    own = tp.identify(campaign, solver=Mine(rtol=1e-6, atol=1e-2, norm=optx.rms_norm), fix=FIX)
    assert own.to_dict()["method"] == "Mine"
    assert own.to_dict()["objective"] == pytest.approx(found.to_dict()["objective"], abs=1.0)
    finer = Mine(rtol=1e-7, atol=1e-2, norm=optx.rms_norm)
    assert described(finer) != described(Mine(rtol=1e-6, atol=1e-2, norm=optx.rms_norm))
    assert described(finer) == described(Mine(rtol=1e-7, atol=1e-2, norm=optx.rms_norm))


@pytest.mark.unchecked
def test_a_number_is_no_solver(campaign):
    with pytest.raises(tp.InputError, match="solver or minimiser of optimistix"):
        tp.identify(campaign, solver=42)


def test_what_makes_up_for_a_number_that_is_not_told_is_not_called_sure():
    """A rider with Coulomb friction alone: how soon Tst rises has no meaning."""
    free = tp.identify(synthetic_campaign(Tst=0.0)).to_dict()
    assert not free["parameters"]["T0"]["identifiable"]
    for name, truth in (("Ts1", BENCH["Ts1"]), ("Tst", 0.0)):
        low, high = free["parameters"][name]["ci95"]
        assert low <= truth <= (np.inf if high is None else high), name
    ridge = next(w for w in free["warnings"] if w["code"] == "ridge")
    assert ridge["parameters"][0] == "T0"
    assert "may be anything from" in ridge["text"]


def test_a_bound_of_ones_own_is_named_and_not_the_data(campaign):
    stopped = tp.identify(campaign, fix=FIX, bound={"k": (0.6, 0.9)}).to_dict()
    told = {w["code"]: w for w in stopped["warnings"]}
    assert "k" not in told["unidentifiable"]["parameters"]
    assert "would take k beyond the bounds that were given" in told["at_bound"]["text"]


def test_its_repr_is_a_line(found):
    text = repr(found)
    assert text.startswith("Identification('synthetic' by least-squares: ")
    assert "k=0.4" in text
    assert len(text) < 300


def test_no_number_is_printed_outside_its_interval(found):
    table = [line.split() for line in found.summary().splitlines()]
    seen = [row for row in table if len(row) > 4 and row[3] == "to"]
    assert len(seen) > 4
    for _, value, low, _, high, *_ in seen:
        assert float(low) < float(value) < float(high)


def test_methods_have_names():
    assert METHODS[:2] == ("least-squares", "nelder-mead")
    assert set(METHODS[2:]) == {
        "variable-projection",
        "levenberg-marquardt",
        "dogleg",
        "gauss-newton",
        "bfgs",
    }
