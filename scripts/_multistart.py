"""Program of scripts/multistart: many starts on virtual rigs, and what they find."""

import dataclasses
import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

from scripts._carried_out import carried_out
from scripts._coverage.pool import mend, read
from scripts._coverage.rig import PROFILED
from tp_jax.cli.arguments import Parser, add_executor, add_seed, count, executor_of, positive
from tp_jax.cli.output import made_folder, plain, write_json
from tp_jax.errors import InputError
from tp_jax.executors import Piece, run_pieces

SCHEMA = "tp-jax/multistart/1"
RIGS, NUMBERS = "rigs.jsonl", "multistart.json"
DECADE = 10.0  # each way from the truth
NEAR = 0.02  # of the truth
REACHED = 1.0  # chi-square above the best of a rig


def main(argv: Sequence[str] | None = None) -> int:
    """Exit code."""
    return carried_out("multistart", _study, _parser().parse_args(argv), resumes=True)


def _parser() -> Parser:
    parser = Parser(
        prog="scripts/multistart",
        description="Many starts on simulated rigs: how often they find the best. Resumes.",
    )
    parser.add_argument("--out", metavar="DIR", default="out/multistart", help="./out/multistart")
    parser.add_argument("--rigs", metavar="N", type=count, default=20, help="default 20")
    parser.add_argument(
        "--starts",
        metavar="N",
        type=count,
        default=16,
        help="of each, the data's own not counted (default 16)",
    )
    parser.add_argument(
        "--raw-starts", action="store_true", help="as `tp-jax identify --raw-starts`"
    )
    add_seed(parser)
    add_executor(parser)
    parser.add_argument(
        "--limit-s",
        metavar="S",
        type=positive,
        default=float("inf"),
        help="begin no rig after so many seconds",
    )
    parser.add_argument("--quick", action="store_true", help="short campaigns, to see it work")
    parser.add_argument("--debug", action="store_true", help="show the traceback of a fault")
    return parser


def _study(args: Any) -> int:
    from tp_jax.cli.progress import shown

    until = time.monotonic() + args.limit_s
    folder = made_folder(args.out)
    settings = {"seed": args.seed, "starts": args.starts, "quick": args.quick}
    if args.raw_starts:
        settings["raw_starts"] = True
    known = read(folder / RIGS)
    if any(entry["settings"] != settings for entry in known.values()):
        raise InputError(f"{folder} holds a study with other settings; give another --out.")
    mend(folder / RIGS)
    failed = 0
    with shown(quiet=False) as progress, (folder / RIGS).open("a", encoding="utf-8") as file:
        left = [i for i in range(args.rigs) if i not in known]
        progress("rigs", len(known) / args.rigs)
        pieces = [Piece(f"rig-{i}", (i, args)) for i in left]
        for ended in run_pieces(_rig, pieces, executor_of(args), until=until):
            i = ended.piece.arguments[0]
            if ended.fault is not None:
                failed = 1
                print(f"multistart: rig {i} failed: {ended.fault}", file=sys.stderr)
                continue
            known[i] = {"rig": i, "settings": settings, **ended.result}
            file.write(json.dumps(plain(known[i]), allow_nan=False) + "\n")
            file.flush()
            progress("rigs", len(known) / args.rigs)
    known = dict(sorted(known.items()))
    found = tally(known)
    write_json(folder / NUMBERS, {"schema": SCHEMA, "settings": settings, **found})
    print("\n".join(lines(found)))
    if len(known) < args.rigs:
        print(f"{args.rigs - len(known)} of {args.rigs} rigs are left; the same call goes on.")
    print(f"Wrote {folder / NUMBERS}")
    return failed


def _rig(number: int, args: Any) -> dict[str, Any]:
    """Starts that reach the best of a rig, and its parameters."""
    import numpy as np

    import tp_jax as tp
    from tp_jax.estimation.prepared_campaign import prepare_campaign
    from tp_jax.identifiability.profile_likelihood import profiles
    from tp_jax.rig import make_campaign
    from trials.draw import draw_rig

    runs, duration = (3, 4.0) if args.quick else (6, 10.0)
    rng = np.random.default_rng([args.seed, number])
    parameters, seed, _ = draw_rig(rng, runs, duration)
    with tempfile.TemporaryDirectory() as folder:
        make_campaign(Path(folder, "rig"), parameters, runs=runs, duration=duration, seed=seed)
        campaign = tp.load_campaign(Path(folder, "rig"))
    truth = {k: v for k, v in dataclasses.asdict(parameters).items() if isinstance(v, float)}
    bound = {
        name: (truth[name] / DECADE, truth[name] * DECADE)
        for name in ("B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")
    }
    begin = time.perf_counter()
    found = tp.identify(
        campaign, starts=args.starts + 1, bound=bound, seed=seed, raw_starts=args.raw_starts
    )
    seconds, result = time.perf_counter() - begin, found.to_dict()
    setting = prepare_campaign(campaign, bound=bound, effects=())
    by_profile = {p.name: p.ci95 for p in profiles(found.fit, setting, PROFILED)}
    # the first start is the data's own
    objectives = [s["objective"] for s in result["starts"]]
    best = min(x for x in objectives if x is not None)
    rows = {}
    for name, entry in result["parameters"].items():
        if name in bound and entry["ci95"] is not None:
            low, high = by_profile.get(name, entry["ci95"])
            low, high = -np.inf if low is None else low, np.inf if high is None else high
            near = abs(entry["value"] / truth[name] - 1.0) <= NEAR
            rows[name] = {
                "truth": truth[name],
                "value": entry["value"],
                "ci95": [low, high],
                "identifiable": entry["identifiable"],
                "good": bool(near or low <= truth[name] <= high),
            }
    return {
        "objectives": objectives,
        "above": [None if x is None else x - best for x in objectives],
        "objective_kind": result["objective_kind"],
        "chi2_dof": result["chi2_dof"],
        "parameters": rows,
        "seconds": seconds,
    }


def tally(known: Mapping[int, Mapping[str, Any]]) -> dict[str, Any]:
    """Starts that reached the best of their rig, with Wilson's interval; parameters that are
    within 2 % of the truth or have it in their interval (Tst and T0: of their profile); seconds."""
    import numpy as np
    from scipy import stats

    def share(held: Sequence[bool]) -> dict[str, Any]:
        test = stats.binomtest(int(sum(held)), len(held))
        low, high = test.proportion_ci(method="wilson")
        return {"held": int(sum(held)), "of": len(held), "ci95": [float(low), float(high)]}

    if not known:
        return {"rigs": 0}
    drawn = [x is not None and x <= REACHED for r in known.values() for x in r["above"][1:]]
    own = [r["above"][0] is not None and r["above"][0] <= REACHED for r in known.values()]
    names = list(dict.fromkeys(n for r in known.values() for n in r["parameters"]))
    good = {
        n: share(
            [
                r["parameters"][n]["good"]
                for r in known.values()
                if n in r["parameters"] and r["parameters"][n]["identifiable"]
            ]
        )
        for n in names
        if any(n in r["parameters"] and r["parameters"][n]["identifiable"] for r in known.values())
    }
    return {
        "rigs": len(known),
        "starts_that_reach_the_best": share(drawn),
        "the_datas_own": share(own),
        "good": good,
        "seconds": [
            float(x) for x in np.percentile([r["seconds"] for r in known.values()], [0, 50, 100])
        ],
    }


def lines(found: Mapping[str, Any]) -> list[str]:
    """A table as plain text."""
    if not found["rigs"]:
        return ["No rig is done."]

    def told(name: str, one: Mapping[str, Any]) -> str:
        low, high = one["ci95"]
        of = f"{one['held']}/{one['of']}"
        return f"{name:28}{of:>9}{one['held'] / one['of']:8.3f}  {low:.3f} to {high:.3f}"

    least, median, most = found["seconds"]
    return [
        told("starts that reach the best", found["starts_that_reach_the_best"]),
        told("the data's own start", found["the_datas_own"]),
        *(told(f"{name} right", one) for name, one in found["good"].items()),
        f"seconds a rig: {least:.1f} to {most:.1f}, median {median:.1f}",
    ]


if __name__ == "__main__":
    sys.exit(main())
