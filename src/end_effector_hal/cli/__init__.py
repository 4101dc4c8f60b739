"""The command line ``eehal``. The group is thin: every command is a module of its own, loaded when it is used."""

from ._completion import completed, profiles, typed_tool
from ._lab import figures
from ._main import main
from ._options import PathName, end_in_order, refuse_inputs, seed_option, the_folder, write_whole
from ._output import Progress, json_text, print_document, print_table
