"""What the text of a number or of a string stands for.

Read next: `parser_strings`, for strings with values in them.
"""

from __future__ import annotations

import re
import unicodedata

_ESCAPE = re.compile(r"\\(\n|[0-7]{1,3}|x[0-9a-fA-F]{2}|u[0-9a-fA-F]{4}|U[0-9a-fA-F]{8}|N\{[^{}]+\}|.)", re.DOTALL)
_SIMPLE = {
    "\n": "",
    "\\": "\\",
    "'": "'",
    '"': '"',
    "a": "\a",
    "b": "\b",
    "f": "\f",
    "n": "\n",
    "r": "\r",
    "t": "\t",
    "v": "\v",
}


def number(text: str) -> int | float | complex:
    """The value of a number token; raises ValueError for a whole number of more than 4300 digits."""
    plain = text.replace("_", "").lower()
    if plain[-1] == "j":
        return complex(0.0, float(plain[:-1]))
    if plain[:2] in ("0x", "0o", "0b"):
        return int(plain, 0)
    if "." in plain or "e" in plain:
        return float(plain)
    return int(plain)


def split_string(token: str) -> tuple[str, int, str]:
    """Prefix in small letters, offset of the content in the token, content as written."""
    quote = next(k for k, character in enumerate(token) if character in "'\"")
    width = 3 if token[quote : quote + 3] in ("'''", '"""') else 1
    return token[:quote].lower(), quote + width, token[quote + width : -width]


def unescape(text: str) -> str:
    """Replace the escapes of a string; raises ValueError with what is wrong."""
    return _ESCAPE.sub(_character, text) if "\\" in text else text


def _character(match: re.Match[str]) -> str:
    escape = match[1]
    if escape in _SIMPLE:
        return _SIMPLE[escape]
    if escape[0] in "01234567":
        return chr(int(escape, 8))
    if len(escape) == 1:
        if escape in "xuUN":
            raise ValueError(f'"\\{escape}" is an incomplete escape')
        return "\\" + escape
    if escape[0] == "N":
        try:
            return unicodedata.lookup(escape[2:-1])
        except KeyError:
            raise ValueError(f'no character is called "{escape[2:-1]}"') from None
    code = int(escape[1:], 16)
    if code > 0x10FFFF:
        raise ValueError(f'there is no character "\\{escape}"')
    return chr(code)
