"""What somebody else's code has raised, as an alarm that every face can send."""

from __future__ import annotations

from end_effector_hal.errors import ReportedError

LONGEST = 300


def error_text(error: BaseException) -> str:
    """One line of at most 300 characters that can be encoded; an error that cannot say what it is, is named."""
    try:
        text = str(error)
    except Exception:  # noqa: BLE001 a third party's
        text = "an error without words"
    if not isinstance(error, ReportedError):
        text = f"{type(error).__name__}: {text}"
    return sendable(text)


def sendable(text: str) -> str:
    """One line of at most 300 characters that can be encoded."""
    return " ".join(text.split())[:LONGEST].encode("utf-8", "replace").decode()
