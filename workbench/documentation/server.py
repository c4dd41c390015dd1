"""The built documentation, served on this machine."""

from __future__ import annotations

from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError


class _Quiet(SimpleHTTPRequestHandler):
    """Files of one folder; requests are not logged."""

    def log_message(self, format: str, *arguments: Any) -> None:
        pass


def documentation_server(folder: Path, port: int) -> ThreadingHTTPServer:
    """A server of the files of a folder on 127.0.0.1; `port` 0 takes a free one."""
    try:
        return ThreadingHTTPServer(("127.0.0.1", port), partial(_Quiet, directory=str(folder)))
    except OSError as error:
        raise InputError(f"--port {port}: {error.strerror}; choose another, or 0 for a free one") from None
