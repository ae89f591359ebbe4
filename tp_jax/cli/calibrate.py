"""tp-jax calibrate: a calibration of the angle sensors from readings at known angles."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from tp_jax.cli.arguments import add_common, add_json
from tp_jax.errors import InputError

if TYPE_CHECKING:
    from tp_jax.recordings.calibration import SensorCalibration
    from tp_jax.recordings.calibration_run import Run

LAWS = ("line", "sine", "sine_cosine")
"""Laws of `tp_jax.recordings.calibration`, which would bring NumPy; a test holds them together."""

SCHEMA = "tp-jax/calibration/1"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "calibrate",
        help="make a calibration of the angle sensors",
        description="Fits the sensors' law to volts read at known angles, and writes it, with its "
        "errors, for `tp-jax record --calibration`. FILE.csv has the columns phi1 (known angle, "
        "rad), sine1 and, where it is wired, cosine1 (volts of the two bridges); likewise phi2, "
        "sine2, cosine2, in the same file or in another.",
    )
    parser.add_argument("files", metavar="FILE.csv", nargs="+", help="readings at known angles")
    parser.add_argument(
        "--out", metavar="CALIBRATION.toml", required=True, help="must not be there yet"
    )
    parser.add_argument(
        "--overwrite", action="store_true", help="replace a calibration that is there"
    )
    parser.add_argument(
        "--law",
        choices=LAWS,
        help="volts over angle: a straight line; half the sine of twice the angle, as of one "
        "bridge; or both bridges (default: sine_cosine where cosine1 was read, else sine)",
    )
    parser.add_argument(
        "--degrees", action="store_true", help="the known angles are degrees, not radians"
    )
    add_json(parser)
    add_common(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    from tp_jax.cli.output import ready, write_json

    out = Path(args.out)
    if not args.overwrite and (out.exists() or out.is_symlink()):
        raise InputError(
            f"There is a file {out} already; choose another name, or add --overwrite to replace it."
        )
    if any(out.exists() and Path(file).exists() and out.samefile(file) for file in args.files):
        raise InputError(f"The calibration would replace the readings {out}; name another --out.")

    from tp_jax.recordings.calibration import calibration_entry, write_calibration
    from tp_jax.recordings.calibration_run import calibrate

    calibration, runs = calibrate(args.files, args.law, degrees=args.degrees)
    ready(args.json, out, inputs=args.files)
    write_calibration(out, calibration)
    if args.json is not None:
        spans = {n: s.span for n, s in calibration.sensors.items() if s.span is not None}
        entry = calibration_entry(calibration, spans)
        write_json(args.json, {"schema": SCHEMA, "file": str(out), **entry})
    if not args.quiet and args.json != "-":
        for name, sensor in calibration.sensors.items():
            print(summary(name, sensor, runs[name]))
        print(f"Wrote {out}; use it with tp-jax record --calibration {out}")


def summary(name: str, sensor: "SensorCalibration", run: "Run") -> str:
    """Sums up the calibration of one sensor, in a few lines."""
    import numpy as np

    from tp_jax.recordings.calibration_run import follows_the_angle

    low, high = float(run.angles.min()), float(run.angles.max())
    lines = [f"{name}: law {sensor.law}, {run.angles.size} readings, {low:.4g} to {high:.4g} rad"]
    for parameter, value in sensor.parameters.items():
        unit = "V/rad" if "gain" in parameter else "rad" if parameter == "zero" else "V"
        lines.append(f"  {parameter:14}{_with_error(value, sensor.errors[parameter])} {unit}")
    errors = 1e3 * sensor.standard_error(np.linspace(low, high, 181))
    known = errors[np.isfinite(errors)]
    scatter = _short(1e3 * (sensor.residual or 0.0))
    lines.append(f"  The readings scatter by {scatter} mV about the law")
    lines.append(
        f"  An angle is known to {_short(known.min())} to {_short(known.max())} mrad by it"
    )
    if sensor.law == "sine" and max(-low, high) > 0.25 * math.pi + 1e-9:
        lines.append(
            "  With one bridge an angle beyond 45° reads like a smaller one: stay within ±0.785 rad"
        )
    if follows_the_angle(sensor, run):
        lines.append(
            "  Beware: the scatter follows the angle. The law is not quite the sensor's, and the\n"
            "  errors above are too small; try another law or a smaller range"
        )
    return "\n".join(lines)


def _short(value: float) -> str:
    """Two digits, without an exponent where it can be done: 0.31, 130."""
    return f"{float(f'{value:.2g}'):g}"


def _with_error(value: float, error: float) -> str:
    """Both to the error's second digit: 2.6102 ± 0.0015."""
    digits = 6 if error <= 0.0 else min(max(1 - math.floor(math.log10(error)), 0), 9)
    return f"{value:.{digits}f} ± {error:.{digits}f}"
