"""What a request must satisfy before any route sees it: host, origin, token, size; and the headers of every answer.

A page of another site that runs in the same browser can send requests to 127.0.0.1. They are refused since their
`Origin` is another (cross-site requests), or since their `Host` is the other site's name (DNS rebinding).
"""

from __future__ import annotations

import hmac
import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, quote, urlencode

from starlette.types import ASGIApp, Message, Receive, Scope, Send

EVERY_ADDRESS = ("0.0.0.0", "::")
"""Addresses to listen on that stand for all addresses of this computer."""
COOKIE = "stagecad"
JSON_LIMIT = 1_000_000
"""Largest body of a request, bytes."""
UPLOAD_LIMIT = 500_000_000
"""Largest record file, bytes."""
WITHOUT_HOST = "/\\"
"""Signs at the beginning of a path that would make the next word a host."""
UPLOAD_PATH = "/api/upload/"

POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "frame-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Content policy of the page: nothing from another site, no script or style in the text of the page."""

REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'self'; sandbox"
"""Content policy of a report, which is one file with its styles and pictures inside: no script at all."""

HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "content-security-policy": POLICY,
    "cache-control": "no-cache",
}


class TooLargeError(Exception):
    """The body of a request exceeds the limit."""


@dataclass(frozen=True)
class Guard:
    """ASGI middleware.

    Args:
        app: the application.
        hosts: permitted values of `Host`, `name:port`.
        token: secret that a browser presents once in the address and then as a cookie; None: not required.
        upload_limit: largest record file, bytes.
        every_address: whether each address of this computer that a request reached is permitted as its `Host`.
    """

    app: ASGIApp
    hosts: frozenset[str]
    token: str | None = None
    upload_limit: int = UPLOAD_LIMIT
    every_address: bool = False

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            return
        headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        refused = self._refusal(scope, headers)
        if refused is not None:
            await _answer(send, *refused)
            return
        if self.token is not None and not self._cookie(headers):
            given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
            if not hmac.compare_digest(given.encode(), self.token.encode()):
                await _answer(send, 401, "the address that 'stagecad workbench' printed, with its token, is required")
                return
            await _set_cookie(send, scope, self.token)
            return
        limit = self.upload_limit if scope["path"].startswith(UPLOAD_PATH) else JSON_LIMIT
        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > limit:
            await _answer(send, 413, f"the body is larger than {limit / 1e6:g} MB")
            return
        await self._guarded(scope, receive, send, limit)

    def _refusal(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        host = headers.get("host", "").lower()
        if host not in self.hosts and not (self.every_address and host == _own_address(scope)):
            return 421, "the Host of the request is not this server"
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in (f"http://{host}", f"https://{host}"):
            return 403, "the request comes from another site"
        if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
            return 403, "the request comes from another site"
        if scope["method"] not in ("GET", "HEAD"):
            kind = headers.get("content-type", "").partition(";")[0].strip()
            wanted = "application/octet-stream" if scope["path"].startswith(UPLOAD_PATH) else "application/json"
            if kind != wanted:
                # A form of another site can send neither kind.
                return 415, f"Content-Type {wanted} is required"
        return None

    def _cookie(self, headers: dict[str, str]) -> bool:
        assert self.token is not None
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
        except CookieError:
            return False
        return cookie is not None and hmac.compare_digest(cookie.value.encode(), self.token.encode())

    async def _guarded(self, scope: Scope, receive: Receive, send: Send, limit: int) -> None:
        received, started = 0, False

        async def counted() -> Message:
            nonlocal received
            message = await receive()
            received += len(message.get("body", b""))
            if received > limit:
                raise TooLargeError
            return message

        async def with_headers(message: Message) -> None:
            nonlocal started
            if received > limit and not started:
                # What the application makes of the interruption is not the answer.
                return
            if message["type"] == "http.response.start":
                started = True
                present = {name for name, _ in message["headers"]}
                extra = [(k.encode(), v.encode()) for k, v in HEADERS.items() if k.encode() not in present]
                message = {**message, "headers": [*message["headers"], *extra]}
            await send(message)

        with suppress(TooLargeError):
            await self.app(scope, counted, with_headers)
        if received > limit and not started:
            await _answer(send, 413, f"the body is larger than {limit / 1e6:g} MB")


def allowed_hosts(host: str, port: int, more: Iterable[str] = ()) -> frozenset[str]:
    """Values of `Host` under which the server is reached."""
    names = {host, *more}
    if host in ("127.0.0.1", "localhost", "::1"):
        names |= {"127.0.0.1", "localhost", "[::1]"}
    if host in EVERY_ADDRESS:
        import socket

        names |= {"127.0.0.1", "localhost", "[::1]", socket.gethostname(), socket.getfqdn()}
    return frozenset(f"{name}:{port}".lower() for name in names)


def _own_address(scope: Scope) -> str:
    """Address of this computer that a request reached, as its `Host` gives it."""
    host, port = scope.get("server") or ("", 0)
    host = host.removeprefix("::ffff:")
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


async def _answer(send: Send, status: int, message: str) -> None:
    body = json.dumps({"error": message}).encode()
    headers = {**HEADERS, "content-type": "application/json", "content-length": str(len(body)), "connection": "close"}
    raw = [(name.encode(), value.encode()) for name, value in headers.items()]
    await send({"type": "http.response.start", "status": status, "headers": raw})
    await send({"type": "http.response.body", "body": body})


async def _set_cookie(send: Send, scope: Scope, token: str) -> None:
    """Store the token as a cookie, and lead to the address without it."""
    query = parse_qs(scope["query_string"].decode("latin-1"))
    query.pop("token", None)
    rest = f"?{urlencode(query, doseq=True)}" if query else ""
    headers = {
        **HEADERS,
        "location": f"/{quote(scope['path'].lstrip(WITHOUT_HOST))}{rest}",
        "set-cookie": f"{COOKIE}={token}; HttpOnly; SameSite=Strict; Path=/",
        "content-length": "0",
    }
    raw = [(name.encode(), value.encode("latin-1")) for name, value in headers.items()]
    await send({"type": "http.response.start", "status": 303, "headers": raw})
    await send({"type": "http.response.body", "body": b""})
