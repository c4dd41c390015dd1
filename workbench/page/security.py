"""What a request must satisfy before any route sees it: host, origin, token, size; and the headers of every answer.

A page of another site that runs in the same browser can send requests to 127.0.0.1. They are refused since their
`Origin` is another (cross-site requests), or since their `Host` is the other site's name (DNS rebinding).
"""

import hmac
from contextlib import suppress
from dataclasses import dataclass

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response
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

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
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
    """ASGI middleware."""

    app: ASGIApp  # the application
    hosts: frozenset[str]  # permitted values of `Host`, `name:port`
    # secret that a browser presents once in the address and then as a cookie; None: not required
    token: str | None = None
    upload_limit: int = UPLOAD_LIMIT  # largest record file, bytes
    # whether each address of this computer that a request reached is permitted as its `Host`
    every_address: bool = False

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
        elif scope["type"] == "http":
            request = Request(scope)
            upload = scope["path"].startswith(UPLOAD_PATH)
            limit = self.upload_limit if upload else JSON_LIMIT
            length = request.headers.get("content-length", "0")
            small = length.isdigit() and int(length) <= limit
            answer = self._refusal(request, upload) or self._entrance(request) or (None if small else _too_large(limit))
            if answer is not None:
                await answer(scope, receive, send)
            else:
                await self._guarded(scope, receive, send, limit)

    def _refusal(self, request: Request, upload: bool) -> Response | None:
        """The answer to a request of another host or another site."""
        host = request.headers.get("host", "").lower()
        if host not in self.hosts and not (self.every_address and host == _own_address(request)):
            return _refused(421, "the Host of the request is not this server")
        origin = request.headers.get("origin", f"http://{host}").lower()
        site = request.headers.get("sec-fetch-site", "same-origin")
        if origin not in (f"http://{host}", f"https://{host}") or site not in ("same-origin", "none"):
            return _refused(403, "the request comes from another site")
        wanted = "application/octet-stream" if upload else "application/json"
        kind = request.headers.get("content-type", "").partition(";")[0].strip()
        if request.method not in ("GET", "HEAD") and kind != wanted:
            # A form of another site can send neither kind.
            return _refused(415, f"Content-Type {wanted} is required")
        return None

    def _entrance(self, request: Request) -> Response | None:
        """The answer to a browser without the token as a cookie: with it in the address, it gets the cookie."""
        if self.token is None or hmac.compare_digest(request.cookies.get(COOKIE, "").encode(), self.token.encode()):
            return None
        if not hmac.compare_digest(request.query_params.get("token", "").encode(), self.token.encode()):
            return _refused(401, "the address that 'stagecad workbench' printed, with its token, is required")
        rest = request.url.remove_query_params("token").query
        place = f"/{request.scope['path'].lstrip(WITHOUT_HOST)}" + (f"?{rest}" if rest else "")
        answer = RedirectResponse(place, 303, headers=HEADERS)
        answer.set_cookie(COOKIE, self.token, httponly=True, samesite="strict")
        return answer

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
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        with suppress(TooLargeError):
            await self.app(scope, counted, with_headers)
        if received > limit and not started:
            await _too_large(limit)(scope, receive, send)


def _too_large(limit: int) -> Response:
    return _refused(413, f"the body is larger than {limit / 1e6:g} MB")


def _refused(status: int, message: str) -> Response:
    return JSONResponse({"error": message}, status, {**HEADERS, "connection": "close"})


def allowed_hosts(host: str, port: int) -> frozenset[str]:
    """Values of `Host` under which the server is reached."""
    names = {host}
    if host in ("127.0.0.1", "localhost", "::1"):
        names |= {"127.0.0.1", "localhost", "[::1]"}
    if host in EVERY_ADDRESS:
        import socket

        names |= {"127.0.0.1", "localhost", "[::1]", socket.gethostname(), socket.getfqdn()}
    return frozenset(f"{name}:{port}".lower() for name in names)


def _own_address(request: Request) -> str:
    """Address of this computer that a request reached, as its `Host` gives it."""
    host, port = request.scope.get("server") or ("", 0)
    host = host.removeprefix("::ffff:")
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
