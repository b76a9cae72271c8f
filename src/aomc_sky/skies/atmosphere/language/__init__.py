"""The language of code blocks: a typed part of GLSL, read once, then evaluated over many altitudes or cosines.

block        A code block as a function of many altitudes or cosines
statements   Statements as they are read; every way through a block ends with a value
expressions  Expressions and names as they are read, with their types
operators    Operators and built-in functions: types of operands, and what is done to arrays
values       Types of values, and the state of one run
lexer        Text to tokens, and what a block is refused for
"""
