"""Rules for links: their frames, the channels in them, and the place of each channel in its frame."""
