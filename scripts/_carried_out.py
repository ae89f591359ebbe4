"""The end of every study: what it came to as an exit code, as the command line tells it."""

import argparse
import sys
from collections.abc import Callable

from tp_jax.cli.faults import explain


def carried_out(
    name: str, work: Callable[[argparse.Namespace], int], args: argparse.Namespace, *, resumes: bool
) -> int:
    """Does the work; the exit code. A fault is one sentence.

    Args:
        name: of the script.
        work: of the arguments, gives an exit code.
        args: with `debug`: whether a fault shows its traceback.
        resumes: whether the same call goes on where an interrupted one was.
    """
    try:
        return work(args)
    except KeyboardInterrupt:
        further = "; the same call goes on from here." if resumes else "."
        print(f"{name}: interrupted{further}", file=sys.stderr)
        return 130
    except Exception as fault:
        return explain(fault, debug=args.debug)
