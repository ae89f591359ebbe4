"""Two causes at once, one of which takes next to nothing of what the other does."""

import tp_jax as tp
from tp_jax.rig import make_campaign


def test_a_small_cause_is_named_beside_a_large_one(tmp_path):
    """And the large one's shape constant is found anew with it: alone it had to do for both."""
    truth = {"contact_stribeck": 0.25, "base_compliance": 0.018}
    make_campaign(tmp_path / "rig", effects=truth, runs=5, duration=6.0, seed=1, with_B2=True)
    d = tp.diagnose(tp.load_campaign(tmp_path / "rig")).to_dict()
    assert [cause["effect"] for cause in d["causes"]] == list(truth)
    assert d["verdict"] == "explained"
    assert d["causes"][0]["parameters"]["vs"]["ci95"] is not None
    for cause in d["causes"]:
        low, high = cause["parameters"]["a"]["ci95"]
        assert low < truth[cause["effect"]] < high
