"""Tests that every line back-end must pass; a test inherits them.

class TestMyLines(LineBackendConformance):
    @pytest.fixture
    def make(self):
        chip = MyChip(lines=self.names, pulled_up=self.names[1:2])
        return lambda: MyLines(chip)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import pytest

from end_effector_hal.errors import LineBusyError, LineNotFoundError
from end_effector_hal.wires.lines import LineBackend

Make = Callable[[], LineBackend]


class LineBackendConformance:
    """Tests of a line back-end. The fixture ``make`` returns a function; each call makes a back-end on the same chip.

    The chip has the three lines ``names``, all inputs at the beginning; the second one has a pull-up.
    """

    names: ClassVar[tuple[str, str, str]] = ("SODIMM_206", "SODIMM_208", "SODIMM_210")
    keeps_level: ClassVar[bool] = True
    """Whether the chip keeps the level of an output after its release; on some chips it falls to its pull or floats."""

    def test_inputs_become_inactive_outputs_though_pulled_up(self, make: Make) -> None:
        a, b, _ = self.names
        backend = make()
        assert backend.request([a, b]) == {a: False, b: False}
        assert backend.levels() == {a: False, b: False}
        backend.close()

    def test_outputs_keep_their_level(self, make: Make) -> None:
        a, b, c = self.names
        first = make()
        first.request([a, b])
        first.set({a: True})
        first.close()
        second = make()
        assert second.request([c, a, b]) == {a: self.keeps_level, b: False, c: False}
        second.close()

    def test_a_level_outlives_any_number_of_owners(self, make: Make) -> None:
        a, b, c = self.names
        for again in (False, True, True, True):
            backend = make()
            left = again and self.keeps_level
            assert backend.request([a, b, c]) == {a: left, b: False, c: left}
            backend.set({a: True, c: True})
            backend.close()

    def test_set_changes_what_it_names(self, make: Make) -> None:
        a, b, c = self.names
        backend = make()
        backend.request([a, b, c])
        backend.set({a: True, c: True})
        assert backend.levels() == {a: True, b: False, c: True}
        backend.set({c: False})
        assert backend.levels() == {a: True, b: False, c: False}
        backend.set({})
        assert backend.levels() == {a: True, b: False, c: False}
        backend.close()

    def test_the_levels_that_were_given_are_nobodys_to_change(self, make: Make) -> None:
        a, _, _ = self.names
        backend = make()
        backend.request([a])
        backend.levels()[a] = True
        assert backend.levels() == {a: False}
        backend.close()

    def test_a_second_owner_is_refused(self, make: Make) -> None:
        a, b, _ = self.names
        first, second = make(), make()
        first.request([a])
        with pytest.raises(LineBusyError, match="held by"):
            second.request([a, b])
        first.set({a: True})
        assert first.levels() == {a: True}
        first.close()
        assert second.request([a, b]) == {a: self.keeps_level, b: False}
        second.close()

    def test_missing_names_are_all_named_and_nothing_is_claimed(self, make: Make) -> None:
        a, _, c = self.names
        near = c[:-1]
        with pytest.raises(LineNotFoundError) as caught:
            make().request([a, near, "y"])
        assert f"{near} (did you mean {c}?), y" in caught.value.what
        assert caught.value.where
        assert caught.value.todo
        backend = make()
        backend.request([a])
        backend.close()

    def test_close_twice(self, make: Make) -> None:
        backend = make()
        backend.request([self.names[0]])
        backend.close()
        backend.close()
