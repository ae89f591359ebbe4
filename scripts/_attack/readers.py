"""Every reader, on spoiled files and streams: an InputError of one line, or a result that holds."""

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, Verbosity, given, settings
from hypothesis import seed as with_seed
from hypothesis import strategies as st

from scripts._attack import corpus, small
from scripts._attack.tally import Tally, Wrong
from scripts._attack.texts import documents, spoiled

Attack = tuple[st.SearchStrategy, Callable[[Any, Path], object]]


def attack(tally: Tally, inputs: int, seed: int = 0, only: str | None = None) -> None:
    """Tries so many inputs, shared among the readers."""
    chosen = {n: a for n, a in readers().items() if only is None or n == only}
    with tempfile.TemporaryDirectory() as folder:
        for door, (strategy, read) in chosen.items():
            _run(tally, door, strategy, read, max(inputs // len(chosen), 1), seed, Path(folder))


def _run(tally, door, strategy, read, inputs, seed, folder) -> None:
    # only drawn: what fails is counted, and not made smaller
    @settings(
        max_examples=inputs,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
        verbosity=Verbosity.quiet,
    )
    @given(strategy)
    def one(content: Any) -> None:
        tally.attempt(f"reader: {door}", lambda: read(content, folder), _short(content))

    with_seed(seed)(one)()


def readers() -> dict[str, Attack]:
    """Door -> what is drawn, and what reads it."""
    return {
        "campaign.toml": (spoiled(corpus.CAMPAIGN.encode()), _campaign),
        "campaign.toml [format]": (spoiled(corpus.FORMAT.encode()), _their_campaign),
        "recording": (spoiled(corpus.recording()), _recording),
        "metadata": (documents(corpus.metadata()), _metadata),
        "calibration": (spoiled(corpus.calibration_text()), _calibration),
        "calibration readings": (spoiled(corpus.readings()), _readings),
        "diagnosis.json": (documents(small.diagnosis()), _diagnosis),
        "diagnosis.json as text": (spoiled(json.dumps(small.diagnosis()).encode()), _text),
        "starts.json": (documents(corpus.starts()), _starts),
        "part of a key": (documents(corpus.part_of_key()), _part_of_key),
        "frames": (st.lists(spoiled(corpus.frames()), min_size=1, max_size=3), _frames),
        "text stream": (st.lists(spoiled(corpus.text_stream()), min_size=1, max_size=3), _lines),
        "program in the cache": (spoiled(program()), _program),
    }


def _put(folder: Path, name: str, content: Any) -> Path:
    file = folder / name
    file.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    return file


def _sound(campaign) -> None:
    for r in campaign.recordings:
        for y in (r.t, r.phi1, r.phi2):
            if y is not None and not np.isfinite(y).all():
                raise Wrong(f"{r.name} holds what is no number")
        if not (np.diff(r.t) > 0.0).all():
            raise Wrong(f"the time of {r.name} does not rise")


def _campaign(content: bytes, folder: Path) -> None:
    from tp_jax.recordings import load_campaign

    for seed, name in enumerate(corpus.RUNS):
        _put(folder, name, corpus.recording(seed))
    _put(folder, "campaign.toml", content)
    _sound(load_campaign(folder))


def _their_campaign(content: bytes, folder: Path) -> None:
    from tp_jax.recordings import load_campaign

    _put(folder, "theirs.txt", corpus.theirs())
    _put(folder, "campaign.toml", content)
    _sound(load_campaign(folder))


def _recording(content: bytes, folder: Path) -> None:
    from tp_jax.recordings import load_campaign

    _sound(load_campaign(_put(folder, "one.csv", content), omega=13.0))


def _metadata(content: Any, folder: Path) -> None:
    from tp_jax.recordings.calibration_error import read_calibration_error

    _put(folder, "run.csv.meta.json", content)
    for error in read_calibration_error(folder / "run.csv").values():
        if not np.isfinite(error.standard_error(np.linspace(-1.0, 1.0, 9))).all():
            raise Wrong("an error is no number")


def _calibration(content: bytes, folder: Path) -> None:
    from tp_jax.acquisition import read_calibration

    for sensor in read_calibration(_put(folder, "rig.toml", content)).sensors.values():
        if not np.isfinite(sensor.values).all():
            raise Wrong("a parameter is no number")


def _readings(content: bytes, folder: Path) -> None:
    from tp_jax.recordings.calibration_run import calibrate

    calibrate([str(_put(folder, "volts.csv", content))])


def _diagnosis(content: Any, folder: Path) -> None:
    from tp_jax.report import summary
    from tp_jax.results.diagnosis import DiagnosisRecord

    summary(DiagnosisRecord.from_json(_put(folder, "diagnosis.json", content)))


_text = _diagnosis


def _starts(content: Any, folder: Path) -> None:
    from tp_jax.estimation.checkpoint import Checkpoint, digest_of
    from tp_jax.estimation.outcome import Outcome
    from tp_jax.schemas.starts import VERSION

    kept = Checkpoint(folder / "starts.json", corpus.starts()["key"])
    if isinstance(content, dict):
        # as if they had been written so
        digests = {"sha256": kept.digest, "done_sha256": digest_of(content.get("done"))}
        content = {"schema": VERSION, **digests, **content}
    _put(folder, "starts.json", content)
    kept.resume()
    for each in kept.done.values():
        Outcome.from_dict(each)


def _part_of_key(content: Any, folder: Path) -> None:
    from tp_jax.schemas.checking import check, read_json
    from trials.schema import CASE

    check(read_json(_put(folder, "key.json", content)), CASE, "key.json")


def _frames(pieces: list[bytes], _: Path) -> None:
    from tp_jax.acquisition.parser import FrameParser
    from tp_jax.acquisition.timeline import Timeline

    parser, timeline = FrameParser(), Timeline(1e-3, 0)
    last = -np.inf
    for piece in pieces:
        found = parser.feed(piece).samples
        _, times = timeline.feed(found["sequence"], found["time"])
        last = _rising(times, last)
        timeline.interrupted()
    _counted(parser.good, parser.corrupt, parser.unknown, timeline)


def _lines(pieces: list[bytes], _: Path) -> None:
    from tp_jax.acquisition.parser import TextParser
    from tp_jax.acquisition.timeline import Timeline

    parser, timeline = TextParser(), Timeline()
    last = -np.inf
    for piece in pieces:
        rows = parser.feed(piece)
        if len(rows):
            last = _rising(timeline.feed_rows(rows)[:, 0], last)
        parser.clear()
    _counted(parser.good, parser.corrupt, 0, timeline)


def _rising(times: np.ndarray, last: float) -> float:
    if not (np.diff(times, prepend=last) > 0.0).all():
        raise Wrong("times do not rise")
    return float(times[-1]) if times.size else last


def _counted(good: int, corrupt: int, unknown: int, timeline) -> None:
    counts = good, corrupt, unknown, timeline.accepted, timeline.lost, timeline.implausible
    if min(counts) < 0:
        raise Wrong(f"a count is negative: {counts}")


def program() -> bytes:
    """A file as `_stored` writes it; its program is none, and must not be asked for."""
    import hashlib

    from tp_jax import _stored

    body = bytes(range(256)) * 4
    return _stored.HEAD + hashlib.sha256(body).digest() + body


def _program(content: bytes, folder: Path) -> None:
    from tp_jax import _stored

    file = _put(folder, "program", content)
    if _stored._kept(file) is not None:
        raise Wrong("a spoiled program is run")
    if file.exists():
        raise Wrong("a spoiled program stays")


def _short(content: Any) -> str:
    text = repr(content)
    return text if len(text) < 160 else f"{text[:80]} ... {len(text)} characters"
