"""The language of code blocks: a typed part of GLSL, checked once and evaluated over many altitudes or cosines.

block        A code block as a function of many altitudes or cosines
lexer        Text to tokens, and a way through them
nodes        Types of values, and the tree of a block with all types settled: what is read, and what runs
functions    Operators and built-in functions: arrays in, arrays out, and where GLSL leaves the result open
statements   Statements and loops as they are read; every way through a block ends with a value
expressions  Expressions as they are read, with names and types settled on the way
rules        What operators, functions and components make of the types of their operands
scope        Names that a block may read and write, by the braces they live in
evaluate     Runs a block over many lanes at once: each lane follows its own branches, by masks
refusal      What a block is refused for: problems gathered until there are enough
"""
