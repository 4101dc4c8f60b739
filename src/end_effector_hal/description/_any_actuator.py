"""An actuator of any kind: its ``kind`` decides which keys it has."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Annotated, Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic_core import CoreSchema, PydanticCustomError, PydanticKnownError, core_schema

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import get_kind, usable_kinds
from end_effector_hal.kinds.stanza import Actuator


class _ByKind:
    """Kinds are looked up when a stanza is read, since other distributions add some."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(_validated)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        stanzas: Any = reduce(or_, (kind.stanza for kind in usable_kinds().values()))
        return handler(TypeAdapter(Annotated[stanzas, Field(discriminator="kind")]).core_schema)


def _validated(value: object) -> Actuator:
    if isinstance(value, Actuator):
        return value
    if not isinstance(value, dict):
        raise PydanticKnownError("dict_type")
    try:
        stanza = get_kind(str(value.get("kind"))).stanza
    except UsageError as error:
        raise PydanticCustomError("kind", "{why}", {"why": str(error)}) from None
    return stanza.model_validate(value)


AnyActuator = Annotated[Actuator, _ByKind()]
