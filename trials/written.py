"""Second look at what was written of a case."""

import hashlib
from pathlib import Path

import numpy as np

from tp_jax.recordings import CampaignError, load_campaign
from trials.draw import FARTHEST


def readable(folder: Path) -> bool:
    """True if the package reads a campaign, and the column stays where springs bend."""
    try:
        campaign = load_campaign(folder)
    except CampaignError:
        return False
    return all(float(np.abs(r.phi1).max()) < FARTHEST for r in campaign.recordings)


def sha256(file: Path) -> str:
    """Computes the SHA-256 of a file."""
    return hashlib.sha256(file.read_bytes()).hexdigest()
