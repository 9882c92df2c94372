"""What is said of Python's forms that the language leaves out.

Read next: `syntax.parser`.
"""

from __future__ import annotations

# What is refused: the message, and what to write instead.
REFUSED = {
    "%": ("`%` formats no text", 'write f"{value}", or f"{value:.2f}" with two digits'),
    "async": ("`async` is not supported", 'functions are written "def name(...):"'),
    "await": ("`await` is not supported", '"wait" lets a step pass, and "do" runs a behavior'),
    "bytes": ("bytes are not supported", 'write a text, without the "b"'),
    "decorator": ("decorators are not supported", 'call the function: "name = decorator(name)"'),
    "else": ("`else` after `try` is not supported", "write its statements at the end of the block above"),
    "except": ("`except` is not supported", 'ask with "if" before what may fail'),
    "finally": ("`finally` is not supported", 'write its statements behind the "try"'),
    "match": ("`match` is not supported", 'write "if", "elif" and "else"'),
    "raise": ("`raise` is not supported", 'write "assert condition, message"'),
    "set": ("sets are not supported", 'write a tuple, "(a, b)", or a list, "[a, b]"'),
    "set comprehension": ("sets are not supported", 'write a list, "[... for ...]"'),
    "with": ("`with` blocks are not supported", "a program opens no files"),
    "yield": ("`yield` is not supported", 'an action is taken with "take", and a function returns a list'),
}
