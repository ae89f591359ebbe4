"""A campaign diagnosed into a folder, for `tp-jax diagnose` of one campaign and of many."""

from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tp_jax.cli.output import forget, made_folder, plain, replaced, write_json
from tp_jax.cli.progress import Progress

if TYPE_CHECKING:
    from tp_jax.recordings import Campaign

FITS, RESULT, REPORT = "fits.json", "diagnosis.json", "report.html"
"""Fits that are done, until the diagnosis ends; what it leaves."""

SCREEN = "screen.npz"
"""Scores of all effects, which a fleet keeps of each rig."""


def default_folder(name: str) -> Path:
    """./NAME-diagnosis; a name that speaks of folders stays one folder here."""
    flat = name.replace("/", "-").replace("\\", "-").strip(". ")
    return Path(f"{flat or 'campaign'}-diagnosis")


def diagnosed(
    campaign: "Campaign",
    folder: Path,
    *,
    seed: int,
    tolerance: float,
    without: Sequence[str] = (),
    figures: bool,
    resume: bool,
    progress: Progress,
    screen: bool = False,
) -> dict[str, Any]:
    """Diagnoses a campaign into a folder, which gets diagnosis.json and the report; the result.

    Args:
        campaign, seed, tolerance, without, resume, progress: as of `tp.diagnose`.
        folder: gets the files. figures: whether it gets the report's figures too.
        screen: whether it gets the scores of all effects, for what the rigs of a fleet share.

    Raises:
        InputError: as `tp.diagnose`.
    """
    import tp_jax as tp

    kept, report = folder / FITS, folder / REPORT
    asked: dict[str, Any] = {
        "seed": seed,
        "tolerance": tolerance,
        "without": without,
        "progress": progress,
        "checkpoint": kept,
        "resume": resume,
    }
    if screen:
        result = _with_screen(campaign, folder, asked)
    else:
        result = plain(tp.diagnose(campaign, **asked).to_dict())
    write_json(folder / RESULT, result)

    from tp_jax.report.html import write_report

    progress("writing the report", None)
    with replaced(report) as part:
        write_report(result, part, figures=figures, day=date.today())
    forget(kept)
    return result


def _with_screen(campaign: "Campaign", folder: Path, asked: dict[str, Any]) -> dict[str, Any]:
    """A diagnosis whose first screen is kept; its result."""
    from tp_jax.gap.diagnosis import examine
    from tp_jax.gap.shared.from_screen import rig_scores
    from tp_jax.gap.shared.scores import write

    examination = examine(campaign, **asked)
    found, seen = examination.diagnosis, examination.choice.rounds[0].screen
    B1_given = campaign.B1 is not None
    scores = rig_scores(folder.name, seen, found.causes, asked["seed"], B1_given=B1_given)
    write(made_folder(folder) / SCREEN, scores)
    return found.to_dict()
