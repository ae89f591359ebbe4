"""Effects that a campaign could show at all."""

from collections.abc import Collection

import numpy as np

from tp_jax.effects import Effect, catalogue, laws
from tp_jax.errors import InputError
from tp_jax.estimation.layout import SENSORS
from tp_jax.estimation.prepared_campaign import PreparedCampaign
from tp_jax.recordings.faults import nearest


def conditions(setting: PreparedCampaign) -> frozenset[str]:
    """Returns what the campaign offers, in the words of `Effect.needs`."""
    met = set()
    if setting.rider:
        met.add("rider")
    if setting.sine:
        met.add("sine")
    if any(setting.recordings[i].measured_drive for i in setting.fitted):
        met.add("measured")
    if not any(r.measured_drive for r in setting.recordings):
        met.add("commanded")
    if len(setting.fitted) > 1:
        met.add("several")
    if setting.campaign.B1 is not None and "B2" in setting.fixed:
        met.add("inertias")
    return frozenset(met)


def check_known(ids: Collection[str]) -> None:
    """Faults ids of which there is neither an effect nor a law.

    Raises:
        InputError: one is not known; the message names the nearest.
    """
    known = [*catalogue(), *laws()]
    for id in ids:
        if id not in known:
            near = nearest(id, known)
            mend = f"did you mean {near}?" if near else "`tp-jax effects` lists them."
            raise InputError(f"There is no effect {id!r} to leave out; {mend}")


def check_predictable(setting: PreparedCampaign) -> None:
    """Faults held-out recordings whose drive no fitted one tells anything of.

    Raises:
        InputError: all commanded, or all measured, drives are held out.
    """
    fitted = [setting.recordings[i] for i in setting.fitted]
    for r in (setting.recordings[i] for i in setting.held_out):
        if r.forced and not any(f.forced and f.measured_drive == r.measured_drive for f in fitted):
            kind = "measured" if r.measured_drive else "commanded"
            raise InputError(
                f"Nothing is known of the drive of {r.label}, which is held out: no recording that "
                f"is fitted has a {kind} drive; hold out another one, or add one."
            )


def why_not(effect: Effect, setting: PreparedCampaign) -> str | None:
    """None if the effect applies, else one sentence that says what is missing."""
    if effect.id in setting.ruled_out:
        return "Left out, as was asked for."
    if effect.n_states and effect.hook in SENSORS:
        return "Not screened: a sensor with states of its own."
    missing = effect.needs - conditions(setting)
    if effect.about_rider and not setting.rider:
        missing = missing | {"rider"}
    sine = [r.omega if r.forced and not r.measured_drive else None for r in setting.recordings]
    seen = [
        effect.resolved(omega or 0.0, float(np.median(np.diff(r.t))))
        for omega, r in zip(sine, setting.recordings, strict=True)
    ]
    if not missing and not all(seen):
        return "Does not apply: it is faster than the samples can show."
    words = {
        "rider": "it needs the angle of a rider",
        "sine": "it needs a commanded sine drive",
        "measured": "it needs a measured drive",
        "commanded": "it needs that no drive is measured",
        "several": "it needs more than one recording",
        "inertias": "it needs B1 and B2 from elsewhere",
    }
    if not missing:
        return None
    return "Does not apply: " + " and ".join(words.get(m, m) for m in sorted(missing)) + "."
