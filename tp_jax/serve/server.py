"""The process: an address of this computer alone, and the page behind it until it is stopped."""

import secrets
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from tp_jax.errors import InputError
from tp_jax.serve.app import create_app
from tp_jax.serve.jobs import Child, diagnosing
from tp_jax.serve.limits import LIMITS, Limits

HOST = "127.0.0.1"


@dataclass(frozen=True)
class Bound:
    """A server that listens and does not answer yet.

    Attributes:
        address: of the page, with its key.
        once: the same for one visit: a browser's command line, where everybody on this computer can
            read it, must not hold the key.
        port: that it listens at.
    """

    address: str
    once: str
    port: int
    _listening: socket.socket
    _server: uvicorn.Server

    @contextmanager
    def ended_by_interrupt(self) -> Iterator[None]:
        """Within the block Ctrl-C makes `run` return, whether it has begun or not.

        An exception instead, raised while the server is put together, may fall into a place that
        ignores it, and Ctrl-C would be lost.
        """
        if threading.current_thread() is not threading.main_thread():  # where signals do not come
            yield
            return
        before = signal.signal(signal.SIGINT, lambda *_: self.stop())
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    def run(self) -> None:
        """Answers until it is interrupted or told to stop; then a diagnosis that runs ends too."""
        try:
            self._server.run(sockets=[self._listening])
        except KeyboardInterrupt:  # which is how a server ends
            pass
        finally:
            self._listening.close()

    def stop(self) -> None:
        """Makes `run` return; may be called from another thread."""
        self._server.should_exit = True


def bind(
    folder: Path, port: int = 0, *, child: Child = diagnosing, limits: Limits = LIMITS
) -> Bound:
    """Listens at a port of this computer, so that requests wait until `run` answers them.

    Args:
        folder: that is served.
        port: 0 for any that is free.
        child, limits: as of `create_app`.

    Raises:
        InputError: the port is taken, or may not be used.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    # a port that was served a moment ago is free, though the system waits for late packets
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen()
    except OSError as fault:
        listening.close()
        raise InputError(
            f"Port {port} cannot be used ({(fault.strerror or '').lower()}); give --port another, "
            "or leave it out for a free one."
        ) from fault
    port = listening.getsockname()[1]
    token, ticket = (secrets.token_urlsafe(limits.token) for _ in range(2))
    cookie = f"tp-jax-serve-{port}"
    app = create_app(folder, token, ticket=ticket, cookie=cookie, child=child, limits=limits)
    config = uvicorn.Config(
        app,
        http="h11",
        ws="none",
        loop="asyncio",
        lifespan="on",
        log_level="warning",
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=3,
    )
    page = f"http://{HOST}:{port}/"
    address, once = f"{page}?token={token}", f"{page}?ticket={ticket}"
    return Bound(address, once, port, listening, uvicorn.Server(config))
