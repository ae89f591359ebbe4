"""Notes of a diagnosis in addition to its numbers."""

from collections.abc import Sequence

import numpy as np

from tp_jax.effects import Law
from tp_jax.estimation.fitted import Fit
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.gap.acceptance import Doubts
from tp_jax.gap.calibration import Floor
from tp_jax.gap.choice import Choice
from tp_jax.gap.policy import POLICY
from tp_jax.gap.refit import Refit
from tp_jax.gap.visited import share_outside
from tp_jax.recordings.drive_noise import POLICY as DRIVE
from tp_jax.recordings.drive_noise import periodic, relative_noise
from tp_jax.results.diagnosis import LackOfFit, Location


def notes(
    setting: PreparedCampaign,
    choice: Choice,
    final: Refit,
    word: str,
    structure_p_after: float,
    anything: LackOfFit,
    least: Floor,
    complete: bool,
    worse: Sequence[str] = (),
    doubts: Doubts | None = None,
    there_alone: bool = False,
) -> list[str]:
    """Returns what to know in addition to the numbers, a sentence or two each.

    Args:
        setting, choice, final, word, structure_p_after, anything, least: what was found.
        complete: whether the models could be integrated through all held-out windows.
        worse: ids of causes with which the held-out recordings are predicted worse.
        doubts: effects that were chosen and are not certain enough to be causes.
        there_alone: whether a gap shows in the held-out recordings and in no fitted one.
    """
    said = []
    if setting.campaign.B1 is None:
        said.append("B1 is not given, so B1 = 1 and torques are per unit of B1: no angle can tell.")
    if setting.rider:
        said.append(
            "Ts2 has no effect on any motion and is held at 0; T0 and Tst are nearly confounded "
            "with Ts1."
        )
    if least.known:
        sizes = " and ".join(f"{1e3 * x:.2g} mrad in {n}" for n, x in least.calibration.items())
        said.append(
            f"The noise floor includes {sizes} that the calibration's error is expected to leave; "
            "an effect has to stand out from it."
        )
    blocks = sorted({n for n in setting.blocks if n > 1})
    if blocks:
        many = f"Recordings have far more samples than their motion needs: each {_joined(blocks)}"
        said.append(
            f"{many} have one of them taken, since steps of the readings hide their noise."
            if setting.coarse
            else f"{many} are averaged, and the noise is that of the means."
        )
    said += _of_drive_noise(setting)
    eps = sorted({f.values.get("eps2") for f in (choice.baseline, final.fit)})
    said.append(f"The friction's smoothing is eps = {' or '.join(f'{x:g}' for x in eps)} s.")
    if not final.fit.converged or not choice.baseline.converged:
        said.append("A fit ended at its iteration limit; its numbers may still move.")
    if not complete:
        said.append(
            "The model cannot be integrated through every window of the held-out recordings; "
            "errors are those of the others, and how far the gap shrinks is not told."
        )
    bound = [u.name for u, b in zip(final.fit.unknowns, final.fit.at_bound, strict=True) if b]
    if bound:
        said.append(f"At a bound: {', '.join(bound)}.")
    for id, reason in unconfirmed(choice).items():
        if id not in final.ids:
            said.append(f"{id} would fit the recordings better, but {reason}.")
    if worse:
        said.append(
            f"With {' and '.join(worse)} the held-out recordings are predicted worse than without: "
            "that model is not offered."
        )
    for id in () if doubts is None else doubts.every:
        kept = id in doubts.unnamed  # type: ignore[union-attr]
        still = "; the model keeps it, since it predicts worse without" if kept else ""
        said.append(
            f"{id} would fit the recordings better, but is not likely enough or of no certain "
            f"size: it is a candidate, not a cause{still}."
        )
    said += _of_own_sizes(final)
    said += in_one_place(final)
    if word == "unknown" and final.ids and structure_p_after >= POLICY.structure.level:
        said.append(
            "The fitted recordings show no structure beside what is named, but the cause is not "
            "certain enough, or the held-out recordings show more than noise or no smaller gap."
        )
    elif word == "unknown" and final.ids:
        said.append("What is named holds part of the gap; what stays is structured still.")
        said += _likeness(anything)
    elif word == "unknown" and there_alone:
        names = ", ".join(setting.recordings[i].label for i in setting.held_out)
        said.append(
            f"The fitted recordings leave noise alone, but {names} is not predicted within the "
            "errors of the fitted numbers. What is missing shows there alone, where no effect is "
            "asked: mark another recording as held out, or record more runs like it."
        )
    elif word == "unknown":
        said.append("No effect of the catalogue explains the gap.")
        said += _likeness(anything)
    return said


def unconfirmed(choice: Choice) -> dict[str, str]:
    """Says why recordings left out speak against an effect that fits better, a clause by its id."""
    found = {id: c for r in choice.rounds for id, c in r.confirmations.items()}
    return {id: c.reason for id, c in found.items() if not c.confirmed}


def why_no_cause(choice: Choice, worse: Sequence[str], doubts: Doubts) -> dict[str, str]:
    """Says what keeps an effect that fits better from being a cause, a clause by its id.

    Args:
        choice: of causes. worse: those that predict held-out recordings worse. doubts: the others
            that were taken out of it again.
    """
    return {
        **unconfirmed(choice),
        **dict.fromkeys(doubts.every, "it is not likely enough or of no certain size"),
        **dict.fromkeys(worse, "with it held-out recordings are predicted worse"),
    }


def elsewhere(where: Sequence[Location], final: Refit) -> list[str]:
    """Says why the gap is said to lie where no cause is, if it is.

    Args:
        where: shares of locations, largest first. final: the model with the causes.
    """
    own = {v.effect.location for v in final.variants}
    if not own or not where or where[0].location in own:
        return []
    return [
        f"What is named acts in {' and '.join(sorted(own))}, but leaves part of the gap: most of "
        f"the whole looks as if it came from {where[0].location}."
    ]


def beyond_its_range(setting: PreparedCampaign, final: Refit, held: Fit) -> list[str]:
    """Says how much of the held-out recordings no learned curve can tell of.

    Args:
        setting: the campaign. final: the model with the causes. held: held-out windows under it.
    """
    said = []
    for v in (v for v in final.variants if isinstance(v.effect, Law)):
        share = share_outside(setting, held, v)
        if share > POLICY.learning.outside:
            said.append(
                f"For {100.0 * share:.2g} % of their time the held-out recordings are beyond the "
                f"range in which {v.effect.id} was learned; the curve is not known there. Hold out "
                "a recording that stays inside, or record one more that goes there."
            )
    return said


def held_out_instead(before: str, now: str) -> str:
    """Says that another recording is held out than the one first chosen."""
    return (
        f"{now} is held out, not {before}: {before} goes further than all others, and a curve that "
        "was learned from those at first said nothing about it."
    )


def unpredicted_fitted(before: str, now: str) -> str:
    """Says that another recording is held out, since the first showed what the others do not."""
    return (
        f"{now} is held out, not {before}: the others left nothing but noise and did not predict "
        f"{before}, so what is missing shows there, and it had to be fitted to ask for a cause."
    )


def _of_own_sizes(final: Refit) -> list[str]:
    """Says of which causes a size was estimated on the held-out recordings themselves."""
    return [
        f"{v.effect.id} has a size of its own in each recording: in held-out ones it was estimated "
        "from their readings, within the scatter of the others; no run that is still to come is "
        "known so well."
        for v in final.variants
        if any(a.per_recording for a in v.effect.amplitudes)
    ]


def in_one_place(final: Refit) -> list[str]:
    """Says which causes act in the same place, where one may patch what another's formula misses.

    Of a contact that slips before it slides by another law than the catalogue's, the nearest
    formula took five sixths and one of vibration the rest.
    """
    places: dict[str, list[str]] = {}
    for v in final.variants:
        places.setdefault(v.effect.location, []).append(v.effect.id)
    return [
        f"{' and '.join(ids)} act in one place, {place}: each is a formula, and one of them may "
        "only take what another misses there."
        for place, ids in places.items()
        if len(ids) > 1
    ]


def _of_drive_noise(setting: PreparedCampaign) -> list[str]:
    """Says what the noise of measured drives does, where it is enough to matter."""
    noisy = [r for r in setting.campaign.recordings if relative_noise(r) > DRIVE.noise]
    found = {r.name: periodic(r) for r in noisy}
    # of a drive that stands noise is all there is, and no part of an amplitude
    moving = [r for r in noisy if (drive := found[r.name]) is None or drive.harmonics]
    if not moving:
        return []
    part = float(np.median([relative_noise(r) for r in moving]))
    size = f"a noise of {100.0 * part:.2g} % of its amplitude"
    as_read = [r.name for r in moving if found[r.name] is None]
    if not as_read:
        return [
            f"The measured drive has {size}. But for that it is periodic, and the model takes its "
            "harmonics instead of the readings, put right by the angles where noise can have made "
            "them wrong."
        ]
    where = "" if len(as_read) == len(moving) else f" of {', '.join(as_read)}"
    return [
        f"The measured drive has {size}. The model takes the readings{where} as they are, so that "
        "what their errors move counts as gap."
    ]


def _joined(numbers: Sequence[int]) -> str:
    return " or ".join(map(str, numbers))


def _likeness(anything: LackOfFit) -> list[str]:
    """Says what the readings look like that no cause explains, where that can be said."""
    if anything.p >= POLICY.structure.left:
        return []
    where, *kind = anything.source.split()
    of = "times" if where == "clock" else f"the readings of {where}"
    how = {"wandering": "wandered", "jumping": "jumped", "stuttering": "stuttered"}
    verb = how.get(kind[0], kind[0]) if kind else "were slowly off"
    return [f"What stays looks most as if {of} {verb}; a torque can look so too."]
