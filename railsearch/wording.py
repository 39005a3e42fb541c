"""How numbers and names are shown, in tables, pages and figures alike."""


def readable(value: object) -> str:
    """A number with five significant digits, a dash for nothing, anything else as it is."""
    if value is None:
        return "–"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def quantity_label(name: str, unit: str) -> str:
    """A name with its unit in brackets."""
    return f"{name} [{unit}]" if unit else name
