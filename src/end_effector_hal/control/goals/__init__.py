"""Goals: accepted or refused and why, over or not, their outcome; the status of the tool that two programs drive."""

from ._goal import CHANNELS, GOAL_COMMANDS, PROGRAM_COMMANDS, Effect, Ending, Goal, GoalEffect, Outcome, Phase
from ._goals import ANSWER_US, NOT_BEGUN, REACHED, Goals, is_over, judge
from ._tool_status import reset_answer, tool_status
