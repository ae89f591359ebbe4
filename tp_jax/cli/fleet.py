"""tp-jax diagnose of several campaigns: each in a folder of its own, one table, one page."""

import argparse
import functools
import hashlib
import os
import re
import sys
import time
import tomllib
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from tp_jax._files import bytes_of
from tp_jax._version import __version__
from tp_jax.cli.arguments import executor_of, load
from tp_jax.cli.diagnosed import FITS, REPORT, RESULT, SCREEN, default_folder, diagnosed
from tp_jax.cli.output import as_text, forget, made_folder, ready, write_json, write_text
from tp_jax.errors import InputError, Notice
from tp_jax.executors import Ended, Piece, done_before, forget_pieces, run_pieces
from tp_jax.executors.pieces import FOLDER as PIECES
from tp_jax.executors.slurm_jobs import LOGS
from tp_jax.schemas.recording import metadata_path

TABLE, CSV, PARQUET, PAGE = "fleet.json", "fleet.csv", "fleet.parquet", "fleet.html"

NAME = "fleet"
"""Name of a fleet whose campaigns are named one by one; that of a folder bears its name."""

LONGEST_NAME = 100
"""Characters of a rig's name, which names a folder and a file."""


@dataclass(frozen=True)
class Rig:
    """A campaign of the fleet, and all that its diagnosis needs.

    Attributes:
        name: in the fleet. campaign: its folder or file. folder: gets its diagnosis.
        omega, decay: of a single file. seed, tolerance, figures, without: as of one diagnosis.
    """

    name: str
    campaign: Path
    folder: Path
    omega: float | None = None
    decay: bool = False
    seed: int = 0
    tolerance: float = 0.0
    figures: bool = False
    without: tuple[str, ...] = ()


def campaigns_of(given: Sequence[str]) -> list[Path] | None:
    """The campaigns of a fleet in order, each once; None where one campaign is meant.

    A folder without a campaign.toml stands for the campaigns in it.
    """
    if len(given) < 2 and not any(map(_inside, given)):
        return None
    found: dict[str, Path] = {}
    for each in given:
        for campaign in _inside(each) or [Path(each)]:
            found.setdefault(os.path.abspath(campaign), campaign)
    return list(found.values())


def _inside(folder: str) -> list[Path]:
    """The campaigns in a folder that is none itself."""
    if not os.path.isdir(folder) or os.path.isfile(os.path.join(folder, "campaign.toml")):
        return []
    return sorted(file.parent for file in Path(folder).glob("*/campaign.toml"))


def fleet_name(given: Sequence[str]) -> str:
    """Names a fleet by the folder that holds the campaigns, if one was given."""
    return as_text(Path(os.path.abspath(given[0])).name) or NAME if len(given) == 1 else NAME


def names_of(campaigns: Sequence[Path]) -> list[str]:
    """A name for each, of its folder or file, that no other has and that can name a folder."""
    taken = {PIECES, LOGS}
    names = []
    for campaign in campaigns:
        path = Path(os.path.abspath(campaign))
        path = path.parent if path.name == "campaign.toml" else path
        plain = re.sub(r"[^\w+=-]+", "-", path.name if os.path.isdir(path) else path.stem)
        first = plain.strip("-")[:LONGEST_NAME] or "rig"
        name, number = first, 1
        while name.lower() in taken:  # some file systems do not tell A from a
            number += 1
            name = f"{first}-{number}"
        taken.add(name.lower())
        names.append(name)
    return names


def diagnose_rig(rig: Rig) -> dict[str, Any]:
    """Diagnoses a rig into its folder, in a worker; returns its row.

    Where fits are there, of a worker that died or of a fleet that was broken off, it goes on from
    them.
    """
    from tp_jax.cli.progress import silent
    from tp_jax.report.fleet.rows import row

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", Notice)
        asked = argparse.Namespace(omega=rig.omega, decay=rig.decay)
        campaign = load(asked, rig.campaign)
        kept = rig.folder / FITS
        goes_on = functools.partial(
            diagnosed,
            campaign,
            rig.folder,
            seed=rig.seed,
            tolerance=rig.tolerance,
            without=rig.without,
            figures=rig.figures,
            progress=silent,
            screen=True,
        )
        resume = kept.is_file()
        try:
            result = goes_on(resume=resume)
        except InputError:
            # Nothing leads on from there: the fits may be of other data, settings or program.
            forget(kept)
            if not resume:
                raise
            result = goes_on(resume=False)
    notices = [
        " ".join(str(each.message).split()) for each in said if issubclass(each.category, Notice)
    ]
    return {
        **row(rig.name, result, f"{rig.folder.name}/{REPORT}"),
        "notices": " ".join(notices) or None,
    }


WORK = diagnose_rig
"""Work that is done on a rig; tests put something quicker here."""


def run(args: argparse.Namespace, campaigns: Sequence[Path]) -> int:
    """Diagnoses a fleet; the exit code: 0, or of the worst that befell a rig."""
    name = fleet_name(args.campaign)
    folder = default_folder(name) if args.out is None else Path(args.out)
    ready(folder / TABLE, args.json)
    rigs = [
        Rig(
            each,
            campaign.absolute(),
            (folder / each).absolute(),
            args.omega,
            args.decay,
            args.seed,
            args.tolerance,
            args.figures,
            tuple(args.without),
        )
        for each, campaign in zip(names_of(campaigns), campaigns, strict=True)
    ]
    pieces = [Piece(rig.name, (rig,), _of(rig)) for rig in rigs]
    gone = [p for p, rig in zip(pieces, rigs, strict=True) if not (rig.folder / RESULT).is_file()]
    forget_pieces(folder, gone)  # a row whose diagnosis was taken away leads nowhere
    if not args.resume:
        forget_pieces(folder, pieces)
        for rig in rigs:
            (rig.folder / FITS).unlink(missing_ok=True)
    elif args.shared:  # a rig that was diagnosed before there were scores is diagnosed anew
        bare = zip(rigs, pieces, strict=True)
        forget_pieces(folder, [p for rig, p in bare if not (rig.folder / SCREEN).is_file()])
    begin = time.perf_counter()
    ended = _ended(args, folder, pieces)
    rows = [_row(each) for each in ended]
    seconds = time.perf_counter() - begin

    from tp_jax.report.fleet import files, page, text
    from tp_jax.report.fleet.rows import FAILED, SCHEMA, counts, in_order

    rows = in_order(rows)
    known = counts(rows)
    shared = _shared(rigs, rows, args.seed) if args.shared else None
    result = {
        "schema": SCHEMA,
        "fleet": name,
        "rigs": rows,
        "verdicts": known,
        **({} if shared is None else {"shared": shared}),
        "provenance": {"version": __version__, "seed": args.seed, "wall_s": round(seconds, 2)},
    }
    write_json(folder / TABLE, result)
    write_text(folder / CSV, files.csv_text(rows))
    files.write_parquet(rows, folder / PARQUET)
    write_text(folder / PAGE, page.render(rows, name, day=date.today(), shared=shared))
    if args.json is not None:
        write_json(args.json, result)
    if args.json != "-" and not args.quiet:
        print(text.summary(rows, shared))
        print(f"\nFleet: {folder / PAGE}")
    failures = known[FAILED]
    if failures:
        rigs = f"{failures} of {len(rows)} rigs" if len(rows) > 1 else "The rig"
        print(f"tp-jax: {rigs} could not be diagnosed; {folder / TABLE} says why.", file=sys.stderr)
    return _status(ended)


def _shared(rigs: Sequence[Rig], rows: Sequence[Mapping[str, Any]], seed: int) -> dict[str, Any]:
    """Finds what the rigs share, from the scores that their diagnoses left."""
    from tp_jax.gap.shared.scores import read
    from tp_jax.gap.shared.table import shared_table
    from tp_jax.report.fleet.rows import FAILED

    failed = {row["rig"] for row in rows if row["verdict"] == FAILED}
    found = {rig.name: None if rig.name in failed else read(rig.folder / SCREEN) for rig in rigs}
    scores = [each for each in found.values() if each is not None]
    return shared_table(scores, [name for name, each in found.items() if each is None], seed)


def _ended(args: argparse.Namespace, folder: Path, pieces: Sequence[Piece]) -> list[Ended]:
    """All rigs, as they ended; progress is reported over all of them."""
    from tp_jax.cli.progress import shown

    made_folder(folder)
    found: list[Ended] = []
    with shown(quiet=args.quiet, form=args.progress) as progress:

        def tell(done: int) -> None:
            progress(f"diagnosing rigs: {done} of {len(pieces)}", done / len(pieces))

        tell(len(done_before(folder, pieces)))  # which come first, and took no time
        try:
            for ended in run_pieces(WORK, pieces, executor_of(args), folder=folder):
                found.append(ended)
                if not ended.kept:
                    tell(len(found))
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"Interrupted; what is done is kept in {folder}, and the same command with "
                "--resume goes on."
            ) from None
    return found


def _row(ended: Ended) -> dict[str, Any]:
    from tp_jax.report.fleet.rows import failed

    row = ended.result if ended.fault is None else failed(ended.piece.key, _sentence(ended))
    return {name: as_text(each) if isinstance(each, str) else each for name, each in row.items()}


def _sentence(ended: Ended) -> str:
    """Puts a fault in a sentence, as `faults.explain` does."""
    fault = ended.fault
    assert fault is not None
    if fault.of_input:
        return fault.text
    said = str(fault).rstrip(".: ")
    return f"A fault of ours, {said}; diagnose this rig alone with --debug for the traceback."


def _status(ended: Sequence[Ended]) -> int:
    """2 where the input of a rig is to be mended, 1 where a fault is ours, which goes before."""
    faults = [each.fault for each in ended if each.fault is not None]
    if not faults:
        return 0
    return 2 if all(fault.of_input for fault in faults) else 1


def _of(rig: Rig) -> str:
    """Digest of all that goes into a rig's row: a row of other data or settings is not taken."""
    options = (
        __version__,
        rig.omega,
        rig.decay,
        rig.seed,
        rig.tolerance,
        rig.figures,
        rig.without,
    )
    digest = hashlib.sha256(repr(options).encode())
    toml = rig.campaign / "campaign.toml" if os.path.isdir(rig.campaign) else rig.campaign
    files = [toml]
    for file in _listed(toml):
        beside = metadata_path(file)  # its sensors' calibration, and when it was started
        files += [file, beside] if beside.exists() else [file]
    if toml.suffix.lower() != ".toml" and metadata_path(toml).exists():  # of a single file
        files.append(metadata_path(toml))
    for file in files:
        digest.update(os.fsencode(file.name) + b"\0")
        try:
            digest.update(hashlib.sha256(bytes_of(file)).digest())
        except (OSError, ValueError):
            digest.update(b"cannot be read")  # its diagnosis says so
    return digest.hexdigest()


def _listed(toml: Path) -> list[Path]:
    """The recordings that a campaign.toml lists; none where it cannot be read."""
    if toml.suffix.lower() != ".toml":
        return []
    try:
        top = tomllib.loads(bytes_of(toml).decode("utf-8-sig"))
        return [toml.parent / str(each["file"]) for each in top["recording"]]
    except (OSError, ValueError, LookupError, TypeError):
        return []
