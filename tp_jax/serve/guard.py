"""Rules on who may ask, and what every answer says to the browser.

The page stands on this computer alone, but a browser carries pages of other makers, and those can
send requests here too. So each request needs the token, names this computer (a foreign name that
was made to lead here does not), and changes something only from the page itself.
"""

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK = {"127.0.0.1", "localhost", "::1"}
"""Names that lead to this computer and nowhere else."""

READING = {"GET", "HEAD"}

PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
REPORT_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; form-action 'none'; "
    "base-uri 'none'; frame-ancestors 'none'"
)
"""A report holds its own styles; a script in it does not run."""

HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}


class Guard:
    """Lets through requests that know the token and come from the page itself."""

    def __init__(self, app: App, token: str, cookie: str, ticket: str = "") -> None:
        """
        Args:
            app: behind it.
            token: the key.
            cookie: its name; cookies of one computer are shared by all its ports.
            ticket: stands for the key in the address of one visit; empty: none does.
        """
        self.app, self.token, self.cookie, self.ticket = app, token, cookie, ticket

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":  # a web socket, which nothing here speaks
            return
        headers = {k.decode("latin-1"): v.decode("latin-1") for k, v in scope["headers"]}

        async def sent(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                there = {name for name, _ in message["headers"]}
                own = {"content-security-policy": PAGE_POLICY, **HEADERS}
                message["headers"] = [
                    *message["headers"],
                    *((k.encode(), v.encode()) for k, v in own.items() if k.encode() not in there),
                ]
            await send(message)

        refused = self._refused(scope, headers)
        if refused is not None:
            await _answer(sent, 403, refused)
            return
        if scope["method"] == "GET" and scope["path"] == "/" and self._let_in(scope):
            cookie = f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
            # to the address without the token, which then stands in no history
            await _answer(sent, 303, "", [(b"location", b"/"), (b"set-cookie", cookie.encode())])
            return
        if not (self._known(_bearer(headers)) or self._known(self._kept(headers))):
            await _answer(
                sent,
                403,
                "This page needs its key; open the address that tp-jax serve printed at its start.",
            )
            return
        await self.app(scope, receive, sent)

    def _refused(self, scope: Scope, headers: dict[str, str]) -> str | None:
        """Says why a request is none of this page's, whatever it knows."""
        host = headers.get("host", "")
        if _name_of(f"http://{host}") not in LOOPBACK:
            return "The address must name this computer, as http://127.0.0.1 does."
        if scope["method"] in READING:
            return None
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{host}":
            return "Only the page itself may change anything here."
        if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
            return "Only the page itself may change anything here."
        return None

    def _let_in(self, scope: Scope) -> bool:
        """True if the address holds the key, or the ticket for the first time."""
        said = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        if self._known(said.get("token", [""])[0]):
            return True
        ticket = said.get("ticket", [""])[0]
        if not self.ticket or not hmac.compare_digest(ticket.encode(), self.ticket.encode()):
            return False
        self.ticket = ""
        return True

    def _known(self, said: str) -> bool:
        return hmac.compare_digest(said.encode(), self.token.encode())

    def _kept(self, headers: dict[str, str]) -> str:
        """The key in the cookie; those of other programs on this computer may have any form."""
        for each in headers.get("cookie", "").split(";"):
            name, _, value = each.strip().partition("=")
            if name == self.cookie:
                return value
        return ""


def _bearer(headers: dict[str, str]) -> str:
    kind, _, said = headers.get("authorization", "").partition(" ")
    return said if kind.lower() == "bearer" else ""


def _name_of(address: str) -> str | None:
    try:
        return urlsplit(address).hostname
    except ValueError:
        return None


async def _answer(
    send: Send, status: int, text: str, more: list[tuple[bytes, bytes]] | None = None
) -> None:
    body = f"{text}\n".encode() if text else b""
    head = [(b"content-type", b"text/plain; charset=utf-8"), *(more or [])]
    head.append((b"content-length", str(len(body)).encode()))
    await send({"type": "http.response.start", "status": status, "headers": head})
    await send({"type": "http.response.body", "body": body})
