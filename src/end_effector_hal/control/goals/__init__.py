"""Goals: acceptance or refusal, end and outcome, and the joint answer to a reset."""

from ._goal import CHANNELS, GOAL_COMMANDS, Effect, Ending, Goal, GoalEffect, Outcome, Phase
from ._goals import NOT_BEGUN, REACHED, Goals, is_over, judge
from ._reset import reset_answer
