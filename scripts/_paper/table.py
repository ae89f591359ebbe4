"""The methods side by side, for a terminal."""

from typing import Any

_SHOWN = ("B2", "k", "A", "c1", "M1", "Tv", "Ts1", "Tst", "T0")


def lines(result: dict[str, Any]) -> list[str]:
    """Plain text."""
    out = []
    titles = {"printed": "as printed", "slipping": "driven near resonance, where the rider slips"}
    for key, run in result["section_5_1"]["runs"].items():
        out += [
            f"Section 5.1, ω = {run['omega']} rad/s, {titles[key]}; y of the start "
            f"{run['y_start']:.3g}",
            f"{'':28}{'evaluations':>12}{'seconds':>9}{'y':>10}  relative errors of "
            + ", ".join(_SHOWN),
        ]
        for row in run["methods"]:
            told = " ".join(f"{_part(row['errors'][n]):>7}" for n in _SHOWN)
            out.append(
                f"{row['method']:28}{row['evaluations']:12d}{row['seconds']:9.1f}{row['y']:10.2g}"
                f"  {told}"
            )
        if key == "printed":
            out.append("  of what a run without slip shows:")
            for row in run["methods"]:
                told = ", ".join(f"{n} {_part(e)}" for n, e in row["stuck_errors"].items())
                out.append(f"  {row['method']:28}{told}")
        out.append("")
    out.append("Section 5.2 on a virtual rig (the paper ended at y = 0.01171 and 0.05328)")
    for i, entry in enumerate(result["section_5_2"]["identifications"]):
        for name, key in (("Nelder-Mead", "nelder_mead"), ("windows", "windows")):
            row = entry[key]
            out.append(
                f"{i + 1} {name:26}{row['evaluations']:12d}{row['seconds']:9.1f}{row['y']:10.2g}"
                f"  rms φ1 {row['rms_phi1']:.3g}, φ2 {row['rms_phi2']:.3g} rad{_negative(row['x'])}"
            )
    return out


def _negative(x: dict[str, float]) -> str:
    """Says what the search has made of numbers that cannot be below zero."""
    below = [n for n, value in x.items() if value < 0.0]
    return f"; below zero: {', '.join(below)}" if below else ""


def _part(error: float) -> str:
    return f"{100.0 * error:+.2g}%" if abs(error) < 10.0 else ">10x"
