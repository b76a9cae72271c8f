"""Arguments of all public functions, classes and methods as type checkers see them, and their closed lists of words."""

import ast
import enum
import importlib
import inspect
import pkgutil
import re
import textwrap
import types
import typing

import aomc_sky as sky

MODULES = [
    importlib.import_module(one.name)
    for one in pkgutil.walk_packages(sky.__path__, "aomc_sky.")
    if "__main__" not in one.name
]
_VALUES = [(name, value) for module in MODULES for name, value in vars(module).items()]
ENUMERATIONS = {
    value.__name__: value
    for _, value in _VALUES
    if isinstance(value, type) and issubclass(value, enum.Enum) and value.__module__.startswith("aomc_sky")
}


def words_of(choice):
    """Words of a Literal or of a union of them; none of any other value."""
    if isinstance(choice, types.UnionType) or typing.get_origin(choice) is typing.Union:
        return tuple(word for part in typing.get_args(choice) for word in words_of(part))
    return typing.get_args(choice) if typing.get_origin(choice) is typing.Literal else ()


CHOICES = {name: words_of(value) for name, value in _VALUES if words_of(value)}
"""Words of each Literal that has a name."""


def words_of_enumeration(kind):
    """What `member_of` takes: the values, or the names where values are no words."""
    return tuple(one.value if isinstance(one.value, str) else one.name.lower() for one in kind)


def constructor(thing):
    """The ``__init__`` of a class that is written for type checkers alone, or None."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(thing)))
    blocks = [node.body for node in tree.body[0].body if isinstance(node, ast.If)]
    found = [node for body in blocks for node in body if getattr(node, "name", "") == "__init__"]
    return found[0].args if found else None


def shown(function):
    """Names of the arguments of a function or a class, with their annotations as text."""
    if isinstance(function, type) and (written := constructor(function)) is not None:
        every = [*written.posonlyargs, *written.args, *written.kwonlyargs]
        return {one.arg: ast.unparse(one.annotation) for one in every if one.arg != "self"}
    return {one.name: str(one.annotation) for one in inspect.signature(function).parameters.values()}


def public():
    """Public functions, classes and methods by the names that a user writes behind ``aomc_sky.``."""
    found = {}
    for name in sky.__all__:
        found[name] = getattr(sky, name)
    for name, module in sky._OLD.items():
        found[f"{module}.{name}"] = getattr(importlib.import_module(f"aomc_sky.{module}"), name)
    for name in ("directions", *(one for one in sky._PUBLIC_MODULES if hasattr(getattr(sky, one), "__all__"))):
        thing = getattr(sky, name)
        names = getattr(thing, "__all__", [one for one in vars(thing) if one[0] != "_"])
        found |= {f"{name}.{inner}": getattr(thing, inner) for inner in names}
    closed = {one for one in found.values() if isinstance(one, type) and issubclass(one, (enum.Enum, BaseException))}
    found = {called: one for called, one in found.items() if _is_ours(one) and one not in closed}
    for called, one in [(called, one) for called, one in found.items() if isinstance(one, type)]:
        methods = {f"{called}.{name}": getattr(one, name) for name in dir(one) if name[0] != "_"}
        found |= {name: method for name, method in methods.items() if _is_ours(method)}
    return found


def _is_ours(thing):
    return callable(thing) and str(getattr(thing, "__module__", "")).startswith("aomc_sky")


def arguments():
    """(function, argument) -> annotation, of everything public."""
    return {(called, name): text for called, one in public().items() for name, text in shown(one).items()}


def choices(annotation):
    """The enumerations and the names of Literals in an annotation."""
    words = re.findall(r"\w+", annotation)
    return [ENUMERATIONS[word] for word in words if word in ENUMERATIONS], [word for word in words if word in CHOICES]
