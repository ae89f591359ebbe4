"""Program of scripts/nulls: false alarms under many kinds of noise, and a weak drag in decays."""

import dataclasses
import os
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from scripts._ledger import add_ledger, entries, extended
from scripts._version import unchanged
from tp_jax.cli.arguments import Parser, count

ROOT = Path(__file__).parent.parent
LEDGER = ROOT / "trials" / "nulls.jsonl"

RATES = {"two-rates": (250.0, 2000.0, 250.0, 2000.0), "coarse": (100.0,) * 4}
"""Samples a second of the four runs [Hz]; of other kinds 250."""

TESTED = ("slow", "coarse", "anticorrelated", "two-rates", "clean", "rough", "measured")
"""Kinds of which the tests alone are asked, as a diagnosis begins; nothing is searched for."""

DRAGS = {"decay": 0.0, "decay-drag": 0.003, "decay-drag-strong": 0.05}
"""Kinds that are diagnosed from end to end: quadratic drag by the column's inertia."""

HEADS = ("kind", "rigs", "alarms", "p < .05", "p < .001", "named", "noise", "CPU s a rig")


@dataclasses.dataclass(frozen=True)
class Row:
    """A rig.

    Attributes:
        kind, seed: which it is. version: of the package that looked.
        p: of the structure test. alarm: whether p, or a test that asks for no effect, finds
            anything; of a diagnosis whether its verdict is not `no_gap`.
        causes: named by a diagnosis.
        noise: estimated noise of the first channel of the first run [rad].
        cpu_s: of the look [s].
    """

    kind: str
    seed: int
    version: str
    p: float
    alarm: bool
    causes: tuple[str, ...]
    noise: float
    cpu_s: float


def main(argv: Sequence[str] | None = None) -> int:
    return carried_out("nulls", _nulls, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/nulls",
        description="False alarms under many kinds of noise, and a weak drag in decays. Resumes.",
    )
    parser.add_argument(
        "--kinds", metavar="K,…", default=",".join((*TESTED, *DRAGS)), help="some of %(default)s"
    )
    parser.add_argument(
        "--seeds", metavar="N", type=count, default=30, help="rigs of each kind (default 30)"
    )
    add_ledger(parser, LEDGER)
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _nulls(args: Any) -> int:
    kinds = args.kinds.split(",")
    there = [row for row in read(Path(args.ledger)) if row.version == args.version]
    known = {(row.kind, row.seed) for row in there}
    # one of each kind by turns, so that a part of the study is a fair part
    tasks = [(k, s, args.version) for s in range(1, args.seeds + 1) for k in kinds]
    left = [task for task in tasks if task[:2] not in known]
    found, status = extended("nulls", args, look, left)
    there += found
    print(table([row for row in there if row.kind in kinds]))
    return status


def read(ledger: Path) -> list[Row]:
    """All whole lines of a ledger."""
    return [Row(**{**entry, "causes": tuple(entry["causes"])}) for entry in entries(ledger)]


def look(kind: str, seed: int, version: str) -> Row:
    """One rig."""
    unchanged(version)
    begin = time.process_time()
    found = _diagnosed(kind, seed) if kind in DRAGS else _tested(kind, seed)
    return Row(kind, seed, version, **found, cpu_s=round(time.process_time() - begin, 1))


def _tested(kind: str, seed: int) -> dict[str, Any]:
    """The tests that a diagnosis makes of its baseline."""
    from tp_jax.estimation.drive_errors import with_drives_of_angles
    from tp_jax.estimation.prepared_campaign import prepare_campaign
    from tp_jax.estimation.schedule import fit_over_schedule
    from tp_jax.estimation.sharpen import fit_with_sharp_friction
    from tp_jax.estimation.start import initial_values
    from tp_jax.gap.known_noise import with_noise_of
    from tp_jax.gap.misfit import misfits
    from tp_jax.gap.policy import POLICY
    from tp_jax.gap.screen import screen
    from tp_jax.gap.structure import structure_test

    setting = prepare_campaign(_campaign(kind, seed))
    fit = fit_over_schedule(setting, initial_values(setting), setting.unknowns())
    setting, fit = with_drives_of_angles(setting, fit)
    setting, fit = with_noise_of(setting, fit, fit)
    fit = fit_with_sharp_friction(setting, fit)
    p = structure_test(screen(fit, setting, states=False), seed=0).p
    alarm = p < POLICY.structure.seen or misfits(setting, fit)
    return {"p": p, "alarm": bool(alarm), "causes": (), "noise": float(setting.levels[0, 0])}


def _diagnosed(kind: str, seed: int) -> dict[str, Any]:
    """A whole diagnosis."""
    import tp_jax as tp
    from tests.gap.test_decays import campaign

    d = tp.diagnose(campaign(DRAGS[kind], seed)).to_dict()
    return {
        "p": d["gap"]["structure_p"],
        "alarm": d["verdict"] != "no_gap",
        "causes": tuple(c["effect"] for c in d["causes"]),
        "noise": d["noise_floor"]["phi1"],
    }


def _campaign(kind: str, seed: int) -> Any:
    from tests import noisy
    from tp_jax.recordings import hold_out, load_campaign

    if kind not in ("clean", "rough", "measured"):
        noise = {"two-rates": noisy.white}.get(kind) or getattr(noisy, kind)
        return noisy.campaign(noise, seed, RATES.get(kind, (250.0,) * 4))
    from trials.case import Settings, make_case
    from trials.plan import Case
    from trials.rough import RoughSettings

    with tempfile.TemporaryDirectory() as folder:
        driven = {"measured": 1.0, "decays_only": 0.0} if kind == "measured" else {}
        settings = Settings() if kind == "clean" else RoughSettings(**driven)
        make_case(Path(folder), Case("case", "none", seed, ()), settings)
        return hold_out(load_campaign(Path(folder) / "case"))


def table(rows: Sequence[Row]) -> str:
    """Tabulates by kind: alarms, small p, how often bearing_drag is named, noise, time."""

    def line(kind: str, mine: list[Row]) -> tuple[str, ...]:
        def share(which: Callable[[Row], bool]) -> str:
            return f"{sum(map(which, mine))} of {len(mine)}"

        noise = [1e3 * row.noise for row in mine]
        named = share(lambda row: "bearing_drag" in row.causes) if kind in DRAGS else "–"
        return (
            kind,
            str(len(mine)),
            share(lambda row: row.alarm),
            share(lambda row: row.p < 0.05),
            share(lambda row: row.p < 0.001),
            named,
            f"{min(noise):.2f} to {max(noise):.2f} mrad",
            f"{sum(row.cpu_s for row in mine) / len(mine):.0f}",
        )

    kinds = dict.fromkeys(row.kind for row in rows)
    return markdown.table(HEADS, [line(k, [row for row in rows if row.kind == k]) for k in kinds])


if __name__ == "__main__":
    sys.exit(main())
