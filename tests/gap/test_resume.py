"""A diagnosis that was broken off goes on from what it kept, to the same result."""

import json
import logging

import pytest

import tp_jax as tp
from tp_jax.cli.output import json_text


@pytest.mark.slow
def test_goes_on_to_the_same_result(short_diagnosis, short_campaign, tmp_path, caplog):
    path = tmp_path / "fits.json"

    def interrupted(stage, part):
        if stage.startswith("polishing"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tp.diagnose(short_campaign, checkpoint=path, progress=interrupted)
    done = json.loads(path.read_text())["done"]
    assert len(done) > 5
    with caplog.at_level(logging.INFO, "tp_jax.estimation.kept_fits"):
        found = tp.diagnose(short_campaign, checkpoint=path, resume=True)
    (taken,) = [r.args[0] for r in caplog.records if "were taken" in r.message]
    assert taken >= len(done)
    again, whole = (json.loads(json_text(d.to_dict())) for d in (found, short_diagnosis))
    for each in (again, whole):
        del each["provenance"]["wall_s"]
    assert again == whole
    assert set(json.loads(path.read_text())["done"]) > set(done)
