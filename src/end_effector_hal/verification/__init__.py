"""Verify models and recorded runs: proofs and replays."""

from ._model_run import has_states, states_of, write_states
