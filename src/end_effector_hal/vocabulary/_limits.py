"""How large a tool may be: every other limit follows from the number of actuators."""

MOST_ACTUATORS = 64
"""Of a tool; and as many plain outputs."""
MOST_LINES = 2 * MOST_ACTUATORS
"""That one program writes, in one message: each actuator, and what blows its part off."""
MOST_CHANNELS = 4 * MOST_ACTUATORS + 6
"""Of a tool: three switches and an alarm for each actuator, four bits of the tool changer, supply and e-stop."""
MOST_PREDICATES = 2 * MOST_CHANNELS + 4
"""In one message: two for each channel with alarms, and four of the tool changer and the e-stop."""
LONGEST_MESSAGE = 1 << 18
"""Bytes: a ``set`` of MOST_LINES names of 64 characters with its last will, each character escaped, is shorter."""
