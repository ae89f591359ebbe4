"""Checks whether the data of a recording can be what they are said to be."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax.recordings import clocks, rounding
from tp_jax.recordings.columns import Columns
from tp_jax.recordings.encoder import leaps, whole_numbers
from tp_jax.recordings.entries import Entry
from tp_jax.recordings.faults import CampaignError, in_rows
from tp_jax.recordings.noise import noise_level
from tp_jax.recordings.odd_units import NAMES, Odd, advice, odd_units
from tp_jax.recordings.readings import repeated
from tp_jax.recordings.recorded_run import RecordedRun
from tp_jax.recordings.sources import ColumnSource

LEAST_SAMPLES = 50

WIDEST_PHI1 = 12.0
"""Span of phi1 [rad] above which it is taken for degrees: the spring would not stand it. phi2
has no such bound, the ring may go round and round; nor has phi1 where the column may."""

IF_IT_TURNS = "if the column turns round and round, rotates = true under [rig]"

OFTEN = 0.05
"""Share of rows that repeat the one before from which they are too many to be removed by hand."""

FINER_PHI2 = 8.0
"""Times that phi1 may have the noise of phi2 for both to be in one unit; degrees make it 57."""

LEAP = np.pi
"""Way of phi1 [rad] from one sample to the next that no counted turns have."""

RATE_TOLERANCE = 0.05

LEAST_STEP = 1e-9
"""Part of the usual step between two rows; nearer ones have one time, since no clock parts them and
differences divided by their step overflow."""


def check_times(columns: Columns) -> None:
    """Faults times that are not finite, do not rise, or leap by an hour of summer time.

    Raises:
        CampaignError: at the first such row, with what it is by the size of its fall.
    """
    t = columns.values["t"]
    _check_finite(columns, "t", 0, t.size)
    source = columns.sources.get("t") or ColumnSource("t")
    counted = None
    if source.wrap is None:
        factor = source.factor("t")
        period = clocks.period_of((t - source.offset) / factor)
        counted = None if period is None else (period, factor)
    period = counted and counted[0] * counted[1]
    fall = clocks.fall_of(t, columns.dated, period, columns.zoned)
    if fall is None:
        _check_repeated(columns)
        return
    i = fall.at
    wrong = f"time runs backwards from {t[i - 1]:g} to {t[i]:g} s"
    if fall.cause == "counter" and counted is not None:
        period, factor = counted
        given: dict[str, Any] = {"wrap": period}
        unit = clocks.unit_of_step(factor * clocks.usual_step(t))
        if source.unit is None and factor == 1.0 and unit is not None:
            given = {"unit": unit, **given}
        wrong += f", as the clock of a board does that starts anew after {period:.10g}"
        mend = columns.advice({"t": given})
    elif fall.cause == "hour":
        if t[i] > t[i - 1]:
            wrong = (
                f"time leaps from {t[i - 1]:g} to {t[i]:g} s, an hour of summer time that begins"
            )
        else:
            wrong += ", an hour of summer time that ends"
        mend = columns.advice({"t": {"summer_time": True}})
        if not columns.sources:
            mend = "give times without summer time"
    elif fall.cause == "row":
        rows = [columns.numbers[j] for j in fall.rows]
        wrong = f"{wrong}{in_rows(rows)}"
        mend = f"remove the {'row' if len(rows) == 1 else 'rows'}, a gap in time is understood"
    elif fall.cause == "order":
        mend = "put the rows in order of time"
    else:
        wrong += ", as after a reset of the board or where two logs were joined"
        mend = (
            "split the file before this line, a file for each run, and leave out a driven one that "
            "begins in motion"
        )
    raise CampaignError(columns.file, wrong, mend, columns.numbers[i])


def _check_repeated(columns: Columns) -> None:
    t = columns.values["t"]
    steps = np.diff(t)
    bad = np.flatnonzero(steps <= LEAST_STEP * (np.median(steps) if steps.size else 0.0))
    if not bad.size:
        return
    i = int(bad[0]) + 1
    same = repeated(columns.values)
    quantum = rounding.rounded(t, same)
    again = [columns.numbers[j + 1] for j in bad.tolist()]
    if quantum is not None:
        raise CampaignError(
            columns.file,
            f"times are rounded to {quantum:.3g} s and repeated in {len(again)} rows, and the rows "
            "do not come evenly or are too few to tell",
            "write the times with more decimals",
            columns.numbers[i],
        )
    if len(again) == 1:
        wrong, mend = f"the time {t[i]:g} s is repeated", "remove one of the two rows"
    else:
        wrong = f"the time {t[i]:g} s and others are repeated{in_rows(again)}"
        mend = "remove one of each two rows"
        if len(again) > OFTEN * t.size and np.all(same[bad]):
            often = t.size / np.unique(t).size
            mend = f"keep one of {often:.3g} rows, as held = true under [format] does"
    raise CampaignError(columns.file, wrong, mend, columns.numbers[i])


def check_values(columns: Columns, begin: int, end: int) -> None:
    """Faults values in rows begin to end that are not finite.

    Raises:
        CampaignError: at the first such row of a column.
    """
    for name in columns.values:
        _check_finite(columns, name, begin, end)


def check_span(columns: Columns, entry: Entry, begin: int, end: int, toml: Path) -> None:
    """Faults a span without data, and too few samples.

    Raises:
        CampaignError: the rows begin to end do not make a recording.
    """
    t = columns.values["t"]
    if end - begin >= LEAST_SAMPLES:
        return
    if entry.span is None:
        raise CampaignError(
            entry.file,
            f"the file has {_samples(end - begin)}, but {LEAST_SAMPLES} are needed",
            "record for longer or at a higher rate",
        )
    where = f"the span [{entry.span[0]:g}, {entry.span[1]:g}] s of {entry.name}"
    if begin >= end:
        wrong = f"{where} holds no data, which last from {t[0]:g} to {t[-1]:g} s"
    else:
        wrong = f"{where} holds {_samples(end - begin)}, but {LEAST_SAMPLES} are needed"
    raise CampaignError(toml, wrong, "choose a span that covers more of the data", entry.line)


def check_recording(
    recording: RecordedRun,
    sample_rate: float | None,
    rotates: bool = False,
    columns: Mapping[str, ColumnSource] | None = None,
    odd: Mapping[str, Mapping[str, Odd]] | None = None,
) -> None:
    """Faults readings that start anew, degrees, rest, and another sample rate than the campaign's.

    Args:
        recording: with finite values and rising times.
        sample_rate: as the campaign states it [Hz], or None.
        rotates: whether the column may turn round and round.
        columns: where the campaign says that the columns are, for the mend.
        odd: of `odd_ones`, where this one may be in another unit than the others.

    Raises:
        CampaignError: the recording is not what it is said to be.
    """
    for name, angle in recording.channels.items():
        _check_wrap(recording, name, angle, columns or {})
    if rotates:
        _check_turns(recording)
    else:
        _check_angles(recording, odd)
    _check_motion(recording)
    if sample_rate is None:
        return
    rate = 1.0 / float(np.median(np.diff(recording.t)))
    if abs(rate / sample_rate - 1.0) > RATE_TOLERANCE:
        raise CampaignError(
            recording.file,
            f"the time column has {rate:.4g} samples a second, but sample_rate is {sample_rate:g}",
            'correct sample_rate under [rig], or give t in seconds, as unit = "ms" for t under '
            "[format.columns] does",
        )


def _check_wrap(
    recording: RecordedRun, name: str, angle: np.ndarray, columns: Mapping[str, ColumnSource]
) -> None:
    """A reading that starts anew after a turn is no angle of a motion."""
    found = leaps(recording.t, angle)
    if found is None or found.period is None:
        return
    source = columns.get(name) or ColumnSource(name)
    period = found.period / abs(source.factor(name))
    turn = abs(period * abs(source.factor(name)) - 2.0 * np.pi) < 1e-6
    unit = ", counts = " + f"{period:g}" if whole_numbers(angle) else ""
    wrap = "true" if turn or unit else f"{period:.6g}"
    times = "once" if found.at.size == 1 else f"{found.at.size} times"
    raise CampaignError(
        recording.file,
        f"{name} leaps {times} by {found.size:.4g} from one sample to the next, first at "
        f"{recording.t[found.at[0]]:.4g} s, as a reading does that starts anew after "
        f"{found.period:.6g}",
        f"write wrap = {wrap}{unit} for {name} under [format.columns]",
    )


def _check_finite(columns: Columns, name: str, begin: int, end: int) -> None:
    values = columns.values[name][begin:end]
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        rows = [columns.numbers[begin + i] for i in bad.tolist()]
        raise CampaignError(
            columns.file,
            f"{name} is {values[bad[0]]}{in_rows(rows)}",
            "remove the row, a gap in time is understood, or write the number measured",
            rows[0],
        )


def odd_ones(recordings: Sequence[RecordedRun]) -> dict[str, dict[str, Odd]] | None:
    """Returns `odd_units` where phi1 of some recordings, not of all, is too wide for radians."""
    wide = [_too_wide(each) for each in recordings]
    return odd_units(recordings) if any(wide) and not all(wide) else None


def _too_wide(recording: RecordedRun) -> bool:
    return float(np.ptp(recording.phi1)) > WIDEST_PHI1


def _check_angles(
    recording: RecordedRun, odd: Mapping[str, Mapping[str, Odd]] | None = None
) -> None:
    if not _too_wide(recording):
        return
    width = float(np.ptp(recording.phi1))
    counts = whole_numbers(recording.phi1)
    unit = None if counts else "deg" if np.radians(width) <= WIDEST_PHI1 else "mrad"
    if odd is not None:  # the others are as they should be, and no unit is to be given for all
        known = odd.get(recording.label, {})
        turns = "" if "phi1" in known else f"; {IF_IT_TURNS}"
        alike = known.get("phi2")
        if alike is not None and alike.unit in ("deg", "gon") and unit == "deg":
            unit = alike.unit  # of two sensors of one file
        known = {"phi1": Odd(unit, 1.0), **known}
        mine = {channel: each.unit for channel, each in known.items()}
        told, *more = dict.fromkeys(each.named for each in known.values())
        raise CampaignError(
            recording.file,
            f"phi1 spans {width:.4g}, too much for radians, in which other recordings are, and is "
            f"probably in {' and '.join([told, *more])}",
            f"{advice(recording, mine)}{turns}",
        )
    # sensors are alike: where phi2 has far less noise it is in another unit than phi1
    both = recording.phi2 is None or noise_level(recording.t, recording.phi2) > (
        noise_level(recording.t, recording.phi1) / FINER_PHI2
    )
    which = "phi1 and phi2" if both else "phi1"
    if counts:
        raise CampaignError(
            recording.file,
            f"phi1 spans {width:.6g} in whole numbers, too much for radians and probably counts "
            "of an encoder",
            f"write counts = N, those of a whole turn, for {which} under [format.columns]",
        )
    raise CampaignError(
        recording.file,
        f"phi1 spans {width:.4g}, too much for radians and probably {NAMES[unit]}",
        f'write unit = "{unit}" for {which} under [format.columns]; {IF_IT_TURNS}',
    )


def _check_turns(recording: RecordedRun) -> None:
    """An angle that winds goes on from sample to sample: degrees, or turns not counted, leap."""
    steps, ways = np.diff(recording.t), np.abs(np.diff(recording.phi1))
    side_by_side = steps < 2.0 * np.median(steps)  # who knows what it did in a gap
    way = float(ways[side_by_side].max(initial=0.0))
    if way > LEAP:
        raise CampaignError(
            recording.file,
            f"phi1 leaps by {way:.4g} from one sample to the next, too far for turns that were "
            "counted on in radians",
            "write wrap = true for phi1 under [format.columns] where its reading starts anew, or "
            'unit = "deg" if it is in degrees',
        )


def _check_motion(recording: RecordedRun) -> None:
    width = float(np.ptp(recording.phi1))
    noise = noise_level(recording.t, recording.phi1)
    # The largest of n normal deviates is near sqrt(2 ln n); a body at rest has no more than
    # noise. Both signs of motion must be absent: a short swing widens only the span, and noise
    # that moves slowly only the standard deviation.
    widest = (2.0 * np.sqrt(2.0 * np.log(recording.n)) + 4.0) * noise
    if width > widest or np.std(recording.phi1) > 2.5 * noise > 0.0:
        return
    raise CampaignError(
        recording.file,
        f"phi1 does not move, it spans {width:.2g} rad at a noise of {noise:.2g} rad",
        "check the sensor, the column and the sample rate, or remove the recording",
    )


def _samples(n: int) -> str:
    return f"{n} sample" if n == 1 else f"{n} samples"
