"""Which effects a campaign could show at all."""

import numpy as np

from tp_jax.effects import Effect
from tp_jax.estimation.baseline import Setting
from tp_jax.estimation.layout import SENSORS


def conditions(setting: Setting) -> frozenset[str]:
    """What the campaign offers, in the words of `Effect.needs`."""
    met = set()
    if setting.rider:
        met.add("rider")
    if setting.sine:
        met.add("sine")
    if len(setting.fitted) > 1:
        met.add("several")
    known = {"B2", "k"} & set(setting.fixed)
    if setting.campaign.B1 is not None and known:
        met.add("inertias")
    return frozenset(met)


def why_not(effect: Effect, setting: Setting) -> str | None:
    """None if the effect applies, else one sentence that says what is missing."""
    if effect.n_states and effect.hook in SENSORS:
        return "Not screened: a sensor with states of its own."
    missing = effect.needs - conditions(setting)
    if effect.about_rider and not setting.rider:
        missing = missing | {"rider"}
    runs = [r for r in setting.recordings if r.forced and r.omega and not r.measured_drive]
    seen = [effect.resolved(r.omega or 0.0, float(np.median(np.diff(r.t)))) for r in runs]
    if not missing and seen and not all(seen):
        return "Does not apply: it is faster than the samples can show."
    words = {
        "rider": "it needs the angle of a rider",
        "sine": "it needs a commanded sine drive",
        "several": "it needs more than one recording",
        "inertias": "it needs B1 and one of B2 and k from elsewhere",
    }
    if not missing:
        return None
    return "Does not apply: " + " and ".join(words.get(m, m) for m in sorted(missing)) + "."
