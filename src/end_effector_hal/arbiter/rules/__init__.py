"""The rules of the lines: leases, interlocks, last wills. No sockets and no files; time is an argument, in µs."""

from ._session import Driven, Session
