"""The error of the emulated board."""

from end_effector_hal.errors import ReportedError


class BoardError(ReportedError, OSError):
    """The emulated board cannot be built, or did not finish its job."""

    code = "EE-600"
    exit_code = 3
