"""Deaths of program and line arbiter at any instant: a network of their own, of two lines and the session record."""

from ._deaths import DEATHS_FILE, death_network
