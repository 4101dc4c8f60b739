"""What opens a recording: ``eehal replay``, ``report`` and ``page``."""
