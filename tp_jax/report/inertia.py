"""The column's inertia in a diagnosis: no angle shows it, and it fixes the scale of all torques."""

from tp_jax.model.inertia_units import per_inertia
from tp_jax.results.diagnosis import DiagnosisRecord


def inertia(diagnosis: DiagnosisRecord) -> float | None:
    """B1 [kg m^2]; 1 where it was not given, None where the file does not say."""
    if diagnosis.fits is None:
        return None
    return diagnosis.fits.before.parameters.get("B1")


def given(B1: float) -> bool:
    """False where torques are per unit of B1, since B1 = 1 was taken for want of a number."""
    return B1 != 1.0


def unit_under(B1: float | None, unit: str) -> str:
    """A unit of a diagnosis, with "/B1" behind a torque's where B1 was not given."""
    return per_inertia(unit) if B1 is not None and not given(B1) else unit
