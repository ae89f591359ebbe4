"""The parser, the kinds of arguments, and the arguments that several commands share."""

import argparse
import math
import os
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from tp_jax.cli.progress import FORMS
from tp_jax.errors import InputError, Notice
from tp_jax.executors import KINDS, ExecutorChoice, available

if TYPE_CHECKING:
    from tp_jax.recordings import Campaign

MOST_SAMPLES = 10_000_000

BYTES_PER_SAMPLE = 600
"""Bytes of memory that a simulated run takes per sample at its peak, its file's text included."""

LONGEST_RUN = 1e7
"""Seconds of a run: four months."""

LARGEST_ANGLE = 100.0
"""Radians beyond which nobody turns a column."""

FASTEST_DRIVE = 1e4
"""rad/s beyond which no motor turns."""

MOST_STARTS = 1_000_000

MOST_WORKERS = 1_000
"""Pieces in hand at once: each may be a process."""


class Parser(argparse.ArgumentParser):
    """Tells a fault in one sentence, without the usage before it."""

    def __init__(self, **options: Any):
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        # "argument --rate: must be ..." -> "Argument --rate must be ..."
        message = re.sub(r"^argument ([^:]+): must ", r"argument \1 must ", message)
        message = " ".join(message.split())  # a word may hold a line end
        sentence = message[:1].upper() + message[1:].rstrip(".")
        self.exit(2, f"tp-jax: {sentence}; see {self.prog} --help.\n")


Kind = Callable[[str], float]

# Kinds of values -----------------------------------------------------------------------------


def number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a number, but is {text!r}")
    return value


def positive(text: str) -> float:
    """A finite number above zero."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"must be above zero, but is {text}")
    return value


def non_negative(text: str) -> float:
    """A finite number, zero or above."""
    value = number(text)
    if value < 0.0:
        raise argparse.ArgumentTypeError(f"must not be negative, but is {text}")
    return value


def whole(text: str, *, least: int = 0, most: int = 2**63 - 1) -> int:
    """A whole number from `least` to `most`."""
    try:
        value = int(text)
    except ValueError:
        value = None
    if value is None or value < least:
        raise argparse.ArgumentTypeError(
            f"must be a whole number from {least} up, but is {_short(text)!r}"
        )
    if value > most:
        raise argparse.ArgumentTypeError(f"must be at most {most}, but is {_short(text)}")
    return value


def count(text: str) -> int:
    """A whole number above zero."""
    return whole(text, least=1)


def up_to(kind: Kind, most: float, unit: str) -> Kind:
    """A number of the kind given, no further from zero than `most` of the unit."""

    def limited(text: str) -> float:
        value = kind(text)
        if abs(value) > most:
            raise argparse.ArgumentTypeError(
                f"must be at most {most:g} {unit}, but is {_short(text)}"
            )
        return value

    return limited


def file_name(text: str) -> str:
    """A file's name; `-`, standard output, is none."""
    if text == "-":
        raise argparse.ArgumentTypeError("must name a file, which standard output (-) is not")
    return text


def figure_name(text: str) -> str:
    """Name of a figure, by whose end its kind is chosen: .png or .svg."""
    if os.path.splitext(file_name(text))[1].lower() not in (".png", ".svg"):
        raise argparse.ArgumentTypeError(f"must end in .png or .svg, but is {_short(text)}")
    return text


def _short(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:37]}..."


seconds = up_to(positive, LONGEST_RUN, "s")
angle = up_to(number, LARGEST_ANGLE, "rad")
frequency = up_to(non_negative, FASTEST_DRIVE, "rad/s")
frequency_above_zero = up_to(positive, FASTEST_DRIVE, "rad/s")


def frequencies(text: str) -> tuple[float, float]:
    """MIN:MAX, frequencies of a drive [rad/s]."""
    low, colon, high = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"must have the form MIN:MAX, but is {_short(text)!r}")
    span = frequency_above_zero(low), frequency_above_zero(high)
    if span[0] > span[1]:
        raise argparse.ArgumentTypeError(f"must rise from MIN to MAX, but is {_short(text)!r}")
    return span


def starts(text: str) -> int:
    """A number of starts."""
    return whole(text, least=1, most=MOST_STARTS)


def workers(text: str) -> int:
    """A number of workers."""
    return whole(text, least=1, most=MOST_WORKERS)


def fixed(text: str) -> tuple[str, float]:
    """NAME=V."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"must have the form NAME=V, but is {text!r}")
    try:
        return name, number(value)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(
            f"must give {name} a number, but gives it {value!r}"
        ) from None


def bounded(text: str) -> tuple[str, tuple[float, float]]:
    """NAME=LO:HI."""
    name, equals, span = text.partition("=")
    low, colon, high = span.partition(":")
    if not (name and equals and colon):
        raise argparse.ArgumentTypeError(f"must have the form NAME=LO:HI, but is {text!r}")
    try:
        bounds = number(low), number(high)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(
            f"must bound {name} by two numbers LO:HI, but has {span!r}"
        ) from None
    if not bounds[0] < bounds[1]:
        raise argparse.ArgumentTypeError(
            f"must bound {name} from below by less than from above, but has {span!r}"
        )
    return name, bounds


def named(pairs: list[tuple[str, Any]], option: str) -> dict[str, Any]:
    """The pairs of a repeated option as a dict; no name may come twice."""
    values: dict[str, Any] = {}
    for name, value in pairs:
        if name in values:
            raise InputError(f"Argument {option} must name {name} only once.")
        values[name] = value
    return values


def sample_count(duration: float, rate: float) -> int:
    """Samples from 0 to `duration` [s] at `rate` [Hz], both ends included.

    Raises:
        InputError: too few, or more than there is memory for.
    """
    intervals = round(min(duration * rate, 2.0 * MOST_SAMPLES))
    asked = min(duration * rate, 1e300) + 1.0
    needed = asked * BYTES_PER_SAMPLE
    if not 1 <= intervals < MOST_SAMPLES:
        taking = f", which would take {size(needed)} of memory" if intervals > 1 else ""
        raise InputError(
            f"Arguments --duration and --rate must give between 2 and {MOST_SAMPLES} samples, "
            f"but {duration:g} s at {rate:g} Hz give {asked:.3g}{taking}."
        )
    if duration > LONGEST_RUN:
        raise InputError(
            f"Argument --duration must be at most {LONGEST_RUN:g} s, but is {duration:g}."
        )
    there = memory()
    if there is not None and needed > there:
        raise InputError(
            f"Arguments --duration and --rate give {intervals + 1} samples, which take about "
            f"{size(needed)} of memory, but this machine has {size(there)}; ask for fewer."
        )
    return intervals + 1


def memory() -> float | None:
    """Memory of this machine [bytes]; None where the system does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None


def size(count: float) -> str:
    """Bytes in words: 1.2 GB."""
    for unit, power in (("EB", 18), ("PB", 15), ("TB", 12), ("GB", 9)):
        if count >= 10.0**power:
            return f"{count / 10.0**power:.3g} {unit}"
    return f"{count / 1e6:.3g} MB"


def check_parameters(
    campaign: "Campaign",
    fix: Mapping[str, float],
    bound: Mapping[str, tuple[float, float]] | None = None,
) -> None:
    """Sees that --fix and --bound are within what a rig of this campaign can have.

    Without JAX, which takes longer to load than a mistyped number should.

    Raises:
        InputError: in one sentence, which is not.
    """
    from tp_jax.model.plausible import check_values

    check_values(fix, bound, campaign.B1)


def check_profiles(wanted: Sequence[str], fix: Mapping[str, float]) -> None:
    """Sees that --profile names parameters that are fitted.

    Raises:
        InputError: which is none.
    """
    from tp_jax.model.plausible import check_names

    check_names([name for name in wanted if name != "all"])
    for name in wanted:
        if name in fix:
            raise InputError(f"Argument --profile names {name}, which --fix holds.")


# Arguments shared by commands ----------------------------------------------------------------


def add_common(parser: argparse.ArgumentParser) -> None:
    """--quiet and --debug also after the command; absent there, what came before it stands."""
    parser.add_argument(
        "--quiet", action="store_true", default=argparse.SUPPRESS, help="no summary, no progress"
    )
    parser.add_argument(
        "--debug",
        action="store_true",
        default=argparse.SUPPRESS,
        help="show the traceback of a fault",
    )


def add_progress(parser: argparse.ArgumentParser) -> None:
    """--progress, of the commands that take long."""
    parser.add_argument(
        "--progress",
        choices=FORMS,
        default=FORMS[0],
        help="auto: bars, on a terminal only (default); plain: a line of text at most every 10 s; "
        "json: an object a line, for other programs; all on standard error",
    )


def add_executor(parser: argparse._ActionsContainer) -> None:
    """--executor and --workers, of what does many independent pieces of work."""
    parser.add_argument(
        "--executor",
        choices=KINDS,
        default=KINDS[0],
        help="what does the work: processes of this machine (default), Ray, Dask, or Slurm's jobs; "
        "docs/scale.md says how each is told where",
    )
    parser.add_argument(
        "--workers",
        metavar="N",
        type=workers,
        default=available(),
        help="how much is done at once (default: as many as processors)",
    )


def executor_of(args: argparse.Namespace) -> ExecutorChoice:
    """Returns what `add_executor`'s arguments ask for."""
    return ExecutorChoice(args.executor, args.workers)


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--json", metavar="F", help="write the result as JSON; - : to standard output, alone"
    )


def add_parent(parser: argparse.ArgumentParser) -> None:
    """Adds an option for another program that runs the command: it ends with that program."""
    parser.add_argument(
        "--until-stdin-closes",
        action="store_true",
        help="end when standard input does: with the program that started this one",
    )


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace a recording that is there, and take its .meta.json away",
    )


def add_seed(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    parser.add_argument(
        "--seed", metavar="N", type=whole, default=0, help="same seed, same result (default 0)"
    )


def add_campaign(
    parser: argparse.ArgumentParser, *, default: str | None = None, several: bool = False
) -> None:
    """CAMPAIGN, and how a single file was driven; several: any number of them, as a list."""
    text = "a folder with a campaign.toml, or one recording (then --omega or --decay is needed)"
    if default is None:
        parser.add_argument("campaign", metavar="CAMPAIGN", help=text)
    else:
        parser.add_argument(
            "campaign",
            metavar="CAMPAIGN",
            nargs="*" if several else "?",
            help=f"{text}; default: {default}",
        )
    drive = parser.add_mutually_exclusive_group()
    drive.add_argument(
        "--omega",
        metavar="W",
        type=frequency,
        help="the one recording was driven at W rad/s",
    )
    drive.add_argument(
        "--decay", action="store_true", help="the one recording is a free decay, motor at rest"
    )


def load(args: argparse.Namespace, path: str | Path) -> "Campaign":
    """The campaign that `add_campaign`'s arguments speak of, if its recordings can be right.

    What is doubtful about them is a `Notice`.

    Raises:
        InputError: something is certainly wrong.
    """
    from tp_jax.checks import examine
    from tp_jax.recordings import load_campaign

    campaign = load_campaign(path, omega=args.omega, decay=args.decay)
    checked = examine(campaign)
    checked.refuse()
    for each in checked.doubtful:
        warnings.warn(each.sentence, Notice, stacklevel=2)
    return campaign
