"""The language of code blocks: a typed part of GLSL, checked once and evaluated over many altitudes or cosines.

block        A checked code block as a function of many altitudes or cosines, and the evaluator that runs it
statements   Statements and loops as they are read; every way through a block ends with a value
expressions  Expressions and the names in them as they are read, typed on the way
operators    Operators and built-in functions: types of operands, and what is done to arrays
nodes        Types of values, and the tree of a block with all types settled: what is read, and what runs
lexer        Text to tokens, a way through them, and what a block is refused for
"""
