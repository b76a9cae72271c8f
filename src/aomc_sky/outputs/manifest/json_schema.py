"""JSON of files that anybody may have changed: read within limits, and held against a published schema."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

MAX_DEPTH = 32
MAX_VALUES = 4_000_000

_TYPES: dict[str, Any] = {
    "object": dict,
    "array": list,
    "string": str,
    "integer": int,
    "number": (int, float),
    "boolean": bool,
    "null": type(None),
}
_NOTES = {"$schema", "$id", "$defs", "title", "description"}


def parse_json(data: bytes) -> Any:
    """Parse JSON text in UTF-8.

    ValueError where it is not JSON, has a key twice, NaN or infinity, is nested deeper than 32, or has more than 4
    million values.
    """
    if data.count(b",") + data.count(b"[") + data.count(b"{") > MAX_VALUES:
        raise ValueError(f"more than {MAX_VALUES} values")
    try:
        value = json.loads(data.decode("utf-8"), object_pairs_hook=_object, parse_constant=_refuse_constant)
    except RecursionError:
        raise ValueError("nested without end") from None
    _check_values(value)
    return value


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {shown(twice)} stands twice")
    return found


def _refuse_constant(text: str) -> Any:
    raise ValueError(f"{text} is no number of JSON")


def _check_values(value: Any) -> None:
    level, depth = [value], 0
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise ValueError(f"nested deeper than {MAX_DEPTH}")
        if any(isinstance(item, float) and not math.isfinite(item) for item in level):
            raise ValueError("a number beyond the largest one")
        level = [
            inner
            for item in level
            if isinstance(item, (dict, list))
            for inner in (item.values() if isinstance(item, dict) else item)
        ]


def shown(value: Any) -> str:
    """A value for a message: short, in ASCII, without what would disturb a terminal."""
    text = (
        ascii(value) if isinstance(value, (str, int, float, bool, type(None))) else f"a value of {len(value)} members"
    )
    return text if len(text) <= 60 else f"{text[:57]}..."


def first_fault(value: Any, schema: Mapping[str, Any]) -> str:
    """What does not fit a schema, and where; empty where everything does.

    Knows the keywords of JSON Schema that `outputs/*.schema.json` use, and fails for any other, so
    that no rule of the published schema is passed over. An integer is written without a point.
    """
    return next(_faults(value, schema, "", schema), "")


def _faults(value: Any, schema: Mapping[str, Any], place: str, root: Mapping[str, Any]) -> Iterator[str]:
    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].removeprefix("#/$defs/")] | {k: schema[k] for k in schema if k != "$ref"}
    at = place or "the whole"
    if "type" in schema and not _is_of_type(value, schema["type"]):
        kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
        yield f"{at}: wanted {' or '.join(kinds)}, found {shown(value)}"
        return
    for keyword, wanted in schema.items():
        if keyword in _NOTES or keyword == "type":
            continue
        yield from _RULES[keyword](value, wanted, place, root, schema)


def _is_of_type(value: Any, wanted: str | list[str]) -> bool:
    kinds = wanted if isinstance(wanted, list) else [wanted]
    return any(
        isinstance(value, _TYPES[kind]) and (kind == "boolean" or (value is not True and value is not False))
        for kind in kinds
    )


def _const(value: Any, wanted: Any, place: str, root: Any, schema: Any) -> Iterator[str]:
    if value != wanted or type(value) is not type(wanted):
        yield f"{place}: wanted {shown(wanted)}, found {shown(value)}"


def _enum(value: Any, wanted: list[Any], place: str, root: Any, schema: Any) -> Iterator[str]:
    if not any(value == one and type(value) is type(one) for one in wanted):
        yield f"{place}: wanted one of {', '.join(map(str, wanted))}, found {shown(value)}"


def _required(value: Any, wanted: list[str], place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        yield from (f"{_member(place, key)} is missing" for key in wanted if key not in value)


def _properties(value: Any, wanted: dict[str, Any], place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key in (key for key in wanted if key in value):
            yield from _faults(value[key], wanted[key], _member(place, key), root)


def _additional(value: Any, wanted: Any, place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key in (key for key in value if key not in schema.get("properties", {})):
            if wanted is False:
                yield f"{_member(place, key)} is not known"
            else:
                yield from _faults(value[key], wanted, _member(place, key), root)


def _property_names(value: Any, wanted: dict[str, Any], place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key in value:
            if next(_faults(key, wanted, place, root), ""):
                yield f"{place}: the name {shown(key)} is not allowed here"


def _items(value: Any, wanted: dict[str, Any], place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, list):
        for k, item in enumerate(value):
            yield from _faults(item, wanted, f"{place}[{k}]", root)


def _prefix_items(value: Any, wanted: list[Any], place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, list):
        for k, (item, rule) in enumerate(zip(value, wanted, strict=False)):
            yield from _faults(item, rule, f"{place}[{k}]", root)


def _limit(value: Any, wanted: Any, place: str, root: Any, schema: Any) -> Iterator[str]:
    low, high = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not low <= value <= high:
        yield f"{place}: wanted {low} to {high}, found {shown(value)}"


def _length(value: Any, wanted: int, place: str, root: Any, schema: Any) -> Iterator[str]:
    few, most = schema.get("minItems", 0), schema.get("maxItems", math.inf)
    if isinstance(value, list) and not few <= len(value) <= most:
        yield f"{place}: wanted {few} to {most} values, found {len(value)}"


def _longest(value: Any, wanted: int, place: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, str) and len(value) > wanted:
        yield f"{place}: wanted at most {wanted} characters, found {len(value)}"


def _pattern(value: Any, wanted: str, place: str, root: Any, schema: Any) -> Iterator[str]:
    # $ of JSON Schema is the end, that of Python also stands before a last line end
    rule = f"{wanted[:-1]}\\Z" if wanted.endswith("$") else wanted
    if isinstance(value, str) and re.search(rule, value) is None:
        yield f"{place}: {shown(value)} is not of the form {wanted}"


def _member(place: str, key: str) -> str:
    name = key if re.fullmatch("[A-Za-z0-9_]{1,60}", key) else f"[{shown(key)}]"
    return f"{place}{name}" if not place or name[0] == "[" else f"{place}.{name}"


_RULES = {
    "const": _const,
    "enum": _enum,
    "required": _required,
    "properties": _properties,
    "additionalProperties": _additional,
    "propertyNames": _property_names,
    "items": _items,
    "prefixItems": _prefix_items,
    "minimum": _limit,
    "maximum": _limit,
    "minItems": _length,
    "maxItems": _length,
    "maxLength": _longest,
    "pattern": _pattern,
}
