"""``/metrics``: the live view in the text format of Prometheus."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric, SummaryMetricFamily
from prometheus_client.registry import Collector

from end_effector_hal.control import Status
from end_effector_hal.page.view import ToolView
from end_effector_hal.recording import AttemptOutcome
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth

TYPE = CONTENT_TYPE_LATEST
Values = Mapping[Any, float]
"""Values of a metric by the tuple of its labels after ``tool``."""


class ToolMetrics(Collector):
    """Computes the metrics of a tool when they are requested.

    Counters count since the page's process began; a metric of which nothing is known now is left out.

    Args:
        view: the view that the page shows.
        now: returns the time, µs.
    """

    def __init__(self, view: ToolView, now: Callable[[], int]) -> None:
        self._view, self._now = view, now
        self._registry = CollectorRegistry()
        self._registry.register(self)

    def text(self) -> bytes:
        """Return the metrics in the text format."""
        return generate_latest(self._registry)

    def describe(self) -> Iterator[Metric]:
        """Return no names in advance: they are known once there is a status."""
        return iter(())

    def collect(self) -> Iterator[Metric]:
        """Yield the metrics as they are now."""
        at = self._now()
        fresh = self._view.is_fresh(at)
        yield self._gauge("up", "Whether the HAL is connected and not silent.", {(): fresh})
        yield from self._grips()
        status = self._view.status()
        if fresh and status is not None:
            yield from self._of(status)
            yield from self._hold(status)
            yield from self._links()

    def _grips(self) -> Iterator[Metric]:
        counts, count = self._view.counts, self._counter
        by_part = {(outcome, part): number for (part, outcome), number in counts.grips.items()}
        yield count("grips", "Grips that ended; STOPPED: the program ended.", by_part, "outcome", "part")
        first = {(part,): number for part, number in counts.first_attempts.items()}
        yield count("first_attempt_grips", "Grips with each actuator confirmed at once.", first, "part")
        what = "Attempts; deactivated: the grip ended before."
        yield count("attempts", what, counts.attempts, "actuator", "outcome")
        lost = {(name,): number for name, number in counts.losses.items()}
        yield count("losses", "Held parts that were lost.", lost, "actuator")
        what = "Time from the activation to the confirmation."
        times = SummaryMetricFamily("eehal_confirm_seconds", what, labels=("tool", "actuator"))
        for name, total_s in counts.confirm_s.items():
            number = counts.attempts[name, str(AttemptOutcome.CONFIRMED)]
            times.add_metric((self._view.description.name, name), number, total_s)
        yield times

    def _of(self, status: Status) -> Iterator[Metric]:
        gauge, count = self._gauge, self._counter
        states = {(state.name,): state is status.ee for state in EndEffectorState}
        yield gauge("state", "Whether this is the state of the tool.", states, "state")
        yield gauge("held", "Whether a part is held.", {(): status.held})
        yield gauge("lift_allowed", "Whether lifting is allowed.", {(): status.lift_allowed})
        alarms = {(each.id, each.about, each.severity): 1 for each in status.alarms if not each.over}
        yield gauge("alarm", "An alarm that is active now.", alarms, "id", "about", "severity")
        late_s = status.worst_late_us / 1e6
        yield gauge("worst_lateness_seconds", "Largest lateness of a step since the HAL began.", {(): late_s})
        missed = {(): status.missed}
        yield count("missed_bounds", "Steps that missed the reaction bound since the HAL began.", missed)
        refused = {(): status.refused_frames}
        yield count("refused_frames", "Frames with an impossible stamp since the HAL began.", refused)

    def _hold(self, status: Status) -> Iterator[Metric]:
        cards = self._view.moment()["cards"] if status.held else ()
        names = [(name, card) for name, card in zip(self._view.description.sequence, cards, strict=False)]
        margins = {(n,): card["margin_kpa"] * 1000 for n, card in names if card["margin_kpa"] is not None}
        yield self._gauge("margin_pascals", "Margin while a part is held.", margins, "actuator")
        holds = {(name,): card["hold"]["leak_kpa_s"] for name, card in names if card["hold"] is not None}
        leaks = {name: leak_kpa_s * 1000 for name, leak_kpa_s in holds.items() if leak_kpa_s is not None}
        yield self._gauge("leak_pascals_per_second", "Fall of a held vacuum.", leaks, "actuator")

    def _links(self) -> Iterator[Metric]:
        health, count = self._view.health, self._counter
        if health is None:
            return
        links: dict[str, LinkHealth | InputsHealth] = {**health.links}
        if health.inputs is not None:
            links["inputs"] = health.inputs
        up = {(name,): not each.error for name, each in links.items()}
        yield self._gauge("link_up", "Whether a link or the inputs can be read.", up, "link")
        for what, words in (
            ("frames", "Frames of"),
            ("lost", "Losses of frames or edges on"),
            ("opened", "Openings of"),
        ):
            values = {(name,): getattr(each, what) for name, each in links.items()}
            yield count(f"link_{what}", f"{words} a link or the inputs since the HAL began.", values, "link")
        errors = {
            (name, kind): number
            for name, each in health.links.items()
            for kind, number in each.errors.items()
        }
        yield count("link_errors", "Errors on a link or bus since the HAL began.", errors, "link", "kind")

    def _gauge(self, name: str, what: str, values: Values, *labels: str) -> Metric:
        return self._filled(GaugeMetricFamily(f"eehal_{name}", what, labels=("tool", *labels)), values)

    def _counter(self, name: str, what: str, values: Values, *labels: str) -> Metric:
        return self._filled(CounterMetricFamily(f"eehal_{name}", what, labels=("tool", *labels)), values)

    def _filled(self, family: GaugeMetricFamily | CounterMetricFamily, values: Values) -> Metric:
        for own, value in values.items():
            family.add_metric((self._view.description.name, *own), value)
        return family
