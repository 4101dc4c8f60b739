"""What can be shown of a model and of a recorded run: proof and replay."""

from ._model_run import has_states, states_of, write_states
