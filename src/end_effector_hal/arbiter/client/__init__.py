"""The other end of the arbiter's socket: for programs that write lines, and for the one that reads the sensors."""

from ._client import OwnerClient, Written
from ._sender import Teller

__all__ = ["OwnerClient", "Teller", "Written"]
