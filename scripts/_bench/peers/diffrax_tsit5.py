"""diffrax's Tsit5: explicit, its usual choice for problems that are not stiff."""

import diffrax

from ..peer import Peer
from ._diffrax import peer


def make() -> Peer:
    """The peer."""
    return peer("diffrax-tsit5", diffrax.Tsit5())
