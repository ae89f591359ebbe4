"""Messages to the user when a command fails, and the exit code."""

import errno
import os
import shlex
import sys
import traceback
from pathlib import Path

from tp_jax.errors import InputError

OF_THE_SYSTEM = {
    getattr(errno, name)
    for name in ("ENAMETOOLONG", "ELOOP", "ENOSPC", "EDQUOT", "EROFS", "EFBIG")
    if hasattr(errno, name)
}
"""Refusals of a file system that may come anywhere, and that nobody but the user can mend."""


def explain(fault: Exception, *, debug: bool, campaign: object = None) -> int:
    """Prints one sentence on standard error (with `debug` the traceback before it).

    Args:
        fault: that ended the command.
        campaign: that the command was given, if any.

    Returns:
        2 where the input is to be mended, 1 where the fault is ours.
    """
    if debug:
        traceback.print_exception(fault)
    if isinstance(fault, InputError):  # CampaignError is one
        text = _one_line(str(fault))
        print(f"tp-jax: {text}{where_it_goes(campaign, text)}", file=sys.stderr)
        return 2
    if isinstance(fault, OSError) and fault.errno in OF_THE_SYSTEM:
        name = str(fault.filename or "")
        name = f" {name[:60]}..." if len(name) > 120 else f" {name}" if name else ""
        print(f"tp-jax: Cannot use the file{name}: {fault.strerror}.", file=sys.stderr)
        return 2
    what = _one_line(f"{type(fault).__name__}: {fault}").rstrip(".: ")
    hint = "" if debug else "; rerun with --debug for the traceback"
    print(f"tp-jax: A fault of ours, {what}{hint}.", file=sys.stderr)
    return 1


def where_it_goes(campaign: object, text: str) -> str:
    """Says where to write what `text` asks for under a section, if one data file was given.

    Such a file has no campaign.toml that the section could stand in.
    """
    if not isinstance(campaign, str) or "under [" not in text or "tp-jax init" in text:
        return ""
    path = Path(campaign)
    if path.suffix.lower() == ".toml" or not os.path.isfile(path):
        return ""
    folder = path.parent
    if (folder / "campaign.toml").exists():
        return f" That belongs in {folder / 'campaign.toml'}; then name the folder, not the file."
    return (
        f" That belongs in a campaign.toml, which `tp-jax init {shlex.quote(str(folder))}` writes; "
        "then name the folder, not the file."
    )


def _one_line(text: str) -> str:
    return " ".join(text.split())
