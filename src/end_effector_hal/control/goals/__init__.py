"""Goals: acceptance or refusal, end and outcome, and the joint status of the tool's two programs."""

from ._goal import CHANNELS, GOAL_COMMANDS, PROGRAM_COMMANDS, Effect, Ending, Goal, GoalEffect, Outcome, Phase
from ._goals import ANSWER_US, NOT_BEGUN, REACHED, Goals, is_over, judge
from ._tool_status import reset_answer, tool_status
