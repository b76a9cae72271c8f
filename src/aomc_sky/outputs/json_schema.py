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
        raise ValueError("nested too deeply") from None
    _check_values(value)
    return value


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {shown(twice)} appears twice")
    return members


def _refuse_constant(text: str) -> Any:
    raise ValueError(f"{text} is not a JSON number")


def _check_values(value: Any) -> None:
    level, depth = [value], 0
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise ValueError(f"nested deeper than {MAX_DEPTH}")
        if any(isinstance(item, float) and not math.isfinite(item) for item in level):
            raise ValueError("a number that is too large")
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


def _faults(value: Any, schema: Mapping[str, Any], path: str, root: Mapping[str, Any]) -> Iterator[str]:
    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].removeprefix("#/$defs/")] | {k: schema[k] for k in schema if k != "$ref"}
    at = path or "the whole"
    if "type" in schema and not _is_of_type(value, schema["type"]):
        kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
        yield f"{at}: wanted {' or '.join(kinds)}, found {shown(value)}"
        return
    for keyword, expected in schema.items():
        if keyword in _NOTES or keyword == "type":
            continue
        yield from _RULES[keyword](value, expected, path, root, schema)


def _is_of_type(value: Any, expected: str | list[str]) -> bool:
    kinds = expected if isinstance(expected, list) else [expected]
    return any(
        isinstance(value, _TYPES[kind]) and (kind == "boolean" or (value is not True and value is not False))
        for kind in kinds
    )


def _const(value: Any, expected: Any, path: str, root: Any, schema: Any) -> Iterator[str]:
    if value != expected or type(value) is not type(expected):
        yield f"{path}: wanted {shown(expected)}, found {shown(value)}"


def _enum(value: Any, expected: list[Any], path: str, root: Any, schema: Any) -> Iterator[str]:
    if not any(value == one and type(value) is type(one) for one in expected):
        yield f"{path}: wanted one of {', '.join(map(str, expected))}, found {shown(value)}"


def _required(value: Any, expected: list[str], path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        yield from (f"{_member(path, key)} is missing" for key in expected if key not in value)


def _properties(value: Any, expected: dict[str, Any], path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key in (key for key in expected if key in value):
            yield from _faults(value[key], expected[key], _member(path, key), root)


def _additional(value: Any, expected: Any, path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key in (key for key in value if key not in schema.get("properties", {})):
            if expected is False:
                yield f"{_member(path, key)} is not known"
            else:
                yield from _faults(value[key], expected, _member(path, key), root)


def _property_names(value: Any, expected: dict[str, Any], path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key in value:
            if next(_faults(key, expected, path, root), ""):
                yield f"{path}: the name {shown(key)} is not allowed here"


def _items(value: Any, expected: dict[str, Any], path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, list):
        for k, item in enumerate(value):
            yield from _faults(item, expected, f"{path}[{k}]", root)


def _prefix_items(value: Any, expected: list[Any], path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, list):
        for k, (item, rule) in enumerate(zip(value, expected, strict=False)):
            yield from _faults(item, rule, f"{path}[{k}]", root)


def _limit(value: Any, expected: Any, path: str, root: Any, schema: Any) -> Iterator[str]:
    low, high = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not low <= value <= high:
        yield f"{path}: wanted {low} to {high}, found {shown(value)}"


def _length(value: Any, expected: int, path: str, root: Any, schema: Any) -> Iterator[str]:
    few, most = schema.get("minItems", 0), schema.get("maxItems", math.inf)
    if isinstance(value, list) and not few <= len(value) <= most:
        yield f"{path}: wanted {few} to {most} values, found {len(value)}"


def _longest(value: Any, expected: int, path: str, root: Any, schema: Any) -> Iterator[str]:
    if isinstance(value, str) and len(value) > expected:
        yield f"{path}: wanted at most {expected} characters, found {len(value)}"


def _pattern(value: Any, expected: str, path: str, root: Any, schema: Any) -> Iterator[str]:
    # $ of JSON Schema is the end, that of Python also matches before a last line end
    rule = f"{expected[:-1]}\\Z" if expected.endswith("$") else expected
    if isinstance(value, str) and re.search(rule, value) is None:
        yield f"{path}: {shown(value)} does not match {expected}"


def _member(path: str, key: str) -> str:
    name = key if re.fullmatch("[A-Za-z0-9_]{1,60}", key) else f"[{shown(key)}]"
    return f"{path}{name}" if not path or name[0] == "[" else f"{path}.{name}"


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
