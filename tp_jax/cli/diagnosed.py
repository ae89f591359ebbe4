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


def default_folder(name: str) -> Path:
    """./NAME-diagnosis; a name that speaks of folders stays one folder here."""
    flat = name.replace("/", "-").replace("\\", "-").strip(". ")
    return Path(f"{flat or 'campaign'}-diagnosis")


def diagnosed(
    campaign: "Campaign", folder: Path, *, seed: int, tolerance: float, figures: bool, resume: bool,
    progress: Progress,
) -> dict[str, Any]:  # fmt: skip
    """Diagnoses a campaign into a folder, which gets diagnosis.json and the report; the result.

    Raises:
        InputError: as `tp.diagnose`.
    """
    import tp_jax as tp

    kept, report = folder / FITS, folder / REPORT
    diagnosis = tp.diagnose(
        campaign, seed=seed, tolerance=tolerance, progress=progress, checkpoint=kept, resume=resume
    )
    result = plain(diagnosis.to_dict())
    write_json(folder / RESULT, result)

    from tp_jax.report.html import write_report

    progress("writing the report", None)
    with replaced(report) as part:
        write_report(result, part, figures=figures, day=date.today())
    forget(kept)
    return result
