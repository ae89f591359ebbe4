"""tp-jax serve: a local page for recordings and their diagnoses."""

import argparse
import contextlib
import threading
import webbrowser
from pathlib import Path

from tp_jax.cli.arguments import add_common, whole
from tp_jax.cli.output import new_folder
from tp_jax.errors import InputError

LARGEST_PORT = 65535

NEW = "recordings"
"""The folder that is made where none is named; the next is recordings-2."""


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "serve",
        help="show a local page: drop recordings, check and diagnose them",
        description=(
            "Serves a page on this computer alone, and opens it: drop recordings, see what they "
            "hold and what is wrong with them, diagnose, read and compare reports. Ctrl-C ends it. "
            "(The virtual rig on a port is `tp-jax rig serve`.)"
        ),
    )
    parser.add_argument(
        "folder",
        metavar="DIR",
        nargs="?",
        help=f"with recordings; default: a new folder ./{NEW}",
    )
    parser.add_argument(
        "--port", metavar="N", type=port, default=0, help="of this computer (a free one)"
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="print the page's address and open nothing"
    )
    add_common(parser)
    parser.set_defaults(run=run)


def port(text: str) -> int:
    """A number of a port."""
    return whole(text, most=LARGEST_PORT)


def run(args: argparse.Namespace) -> None:
    try:
        from tp_jax.serve.server import bind
    except ModuleNotFoundError as fault:
        if (fault.name or "").partition(".")[0] not in ("starlette", "uvicorn"):
            raise
        raise InputError(
            f"`tp-jax serve` needs {fault.name}, which is not installed: pip install "
            "'tp-jax[serve]'."
        ) from fault

    new = args.folder is None
    folder = new_folder(NEW).resolve() if new else _folder(args.folder)
    try:
        bound = bind(folder, args.port)
        with bound.ended_by_interrupt():
            print(bound.address, flush=True)
            if not args.quiet:
                print(f"This page is of the folder {folder}; Ctrl-C ends it.", flush=True)
            if not args.no_browser:
                # a browser of the terminal keeps the call until it is closed
                threading.Thread(target=webbrowser.open, args=(bound.once,), daemon=True).start()
            bound.run()
    finally:
        if new:
            with contextlib.suppress(OSError):
                folder.rmdir()  # only where nothing came into it


def _folder(name: str) -> Path:
    folder = Path(name)
    if not folder.is_dir():
        raise InputError(f"{name} is no folder; name one that is there, or none for a new one.")
    return folder.resolve()
