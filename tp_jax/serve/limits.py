"""Every number that limits or waits."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Limits on what a page may ask for, and on how long is waited.

    Attributes:
        upload: bytes of a file: some eight million rows. A longer recording can be put into the
            folder by hand.
        files: in the folder in addition to which no more are taken; a page of so many is no use.
        answers: bytes of what the page says of the rig and its runs, a line for each file.
        name: bytes of a file's name; file systems take 255, a name of its part included.
        token: bytes of chance in the key, as many as a session of a bank has.
        grace: seconds that a child has to end by itself before it is killed.
        messages: lines that are kept of what a child says.
        slowest, fastest: frequencies of a drive [rad/s]: a turn in most of a day, and what no motor
            reaches.
    """

    upload: int = 500_000_000
    files: int = 200
    answers: int = 200_000
    name: int = 200
    token: int = 32
    grace: float = 5.0
    messages: int = 20
    slowest: float = 1e-4
    fastest: float = 1e4


LIMITS = Limits()
