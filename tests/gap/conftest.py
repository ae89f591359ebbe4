"""Campaigns cut short, and what the program says of them."""

import dataclasses
from pathlib import Path

import pytest

import tp_jax as tp

BUNDLED = Path(tp.__file__).parent / "examples" / "case-02"


@pytest.fixture(scope="session")
def short_campaign():
    """The bundled campaign, 4 s of each recording: from an independent simulator."""
    campaign = tp.load_campaign(BUNDLED)
    cut = tuple(
        dataclasses.replace(r.cut(0.0, 4.0), label=r.name, span=None) for r in campaign.recordings
    )
    return dataclasses.replace(campaign, recordings=cut)


@pytest.fixture(scope="session")
def short_diagnosis(short_campaign):
    return tp.diagnose(short_campaign, seed=0)
