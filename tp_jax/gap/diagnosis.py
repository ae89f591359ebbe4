"""`diagnose`: from a campaign to where the gap lies, what causes it and how far it shrinks."""

import dataclasses
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Literal

import numpy as np

from tp_jax._blas import one_blas_thread
from tp_jax._files import plain
from tp_jax._version import __version__
from tp_jax.errors import InputError
from tp_jax.estimation.kept_fits import fits_checkpoint, keeping
from tp_jax.estimation.prepared_campaign import PreparedCampaign, prepare_campaign
from tp_jax.estimation.schedule import fit_over_schedule
from tp_jax.estimation.start import initial_values
from tp_jax.gap.applicability import check_known, check_predictable
from tp_jax.gap.assemble import assemble
from tp_jax.gap.choice import Choice
from tp_jax.gap.known_noise import choose_under_noise
from tp_jax.gap.notes import held_out_instead, unpredicted_fitted
from tp_jax.gap.predict import found_pendulum, predict
from tp_jax.gap.unpredicted import better_held_out
from tp_jax.gap.visited import inside_of_others
from tp_jax.model.pendulum import AbstractTorsionPendulum
from tp_jax.recordings import Campaign, hold_out
from tp_jax.report.excerpt import excerpt
from tp_jax.report.html import write_report
from tp_jax.report.text import summary
from tp_jax.results.diagnosis import DiagnosisRecord, Provenance
from tp_jax.simulation.solve import Trajectory


@dataclasses.dataclass(frozen=True, kw_only=True)
class Diagnosis(DiagnosisRecord):
    """Result of `diagnose`: the contents of diagnosis.json, and what can be made of them."""

    def __repr__(self) -> str:
        by = f" by {' and '.join(self.causes)}" if self.causes else ""
        shrink = self.gap.shrink
        part = f", shrink {shrink:.3g}" if self.causes and shrink is not None else ""
        return f"Diagnosis({self.campaign!r}: {self.verdict}{by}{part})"

    def _repr_html_(self) -> str:
        return excerpt(self)

    def summary(self) -> str:
        """The verdict in at most 25 lines of plain text; see `tp_jax.report.summary`."""
        return summary(self)

    def write_report(self, path: str | Path, *, figures: bool = False) -> None:
        """Writes the report as one HTML file; see `tp_jax.report.write_report`.

        Args:
            path: the file; its folder must exist.
            figures: whether to write them to `figures/` beside it too, as PNG and SVG.

        Raises:
            OSError: a file cannot be written.
        """
        write_report(self, path, figures=figures)

    def predict(
        self,
        *,
        omega: float | None = None,
        phi1: float | None = None,
        recording: str | Path | None = None,
        duration: float | None = None,
        rate: float | None = None,
        model: Literal["before", "after"] | None = None,
    ) -> Trajectory:
        """Predicts a run never seen; see `tp_jax.predict`.

        Args:
            omega: frequency of a forced run from rest [rad/s].
            phi1: angle from which a decay is released, the motor at rest [rad].
            recording: a file of the campaign whose drive and start are to be used. Exactly one of
                these three says which run.
            duration: length [s]; that of the recording if None.
            rate: samples per second [Hz]; those of the recording if None.
            model: None: after, or before where no cause was accepted.

        Raises:
            InputError: in one sentence, what is wrong with the arguments or the diagnosis.
        """
        return predict(
            self,
            omega=omega,
            phi1=phi1,
            recording=recording,
            duration=duration,
            rate=rate,
            model=model,
        )

    def pendulum(
        self,
        *,
        omega: float | None = None,
        duration: float = 10.0,
        model: Literal["before", "after"] | None = None,
    ) -> AbstractTorsionPendulum:
        """The pendulum with what was found, for `tp.simulate`, `tp.sweep` and their derivatives.

        Args:
            omega: frequency of the drive [rad/s]; None: the motor stands still.
            duration: of the run [s], over which a drift runs its course.
            model: None: after, or before where no cause was accepted.

        Raises:
            InputError: in one sentence, what is wrong with the arguments or the diagnosis.
        """
        return found_pendulum(self, omega=omega, duration=duration, model=model)


@dataclasses.dataclass(frozen=True)
class Examination:
    """A diagnosis with the fits it rests on.

    setting, choice: of the diagnosis.
    """

    setting: PreparedCampaign
    choice: Choice
    diagnosis: Diagnosis


def _silent(stage: str, fraction: float | None) -> None:
    """Reports to nobody."""


def diagnose(
    campaign: Campaign,
    *,
    model: str = "newton",
    seed: int = 0,
    tolerance: float = 0.0,
    without: Collection[str] = (),
    progress: Callable[[str, float | None], None] | None = None,
    checkpoint: str | Path | None = None,
    resume: bool = False,
) -> Diagnosis:
    """Finds where the model falls short of a campaign, which effect is missing, and what it gains.

    Args:
        campaign: see `load_campaign`. Where no recording is marked held out, one is.
        model: "newton" or "paper".
        seed: of every random draw.
        tolerance: root mean square [rad] below which a gap matters to nobody.
        without: ids of effects (`bearing_position`) and laws (`bearing_dry.phi1`) that are not
            asked about: what was ruled out by hand, say.
        progress: called with a stage's name and the part of it that is done.
        checkpoint: file in which finished fits are kept.
        resume: go on from that file; the result is the one of a run that was not broken off.

    Raises:
        InputError: the model cannot be integrated through the recordings, a held-out one cannot
            be predicted, there is no effect of such an id, or there is nothing to resume.

    Returns:
        A `Diagnosis`. The search for causes uses the fitted recordings alone. The held-out ones are
        read after it; they may take causes out, or show that another one is to be held out.
    """
    return examine(
        campaign,
        model=model,
        seed=seed,
        tolerance=tolerance,
        without=without,
        progress=progress,
        checkpoint=checkpoint,
        resume=resume,
    ).diagnosis


@one_blas_thread()
def examine(
    campaign: Campaign,
    *,
    model: str = "newton",
    seed: int = 0,
    tolerance: float = 0.0,
    without: Collection[str] = (),
    progress: Callable[[str, float | None], None] | None = None,
    checkpoint: str | Path | None = None,
    resume: bool = False,
) -> Examination:
    """Does as `diagnose` does, and keeps the fits too, for whoever asks them further."""
    begin = time.perf_counter()
    progress = progress or _silent
    check_known(without)
    progress("preparing the recordings", None)
    given, campaign = campaign, hold_out(campaign)
    asked = {
        "model": model,
        "seed": seed,
        "tolerance": tolerance,
        "without": sorted(set(without)),
    }
    kept = fits_checkpoint(checkpoint, resume, campaign, asked)
    with keeping(kept):
        setting, choice = _chosen(campaign, model, seed, without, progress)
        more: tuple[str, ...] = ()
        # of one or two recordings a part is held out, and there is no other
        whole = not given.held_out and len(given.recordings) > 2
        other = inside_of_others(setting, choice.final) if whole else None
        why = held_out_instead
        if whole and other is None:
            other, why = better_held_out(setting, choice), unpredicted_fitted
        if other is not None:
            first, campaign = campaign.held_out[0].name, hold_out(given, other)
            now = campaign.held_out[0].name
            more = (why(first, now),)
            progress(f"beginning anew, with {now} held out", None)
            setting, choice = _chosen(campaign, model, seed, without, progress, gap=True)
        progress("reading the held-out recordings", None)
        result = assemble(setting, choice, seed, tolerance, more)
    provenance = Provenance(
        __version__, seed, campaign.data_sha256, round(time.perf_counter() - begin, 2)
    )
    found = Diagnosis.read(plain({**result.to_dict(), "provenance": provenance.to_dict()}))
    return Examination(setting, choice, found)


def _chosen(
    campaign: Campaign,
    model: str,
    seed: int,
    without: Collection[str],
    progress: Callable[[str, float | None], None],
    gap: bool = False,
) -> tuple[PreparedCampaign, Choice]:
    """The causes that fitted recordings speak for.

    Args:
        campaign, model, seed, without, progress: see `diagnose`. gap: see `choose_under_noise`.
    """
    setting = prepare_campaign(campaign, model=model, without=without)
    check_predictable(setting)
    setting.problem(setting.horizons[0]).compile_ahead(frozenset())
    baseline = fit_over_schedule(
        setting, initial_values(setting), setting.unknowns(), progress=progress
    )
    if not np.isfinite(baseline.cost):
        raise InputError(
            "The model cannot be integrated through the recordings from any start; check the units "
            "of times and angles, and that omega is in rad/s."
        )
    return choose_under_noise(setting, baseline, seed, progress, gap)
