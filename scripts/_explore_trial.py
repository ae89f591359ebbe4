"""Program of scripts/explore_trial: explorations beside fixed sweeps, on the same virtual rigs."""

import dataclasses
import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

import numpy as np

from scripts import _markdown as markdown
from scripts._carried_out import carried_out
from scripts._ledger import add_ledger, entries, extended
from scripts._version import APART, DIGITS, computed, unchanged
from tp_jax.acquisition import Port, Settings, protocol, record
from tp_jax.acquisition.campaign_entry import append_entry, entries_of, free_name
from tp_jax.cli.arguments import Parser, count
from tp_jax.rig import RigParameters, VirtualRig
from tp_jax.rig.effects import catalogue
from tp_jax.rig.emulator import Firmware
from tp_jax.rig.serve import Emulator

ROOT = Path(__file__).parent.parent
LEDGER = ROOT / "trials" / "explore.jsonl"

SWEEP = 6
"""Runs of the fixed sweep, a decay and drives about the resonance, as in the sealed trials."""

LEAST, MOST = 1.0, 2.0
"""Times the size that the sweep just detects, uniform in the logarithm."""

LIMIT = 3.0  # rad; springs of this kind go no further
DURATION, RATE, NOISE = 10.0, 250.0, 1e-3  # s, Hz, rad, as in the sealed trials
PACE = 0.02  # s between looks at a motion

WINDOWS = 2
"""Windows of a run that the stand-in looks at: fewer than for the size, since it looks often."""

STAND_IN, REAL = "stand-in", "real"

ELSEWHERE = tuple(room for room in APART if room != "exploring")
"""Rooms in which nothing of this study is made: other than a diagnosis, it goes by `exploring`."""

HEADS = ("diagnosis", "rigs", "named by explore", "runs", "named by the sweep", "runs", "fewer")


@dataclasses.dataclass(frozen=True)
class Row:
    """A rig.

    Attributes:
        seed: which it is. diagnosis: stand-in or real. version: of the package that looked.
        effect, multiple: hidden, and its size over the detectable one.
        explored, swept: the first cause after each run, or None. stopped: why explore ended.
        cpu_s: of both [s].
    """

    seed: int
    diagnosis: str
    version: str
    effect: str
    multiple: float
    explored: tuple[str | None, ...]
    swept: tuple[str | None, ...]
    stopped: str
    cpu_s: float


@dataclasses.dataclass(frozen=True)
class Hidden:
    """A rig with its secret, and the runs of its sweep."""

    seed: int
    parameters: RigParameters
    effect: str
    sizes: tuple[float, ...]
    shapes: dict[str, float]
    multiple: float
    plan: tuple[dict[str, float], ...]


def main(argv: Sequence[str] | None = None) -> int:
    return carried_out("explore_trial", _trial, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/explore_trial",
        description="Runs that explore needs until the right cause is named first, beside a fixed "
        "sweep of six. Resumes.",
    )
    parser.add_argument("--rigs", metavar="N", type=count, default=20, help="default 20")
    parser.add_argument(
        "--diagnosis",
        choices=(STAND_IN, REAL),
        default=STAND_IN,
        help="the stand-in (default) knows the secret and tells it once "
        "the runs show it; the real one takes many minutes a rig",
    )
    add_ledger(parser, LEDGER, computed(apart=ELSEWHERE)[:DIGITS])
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _trial(args: Any) -> int:
    there = [
        r
        for r in read(Path(args.ledger))
        if (r.version, r.diagnosis) == (args.version, args.diagnosis)
    ]
    known = {row.seed for row in there}
    seeds = range(1, args.rigs + 1)
    left = [(seed, args.diagnosis, args.version) for seed in seeds if seed not in known]
    found, status = extended("explore_trial", args, look, left)
    there += found
    print(table([row for row in there if row.seed in seeds]))
    return status


def read(ledger: Path) -> list[Row]:
    """All whole lines of a ledger."""
    lists = ("explored", "swept")
    return [Row(**{**e, **{name: tuple(e[name]) for name in lists}}) for e in entries(ledger)]


def look(seed: int, diagnosis: str, version: str) -> Row:
    """One rig."""
    unchanged(version, apart=ELSEWHERE)
    from tp_jax.exploring import explore
    from tp_jax.gap.next_run import Limits, Run

    begin = time.process_time()
    hidden = hide(seed)
    limits, stopped = Limits(LIMIT), ""
    firsts: dict[str, list[str | None]] = {"explore": [], "sweep": []}
    with tempfile.TemporaryDirectory() as place:
        for way, found in firsts.items():
            folder = Path(place) / way
            rig = VirtualRig(hidden.parameters, {hidden.effect: hidden.sizes}, seed, hidden.shapes)
            firmware = Firmware(rig, rate=RATE, noise=NOISE, seed=seed)
            diagnose = (StandIn if diagnosis == STAND_IN else Real)(hidden, limits)
            with Emulator(firmware, speed=None) as emulator:
                port = emulator.port

                def recorded(run: Run, out: Path, port: str = port) -> Any:
                    settings = Settings(DURATION, run.omega, None, run.release, real_time=False)
                    return record(Port(port, protocol.BAUD), out, settings)

                if way == "explore":
                    ended = explore(
                        folder, recorded, diagnose, limits=limits, most=SWEEP, duration=DURATION
                    )
                    found += [made.first for made in ended.runs]
                    stopped = ended.stop.reason
                else:
                    folder.mkdir()
                    for each in hidden.plan:
                        run = Run(each.get("omega"), each.get("release"))
                        append_entry(folder, recorded(run, free_name(folder, run.omega)))
                        found.append(diagnose(folder).first)
    spent = round(time.process_time() - begin, 1)
    return Row(
        seed,
        diagnosis,
        version,
        hidden.effect,
        round(hidden.multiple, 3),
        tuple(firsts["explore"]),
        tuple(firsts["sweep"]),
        stopped,
        spent,
    )


def hide(seed: int) -> Hidden:
    """A rig with one effect of the catalogue that its sweep shows, one to two times detectable."""
    from trials.detectable import minimum_detectable
    from trials.draw import applies, draw_rig, largest

    rng = np.random.default_rng([seed, 0xE7])
    parameters, own, plan = draw_rig(rng, SWEEP, DURATION)
    bench = _bench(parameters, plan, own)
    ids = [
        id
        for id, e in catalogue().items()
        if e.in_catalogue and not e.per_run and applies(id, False)
    ]
    for id in rng.permutation(ids).tolist():
        draw = catalogue()[id].draw(rng, parameters)
        factor = minimum_detectable(bench, id, draw.sizes, draw.shapes)
        multiple = LEAST * math.exp(math.log(MOST / LEAST) * rng.random())
        if multiple * factor > largest(id, draw.sizes):
            continue  # it would be implausibly large: another one
        sizes = tuple(multiple * factor * x for x in draw.sizes)
        return Hidden(seed, parameters, id, sizes, dict(draw.shapes), multiple, tuple(plan))
    raise RuntimeError(f"No effect shows on rig {seed}.")


def _bench(parameters: RigParameters, plan: Sequence[dict[str, float]], seed: int) -> Any:
    from trials.projection import Bench

    return Bench(parameters, plan, duration=DURATION, rate=RATE, noise=NOISE, seed=seed)


class StandIn:
    """A diagnosis that knows the secret, and says it as surely as the runs made show it.

    The evidence is half of what only the effect explains of them (`trials.projection`), less
    what the best of the catalogue's effects shows by chance; a run is forecast to add its part.
    """

    def __init__(self, hidden: Hidden, limits: Any) -> None:
        self.hidden, self.limits = hidden, limits

    def __call__(self, folder: Path) -> Any:
        from tp_jax.gap.next_run import NOTHING, Finding, Forecast, Run, runs_to_compare

        p = self.hidden.parameters
        made = []
        for entry in entries_of(folder):
            meta = json.loads(Path(f"{entry.file}.meta.json").read_text())
            made.append(Run(entry.omega, meta["drive"]["release"]))
        known = self.shown(made)
        evidence = known - math.log(len(catalogue()))
        probability = 1.0 / (1.0 + math.exp(-max(min(evidence, 30.0), -30.0)))
        first = self.hidden.effect if probability > 0.5 else None
        natural = math.sqrt(p.k / (p.B1 + p.B2))
        forecasts = tuple(
            Forecast(run, self.largest(run), {NOTHING: max(self.shown([*made, run]) - known, 0.0)})
            for run in runs_to_compare(natural, self.limits)
        )
        causes = ((first, probability),) if first else ()
        rivals = {NOTHING: 1.0 - probability}
        return Finding("unknown", causes, first, probability, rivals, forecasts)

    def shown(self, made: Sequence[Any]) -> float:
        """Expected log evidence of some runs [nat]."""
        from trials.projection import noncentralities

        h = self.hidden
        plan = [
            {"release": run.release} if run.omega is None else {"omega": run.omega} for run in made
        ]
        bench = dataclasses.replace(_bench(h.parameters, plan, h.seed), per_run=WINDOWS)
        return 0.5 * float(noncentralities(bench, h.effect, h.sizes, h.shapes)[0].sum())

    def largest(self, run: Any) -> float:
        """Largest angle of both bodies [rad], without the secret."""
        rig = VirtualRig(self.hidden.parameters)
        rig.start(omega=run.omega, release=run.release, duration=DURATION)
        return max(
            abs(x) for t in np.arange(PACE, DURATION, PACE).tolist() for x in rig.motion(t)[:2]
        )


class Real:
    """The diagnosis of the package."""

    def __init__(self, hidden: Hidden, limits: Any) -> None:
        self.hidden, self.limits = hidden, limits

    def __call__(self, folder: Path) -> Any:
        from tp_jax.exploring.amplitudes import announced_amplitude
        from tp_jax.gap.diagnosis import examine
        from tp_jax.gap.forecast import outlook
        from tp_jax.recordings import load_campaign

        examination = examine(load_campaign(folder), seed=0)
        return outlook(examination, self.limits, DURATION, announced_amplitude(folder))


def needed(firsts: Sequence[str | None], effect: str) -> int | None:
    """Runs after which the right cause is named first, and stays so; None: it is not in the end."""
    if not firsts or firsts[-1] != effect:
        return None
    return max((n + 1 for n, first in enumerate(firsts) if first != effect), default=0) + 1


def table(rows: Sequence[Row]) -> str:
    """Rigs on which either way names the cause, mean runs where both do, and where explore wins."""

    def line(kind: str, mine: list[Row]) -> tuple[str, ...]:
        pairs = [(needed(r.explored, r.effect), needed(r.swept, r.effect)) for r in mine]
        both = [(a, b) for a, b in pairs if a is not None and b is not None]

        def mean(which: int) -> str:
            return f"{np.mean([pair[which] for pair in both]):.2f}" if both else "–"

        return (
            kind,
            str(len(mine)),
            f"{sum(a is not None for a, _ in pairs)}",
            mean(0),
            f"{sum(b is not None for _, b in pairs)}",
            mean(1),
            f"{sum(a < b for a, b in both)} of {len(both)}",
        )

    kinds = dict.fromkeys(row.diagnosis for row in rows)
    return markdown.table(HEADS, [line(k, [r for r in rows if r.diagnosis == k]) for k in kinds])


if __name__ == "__main__":
    sys.exit(main())
