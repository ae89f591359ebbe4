"""tp-jax record: records a run of a rig at a serial port, or of the virtual rig."""

import argparse
import subprocess
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from tp_jax.cli.arguments import (
    LARGEST_ANGLE,
    add_common,
    add_json,
    angle,
    file_name,
    frequency_above_zero,
    positive,
    seconds,
    up_to,
    whole,
)
from tp_jax.cli.rig import add_rig, rig_arguments
from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.acquisition.run_log import Recorded, Settings

EMULATOR = "emulator"

WORTH_TELLING = 1e-4
"""Standard error of a clock's skew above which a short recording says nothing of it."""

FASTEST_BAUD = 100_000_000
"""Bits a second beyond those of any serial line."""

LONGEST_WAIT = 86400.0  # s, a day


def baud(text: str) -> int:
    """Bits a second."""
    return whole(text, least=1, most=FASTEST_BAUD)


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "record",
        help="record a run of a rig",
        description="Records a run of a rig at a serial port as t,phi1,phi2; what is known of it "
        "goes beside it, to FILE.csv.meta.json. Without --omega and --release the motor stands "
        "still. Ctrl-C ends a recording early and keeps it.",
    )
    add_port(parser)
    parser.add_argument(
        "--duration", metavar="S", type=seconds, required=True, help="seconds of the run"
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument(
        "--out", metavar="FILE.csv", type=file_name, help="the file to write, never over another"
    )
    where.add_argument(
        "--campaign",
        metavar="DIR",
        help="or a campaign's folder: a new file there, and its entry in campaign.toml",
    )
    run = parser.add_mutually_exclusive_group()
    run.add_argument("--omega", metavar="W", type=frequency_above_zero, help="drive it at W rad/s")
    run.add_argument(
        "--release", metavar="X", type=angle, help="let it go at X rad, the motor at neutral"
    )
    add_line(parser)
    add_rig(parser)
    add_json(parser)
    add_common(parser)
    parser.set_defaults(run=run_record)


def add_port(parser: argparse.ArgumentParser) -> None:
    """--port; `tp-jax explore` has it too."""
    parser.add_argument(
        "--port",
        metavar="PORT",
        required=True,
        help=f"/dev/ttyACM0, COM3, ...; {EMULATOR}: the virtual rig",
    )


def add_line(parser: argparse.ArgumentParser) -> None:
    """Adds arguments on how the rig at the port is spoken to; `tp-jax explore` takes the same."""
    parser.add_argument(
        "--amplitude",
        metavar="A",
        type=up_to(positive, LARGEST_ANGLE, "rad"),
        help="of the drive, rad",
    )
    parser.add_argument(
        "--baud", metavar="N", type=baud, default=460800, help="bits a second (460800)"
    )
    parser.add_argument(
        "--calibration", metavar="FILE", help="a TOML file; default: what the rig announces"
    )
    parser.add_argument(
        "--patience",
        metavar="S",
        type=up_to(positive, LONGEST_WAIT, "s"),
        default=5.0,
        help="seconds to wait for an answer of the rig, or for samples (5)",
    )
    parser.add_argument(
        "--reconnect",
        metavar="S",
        type=up_to(positive, LONGEST_WAIT, "s"),
        default=30.0,
        help="seconds to wait for a rig that was unplugged (30)",
    )


def run_record(args: argparse.Namespace) -> None:
    from tp_jax.acquisition.campaign_entry import append_entry, check_campaign, free_name
    from tp_jax.acquisition.recorder import MAY_STILL_RUN, check, uninterrupted
    from tp_jax.cli.output import made_folder, ready, write_json

    if args.port != EMULATOR:
        check_no_rig(args)
    settings = settings_of(args, omega=args.omega, release=args.release)
    # all that can be wrong is reported before the rig moves
    ready(args.json)
    if args.campaign is None:
        out, folder = Path(args.out), None
        check(out, settings)
        ready(args.out)
    else:
        folder = Path(args.campaign)
        check_campaign(folder)
        made_folder(folder)
        out = free_name(folder, args.omega)
        check(out, settings)

    recorded = recorded_at(args, out, settings)
    with uninterrupted():
        unfit = None if folder is None else append_entry(folder, recorded)
    if args.json is not None:
        write_json(args.json, recorded.metadata)
    if not args.quiet and args.json != "-":
        print(summary(recorded))
        if folder is not None and unfit is None:
            print(f"Added it to {folder / 'campaign.toml'}")
    said = [] if recorded.fault is None else [recorded.fault]
    if MAY_STILL_RUN in recorded.metadata["notes"] and MAY_STILL_RUN not in " ".join(said):
        said.append(MAY_STILL_RUN)
    if unfit is not None:
        said.append(f"Not added to the campaign {folder}: {unfit}")
    if recorded.state == "interrupted":
        if said:
            print(" ".join(said), file=sys.stderr if args.json == "-" else sys.stdout)
        raise KeyboardInterrupt
    if said:
        raise InputError(" ".join(said))


def settings_of(
    args: argparse.Namespace, *, omega: float | None, release: float | None
) -> "Settings":
    """The settings of a run, of the arguments of `add_line` and --duration.

    omega: of the drive [rad/s]; release: angle from which the column is let go [rad].
    """
    from tp_jax.acquisition.run_log import Settings
    from tp_jax.recordings.calibration import read_calibration

    return Settings(
        duration=args.duration,
        omega=omega,
        amplitude=args.amplitude,
        release=release,
        calibration=None if args.calibration is None else read_calibration(args.calibration),
        patience=args.patience,
        reconnect=args.reconnect,
        # a simulator that is to be faster may fall behind, which is no skew of a clock
        real_time=args.port != EMULATOR or (args.speed is not None and args.speed <= 1.0),
        command=_command(),
    )


def recorded_at(
    args: argparse.Namespace,
    out: Path,
    settings: "Settings",
    ready: Callable[[], None] | None = None,
) -> "Recorded":
    """Records a run at the port of the arguments, and shows it on a terminal.

    out: the file, not there yet; ready: see `tp_jax.acquisition.recorder.record`.
    """
    from tp_jax.acquisition.port import Port
    from tp_jax.acquisition.recorder import record
    from tp_jax.cli.live import live

    virtual = args.port == EMULATOR
    if virtual:
        # another recording of the same rig has other noise, the same one again the same
        seed = zlib.crc32(f"{args.seed} {out.name}".encode())
        args = argparse.Namespace(**{**vars(args), "seed": seed})
    with _port(args) as name, live(quiet=args.quiet) as progress:
        faster = args.speed if virtual and args.speed is not None else 1.0
        port = Port(name, args.baud, lambda: faster * time.monotonic())
        return record(port, out, settings, progress=progress, ready=ready)


def summary(recorded: "Recorded") -> str:
    """Sums up what was recorded, in a line or three; not that the motor may still run."""
    from tp_jax.acquisition.recorder import MAY_STILL_RUN

    meta = recorded.metadata
    samples, frames, clock = meta["samples"], meta["frames"], meta["clock"]
    kind = "frames" if meta["stream"] == "frames" else "lines"
    lines = [
        f"Wrote {recorded.path}: {samples['written']} samples in {recorded.duration:.6g} s, "
        f"{samples['lost']} lost, {frames['corrupt']} corrupt {kind}"
    ]
    if clock is not None and (clock["applied"] or clock["skew_error"] < WORTH_TELLING):
        done = ", corrected" if clock["applied"] else ""
        lines.append(
            f"The rig's clock is {1e6 * clock['skew']:+.1f} ± {1e6 * clock['skew_error']:.1f} ppm "
            f"against this computer's{done}"
        )
    for gap in meta["gaps"]:
        lines.append(
            f"Gap from {gap['after']:.4g} to {gap['before']:.4g} s, {gap['samples']} samples, "
            f"{gap['cause']}"
        )
    for sensor, n in samples["clipped"].items():
        if n:
            lines.append(f"{n} readings of {sensor} lie at the end of the converter's range")
    if recorded.fault is None:  # which says it as well
        lines += [note for note in meta["notes"] if note != MAY_STILL_RUN]
    return "\n".join(lines)


@contextmanager
def _port(args: argparse.Namespace) -> Iterator[str]:
    """The port's name; the virtual rig runs, in a process of its own, as long as it is needed."""
    if args.port != EMULATOR:
        yield args.port
        return
    if args.run_duration is None:
        args.run_duration = args.duration
    words = [sys.executable, "-m", "tp_jax", "rig", "serve", "--until-stdin-closes"]
    rig = subprocess.Popen(
        [*words, *rig_arguments(args)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for the recorder
    )
    try:
        assert rig.stdout is not None
        name = rig.stdout.readline().strip()
        if not name:
            told = rig.communicate()[1].strip().split("\n")[-1].removeprefix("tp-jax: ")
            raise InputError(told or "The virtual rig did not start.")
        yield name
    finally:
        assert rig.stdin is not None
        rig.stdin.close()  # which ends it
        try:
            rig.wait(5.0)
        except subprocess.TimeoutExpired:
            rig.kill()
            rig.wait()
        for stream in (rig.stdout, rig.stderr):
            if stream is not None:
                stream.close()


def check_no_rig(args: argparse.Namespace, used: Sequence[str] = ()) -> None:
    """Refuses arguments of the virtual rig where a real one is recorded: it would not be so.

    used: names of those that the command uses itself.
    """
    parser = argparse.ArgumentParser()
    add_rig(parser)
    for name, usual in vars(parser.parse_args([])).items():
        if name not in used and getattr(args, name) != usual:
            option = f"--{name.replace('_', '-')}"
            raise InputError(
                f"Argument {option} is for the virtual rig, --port {EMULATOR}; leave it out for "
                f"a rig at {args.port}."
            )


def _command() -> list[str]:
    return ["tp-jax", *sys.argv[1:]]
