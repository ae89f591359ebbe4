"""Program of scripts/guard: rigs whose diagnoses a change must not alter unseen."""

import dataclasses
import json
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from scripts._version import DIGITS, computed
from tp_jax.cli.arguments import Parser, add_executor, executor_of, positive
from tp_jax.errors import InputError
from tp_jax.executors import ExecutorChoice, Piece, run_pieces

ROOT = Path(__file__).parent.parent
KEPT = ROOT / "trials" / "guard.json"
FOLDER = ROOT / ".cache" / "guard"

SEED = 34
"""Seed of both trials. No other study may use it; no choice of the diagnosis is scored on them."""

RIGS = {"clean": 12, "rough": 12}
"""Rigs of each kind."""

SHARED = ROOT.parent / "shared"
BESIDE = ("examples", "data/rough", "data/furuta", "data/multiarm", "data/pohl_wheel")
"""Campaigns that may lie beside the repository: of another simulator, and of real rigs. They are
looked at too where they are there."""

SAME_SHRINK = 0.01
"""A shrink is as it was within this."""

HEADS = ("rig", "hidden", "verdict", "causes", "shrink", "CPU s")


@dataclasses.dataclass(frozen=True)
class Row:
    """A rig's answer.

    Attributes:
        hidden: ids of its effects; known, since the guard is for development.
        verdict, causes, shrink: of the diagnosis.
        cpu_s: of its process, with what had to be compiled or loaded [s].
    """

    hidden: tuple[str, ...]
    verdict: str
    causes: tuple[str, ...]
    shrink: float | None
    cpu_s: float

    @classmethod
    def read(cls, entry: Mapping[str, Any]) -> "Row":
        """Reads a row from its JSON."""
        lists = {name: tuple(entry[name]) for name in ("hidden", "causes")}
        return cls(**{**entry, **lists})

    def differs(self, other: "Row") -> bool:
        """True if verdict, causes or shrink differ."""
        mine, theirs = self.shrink, other.shrink
        if (self.verdict, self.causes) != (other.verdict, other.causes):
            return True
        if mine is None or theirs is None:
            return mine is not theirs
        return abs(mine - theirs) > SAME_SHRINK


def main(argv: Sequence[str] | None = None) -> int:
    return carried_out("guard", _guard, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/guard",
        description="Diagnoses 24 rigs, and the campaigns beside the repository, and compares "
        "with what is kept of them. Resumes.",
    )
    parser.add_argument(
        "--name",
        help="of this version; what it has diagnosed already is not done again (default: a digest "
        "of what the package computes)",
    )
    parser.add_argument("--afresh", action="store_true", help="forget what this name has diagnosed")
    parser.add_argument(
        "--against", metavar="NAME", help="compare with this version instead of trials/guard.json"
    )
    parser.add_argument(
        "--folder",
        metavar="DIR",
        default=str(FOLDER),
        help="of the rigs and their diagnoses (default .cache/guard)",
    )
    add_executor(parser)
    parser.add_argument(
        "--limit-s",
        metavar="S",
        type=positive,
        default=float("inf"),
        help="begin no rig after so many seconds",
    )
    parser.add_argument(
        "--made-only",
        action="store_true",
        help="leave out the campaigns that lie beside the repository",
    )
    parser.add_argument(
        "--keep", action="store_true", help="write trials/guard.json from what was found"
    )
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _guard(args: Any) -> int:
    from tp_jax.cli.output import write_json

    folder = Path(args.folder)
    made = _made(folder, executor_of(args))
    rigs = {name: (folder / name.replace("-", "/", 1), hidden) for name, hidden in made.items()}
    beside = {} if args.made_only else _beside()
    rows = folder / (args.name or computed()[:DIGITS])
    if args.afresh:
        for file in rows.glob("*.json"):
            file.unlink()
    rows.mkdir(parents=True, exist_ok=True)
    # rough ones by turns with clean ones, so that a part of the guard is a fair part
    order = [name for pair in zip(*_by_kind(made), strict=True) for name in pair]
    rigs |= beside
    tasks = [(rows / f"{name}.json", *rigs[name]) for name in [*order, *beside]]
    left = [task for task in tasks if not task[0].is_file()]
    status = 0
    until = time.monotonic() + args.limit_s
    pieces = [Piece(task[0].stem, task) for task in left]  # each writes its own result
    for ended in run_pieces(_diagnose, pieces, executor_of(args), until=until):
        told = "is done" if ended.fault is None else f"failed: {ended.fault}"
        print(f"guard: {ended.piece.key} {told}", file=sys.stderr)
        status = status if ended.fault is None else 1
    # a folder of rows may hold those of other calls, of campaigns that are not asked for now
    found = {name: row for name, row in _read_all(rows).items() if name in rigs}
    other = _kept() if args.against is None else _read_all(folder / args.against)
    print(_table(found, other, len(rigs)))
    if args.keep:
        if status or len(found) < len(rigs):
            raise InputError("Not all rigs are diagnosed: the same call goes on, then --keep.")
        KEPT.parent.mkdir(exist_ok=True)
        write_json(KEPT, {name: dataclasses.asdict(row) for name, row in found.items()})
        return 0  # what changed is what is kept from now on
    changed = [name for name, row in found.items() if name in other and row.differs(other[name])]
    return status or (1 if changed else 0)


def _beside() -> dict[str, tuple[Path, tuple[str, ...]]]:
    """Folders of the campaigns beside the repository by name; what is hidden there is not told."""
    roots = [SHARED / name for name in BESIDE]
    places = [file.parent for root in roots for file in sorted(root.rglob("campaign.toml"))]
    names = ["-".join(place.relative_to(SHARED).parts[1:]) for place in places]
    return {name: (place, ()) for name, place in zip(names, places, strict=True)}


def _made(folder: Path, executor: ExecutorChoice) -> dict[str, tuple[str, ...]]:
    """Names of the rigs and what is hidden in each; made where they are not there."""
    from trials import make
    from trials.seal import KEY

    out = {}
    for kind, cases in RIGS.items():
        if not (folder / kind / KEY).is_file():
            folder.mkdir(parents=True, exist_ok=True)
            make(folder / kind, cases, SEED, rigs=kind, executor=executor)
        key = json.loads((folder / kind / KEY).read_text(encoding="utf-8"))
        for entry in key["cases"]:
            out[f"{kind}-{entry['case']}"] = tuple(entry["given"]["effects"])
    return out


def _by_kind(rigs: Mapping[str, Any]) -> list[list[str]]:
    return [[name for name in rigs if name.startswith(f"{kind}-")] for kind in RIGS]


def _diagnose(target: Path, folder: Path, hidden: tuple[str, ...]) -> None:
    import tp_jax as tp
    from tp_jax.cli.output import write_json

    begin = time.process_time()
    diagnosis = tp.diagnose(tp.load_campaign(folder))
    found = diagnosis.to_dict()
    row = Row(
        hidden,
        found["verdict"],
        tuple(c["effect"] for c in found["causes"]),
        found["gap"]["shrink"],
        time.process_time() - begin,
    )
    write_json(target, dataclasses.asdict(row))


def _kept() -> dict[str, Row]:
    if not KEPT.is_file():
        return {}
    entries = json.loads(KEPT.read_text(encoding="utf-8"))
    return {name: Row.read(entry) for name, entry in entries.items()}


def _read_all(rows: Path) -> dict[str, Row]:
    files = sorted(rows.glob("*.json"))
    return {f.stem: Row.read(json.loads(f.read_text(encoding="utf-8"))) for f in files}


def _table(found: Mapping[str, Row], other: Mapping[str, Row], of: int) -> str:
    """Each rig, what has changed as `then → now`, and the sums."""

    def both(name: str, cell) -> str:
        now = cell(found[name])
        then = cell(other[name]) if name in other else now
        return now if then == now else f"{then} → {now}"

    def shrink(row: Row) -> str:
        return "–" if row.shrink is None else f"{row.shrink:.3f}"

    lines = [
        (
            name,
            ", ".join(row.hidden) or "–",
            both(name, lambda r: r.verdict),
            both(name, lambda r: ", ".join(r.causes) or "–"),
            both(name, shrink),
            both(name, lambda r: f"{r.cpu_s:.0f}"),
        )
        for name, row in found.items()
    ]
    shared = [name for name in found if name in other]
    same = sum(not found[name].differs(other[name]) for name in shared)
    parts = [f"{len(found)} of {of} rigs; {same} of {len(shared)} as before."]
    if shared:
        now, then = (sum(rows[name].cpu_s for name in shared) for rows in (found, other))
        parts.append(f"CPU {then:.0f} → {now:.0f} s ({now / then:.2f} times).")
    return "\n".join([markdown.table(HEADS, lines), "", " ".join(parts)])


if __name__ == "__main__":
    sys.exit(main())
