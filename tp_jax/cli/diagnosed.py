"""A campaign diagnosed into a folder, for `tp-jax diagnose` of one campaign and of many."""

from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tp_jax.cli.output import forget, plain, replaced, write_json
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
    campaign: "Campaign", folder: Path, *, seed: int, tolerance: float, figures: bool, resume: bool,
    progress: Progress, screen: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Diagnoses a campaign into a folder, which gets diagnosis.json and the report; the result.

    Args:
        campaign, seed, tolerance, resume, progress: as of `tp.diagnose`.
        folder: gets the files. figures: whether it gets the report's figures too.
        screen: whether it gets the scores of all effects, for what the rigs of a fleet share.

    Raises:
        InputError: as `tp.diagnose`.
    """
    from tp_jax._config import use_float64

    use_float64()

    from tp_jax.gap.diagnosis import examine

    kept, report = folder / FITS, folder / REPORT
    examination = examine(
        campaign, seed=seed, tolerance=tolerance, progress=progress, checkpoint=kept, resume=resume
    )
    result = plain(examination.result)
    write_json(folder / RESULT, result)
    if screen:
        from tp_jax.gap.shared.from_screen import rig_scores
        from tp_jax.gap.shared.scores import write

        causes = [cause["effect"] for cause in result["causes"]]
        seen = examination.choice.rounds[0].screen
        write(folder / SCREEN, rig_scores(folder.name, seen, causes, seed))

    from tp_jax.report.html import write_report

    progress("writing the report", None)
    with replaced(report) as part:
        write_report(result, part, figures=figures, day=date.today())
    forget(kept)
    return result
