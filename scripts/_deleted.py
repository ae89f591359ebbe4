"""Program of scripts/deleted: rigs whose effect no catalogue has, since it is left out."""

import dataclasses
import os
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from scripts._ledger import add_ledger, entries, extended
from scripts._version import unchanged
from tp_jax.cli.arguments import Parser, count

ROOT = Path(__file__).parent.parent
LEDGER = ROOT / "trials" / "deleted.jsonl"
FOLDER = ROOT / ".cache" / "deleted"
"""Folder of the rigs in hand; each goes when its line is written."""

FAMILY = {
    "bearing_drag": "bearing_dry.v1",
    "bearing_load": "bearing_dry.load",
    "bearing_position": "bearing_dry.phi1",
    "bearing_stribeck": "bearing_dry.v1",
    "bearing_warmup": "bearing_dry.t",
    "column_tilt": "column.phi1",
    "contact_position": "contact_dry.phi2",
    "contact_stribeck": "contact_dry.v2",
    "contact_wear": "contact_dry.t",
    "drive_harmonics": "drive.theta",
    "elastic_stop": "column.phi1",
    "sensor1_eccentricity": "sensor1.phi1",
    "sensor1_nonlinearity": "sensor1.phi1",
    "sensor2_eccentricity": "sensor2.phi2",
    "sensor2_nonlinearity": "sensor2.phi2",
    "spring_asymmetry": "spring.d",
    "spring_deadzone": "spring.d",
    "spring_hardening": "spring.d",
}
"""The law, place and argument, that holds what an effect of the catalogue does. Effects that
remember, or have more periods than a curve of twelve coefficients follows, are not among them."""

SEED = 38

AS_GOOD = 0.95
"""Part of the shrink of the true law from which a learned one counts as good as it."""

HEADS = (
    "rigs",
    "of times detectable",
    "gap seen",
    "place and argument",
    "as good as the true law",
    "explained",
    "harm",
    "CPU s a rig",
)


@dataclasses.dataclass(frozen=True)
class Row:
    """A rig.

    Attributes:
        number: in the study. version: of the package that diagnosed it.
        effect: hidden, and left out of the diagnosis. multiple: of the size that shows just.
        verdict, causes: of the diagnosis. probability: that it states of its first cause.
        shrink, best: on runs that were never given, of the diagnosis and of the true law.
        harm: whether the causes predict those runs worse than nothing does.
        cpu_s: of the diagnosis and the sealed runs [s].
    """

    number: int
    version: str
    effect: str
    multiple: float | None
    verdict: str
    causes: tuple[str, ...]
    probability: float | None
    shrink: float | None
    best: float | None
    harm: bool | None
    cpu_s: float

    @property
    def right(self) -> bool:
        """True if the first cause is the hidden law, or a formula of its place and argument."""
        first = self.causes[0] if self.causes else ""
        return FAMILY.get(first, first) == FAMILY[self.effect]


def main(argv: Sequence[str] | None = None) -> int:
    return carried_out("deleted", _trial, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/deleted",
        description="Diagnoses rigs without the formula of what they hide: does a learned curve "
        "name place and argument, and predict as well as the true law? Resumes.",
    )
    parser.add_argument("--rigs", metavar="N", type=count, default=18, help="default 18")
    # A digest of what a diagnosis computes: rigs of two programs are not one study.
    add_ledger(parser, LEDGER)
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _trial(args: Any) -> int:
    there = {row.number for row in read(Path(args.ledger)) if row.version == args.version}
    tasks = [(n, args.version) for n in range(1, args.rigs + 1) if n not in there]
    _, status = extended("deleted", args, look, tasks)
    rows = [row for row in read(Path(args.ledger)) if row.version == args.version]
    print(f"{table(rows)}\n\n({markdown.circumstances(SEED)})")
    return status


def read(ledger: Path) -> list[Row]:
    """The rigs of a ledger."""
    return [Row(**{**line, "causes": tuple(line["causes"])}) for line in entries(ledger)]


def effects_of(number: int) -> tuple[str, ...]:
    """Effects of a rig, those most wanted first: each comes first once before one does again."""
    turn, place = divmod(number - 1, len(FAMILY))
    first = np.random.default_rng([SEED, turn]).permutation(sorted(FAMILY)).tolist()
    rest = np.random.default_rng([SEED, turn, place]).permutation(sorted(FAMILY)).tolist()
    return (first[place], *(id for id in rest if id != first[place]))


def look(number: int, version: str) -> Row:
    """One rig: made, diagnosed without its effect, and asked on its sealed runs."""
    from scripts._blind.pool import diagnosed
    from trials.case import Case, Settings, make_case

    seed = int(np.random.SeedSequence([SEED, number]).generate_state(1)[0])
    case = Case(f"rig-{number:05d}", "one", seed, effects_of(number))
    root = FOLDER / case.name
    shutil.rmtree(root, ignore_errors=True)  # of a call that was cut off
    root.mkdir(parents=True)
    entry = make_case(root, case, Settings())
    (hidden,) = entry["given"]["effects"]
    begin = time.process_time()
    diagnosis, sealed = diagnosed(root, entry, [hidden])
    spent = round(time.process_time() - begin, 1)
    unchanged(version)
    shutil.rmtree(root)
    causes = diagnosis["causes"]
    harms = [x for x in (sealed["harm_windowed"], sealed["harm_free_run"]) if x is not None]
    return Row(
        number,
        version,
        hidden,
        entry["reference"][hidden]["multiple"],
        diagnosis["verdict"],
        tuple(c["effect"] for c in causes),
        causes[0]["probability"] if causes else None,
        sealed["shrink"],
        sealed["best"],
        any(harms) if harms else None,
        spent,
    )


BANDS = ((0.0, 3.0), (3.0, 10.0), (10.0, np.inf))


def table(rows: Sequence[Row]) -> str:
    """Counts by size of what is hidden, a Markdown table."""

    def share(mine: Sequence[Row], which: Callable[[Row], bool]) -> str:
        return f"{sum(map(which, mine))} of {len(mine)}" if mine else "–"

    def line(low: float, high: float) -> tuple[str, ...]:
        mine = [r for r in rows if low <= (r.multiple or 0.0) < high]
        asked = [r for r in mine if r.best is not None and r.shrink is not None]
        spent = sum(r.cpu_s for r in mine) / max(len(mine), 1)
        return (
            str(len(mine)),
            f"from {low:g}" if high == np.inf else f"{low:g} to {high:g}",
            share(mine, lambda r: r.verdict != "no_gap"),
            share(mine, lambda r: r.right),
            share(asked, lambda r: r.shrink >= AS_GOOD * r.best),
            share(mine, lambda r: r.verdict == "explained"),
            share([r for r in mine if r.harm is not None], lambda r: bool(r.harm)),
            f"{spent:.0f}",
        )

    return markdown.table(HEADS, [line(*band) for band in (*BANDS, (0.0, np.inf))])


if __name__ == "__main__":
    os.environ.setdefault("EQX_ON_ERROR", "nan")  # see tp_jax._config
    sys.exit(main())
