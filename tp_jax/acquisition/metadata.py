"""What is known of a recording besides its angles: FILE.csv.meta.json beside FILE.csv.

The file is there from the first sample on and says `"state": "recording"` until the end, so that
a recording that was cut off tells so itself.

    {"schema": "tp-jax/recording/1", "file": "run.csv", "columns": ["t", "phi1", "phi2"],
     "state": "complete",              // recording | complete | interrupted | unplugged
                                       // | restarted | silent | failed
     "started": "2026-03-01T09:30:00.123456+00:00",    // host's clock at t = 0, UTC
     "command": ["tp-jax", "record", ...],
     "port": "/dev/ttyACM0", "baud": 460800, "stream": "frames",      // or "text"
     "device": {"name": "...", "boot": 1, "protocol": 1, "rate": 1000.0, ...},  // null: text
     "drive": {"omega": 13.09, "amplitude": null, "release": null,
               "commanded": true},     // false: a text stream, or a rig without a motor to command
     "calibration": {"source": "...", "phi1": {"law": "sine_cosine", ..., "standard_error":
                     {"angle": [..], "value": [..], "modes": [[..], ..], "largest": ..}}},  // rad
     "samples": {"written": 60001, "lost": 0, "implausible": 0, "clipped": {"phi1": 0}},
     "frames": {"good": 60003, "corrupt": 0, "unknown": 0},
     "gaps": [{"after": 20.0, "before": 23.001, "samples": 3000, "cause": "unplugged"}],  // s
     "gaps_not_listed": 0,
     "uncertain_turns": {"phi2": [23.001]},            // times at which a branch was guessed
     "clock": {"skew": 1.2e-6, "skew_error": .., "offset": .., "offset_error": .., "delay": ..,
               "applied": false},      // null: too short, or not in real time
     "time": "..."}                    // in words, what the time column is

`standard_error` is the part of the angle's error that the calibration causes, the same for all
samples at an angle. `modes` are the shapes over the angle it is made of, independent of each other;
`value` is their root sum of squares (see `recordings.calibration_error`).
"""

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tp_jax._files import replaced
from tp_jax.acquisition.calibration import Calibration, SensorCalibration
from tp_jax.acquisition.clock import ClockFit
from tp_jax.acquisition.protocol import Identity


def metadata_path(recording: str | os.PathLike[str]) -> Path:
    """Where a recording's metadata are."""
    return Path(f"{os.fspath(recording)}.meta.json")


def write_metadata(recording: Path, content: Mapping[str, Any]) -> dict[str, Any]:
    """Writes or replaces a recording's metadata; returns them in JSON's own types."""
    plain = _plain(content)
    text = json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with replaced(metadata_path(recording)) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return plain


def calibration_entry(
    calibration: Calibration, spans: Mapping[str, tuple[float, float]]
) -> dict[str, Any]:
    """The calibration with its standard errors over the angles that were recorded.

    Args:
        calibration: of the rig.
        spans: sensor -> least and largest angle [rad] recorded, where there are any yet.
    """
    entry: dict[str, Any] = {"source": calibration.source}
    for name, sensor in calibration.sensors.items():
        entry[name] = _sensor(sensor, spans.get(name, (-0.25 * math.pi, 0.25 * math.pi)))
    return entry


def clock_entry(fit: ClockFit | None, applied: bool) -> dict[str, Any] | None:
    """The clock's fit; None where there is none."""
    if fit is None:
        return None
    return {
        "skew": fit.skew,
        "skew_error": fit.skew_error,
        "offset": fit.offset,
        "offset_error": fit.offset_error,
        "delay": fit.delay,
        "points": fit.points,
        "applied": applied,
    }


def identity_entry(identity: Identity | None) -> dict[str, Any] | None:
    """The rig's identity for the metadata; None where it has none."""
    if identity is None:
        return None
    return {
        "name": identity.name,
        "protocol": identity.protocol,
        "boot": identity.boot,
        "run": identity.run,
        "rate": identity.rate,
        "adc_bits": identity.adc_bits,
        "reference": identity.reference,
        "wired": [
            name
            for bit, name in enumerate(("sine1", "cosine1", "sine2", "cosine2"))
            if identity.wired >> bit & 1
        ],
        "amplitude": identity.amplitude or None,
    }


def _sensor(sensor: SensorCalibration, span: tuple[float, float]) -> dict[str, Any]:
    # a bridge repeats itself after half a turn: a ring that winds needs no more of it
    winds = span[1] - span[0] >= math.pi and sensor.law != "line"
    low, high = (-0.5 * math.pi, 0.5 * math.pi) if winds else span
    angle = np.linspace(low, max(high, low + 1e-3), 25)  # of a body that never moved as well
    error, modes = sensor.standard_error(angle), sensor.error_modes(angle)
    modes = modes[modes.any(axis=1)]
    return {
        "law": sensor.law,
        **sensor.parameters,
        "errors": sensor.errors,
        "covariance": sensor.covariance,
        "span": sensor.span,
        "residual": sensor.residual,
        "standard_error": {
            "angle": angle,
            "value": error,
            "modes": modes,
            "largest": float(error.max()),
        },
    }


def _plain(value: Any) -> Any:
    """The value in JSON's own types; NaN and infinities become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
