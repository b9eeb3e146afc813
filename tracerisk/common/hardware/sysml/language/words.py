"""The words and the signs of SysML v2, and the terminals of the grammar that they are."""

from __future__ import annotations

SIGNS = {
    ";": "_SEMICOLON", "{": "_OPEN", "}": "_CLOSE", "(": "OPEN_ROUND", ")": "_CLOSE_ROUND",
    "[": "OPEN_SQUARE", "]": "_CLOSE_SQUARE", ",": "_COMMA", ":": "_COLON", "::": "_SCOPE",
    "=": "_EQUALS", ":=": "_ASSIGN", ":>": "RELATION", ":>>": "RELATION", "::>": "RELATION",
    "=>": "RELATION", ".": "_DOT", "..": "DOTS", ".?": "_SELECT", "->": "_ARROW", "@": "AT",
    "#": "_HASH", "*": "STAR", "**": "STARS", "+": "SIGN", "-": "SIGN", "~": "TILDE", "<": "LESS",
    ">": "GREATER", "?": "_QUESTION",
    **dict.fromkeys(
        ("===", "==", "!==", "!=", "@@", "??", "<=", ">=", "/", "%", "^", "|", "&"), "OPERATOR"
    ),
}  # fmt: skip
"""The terminal of each sign."""

SKIPPED_WORDS = frozenset(
    """
    accept action actor allocate allocation analysis assert assign assume bind binding calc case
    concern connect connection constraint decide dependency do entry event exhibit exit expose
    filter first flow fork frame include interface join loop merge message objective occurrence
    parallel perform port render rendering require requirement return satisfy send snapshot
    stakeholder state subject succession terminate then timeslice transition until use
    verification verify via view viewpoint while
    """.split()  # noqa: SIM905
)
"""Words with which elements begin that are skipped."""

WORDS = {
    "package": "_PACKAGE", "import": "_IMPORT", "alias": "_ALIAS", "all": "ALL", "for": "_FOR",
    "def": "_DEF", "metadata": "_METADATA", "about": "_ABOUT", "doc": "_DOC",
    "comment": "_COMMENT", "locale": "_LOCALE", "rep": "_REP", "language": "_LANGUAGE",
    "defined": "_DEFINED", "by": "_BY", "default": "_DEFAULT", "new": "_NEW", "null": "NULL",
    "if": "_IF", "else": "_ELSE", "not": "NOT", "true": "BOOLEAN", "false": "BOOLEAN",
    **dict.fromkeys(("part", "item", "attribute", "enum"), "KIND"),
    **dict.fromkeys(("ordered", "nonunique"), "FLAG"),
    **dict.fromkeys(("specializes", "subsets", "redefines", "references", "crosses"), "RELATION"),
    **dict.fromkeys(("and", "or", "xor", "implies", "istype", "hastype", "as", "meta"), "OPERATOR"),
    **dict.fromkeys(
        (
            "public", "private", "protected", "in", "out", "inout", "abstract", "variation",
            "variant", "derived", "readonly", "constant", "ref", "end", "individual", "standard",
            "library",
        ),
        "PREFIX",
    ),
    **dict.fromkeys(("after", "at", "from", "of", "to", "when"), "RESERVED"),
    **dict.fromkeys(SKIPPED_WORDS, "SKIPPED"),
}  # fmt: skip
"""The terminal of each word of the language; no name but in quotes may be one of them."""
