"""Turn exceptions of third-party code into text that every interface can send."""

from __future__ import annotations

from end_effector_hal.errors import ReportedError

LONGEST = 300


def error_text(error: BaseException) -> str:
    """Return the error as one line of at most 300 characters that can be encoded.

    An error whose text cannot be read is shown by the name of its class.
    """
    try:
        text = str(error)
    except Exception:  # noqa: BLE001 a third party's
        text = "an error without words"
    if not isinstance(error, ReportedError):
        text = f"{type(error).__name__}: {text}"
    return sendable(text)


def sendable(text: str) -> str:
    """Return the text as one line of at most 300 characters that can be encoded."""
    return " ".join(text.split())[:LONGEST].encode("utf-8", "replace").decode()
