"""Who may ask the app: pages of its own, on this machine, or anybody who knows its token."""

from __future__ import annotations

import secrets
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = ("127.0.0.1", "localhost", "::1")
COOKIE = "turingfold"
HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'self'; "
    "base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Guard:
    """Refuses what does not come from the app's own pages.

    Without a token only names of this machine are answered, so that no page of another site reaches the app
    by a name of its own that leads here. With one, visitors come with ?token=... first, then with a cookie.
    """

    def __init__(self, app: ASGIApp, token: str | None = None) -> None:
        self._app, self._token = app, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer or refuse a request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        await (self._answer(Request(scope)) or self._app)(scope, receive, sending)

    def _answer(self, request: Request) -> Response | None:
        """Return the refusal, or the way back with a cookie; None where the app is to answer."""
        host = request.headers.get("host", "")
        origin = request.headers.get("origin")
        if origin is not None and _place(origin) != host:
            return PlainTextResponse("This request comes from a page of another site.", 403)
        elsewhere = request.headers.get("sec-fetch-site") in ("cross-site", "same-site")
        if elsewhere and request.url.path.startswith("/api/"):
            return PlainTextResponse("This request comes from a page of another site.", 403)
        if self._token is None:
            if _name(host) in LOOPBACK:
                return None
            words = f"The app answers {', '.join(LOOPBACK)} only; for other names start it with --token."
            return PlainTextResponse(words, 403)
        if self._is_token(request.query_params.get("token")) and request.method == "GET":
            back = RedirectResponse(request.url.path.rpartition("/")[2] or "./", 303)
            back.set_cookie(COOKIE, self._token, httponly=True, samesite="lax")
            return back
        if self._is_token(request.cookies.get(COOKIE)):
            return None
        return PlainTextResponse("Open the address with ?token=... that turingfold app printed.", 401)

    def _is_token(self, given: str | None) -> bool:
        own = self._token or ""
        return given is not None and secrets.compare_digest(given.encode(), own.encode())


def _place(origin: str) -> str | None:
    """Return host and port of an Origin header."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None


def _name(host: str) -> str | None:
    """Return the name in a Host header without its port."""
    try:
        return urlsplit(f"//{host}").hostname
    except ValueError:
        return None
