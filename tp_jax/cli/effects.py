"""tp-jax effects: the catalogue, and what to do about an effect."""

import argparse
from typing import TYPE_CHECKING, Any

from tp_jax.cli.arguments import add_common, add_json
from tp_jax.cli.output import ready, write_json
from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.effects import Effect


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "effects",
        help="list the effects that a diagnosis knows, or describe one",
        description=(
            "Lists the catalogue of effects, those of installed plug-ins among them; with an ID "
            "tells what it does, its formula, how it looks, and what to do about it at the rig."
        ),
    )
    parser.add_argument("id", metavar="ID", nargs="?", help="an effect, as contact_stribeck")
    add_json(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    ready(args.json)

    from tp_jax.effects import catalogue
    from tp_jax.recordings.faults import nearest

    effects = catalogue()
    if args.id is not None and args.id not in effects:
        near = nearest(args.id, effects)
        hint = f"did you mean {near}?" if near else "tp-jax effects lists them."
        raise InputError(f"There is no effect {args.id}; {hint}")
    chosen = effects if args.id is None else {args.id: effects[args.id]}
    if args.json is not None:
        write_json(args.json, {name: told(effect) for name, effect in chosen.items()})
    if args.json == "-":
        return
    if args.id is None:
        width = max(map(len, effects))
        for name, effect in effects.items():
            print(f"{name:{width}}  {effect.location:8}  {told(effect)['says']}")
        return
    labels = {
        "says": "What happens",
        "location": "Where",
        "formula": "Formula",
        "amplitudes": "Amplitudes",
        "shapes": "Shape constants",
        "needs": "Needs",
        "looks_like": "Looks like",
        "source": "Source",
        "remedy": "What to do",
        "by_hand": "Check by hand",
    }
    print(args.id)
    for key, value in told(chosen[args.id]).items():
        if value:
            text = ", ".join(value) if isinstance(value, list) else value
            print(f"  {labels[key] + ':':17}{text}")


def told(effect: "Effect") -> dict[str, Any]:
    """Returns what there is to say of an effect, by name."""
    from tp_jax.report.words import clause

    return {
        "says": effect.says or clause(effect.id),
        "location": effect.location,
        "formula": effect.formula,
        "amplitudes": [f"{a.name} [{a.unit}]" for a in effect.amplitudes],
        "shapes": [f"{s.name} [{s.unit}]" for s in effect.shapes],
        "needs": sorted(effect.needs),
        "looks_like": effect.looks_like,
        "source": effect.source,
        "remedy": effect.remedy,
        "by_hand": effect.by_hand,
    }
