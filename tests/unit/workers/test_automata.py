"""The UPPAAL file of a tool travels to machines that have another one, or none."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path

from end_effector_hal.control import network_of
from end_effector_hal.description import SHIPPED_AUTOMATA, load, profile_path
from end_effector_lab.workers import ShippedAutomata


def test_a_machine_without_the_file_gets_it(tmp_path: Path) -> None:
    tool, own = tmp_path / "end_effector.yaml", tmp_path / "end_effector.xml"
    shutil.copy(profile_path(), tool)
    text = SHIPPED_AUTOMATA.read_text().replace("</nta>", "<!-- mine --></nta>")
    own.write_text(text)
    description = load(tool)
    sent = pickle.dumps((description, ShippedAutomata.read(description)))
    there, automata = pickle.loads(sent)
    assert automata.of(there).automata_path == own  # the same machine
    own.unlink()
    there, automata = pickle.loads(sent)
    found = automata.of(there)
    assert found.automata_path.read_text() == text
    assert network_of(found).document == network_of(automata.of(there)).document
    own.write_text(text.replace("mine", "another"))
    there, automata = pickle.loads(sent)
    assert automata.of(there).automata_path.read_text() == text


def test_the_shipped_file_is_used_where_it_is(tmp_path: Path) -> None:
    description = load(profile_path())
    there, automata = pickle.loads(pickle.dumps((description, ShippedAutomata.read(description))))
    assert automata.of(there) is there
