"""The column receives more or less than the contact's torque."""

from tp_jax.effects.base import Amplitude, Effect


class ReactionFactor(Effect):
    """`B1 v1' = ... + (1 + a) M_T`"""

    id = "reaction_factor"
    location = "model"
    hook = "column"
    amplitudes = (Amplitude("a", "1", typical=0.2),)
    needs = frozenset({"rider", "inertias"})
    formula = "B1 v1' = ... + (1 + a) M_T"
    source = "the factor 2 of equation (16a)"
    looks_like = "inertias that do not agree with those given"
    remedy = "keep the factor at 1, which Newton's third law asks for; the paper prints 2"
    by_hand = "weigh and measure both bodies, and compare their inertias with the fitted ones"

    def increment(self, m, a):  # type: ignore[override]
        """See the class."""
        return a * m.contact
