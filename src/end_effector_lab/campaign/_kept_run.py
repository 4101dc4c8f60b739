"""A run as it is kept in a file, which anybody may have changed since."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from ._coverage import CoverageMap

MOST_MOMENTS = 60
_Number = Annotated[int, Field(ge=0, lt=2**53)]


class _KeptReached(BaseModel):
    """Numbers of a `CoverageMap`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    edges: list[_Number]
    locations: list[_Number]
    pairs: list[_Number]


class KeptRun(BaseModel):
    """One run, with its case only if it failed or reached something new."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    run: _Number
    grips: _Number
    s: float = Field(ge=0, allow_inf_nan=False)
    case: dict[str, Any] | None = None
    moments: list[_Number] | None = Field(None, max_length=MOST_MOMENTS)
    new: _KeptReached | None = None
    failures: dict[str, str] | None = Field(None, min_length=1)

    def misfit(self, run: int, known: CoverageMap) -> str:
        """What contradicts the number of the run, the tool, or itself; empty: nothing."""
        if self.run != run:
            return f"it is run {self.run}, and run {run} is the next one."
        useless = self.case is not None and self.new is None and self.failures is None
        if useless or (self.new is None) != (self.moments is None) or (self.new and self.case is None):
            return "a case, what it reached and its moments do not stand together."
        if self.new is not None:
            most = len(known.edges), len(known.locations), len(known.edges) * len(known.faults)
            found = self.new.edges, self.new.locations, self.new.pairs
            if any(max(numbers, default=-1) >= limit for numbers, limit in zip(found, most, strict=True)):
                return "it reached what this tool does not have."
        return ""

    def as_json(self) -> dict[str, Any]:
        """As it stands in the file."""
        return self.model_dump(exclude_none=True)


KEPT_RUN = TypeAdapter(KeptRun)
