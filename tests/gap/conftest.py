"""A rig in which something is hidden: what was recorded, and what the program says of it."""

import pytest

import tp_jax as tp
from tests import kept


@pytest.fixture(scope="session")
def short_diagnosis():
    """Its diagnosis, by the shell."""
    return kept.recorded()


@pytest.fixture(scope="session")
def short_campaign(short_diagnosis):
    """Six runs of the virtual rig of 4 s each."""
    return tp.load_campaign(kept.recorded_folder())
