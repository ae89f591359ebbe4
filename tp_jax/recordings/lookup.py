"""A file of a campaign, by its path."""

from pathlib import Path

from tp_jax.errors import InputError
from tp_jax.recordings.campaign import load_campaign
from tp_jax.recordings.recording import Recording


def recording_of(file: str | Path) -> Recording:
    """The recording that a campaign beside a file makes of it; a held-out span before a fitted one.

    Raises:
        InputError: there is no such file, no campaign beside it, or none that has it.
    """
    file = Path(file)
    try:
        there = file.is_file()
    except (OSError, ValueError):  # a name that is too long
        there = False
    if not there:
        raise InputError(
            f"{str(file)[:200]} is no file; name a data file that lies beside a campaign.toml."
        )
    campaign = load_campaign(file.parent)
    spans = [r for r in campaign.recordings if r.file.resolve() == file.resolve()]
    if not spans:
        raise InputError(f"{file.parent / 'campaign.toml'} has no recording {file.name}; add it.")
    return next((r for r in spans if r.held_out), spans[0])
