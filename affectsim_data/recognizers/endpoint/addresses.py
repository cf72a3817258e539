"""Where an endpoint is, what key it is given, and what of both may be shown."""

from __future__ import annotations

import dataclasses
import ipaddress
import os
from urllib.parse import urlsplit

__all__ = ["DEFAULT_BASE_URL", "Address", "find_address"]

DEFAULT_BASE_URL = "https://api.openai.com/v1"
_NO_KEY = "none"
"""What a local server is told: the client library sends some key in every request."""
_MIN_SCRUBBED = 6
"""Characters of a key below which it may be a part of any word."""


@dataclasses.dataclass(frozen=True)
class Address:
    """A checked base URL, and the key that goes there and nowhere else."""

    base_url: str
    """Without a slash at its end; `chat/completions` is below it."""
    api_key: str = dataclasses.field(repr=False)
    """Sent as a bearer token."""

    @property
    def host(self) -> str:
        """Name or address of the machine."""
        return urlsplit(self.base_url).hostname or ""

    @property
    def is_openai(self) -> bool:
        """Whether it is OpenAI's own."""
        return self.host == urlsplit(DEFAULT_BASE_URL).hostname

    def without_key(self, text: str) -> str:
        """A text that may be shown: servers repeat keys they reject."""
        if len(self.api_key) < _MIN_SCRUBBED:
            return text
        return text.replace(self.api_key, "[key]")


def find_address(
    base_url: str | None = None,
    api_key: str | None = None,
    *,
    api_key_env: str = "OPENAI_API_KEY",
) -> Address:
    """The address of an endpoint, and its key.

    Args:
        base_url: For example `http://localhost:8000/v1`; if not given, that of the environment
            variable `OPENAI_BASE_URL`, else OpenAI's own.
        api_key: The key; if not given, that of an environment variable.
        api_key_env: Name of that variable. It may be unset for a machine of the local network.

    Raises:
        ValueError: The URL is none, holds a secret, or would send the key in the clear over the
            internet; or there is no key.
    """
    url = (base_url or os.environ.get("OPENAI_BASE_URL") or DEFAULT_BASE_URL).strip().rstrip("/")
    local = _is_local(_checked_host(url))
    key = (api_key or os.environ.get(api_key_env) or "").strip()
    if not key:
        if not local:
            raise ValueError(
                f"{url}: needs a key; put it into the environment variable {api_key_env}"
            )
        return Address(url, _NO_KEY)
    if not (key.isascii() and key.isprintable()):
        raise ValueError(f"the key for {url} must be printable ASCII; look at {api_key_env}")
    if url.startswith("http:") and not local:
        raise ValueError(f"{url}: the key would go over the internet in the clear; use https")
    return Address(url, key)


def _checked_host(url: str) -> str:
    """The host of a URL that may stand in messages and logs."""
    try:
        parts = urlsplit(url)
        host, _ = parts.hostname, parts.port
    except ValueError as error:
        raise ValueError(f"base_url must be an http or https URL: {error}") from None
    if any(not 32 < ord(letter) < 127 for letter in url):
        raise ValueError("base_url must be ASCII without spaces")
    # Not shown before this is checked: it may hold a password.
    if parts.username is not None or parts.query or parts.fragment:
        raise ValueError(
            "base_url must have no user, password, query or fragment; keys go into the environment"
        )
    if parts.scheme not in ("http", "https") or not host:
        raise ValueError(f"base_url must be like http://localhost:8000/v1, got {url!r}")
    if parts.path.endswith("/chat/completions"):
        raise ValueError(f"base_url must end before /chat/completions, got {url!r}")
    return host


def _is_local(host: str) -> bool:
    """Whether a host is this machine or of its own network."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return "." not in host or host.endswith((".local", ".localhost", ".internal", ".lan"))
    return address.is_loopback or address.is_private or address.is_link_local
