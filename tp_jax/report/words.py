"""Names of the ids of results in sentences.

Parameters from outside the package have no entry here and go by their ids; effects from outside
bring their clause, `says`.
"""

import sys

#: Effect to a clause that can follow "the cause:".
EFFECTS = {
    "base_compliance": "the housing gives way, so that bearing and spring hook move with the load",
    "bearing_asymmetry": "the bearing's dry friction differs between the two senses of rotation",
    "bearing_drag": "the column feels a drag that grows with the square of its speed",
    "bearing_load": "the bearing's dry friction grows with the load of the spring",
    "bearing_position": "the bearing's dry friction depends on its angle",
    "bearing_presliding": "the bearing gives way elastically before it slides",
    "bearing_stribeck": "the bearing's dry friction drops as the column starts to move",
    "bearing_warmup": "the bearing's friction drifts within a recording, as when it warms up",
    "channel_delay": "the second channel is sampled later than the first",
    "clock_skew": "the recorder's clock runs fast or slow",
    "column_cable": "the sensor cable holds the column back elastically, then slips",
    "column_tilt": "gravity pulls on a mass off the column's axis",
    "contact_asymmetry": "the contact's dry friction differs between the two senses of sliding",
    "contact_cogging": "magnets on the rider pull it to preferred angles",
    "contact_position": "the contact's dry friction depends on the rider's angle",
    "contact_presliding": "the contact gives way elastically before the rider slides",
    "contact_repeatability": "the contact's friction is not the same from run to run",
    "contact_stribeck": "the contact's dry friction drops as the rider starts to slide",
    "contact_vibration": "the column vibrates vertically, so that the contact's friction ripples",
    "contact_wear": "the contact's dry friction drifts within a recording",
    "drive_backlash": "the drive has play",
    "drive_delay": "the recorded drive is late or early against the angles",
    "drive_frequency": "the motor does not turn at the commanded speed",
    "drive_harmonics": "the drive's cam and arm do not make a pure sine",
    "drive_steps": "the stepper motor moves in steps",
    "elastic_stop": "beyond some angle the column runs against an elastic stop",
    "reaction_factor": "the column receives more or less than the contact's torque",
    "sensor1_drift": "gain or zero of sensor 1 drift within a recording",
    "sensor1_eccentricity": "the disc of sensor 1 sits off its axis",
    "sensor1_interpolation": "the two signals of sensor 1 are no clean sine and cosine",
    "sensor1_nonlinearity": "sensor 1 is not linear",
    "sensor2_drift": "gain or zero of sensor 2 drift within a recording",
    "sensor2_eccentricity": "the disc of sensor 2 sits off its axis",
    "sensor2_interpolation": "the two signals of sensor 2 are no clean sine and cosine",
    "sensor2_nonlinearity": "sensor 2 is not linear",
    "sensor_crosstalk": "the rider's sensor also sees the column's angle",
    "spring_asymmetry": "the spring is stiffer in one sense of winding than in the other",
    "spring_deadzone": "there is play between the spring and its hook",
    "spring_hardening": "the spring hardens or softens as it is wound",
    "spring_hysteresis": "the spring's torque differs between loading and unloading",
    "spring_relaxation": "the spring's stiffness drifts within a recording",
}

#: Place of a law that was learned, to a noun; see `tp_jax.effects.laws`.
LAW_PLACES = {
    "bearing_dry": "the bearing's dry friction",
    "column": "a torque on the column",
    "contact_dry": "the contact's dry friction",
    "drive": "the drive's angle",
    "sensor1": "the error of sensor 1",
    "sensor2": "the error of sensor 2",
    "spring": "the spring's torque",
}

#: Argument of such a law, to a noun.
LAW_ARGUMENTS = {
    "d": "how far the spring is wound",
    "load": "the spring's load",
    "phi1": "the column's angle",
    "phi2": "the rider's angle",
    "t": "the time within a recording",
    "theta": "the motor's phase",
    "v1": "the column's speed",
    "v2": "the speed of sliding",
}

#: Location in the rig to a noun.
LOCATIONS = {
    "base": "the base",
    "bearing": "the bearing of the column",
    "clock": "the timing of the recording",
    "column": "the column",
    "contact": "the contact between column and rider",
    "drive": "the drive",
    "model": "the model's reaction torque",
    "sensor1": "sensor 1 (φ1)",
    "sensor2": "sensor 2 (φ2)",
    "spring": "the spring",
}

#: Parameter of the model to a noun.
PARAMETERS = {
    "A": "amplitude of the drive",
    "B1": "inertia of the column",
    "B2": "inertia of the rider",
    "M1": "dry bearing friction",
    "T0": "rate at which Tst rises",
    "Ts1": "dry contact friction",
    "Ts2": "contact friction at rest",
    "Tst": "contact friction that rises with speed",
    "Tv": "viscous contact friction",
    "c1": "viscous bearing friction",
    "k": "stiffness of the spring",
    "phase": "phase of the drive at t = 0",
}


def effect(name: str) -> str:
    """`contact_stribeck` to what happens; an unknown effect to its id in words."""
    return clause(name) or f"the effect {name}"


def clause(name: str) -> str:
    """Says what an effect does, as a clause; "" where nobody has said."""
    if name in EFFECTS:
        return EFFECTS[name]
    place, _, argument = name.partition(".")
    if place in LAW_PLACES and argument in LAW_ARGUMENTS:
        over = LAW_ARGUMENTS[argument]
        return f"{LAW_PLACES[place]} changes with {over}, along a curve that was learned"
    effects = sys.modules.get("tp_jax.effects")  # a report of what was diagnosed before needs none
    own = None if effects is None else effects.catalogue().get(name)
    return "" if own is None else own.says


def location(name: str) -> str:
    """`contact` to a noun with its article."""
    return LOCATIONS.get(name, name)


def parameter(name: str) -> str:
    """`k` to a noun; nothing where there is no word for it."""
    return PARAMETERS.get(name, "")


def capital(text: str) -> str:
    """The text with a capital first letter, the rest as it is."""
    return text[:1].upper() + text[1:]


def listed(items: list[str], last: str = "and") -> str:
    """`a, b and c`"""
    return f" {last} ".join(part for part in (", ".join(items[:-1]), *items[-1:]) if part)
