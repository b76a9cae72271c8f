"""The language of code blocks: a typed part of GLSL, checked once and evaluated over many altitudes or cosines.

block              A code block as a function of many altitudes or cosines
check_expressions  Types of expressions: what GLSL takes, and nothing else
check_statements   Types of statements, scopes, and whether every way through a block ends with a value
cursor             A place in the tokens of a block, with the questions a parser asks
evaluate           Runs a checked block over many lanes at once: each lane follows its own branches, by masks
expressions        Parser of expressions: operator precedence without recursion, recursion for brackets alone
functions          Operators and built-in functions: arrays in, arrays out, and where GLSL leaves the result open
lexer              Text of a code block to tokens: names, whole numbers, real numbers and symbols
program            A code block with all types settled: what the checker makes and the evaluator runs
refusal            What a code block is refused for: problems with their place, gathered until there are enough
scope              Names that a block may read and write, by the braces they live in
statements         Parser of statements: a block is the body of a function
syntax             Syntax tree of a code block, before types: what the parser makes and the checker reads
types              Types of values, and what may stand in for what
"""
