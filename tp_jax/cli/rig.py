"""tp-jax rig serve: the virtual rig on a pseudo-terminal, for `tp-jax record` or any other host."""

import argparse
import sys
from typing import TYPE_CHECKING

from tp_jax.cli.arguments import (
    LARGEST_ANGLE,
    LONGEST_RUN,
    add_common,
    add_parent,
    add_seed,
    angle,
    frequency_above_zero,
    named,
    non_negative,
    number,
    positive,
    seconds,
    up_to,
)
from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.rig.serve import Emulator

FASTEST_RATE = 100_000.0  # Hz; the simulator takes a step for every sample
LARGEST_SKEW = 1e5  # parts per million
FASTEST_SPEED = 1e6


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "rig",
        help="the virtual rig",
        description="The virtual rig: a simulator behind the firmware's protocol.",
    )
    kinds = parser.add_subparsers(dest="rig_command", metavar="COMMAND", required=True)
    serve = kinds.add_parser(
        "serve",
        help="serve it on a pseudo-terminal",
        description="Serves the virtual rig on a pseudo-terminal, whose name it prints, until "
        "interrupted. (The page in a browser is `tp-jax serve`.)",
    )
    add_rig(serve)
    serve.add_argument(
        "--text", action="store_true", help="send lines of `t phi1 phi2` instead of frames"
    )
    run = serve.add_mutually_exclusive_group()
    run.add_argument(
        "--omega", metavar="W", type=frequency_above_zero, help="drive of a text stream, rad/s"
    )
    run.add_argument("--release", metavar="X", type=angle, help="or angle let go from, rad")
    add_parent(serve)
    add_common(serve)
    serve.set_defaults(run=run_serve)


def add_rig(parser: argparse.ArgumentParser) -> None:
    """Adds arguments of the virtual rig; `tp-jax record --port emulator` takes the same."""
    group = parser.add_argument_group("the virtual rig")
    group.add_argument(
        "--effect",
        metavar="ID=SIZE",
        type=effect,
        action="append",
        default=[],
        help="hide an effect in it; several sizes with commas between them; repeat for more",
    )
    add_seed(group)  # type: ignore[arg-type]
    group.add_argument(
        "--rate",
        metavar="HZ",
        type=up_to(positive, FASTEST_RATE, "Hz"),
        default=1000.0,
        help="samples a second (1000)",
    )
    group.add_argument(
        "--speed",
        metavar="X",
        type=speed,
        default=1.0,
        help="times real time (1); max: as fast as it is read",
    )
    group.add_argument(
        "--noise",
        metavar="RAD",
        type=up_to(non_negative, LARGEST_ANGLE, "rad"),
        default=1e-3,
        help="of the sensors (0.001)",
    )
    group.add_argument(
        "--skew",
        metavar="PPM",
        type=up_to(number, LARGEST_SKEW, "parts per million"),
        default=0.0,
        help="parts per million its clock is fast",
    )
    group.add_argument(
        "--corrupt", metavar="FRACTION", type=fraction, default=0.0, help="of bytes damaged"
    )
    group.add_argument(
        "--drop", metavar="FRACTION", type=fraction, default=0.0, help="of bytes lost"
    )
    group.add_argument(
        "--unplug", metavar="AT:FOR", type=outage, help="unplug it at AT s for FOR s of a run"
    )
    group.add_argument(
        "--run-duration",
        metavar="S",
        type=seconds,
        help="seconds over which hidden drifts run their course",
    )


def effect(text: str) -> tuple[str, tuple[float, ...]]:
    """ID=SIZE or ID=SIZE,SIZE."""
    name, equals, sizes = text.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"must have the form ID=SIZE, but is {text!r}")
    try:
        return name, tuple(number(each) for each in sizes.split(","))
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(
            f"must give {name} a number, but gives it {sizes!r}"
        ) from None


def speed(text: str) -> float | None:
    """A number above zero, or max: None."""
    return None if text == "max" else up_to(positive, FASTEST_SPEED, "times real time")(text)


def fraction(text: str) -> float:
    """A number from 0 up to, but not, 1."""
    value = non_negative(text)
    if value >= 1.0:
        raise argparse.ArgumentTypeError(f"must be below 1, but is {text}")
    return value


def outage(text: str) -> tuple[float, float]:
    """AT:FOR."""
    at, colon, duration = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"must have the form AT:FOR, but is {text!r}")
    return up_to(non_negative, LONGEST_RUN, "s")(at), seconds(duration)


def rig_arguments(args: argparse.Namespace) -> list[str]:
    """The arguments of `add_rig` again, as words of a command line."""
    words = [
        f"--seed={args.seed}",
        f"--rate={args.rate!r}",
        f"--speed={'max' if args.speed is None else repr(args.speed)}",
        f"--noise={args.noise!r}",
        f"--skew={args.skew!r}",
        f"--corrupt={args.corrupt!r}",
        f"--drop={args.drop!r}",
    ]
    for name, sizes in args.effect:
        words.append(f"--effect={name}={','.join(map(repr, sizes))}")
    if args.unplug is not None:
        words.append(f"--unplug={args.unplug[0]!r}:{args.unplug[1]!r}")
    if args.run_duration is not None:
        words.append(f"--run-duration={args.run_duration!r}")
    return words


def run_serve(args: argparse.Namespace) -> None:
    from tp_jax.rig.serve import serve_until_interrupted

    emulator = made(args)
    print(emulator.port, flush=True)
    if sys.stderr.isatty() and not args.quiet:
        print("Serving until Ctrl-C; record with --port and the name above.", file=sys.stderr)
    watch = sys.stdin.fileno() if args.until_stdin_closes else None
    serve_until_interrupted(emulator, watch)


def made(args: argparse.Namespace) -> "Emulator":
    """The emulator that the arguments describe."""
    from tp_jax.rig.emulator import Firmware
    from tp_jax.rig.serve import Emulator, Line
    from tp_jax.rig.simulator import VirtualRig

    if (args.omega or args.release) and not args.text:
        raise InputError(
            "Arguments --omega and --release are for --text; otherwise the host commands the run."
        )
    rig = VirtualRig(effects=named(args.effect, "--effect"), seed=args.seed)
    firmware = Firmware(
        rig,
        rate=args.rate,
        noise=args.noise,
        skew=1e-6 * args.skew,
        seed=args.seed,
        text=args.text,
        omega=args.omega,
        release=args.release,
        run_duration=args.run_duration,
    )
    line = Line(args.corrupt, args.drop, args.seed)
    return Emulator(firmware, speed=args.speed, line=line, unplug=args.unplug)
