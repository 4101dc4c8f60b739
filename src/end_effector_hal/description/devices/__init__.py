"""The library of devices: a fragment of a description for each, found by its name, merged under the user's keys."""
