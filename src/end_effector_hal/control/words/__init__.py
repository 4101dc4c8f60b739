"""What was decided, in words. Nothing is decided here."""

from ._alarm_changes import alarm_changes
from ._changer_reasons import explain_changer, loose
from ._e_stop import unread_e_stop
from ._reasons import blocking, explain, held_words, latched, left_active, no_maintenance, refusal
from ._status_lines import StatusLines, refused, transition, unanswered
from ._words import word_of
