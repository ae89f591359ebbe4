"""Effects between rider and column beyond the package's catalogue."""

import math

from trials.effects.base import Outside


class OutsideContact(Outside):
    """Base class of the contact's effects that the catalogue lacks."""

    channel, location = "contact", "contact"
    needs_rider = True


class ContactDwell(OutsideContact):
    """A rider that rests grows fast: its friction at rest rises with the time it has rested."""

    id = "contact_dwell"
    formula = "at rest, limit times 1 + a (1 - exp(-rested / tau)); sliding, as without"
    shapes = {"tau": 0.05}  # noqa: RUF012

    def install(self, run, a):
        tau = run.shapes["tau"]
        since: float | None = None

        def commit(m, stuck):
            nonlocal since
            since = (m.t if since is None else since) if stuck else None

        def grown(m):
            if not m.stuck or since is None:
                return 0.0
            return -a * math.expm1(-(m.t - since) / tau)

        run.hooks.commits.append(commit)
        run.hooks.grip.append(grown)

    def drawn(self, dice):
        return self._drawn(dice.between(0.4, 1.0), tau=dice.between(0.02, 0.06))


class ContactTwist(OutsideContact):
    """The head wobbles with the column's angle, and with it the normal force."""

    id = "contact_twist"
    formula = "dry friction times 1 + a phi1"
    unit = ("1/rad",)

    def install(self, run, a):
        run.hooks.grip.append(lambda m: a * m.phi1)

    def drawn(self, dice):
        return self._drawn(dice.signed(0.1, 0.25) / dice.rig.A)


class ContactCubic(OutsideContact):
    """Viscous friction that rises with the third power of the speed."""

    id = "contact_cubic"
    formula = "a v2^3"
    unit = ("N m s^3/rad^3",)

    def install(self, run, a):
        run.hooks.contact.append(lambda m: a * m.v2 * m.v2 * m.v2)

    def drawn(self, dice):
        return self._drawn(dice.between(0.3, 1.0) * dice.rig.Ts1 / 5.0**3)


class ContactCentrifugal(OutsideContact):
    """The rider's jaws fly outwards with its absolute speed, and press less."""

    id = "contact_centrifugal"
    formula = "dry friction times 1 - a (v1 + v2)^2"
    unit = ("s^2/rad^2",)

    def install(self, run, a):
        run.hooks.grip.append(lambda m: -a * (m.v1 + m.v2) ** 2)

    def drawn(self, dice):
        return self._drawn(dice.between(0.2, 0.6) / 5.0**2)
