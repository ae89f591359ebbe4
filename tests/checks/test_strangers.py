"""Files as others have them: each ends in the right reading, or in a sentence that says what to do.

The packaged example, written as a stranger would have it.
"""

import functools
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tp_jax.checks import check
from tp_jax.cli.diagnose import EXAMPLE
from tp_jax.recordings import CampaignError, load_campaign, write_csv

OMEGAS = {"run-13.csv": 13.09, "run-17.csv": 17.0}


@functools.cache
def right(name: str) -> np.ndarray:
    """(3, n) t, phi1, phi2 of a run of the example."""
    return np.loadtxt(EXAMPLE / name, delimiter=",", skiprows=1).T


Columns = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, ...]]


@pytest.fixture
def written(tmp_path):
    """Writes three runs as CSV, their columns spoilt, and the campaign.toml."""

    def write(
        spoil: Columns = lambda *columns: columns,
        form: str = "",
        omega: str = "omega = {omega}",
    ) -> Path:
        toml = ['name = "strange"', form]
        for name in ("decay.csv", *OMEGAS):
            write_csv(tmp_path / name, *spoil(*right(name)))
            how = "forced = false" if name not in OMEGAS else omega.format(omega=OMEGAS[name])
            toml.append(f'[[recording]]\nfile = "{name}"\n{how}')
        (tmp_path / "campaign.toml").write_text("\n".join(toml), encoding="utf-8")
        return tmp_path

    return write


def is_right(folder: Path, within: float = 1e-6) -> None:
    """The campaign reads as the example, and nothing is wrong with it."""
    campaign = load_campaign(folder)
    assert len(campaign.recordings) == 3
    for recording in campaign.recordings:
        names = [each for each in ("decay", "run-13", "run-17") if each in recording.name]
        t, phi1, phi2 = right(f"{names[0]}.csv")
        np.testing.assert_allclose(recording.t - recording.t[0], t, rtol=0, atol=within)
        for angle, truth in ((recording.phi1, phi1), (recording.phi2, phi2)):
            # whole turns are nobody's business
            off = angle - truth
            off -= TURN * np.round(off[0] / TURN)
            np.testing.assert_allclose(off, 0.0, atol=within)
    assert check(folder).wrong == ()


def told(folder: Path) -> str:
    """The first thing that is wrong; `check` and the other commands say the same."""
    wrong = check(folder).wrong
    assert wrong
    return wrong[0].sentence


COLUMNS = "[format.columns]\nt = {{ column = 't'{t} }}\nphi1 = {{ column = 'phi1'{a} }}\n" + (
    "phi2 = {{ column = 'phi2'{b} }}\n"
)

TURN = 2.0 * np.pi


def counts(angle: np.ndarray) -> np.ndarray:
    return np.floor(angle % TURN / TURN * 4096.0)


# What was done to the columns, what is said of it, and the [format.columns] that mends it
SPOILT = {
    "milliseconds": (
        lambda t, a, b: (1e3 * t, a, b),
        'unit = "ms"',
        {"t": ", unit = 'ms'"},
        1e-6,
    ),
    "microseconds": (
        lambda t, a, b: (1e6 * t, a, b),
        'unit = "us"',
        {"t": ", unit = 'us'"},
        1e-6,
    ),
    "degrees": (
        lambda t, a, b: (t, np.degrees(a), np.degrees(b)),
        'unit = "deg"',
        {"a": ", unit = 'deg'", "b": ", unit = 'deg'"},
        1e-6,
    ),
    "an encoder in radians that starts anew": (
        lambda t, a, b: (t, a % TURN, b % TURN),
        "wrap = true",
        {"a": ", wrap = true", "b": ", wrap = true"},
        1e-6,
    ),
    "counts that start anew": (
        lambda t, a, b: (t, counts(a), counts(b)),
        "wrap = true, counts = 4096",
        {"a": ", wrap = true, counts = 4096", "b": ", wrap = true, counts = 4096"},
        5e-3,
    ),
    "the rider against the base": (
        lambda t, a, b: (t, a, a + b),
        'minus = "phi1"',
        {"b": ", minus = 'phi1'"},
        1e-6,
    ),
    "a mirrored rider": (
        lambda t, a, b: (t, a, -b),
        "scale = -1",
        {"b": ", scale = -1"},
        1e-6,
    ),
}


@pytest.mark.parametrize("what", SPOILT)
def test_spoilt_columns_are_refused_and_mended(what, written):
    spoil, says, mend, within = SPOILT[what]
    assert says in told(written(spoil))
    form = COLUMNS.format(**{"t": "", "a": "", "b": "", **mend})
    is_right(written(spoil, form), within)


# omega as it is given, what is said of it where it is taken for rad/s, and how to say it
FREQUENCIES = {
    "Hz": (lambda w: w / TURN, "is in Hz", "frequency = {omega}"),
    "turns a minute": (lambda w: w * 60.0 / TURN, 'unit = "rpm"', "omega = {omega}\nunit = 'rpm'"),
    "a period": (lambda w: TURN / w, "write period in place of", "period = {omega}"),
    "degrees a second": (np.degrees, 'unit = "deg/s"', "omega = {omega}\nunit = 'deg/s'"),
}


@pytest.mark.parametrize("what", FREQUENCIES)
def test_frequencies(what, written, monkeypatch):
    given, says, mend = FREQUENCIES[what]
    monkeypatch.setattr(
        f"{__name__}.OMEGAS", {name: float(given(omega)) for name, omega in OMEGAS.items()}
    )
    sentence = told(written())
    assert says in sentence
    # one number would be wrong of all runs but one
    assert not re.search(r"write (omega|period) = \d", sentence)
    is_right(written(omega=mend))


def test_a_wrong_omega_is_told_with_the_right_one(written):
    assert "phi1 moves at 13.0" in told(written(omega="omega = 9.4"))


def german(folder: Path) -> None:
    """Three CSVs as a German programme exports them."""
    for name in ("decay.csv", *OMEGAS):
        rows = [
            f"{1e3 * t:.6f};{np.degrees(a):.9f};{np.degrees(b):.9f}" for t, a, b in right(name).T
        ]
        head = [
            "Prüfstand Drehpendel 2;;",
            "Abtastrate;250;",
            "",
            "Zeit [ms];Winkel1 [°];Winkel2 [°]",
        ]
        text = "\n".join([*head, *rows]).replace(".", ",")
        (folder / name).write_bytes(text.encode("cp1252"))


def entries() -> str:
    lines = ["[[recording]]\nfile = 'decay.csv'\nforced = false"]
    return "\n".join(
        lines + [f"[[recording]]\nfile = '{f}'\nomega = {w}" for f, w in OMEGAS.items()]
    )


@pytest.mark.parametrize("skip_lines", ["", "skip_lines = 2", "skip_lines = 3"])
def test_a_german_csv(tmp_path, skip_lines):
    """skip_lines counts the line with the names or does not."""
    german(tmp_path)
    with pytest.raises(CampaignError, match=r'"Zeit \[ms\]", "Winkel1 .*tp-jax init'):
        load_campaign(tmp_path / "run-13.csv", omega=13.09)
    form = (
        f"[format]\n{skip_lines}\n[format.columns]\nt = {{ column = 'Zeit', unit = 'ms' }}\n"
        "phi1 = { column = 'Winkel1', unit = 'deg' }\nphi2 = { column = 'Winkel2', unit = 'deg' }\n"
    )
    (tmp_path / "campaign.toml").write_text(form + entries(), encoding="utf-8")
    is_right(tmp_path)


def test_units_in_the_header_are_read(tmp_path):
    t, a, b = right("run-13.csv")
    rows = "\n".join(f"{1e3 * x};{np.degrees(y)};{z}" for x, y, z in zip(t, a, b, strict=True))
    (tmp_path / "a.csv").write_text(f"t;phi1 (deg);phi2\nms;;rad\n{rows}\n")
    recording = load_campaign(tmp_path / "a.csv", omega=13.09).recordings[0]
    np.testing.assert_allclose(recording.t, t, atol=1e-9)
    np.testing.assert_allclose(recording.phi1, a, atol=1e-9)


@pytest.mark.parametrize("kind", ["iso", "german", "clock"])
def test_dates_and_clock_times(kind, tmp_path):
    t, a, b = right("run-13.csv")
    start = np.datetime64("2026-11-23T23:59:57.500000")  # over midnight
    rows = []
    for x, y, z in zip(t, a, b, strict=True):
        iso = str(start + np.timedelta64(round(1e6 * x), "us"))
        day, clock = iso.split("T")
        year, month, number = day.split("-")
        cell = {"iso": iso + "Z", "german": f"{number}.{month}.{year} {clock}", "clock": clock}[
            kind
        ]
        rows.append(f"{cell};{y:.17g};{z:.17g}")
    (tmp_path / "a.csv").write_text("t;phi1;phi2\n" + "\n".join(rows) + "\n")
    recording = load_campaign(tmp_path / "a.csv", omega=13.09).recordings[0]
    np.testing.assert_allclose(recording.t, t, atol=1e-6)


def test_repeated_times_and_empty_cells_are_told_at_once(written):
    folder = written()
    lines = (folder / "run-13.csv").read_text().split("\n")
    twice = [*lines[:100], lines[99], *lines[100:200], lines[199], *lines[200:]]
    (folder / "run-13.csv").write_text("\n".join(twice))
    empty = [
        line if i not in (50, 60) else f"{line.split(',')[0]},," for i, line in enumerate(lines)
    ]
    (folder / "run-17.csv").write_text("\n".join(empty))
    texts = [each.sentence for each in check(folder).wrong]
    assert len(texts) == 2
    assert "in 2 rows, lines 101, 202; remove one of each two" in texts[0]
    assert "lines 51, 61; remove the rows, a gap in time is understood" in texts[1]
    with pytest.raises(CampaignError, match="lines 101, 202"):
        load_campaign(folder)
