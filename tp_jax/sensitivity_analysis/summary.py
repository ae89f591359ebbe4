"""A sensitivity analysis as a table for a terminal."""

from tp_jax.results.sensitivity import KnownParameter, SensitivityRecord

_MANY = 100.0  # standard errors that are this part of a value or more are not told in digits


def summary(result: SensitivityRecord) -> str:
    """A table of the parameters, then what cannot be known and what to be careful about."""
    s = result.structural
    channels = list(result.local.rms)
    signs = [c.replace("phi", "φ") for c in channels]
    lines = [
        f"{result.campaign}: {result.model} model, chi2/dof {result.quality.chi2_dof:.4g}",
        f"Rank {s.rank} of {s.of} over {len(s.recordings)} recordings at {s.points} random points.",
        "",
        f"{'':6}{'value':>11} {'s.e.':>8} {'known':>6}"
        + "".join(f"{'local ' + s:>10}" for s in signs)
        + "".join(f"{'Sobol ' + s:>10}" for s in signs),
        f"{'':6}{'':>11} {'':>8} {'':>6}"
        + f"{'mrad/%':>10}" * len(channels)
        + f"{'total':>10}" * len(channels),
    ]
    for name, p in result.parameters.items():
        cells = [f"{_local(result, c, name):>10}" for c in channels]
        cells += [f"{_total(result, c, name):>10}" for c in channels]
        known = "given" if p.given else "yes" if p.identifiable else "no"
        lines.append(f"{name:6}{p.value:11.4g} {_error(p):>8} {known:>6}{''.join(cells)}")
    if result.null_directions:
        lines += ["", "Not told by these recordings:"]
        for d in result.null_directions:
            ending = f" ({d.removed_by})" if d.removed_by else ""
            lines.append(f"  {d.text}{ending}")
    for name, p in result.profile.items():
        low, high = (("open" if x is None else f"{x:.4g}") for x in p.ci95)
        lines.append(f"Profile of {name}: {low} to {high} (95 %)")
    lines += [f"Warning: {w.text}" for w in result.warnings]
    return "\n".join(lines)


def _error(p: KnownParameter) -> str:
    if p.given or p.standard_error is None:
        return "-"
    part = p.standard_error / max(abs(p.value), 1e-300)
    return f"{100.0 * part:.2g} %" if part < _MANY else "large"


def _local(result: SensitivityRecord, channel: str, name: str) -> str:
    found = result.local.rms.get(channel, {}).get(name)
    return "-" if found is None else f"{10.0 * found:.3g}"  # rad per unit = 10 mrad per cent


def _total(result: SensitivityRecord, channel: str, name: str) -> str:
    found = result.sobol.total.get(channel, {}).get(name)
    return "-" if found is None else f"{found:.3f}"
