"""Contents of each figure in words: its caption, and its text for those who do not see it."""

from tp_jax.report import figures, words
from tp_jax.report.figures.curves import curves_of, dense, drawable
from tp_jax.report.formatting import percent
from tp_jax.results.diagnosis import DiagnosisRecord, HeldOutRun

_FAR = 3.0  # standard errors

GAP = (
    "Error of the model on held-out data. A complete model would reach down to the noise and no "
    "further."
)


def close_up(diagnosis: DiagnosisRecord) -> str:
    """Of the stretch of a run that is missed most."""
    curve = figures.free_run.worst(diagnosis)
    if curve is None:
        return ""
    entry = drawable(diagnosis.curves)[0]
    which = _recording(entry)
    if curve.t.size < curves_of(entry)[0].t.size:
        which = f"The part of {which} where the model misses most"
    return (
        f"{which}, never fitted. Above, the angle: {_lines(entry)} Below, the model's error, and "
        "the band that holds 95 % of the noise."
    )


def run(diagnosis: DiagnosisRecord, index: int) -> str:
    """Of a free run."""
    entry = drawable(diagnosis.curves)[index]
    return (
        f"Free run over {_recording(entry)}, from its first moments on: {_lines(entry)} The better "
        "the model, the closer it stays to the grey. Below each angle, the model's error on a "
        "scale of its own beside the band that holds 95 % of the noise; "
        f"{figures.free_run.described(diagnosis, index)}."
    )


def windows(diagnosis: DiagnosisRecord, index: int) -> str:
    """Of residuals over time."""
    entry = drawable(diagnosis.residuals)[index]
    return (
        f"Residuals over {_recording(entry)}, each window started anew. A complete model leaves "
        "95 % of them inside the grey band and no pattern; "
        f"{figures.residuals.described(diagnosis, index)}."
    )


def over_states(diagnosis: DiagnosisRecord) -> str:
    """Of residuals over angle and velocity."""
    most = figures.state_map.described(diagnosis)
    caption = (
        "The residuals again, gathered by the angle and the velocity measured at the time: the "
        "lighter a cell, the more the model misses there; empty cells were never visited. A light "
        "patch in one place points at something that acts there; light all over, at something that "
        "does not depend on the motion."
    )
    return f"{caption} Before, the largest miss is of {most}." if most else caption


def where(diagnosis: DiagnosisRecord) -> str:
    """Of the shares of the places."""
    shares = figures.where.shown(diagnosis)
    if not shares:
        return ""
    place = words.location(shares[0].location)
    return (
        "Share of the gap by place in the rig. The longest bar says where to look first: "
        f"{place}, with {percent(shares[0].share)}."
    )


def law(diagnosis: DiagnosisRecord, index: int) -> str:
    """Of the curve of a learned cause."""
    cause, _ = figures.law.shown(diagnosis)[index]
    said = "No short formula stays in its band."
    if cause.formula:
        said = f"Within its band it is {cause.formula}."
    return (
        f"The curve that was learned: {words.effect(cause.effect)}. {said} Below, "
        "how often the fitted recordings were there; beyond, nothing is known of the curve."
    )


def candidates(diagnosis: DiagnosisRecord) -> str:
    """Of the candidates' bars."""
    caption = (
        f"The {len(figures.candidates.shown(diagnosis))} most probable candidates, each added to "
        "the model alone. A long blue bar is an effect that removes the gap on data it was not "
        "fitted on; where it is much shorter than the grey one, the linear forecast was too "
        "hopeful. No blue bar: not refitted."
    )
    return f"{caption} Bold: accepted." if diagnosis.accepted else caption


def moved(diagnosis: DiagnosisRecord) -> str:
    """Of the parameters' shifts."""
    caption = "How far each parameter had been pulled aside to hide what was missing."
    rows = figures.moved.shown(diagnosis)
    if not rows:
        return caption
    name, shift = rows[0]
    if abs(shift) > _FAR:
        more = (
            f"The longest bar is {name}: without the cause, its value was far outside its interval."
        )
    else:
        more = "All bars are short: the parameters hid little of it."
    return f"{caption} {more}"


def _lines(entry: HeldOutRun) -> str:
    """Kinds of lines, and what each stands for."""
    joined = all(dense(curve) for curve in curves_of(entry))
    after = any(curve.after is not None for curve in curves_of(entry))
    before = "dashed" if joined else "orange"
    model = (
        f"{before} is the model before, blue the model after" if after else f"{before} the model"
    )
    if joined:
        return f"broad and grey is what was measured, {model}."
    return f"grey is what was measured, {model}; the points are too few to be joined."


def _recording(entry: HeldOutRun) -> str:
    return entry.recording or "a held-out recording"
