"""Which calibration a rig is read with."""

import numpy as np

from tp_jax.acquisition import protocol
from tp_jax.acquisition.calibration import Calibration, SensorCalibration, nominal
from tp_jax.acquisition.device import Device
from tp_jax.errors import InputError

_BRIDGES = {"phi1": (protocol.SINE1, protocol.COSINE1), "phi2": (protocol.SINE2, protocol.COSINE2)}


def rig_calibration(device: Device, given: Calibration | None, patience: float) -> Calibration:
    """The calibration for a rig that speaks the protocol: given, else announced, else nominal.

    Raises:
        InputError: a sensor has no calibration, or one that needs a bridge that is not wired.
    """
    identity = device.identity
    assert identity is not None
    wired = {n: bits for n, bits in _BRIDGES.items() if identity.wired & bits[0]}
    if "phi1" not in wired:
        raise InputError("The rig has no sine bridge on the column wired; connect it.")
    if given is not None:
        for name, (_, cosine) in wired.items():
            sensor = given.sensors.get(name)
            if sensor is None:
                raise InputError(
                    f"The calibration {given.source} has no [{name}], which the rig has; add it."
                )
            if sensor.needs_cosine and not identity.wired & cosine:
                raise InputError(
                    f"The calibration {given.source} of {name} needs the cosine bridge, which the "
                    'rig has not wired; use the law "sine" or wire it.'
                )
        return Calibration({n: given.sensors[n] for n in wired}, given.source)
    announced = device.calibrations(patience)
    sensors, sources = {}, set()
    for number, (name, (_, cosine)) in enumerate(_BRIDGES.items(), start=1):
        if name not in wired:
            continue
        if number in announced and announced[number].law < len(protocol.LAWS):
            sensors[name] = _announced(announced[number])
            sources.add("announced by the rig")
        else:
            sensors[name] = nominal(identity.reference, bool(identity.wired & cosine))
            sources.add("nominal, to be replaced by a calibration of this rig")
    return Calibration(sensors, "; ".join(sorted(sources)))


def _announced(told: protocol.Announced) -> SensorCalibration:
    law = protocol.LAWS[told.law]
    p = 5 if law == "sine_cosine" else 2
    # as the decimal numbers that single precision stands for: 1.7, not 1.7000000476837158
    values = [float(f"{x:.7g}") for x in told.values[:p]]
    errors = [float(f"{x:.7g}") for x in told.errors[:p]]
    return SensorCalibration(law, np.array(values), np.diag(np.square(errors)))
