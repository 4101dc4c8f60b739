"""Texts that explain decisions. This package makes no decisions."""

from ._changer_reasons import explain_changer, loose
from ._event_lines import event_line, event_lines, event_text, refused, unanswered
from ._reasons import blocking, explain, held_words, left_active, no_maintenance, no_part, refusal
from ._words import unread_e_stop, word_of
