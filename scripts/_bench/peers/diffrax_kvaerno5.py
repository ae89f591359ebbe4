"""diffrax's Kvaerno5: implicit, its strongest method for stiff problems."""

import diffrax

from ..peer import Peer
from ._diffrax import peer


def make() -> Peer:
    """The peer."""
    return peer("diffrax-kvaerno5", diffrax.Kvaerno5())
