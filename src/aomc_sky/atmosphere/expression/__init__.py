"""The language of code blocks: a typed part of GLSL, checked once and evaluated over many altitudes or cosines."""

from aomc_sky.atmosphere.expression.block import Block, read_block
from aomc_sky.atmosphere.expression.types import Type

__all__ = ["Block", "Type", "read_block"]
