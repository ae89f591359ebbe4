"""tp-jax explore: records, diagnoses and chooses the next run, until the cause is known."""

import argparse
import functools
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tp_jax.cli.arguments import (
    LARGEST_ANGLE,
    add_common,
    add_json,
    add_progress,
    count,
    frequencies,
    load,
    positive,
    seconds,
    up_to,
)
from tp_jax.cli.record import (
    EMULATOR,
    add_line,
    add_port,
    check_no_rig,
    recorded_at,
    settings_of,
)
from tp_jax.cli.rig import add_rig
from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.acquisition.run_log import Recorded
    from tp_jax.exploring.state import Made
    from tp_jax.gap.next_run import Finding, Limits, Run

REPORT = "diagnosis"
"""Folder in the campaign's that gets report.html and diagnosis.json of the last diagnosis."""

NEW = "exploration"
"""The folder that is made where none is named; the next is exploration-2."""

MOST_RUNS = 8
"""Recordings unless it is said: the trials' campaigns have six, and a diagnosis of more of them
takes minutes."""

DURATION = 10.0
"""Seconds of a run unless it is said, as in the trials."""


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "explore",
        help="record, diagnose and choose the next run until the cause is known",
        description="Records a run of a rig, diagnoses all runs so far, and chooses the next one, "
        "until a cause is known, nothing is left to explain, no allowed run could tell the causes "
        "apart, or N runs are made. The same command goes on where it was interrupted. All of it "
        "is in the campaign's folder: recordings, campaign.toml, explore.json, and the last report "
        f"in {REPORT}/.",
    )
    add_port(parser)
    parser.add_argument(
        "--campaign",
        metavar="DIR",
        help="the campaign's folder; its recordings count, and a missing one is made; default: a "
        f"new folder ./{NEW}",
    )
    parser.add_argument(
        "--limit",
        metavar="ANGLE",
        type=up_to(positive, LARGEST_ANGLE, "rad"),
        help="rad that neither column nor rider may be predicted to exceed",
    )
    parser.add_argument(
        "--omega",
        metavar="MIN:MAX",
        type=frequencies,
        help="rad/s of the drive; default: about the resonance that the first run shows",
    )
    parser.add_argument(
        "--no-release",
        action="store_true",
        help="only driven runs; needs --omega, whose MIN is the first run",
    )
    parser.add_argument(
        "--runs",
        metavar="N",
        type=count,
        default=MOST_RUNS,
        help=f"recordings of the campaign at most ({MOST_RUNS})",
    )
    parser.add_argument(
        "--duration",
        metavar="S",
        type=seconds,
        default=DURATION,
        help=f"seconds of a run ({DURATION:g})",
    )
    parser.add_argument(
        "--yes",
        action="store_true",
        help="do not wait for Enter where somebody has to set the rig",
    )
    add_line(parser)
    add_rig(parser)
    add_json(parser)
    add_progress(parser)
    add_common(parser)
    parser.set_defaults(run=run_explore)


def run_explore(args: argparse.Namespace) -> None:
    if args.port != EMULATOR:
        check_no_rig(args, used=["seed"])  # of the diagnoses
    if args.no_release and args.omega is None:
        raise InputError(
            "Argument --no-release needs --omega MIN:MAX, of which MIN is driven first."
        )

    from tp_jax.acquisition.campaign_entry import check_campaign
    from tp_jax.acquisition.recorder import MAY_STILL_RUN
    from tp_jax.cli.output import made_folder, new_folder, ready, write_json

    ready(args.json)
    settings_of(args, omega=None, release=None)  # sees that the calibration can be read
    if args.campaign is not None:
        check_campaign(Path(args.campaign))
    rig = _rig_at(args)
    if not rig.drives and args.no_release:
        raise InputError(f"The rig at {args.port} has no motor to command; leave out --no-release.")
    folder = new_folder(NEW) if args.campaign is None else made_folder(args.campaign)
    if args.campaign is None and not args.quiet:
        where = sys.stderr if args.json == "-" else sys.stdout
        print(f"Recordings go to {folder}.", file=where, flush=True)

    from tp_jax.exploring import explore
    from tp_jax.exploring.amplitudes import amplitude_of
    from tp_jax.gap.next_run import Limits

    args.amplitude = amplitude_of(folder, args.amplitude, rig.amplitude)
    limits = Limits(args.limit, args.omega, rig.drives, not args.no_release)

    def record(run: "Run", out: Path) -> "Recorded":
        settings = settings_of(args, omega=run.omega, release=run.release)
        ready = None
        if args.port != EMULATOR and (run.release is not None or not rig.commanded):
            if rig.frames:  # a board that starts anew with its port answers before the column goes
                ready = functools.partial(_ask, args, run)
            else:
                _ask(args, run)
        recorded = recorded_at(args, out, settings, ready)
        for note in recorded.metadata["notes"] if recorded.fault is None else ():
            if not args.quiet or note == MAY_STILL_RUN:
                print(note, file=sys.stderr, flush=True)
        return recorded

    def tell(made: "Made | None", number: int, finding: "Finding") -> None:
        if not args.quiet and args.json != "-":
            print(line(made, number, finding), flush=True)

    try:
        explored = explore(
            folder,
            record,
            _diagnoser(args, limits),
            limits=limits,
            most=args.runs,
            duration=args.duration,
            amplitude=args.amplitude,
            diagnosed=tell,
        )
    except KeyboardInterrupt:
        more = f" with --campaign {folder}" if args.campaign is None else ""
        raise KeyboardInterrupt(f"interrupted; the same command{more} goes on from here.") from None
    if args.json is not None:
        write_json(args.json, explored.to_dict())
    if args.json != "-" and not args.quiet:
        print(explored.stop.sentence)
        print(f"Report: {folder / REPORT / 'report.html'}")


def line(made: "Made | None", number: int, finding: "Finding") -> str:
    """One round: the run, what was set, the first cause with its probability."""
    if made is None:
        done = f"Recordings that are there, {number}"
    else:
        done = f"Run {number}, {made.file}, {made.run}"
    if finding.verdict == "no_gap":
        return f"{done}: no gap"
    if finding.first is None:
        return f"{done}: no cause is likely yet"
    from tp_jax.gap.next_run import shown

    kind = "cause" if finding.causes else "candidate"
    return f"{done}: first {kind} {finding.first}, probability {shown(finding.probability)}"


def _diagnoser(args: argparse.Namespace, limits: "Limits") -> "Callable[[Path], Finding]":
    """Diagnoses a folder, writes its report, and forecasts the next runs."""

    def diagnose(folder: Path) -> "Finding":
        from tp_jax._config import enable_compilation_cache

        enable_compilation_cache()
        from tp_jax.cli.output import replaced, write_json
        from tp_jax.cli.progress import shown
        from tp_jax.exploring.amplitudes import announced_amplitude
        from tp_jax.gap.diagnosis import examine
        from tp_jax.gap.forecast import outlook
        from tp_jax.report.html import write_report

        campaign = load(argparse.Namespace(omega=None, decay=False), folder)
        amplitude = args.amplitude or announced_amplitude(folder)
        with shown(quiet=args.quiet, form=args.progress) as progress:
            examination = examine(campaign, seed=args.seed, progress=progress)
            progress("comparing runs", None)
            found = outlook(examination, limits, args.duration, amplitude)
            progress("writing the report", None)
            write_json(folder / REPORT / "diagnosis.json", examination.diagnosis.to_dict())
            with replaced(folder / REPORT / "report.html") as part:
                write_report(examination.diagnosis, part, figures=False)
        return found

    return diagnose


class _Rig(NamedTuple):
    """The rig at the port.

    drives: it can be driven at a frequency that is known; commanded: it sets that when told to;
    frames: it is asked before a run begins; amplitude: of its drive [rad], None: it says none.

    A stream of text takes no commands: whoever sets the motor is told what to set. A rig of frames
    that has no motor records decays.
    """

    drives: bool
    commanded: bool
    frames: bool
    amplitude: float | None


def _rig_at(args: argparse.Namespace) -> _Rig:
    if args.port == EMULATOR:
        return _Rig(True, True, True, None)

    from tp_jax.acquisition.device import Device
    from tp_jax.acquisition.port import Port, Unplugged

    port = Port(args.port, args.baud)
    try:
        device = Device(port)
        device.identify(args.patience)
    except Unplugged as fault:
        raise InputError(f"The port {args.port} has gone; plug the rig in again.") from fault
    finally:
        port.close()
    told = device.identity
    if told is None:
        return _Rig(True, False, False, None)
    return _Rig(told.drives, told.drives, True, told.amplitude or None)


def _ask(args: argparse.Namespace, run: "Run") -> None:
    """Says what is to be set at the rig, and waits for Enter."""
    if run.omega is not None:
        said = f"Set the motor to {run.omega:.4g} rad/s ({run.omega / math.tau:.4g} Hz)"
    else:
        said = f"With the motor at rest, hold the column at {run.release:.3g} rad"
    if args.yes:
        if not args.quiet:
            print(f"{said}.", file=sys.stderr)
        return
    last = ", and press Enter." if run.omega is not None else ", press Enter, and let it go."
    print(f"{said}{last}", file=sys.stderr, flush=True)
    try:
        input()
    except EOFError:
        raise InputError(
            "Nobody is there to set the rig, standard input being at its end; run it on a "
            "terminal, or add --yes where the rig is set in another way."
        ) from None
